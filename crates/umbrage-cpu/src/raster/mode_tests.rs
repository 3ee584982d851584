//! Tests of the modes other than the least depth, against the reference rasteriser and by their
//! purpose.

use crate::raster::{
    Draw, Mode, Position, Rasterizer, Target,
    mode::stored16,
    reference,
    tests::{KINDS, RasterRandom, bits, draw_of, fast, perspective, soup},
};
use glam::{Mat4, UVec2, Vec3, Vec4};
use umbrage_core::{Cull, RasterBias, Simd};

const SIZES: [UVec2; 4] = [
    UVec2::new(150, 75),
    UVec2::new(64, 64),
    UVec2::new(1, 130),
    UVec2::new(257, 3),
];

/// Panics unless both rasterisers produce the same bits.
fn compare<P: Position>(draw: &Draw<'_, P>, other: &[f32], what: &str) -> Vec<f32> {
    let (texels, _) = fast(draw, other);
    assert!(
        bits(&reference::draw(draw, other).0) == bits(&texels),
        "{what}: {:?} differs",
        draw.mode
    );
    texels
}

/// Returns depths in front of and behind the triangles, some exactly equal to theirs, some at
/// either end of the range.
fn noise<P: Position>(draw: &Draw<'_, P>, r: &mut RasterRandom) -> Vec<f32> {
    let (least, _) = reference::draw(
        &Draw {
            mode: Mode::Depth,
            holes: None,
            bias: RasterBias::default(),
            ..*draw
        },
        &[],
    );
    let other = least
        .into_iter()
        .map(|z| [z, r.range(0.0, 1.0), 1.0, 0.0][r.bits() as usize % 4]);
    if draw.mode == Mode::DepthPeel16 {
        other.map(stored16).collect()
    } else {
        other.collect()
    }
}

/// Returns a projection with an infinite far plane.
fn infinite() -> Mat4 {
    Mat4::from_cols_array(&[
        1.2, 0.0, 0.0, 0.0, 0.0, 1.6, 0.0, 0.0, 0.0, 0.0, -1.0, -1.0, 0.0, 0.0, -0.1, 0.0,
    ])
}

/// Returns the same triangles with other weights, some of them infinitely far away along their
/// direction.
fn homogeneous(positions: &[Vec3], r: &mut RasterRandom) -> Vec<Vec4> {
    let scaled = |p: &Vec3| match r.bits() % 4 {
        0 => p.extend(0.0),
        1 => p.extend(1.0),
        _ => p.extend(1.0) * r.range(0.2, 3.0),
    };
    positions.iter().map(scaled).collect()
}

#[test]
fn every_mode_agrees_with_the_plain_rasteriser() {
    let mut r = RasterRandom(2024);
    for i in 0..64 {
        let (positions, triangles) = soup(0..KINDS, 80, &mut r);
        let mut draw = draw_of(&positions, &triangles);
        draw.mode = [
            Mode::Depth16,
            Mode::DepthPeel,
            Mode::DepthPeel16,
            Mode::StencilDepthFail,
        ][i % 4];
        draw.simd = [Simd::Native, Simd::Baseline][i / 4 % 2];
        draw.size = SIZES[i / 8 % 4];
        draw.clip_from_world = [Mat4::IDENTITY, perspective()][i / 5 % 2];
        if draw.mode != Mode::StencilDepthFail {
            draw.cull = [Cull::None, Cull::Front, Cull::Back][i / 3 % 3];
        }
        if draw.mode == Mode::Depth16 {
            let constant = [0, 2, -700, 30_001][i / 3 % 4];
            draw.bias = RasterBias {
                constant,
                slope: [0.0, 4.0, -1.5][i / 6 % 3],
                clamp: [0.0, 1e-3, -1e-3][i / 9 % 3],
            };
        }
        let other = noise(&draw, &mut r);
        compare(&draw, &other, &format!("soup {i}"));
    }
}

#[test]
fn homogeneous_vertices_agree_with_the_plain_rasteriser() {
    let mut r = RasterRandom(5);
    for i in 0..40 {
        let (positions, triangles) = soup(0..KINDS, 60, &mut r);
        // Most are in front of the eye, and some behind it.
        let positions: Vec<Vec3> = positions
            .iter()
            .map(|p| Vec3::new(p.x * 3.0, p.y * 3.0, 0.5 - p.z * 4.0))
            .collect();
        let positions = homogeneous(&positions, &mut r);
        let mut draw = draw_of(&positions, &triangles);
        draw.mode = [
            Mode::Depth,
            Mode::Depth16,
            Mode::DepthPeel,
            Mode::DepthPeel16,
            Mode::StencilDepthFail,
        ][i % 5];
        draw.clip_from_world = [infinite(), perspective()][i / 5 % 2];
        draw.simd = [Simd::Native, Simd::Baseline][i / 2 % 2];
        let other = noise(&draw, &mut r);
        let texels = compare(&draw, &other, &format!("soup {i}"));
        let clear_value = draw.mode.clear_value();
        assert!(
            texels.iter().any(|&v| v != clear_value),
            "soup {i}: nothing was drawn"
        );
    }
}

#[test]
fn weight_one_makes_a_point() {
    let mut r = RasterRandom(6);
    let (positions, triangles) = soup(0..KINDS, 200, &mut r);
    let points: Vec<Vec4> = positions.iter().map(|p| p.extend(1.0)).collect();
    for clip_from_world in [perspective(), infinite()] {
        let plain = fast(
            &Draw {
                clip_from_world,
                ..draw_of(&positions, &triangles)
            },
            &[],
        )
        .0;
        assert!(
            bits(&plain)
                == bits(
                    &fast(
                        &Draw {
                            clip_from_world,
                            ..draw_of(&points, &triangles)
                        },
                        &[]
                    )
                    .0
                )
        );
    }
}

#[test]
fn a_spoilt_other_image_is_noticed() {
    let mut r = RasterRandom(8);
    let (positions, triangles) = soup(0..2, 60, &mut r);
    for mode in [Mode::DepthPeel, Mode::DepthPeel16, Mode::StencilDepthFail] {
        let draw = Draw {
            mode,
            ..draw_of(&positions, &triangles)
        };
        let (mut other, plain) = (noise(&draw, &mut r), fast(&draw, &vec![0.5; 150 * 75]).0);
        other.fill(0.5);
        // Move a covered texel from in front of everything to behind it, or back.
        let Some(i) = plain.iter().position(|&v| v != mode.clear_value()) else {
            panic!("nothing was drawn")
        };
        other[i] = if mode == Mode::StencilDepthFail {
            1.1
        } else {
            1.0
        };
        assert!(
            bits(&reference::draw(&draw, &other).0) != bits(&plain),
            "{mode:?}"
        );
    }
}

/// Returns a triangle over the whole image at a depth, a front or a back face.
fn wall(z: f32, front: bool) -> ([Vec3; 3], [u32; 3]) {
    let corners = [
        Vec3::new(-1.0, -1.0, z),
        Vec3::new(3.0, -1.0, z),
        Vec3::new(-1.0, 3.0, z),
    ];
    (corners, if front { [0, 1, 2] } else { [0, 2, 1] })
}

fn walls(of: &[(f32, bool)]) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let all = of.iter().map(|&(z, front)| wall(z, front));
    let indices = |(i, (_, t)): (usize, ([Vec3; 3], [u32; 3]))| t.map(|v| v + 3 * i as u32);
    (
        all.clone().flat_map(|(p, _)| p).collect(),
        all.enumerate().map(indices).collect(),
    )
}

const SIZE: UVec2 = UVec2::new(70, 66);

/// Returns the common value of all texels.
fn uniform(texels: &[f32]) -> f32 {
    assert_eq!(texels.len(), (SIZE.x * SIZE.y) as usize);
    assert!(texels.iter().all(|v| v == &texels[0]));
    texels[0]
}

#[test]
fn layers_peel_off_one_by_one() {
    let (positions, triangles) = walls(&[(0.5, true), (0.75, false), (0.25, true), (0.5, false)]);
    for (mode, step) in [(Mode::DepthPeel, 0.0), (Mode::DepthPeel16, 1.0 / 65_535.0)] {
        let mut layer = vec![0.0; (SIZE.x * SIZE.y) as usize];
        for expected in [0.25, 0.5, 0.75, 1.0, 1.0] {
            layer = fast(
                &Draw {
                    size: SIZE,
                    mode,
                    ..draw_of(&positions, &triangles)
                },
                &layer,
            )
            .0;
            assert!(
                (uniform(&layer) - expected).abs() <= 0.5 * step,
                "{mode:?}: {expected}"
            );
        }
    }
}

#[test]
fn counts_tell_inside_from_outside() {
    // A volume from 0.25 to 0.75, seen from the front. Points on its back are outside, points on
    // its front inside.
    let (positions, triangles) = walls(&[(0.25, true), (0.75, false)]);
    let draw = Draw {
        size: SIZE,
        mode: Mode::StencilDepthFail,
        holes: None,
        ..draw_of(&positions, &triangles)
    };
    for (z, count) in [
        (0.1, 0.0),
        (0.25, 0.0),
        (0.5, 1.0),
        (0.75, 1.0),
        (0.8, 0.0),
        (1.0, 0.0),
    ] {
        assert_eq!(
            uniform(&fast(&draw, &vec![z; (SIZE.x * SIZE.y) as usize]).0),
            count,
            "{z}"
        );
    }
}

#[test]
fn counts_wrap_and_go_on_without_clearing() {
    let (positions, triangles) = walls(&[(0.5, true); 300]);
    let other = vec![0.5; (SIZE.x * SIZE.y) as usize];
    let draw = Draw {
        size: SIZE,
        mode: Mode::StencilDepthFail,
        holes: None,
        ..draw_of(&positions, &triangles)
    };
    let mut texels = fast(&draw, &other).0;
    assert_eq!(uniform(&texels), 212.0, "-300 modulo 256");
    let target = Target {
        width: SIZE.x as usize,
        texels: &mut texels,
        ids: &mut [],
        other: &other,
        clear: false,
    };
    Rasterizer::default().draw(&draw, target);
    assert_eq!(uniform(&texels), 168.0, "-600 modulo 256");
}

#[test]
fn a_face_and_its_reverse_cancel() {
    let mut r = RasterRandom(9);
    let (positions, triangles) = soup(0..6, 600, &mut r);
    // Exclude clipped triangles. Clipping splits the two into different pieces if it removes their
    // first corner, and the planes of those round differently.
    let inside = |p: Vec3| p.truncate().abs().max_element() <= 1.0 && (0.0..=1.0).contains(&p.z);
    let whole = |t: &&[u32; 3]| t.iter().all(|&v| inside(positions[v as usize]));
    let triangles: Vec<[u32; 3]> = triangles.iter().filter(whole).copied().collect();
    let reversed: Vec<[u32; 3]> = triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    let draw = Draw {
        mode: Mode::StencilDepthFail,
        holes: None,
        ..draw_of(&positions, &triangles)
    };
    let other = noise(&draw, &mut r);
    let both = [&triangles[..], &reversed].concat();
    assert!(fast(&draw, &other).0.iter().filter(|&&n| n != 0.0).count() > 1000);
    assert!(
        fast(
            &Draw {
                triangles: &both,
                ..draw
            },
            &other
        )
        .0
        .iter()
        .all(|&n| n == 0.0)
    );
}
