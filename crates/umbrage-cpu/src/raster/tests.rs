//! Bit-exact tests of the fast rasteriser against the reference rasteriser.

use crate::raster::{Draw, Mode, PlaneShift, Position, Rasterizer, Rounding, Target, reference};
use glam::{Mat4, UVec2, Vec3, Vec4};
use umbrage_core::{Cull, DepthPlanes, NO_TRIANGLE, RasterBias, Simd, Snapping};

/// Random number generator (Marsaglia: Xorshift RNGs, 2003), for the same triangles on every run.
pub(crate) struct RasterRandom(pub(crate) u64);

impl RasterRandom {
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0 >> 11
    }

    /// Returns a uniform number in `lo..hi`.
    pub(crate) fn range(&mut self, lo: f32, hi: f32) -> f32 {
        lo + (hi - lo) * (self.bits() as f64 / (1_u64 << 53) as f64) as f32
    }

    fn point(&mut self, radius: f32) -> Vec3 {
        Vec3::new(
            self.range(-radius, radius),
            self.range(-radius, radius),
            self.range(0.0, 1.0),
        )
    }
}

/// Returns a triangle of a kind that has broken rasterisers, in clip space with w = 1 (or less,
/// with `perspective`).
fn triangle(kind: usize, r: &mut RasterRandom) -> [Vec3; 3] {
    let (a, size) = (r.point(1.0), UVec2::new(150, 75).as_vec2());
    let mut near = |d: f32| a + Vec3::new(r.range(-d, d), r.range(-d, d), r.range(-0.1, 0.1));
    // Round to a pixel centre, corner or sub-pixel tie, exact in binary fractions of the window.
    let on_grid = |p: Vec3, step: f32| {
        let w = ((p.truncate() * 0.5 + 0.5) * size / step).floor() * step;
        (w / size * 2.0 - 1.0).extend(p.z)
    };
    match kind {
        0 => [a, near(1.0), near(1.0)],
        1 => [a, near(0.05), near(0.05)],
        2 => [a, near(0.004), near(0.004)],
        3 => {
            let b = near(1.0);
            [a, b, a + (b - a) * 0.5 + Vec3::new(1e-4, 2e-4, 0.0)]
        }
        4 => [near(1.0), near(1.0), near(1.0)].map(|p| on_grid(p, 0.5)),
        5 => [near(1.0), near(1.0), near(1.0)].map(|p| on_grid(p, 1.0 / 512.0)),
        6 => [a, near(200.0), near(200.0)],
        7 => [a, near(3.0), near(3.0)].map(|p| Vec3::new(p.x, p.y, p.z * 4.0 - 2.0)),
        8 => [a, a, near(1.0)],
        _ => [a + Vec3::new(2.5, 0.0, 0.0), near(3.0), near(3.0)],
    }
}

pub(super) const KINDS: usize = 10;

/// Returns random triangles: positions and indices.
pub(super) fn soup(
    kinds: std::ops::Range<usize>,
    count: usize,
    r: &mut RasterRandom,
) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let positions = (0..count)
        .flat_map(|i| triangle(kinds.start + i % kinds.len(), r))
        .collect();
    (
        positions,
        (0..count as u32)
            .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
            .collect(),
    )
}

pub(super) fn draw_of<'a, P>(positions: &'a [P], triangles: &'a [[u32; 3]]) -> Draw<'a, P> {
    Draw {
        positions,
        triangles,
        first_id: 7,
        clip_from_world: Mat4::IDENTITY,
        size: UVec2::new(150, 75),
        cull: Cull::None,
        bias: RasterBias::default(),
        mode: Mode::Depth,
        holes: None,
        simd: Simd::Native,
    }
}

/// Draws with the fast rasteriser into a spoilt image that it must clear.
pub(super) fn fast<P: Position>(draw: &Draw<'_, P>, other: &[f32]) -> reference::DrawnImages {
    fast_on(Snapping::default(), draw, other)
}

/// Draws like [`fast`], with this rounding of vertices.
fn fast_on<P: Position>(
    snapping: Snapping,
    draw: &Draw<'_, P>,
    other: &[f32],
) -> reference::DrawnImages {
    let n = (draw.size.x * draw.size.y) as usize;
    let (mut texels, mut ids) = (
        vec![0.5; n],
        vec![0; if draw.mode.has_ids() { n } else { 0 }],
    );
    let target = Target {
        width: draw.size.x as usize,
        texels: &mut texels,
        ids: &mut ids,
        other,
        clear: true,
    };
    let rounding = Rounding {
        snapping,
        ..Rounding::default()
    };
    Rasterizer::new(rounding).draw(draw, target);
    (texels, ids)
}

/// Returns the least depth.
fn depth(draw: &Draw<'_>) -> Vec<f32> {
    fast(draw, &[]).0
}

pub(super) fn bits(depth: &[f32]) -> Vec<u32> {
    depth.iter().map(|z| z.to_bits()).collect()
}

/// Panics unless both rasterisers produce the same bits, with and without ids.
fn compare(draw: &Draw<'_>, what: &str) {
    let (depth, ids) = reference::draw(draw, &[]);
    let (fast_depth, fast_ids) = fast(
        &Draw {
            mode: Mode::DepthWithIds,
            holes: None,
            ..*draw
        },
        &[],
    );
    assert!(bits(&depth) == bits(&fast_depth), "{what}: depth differs");
    assert!(ids == fast_ids, "{what}: ids differ");
    assert!(
        bits(&depth) == bits(&fast(draw, &[]).0),
        "{what}: depth without ids differs"
    );
}

/// Returns a matrix that divides by a w of about 1 to 3, and places some triangles in front of the
/// near plane.
pub(super) fn perspective() -> Mat4 {
    Mat4::from_cols_array(&[
        1.5, 0.0, 0.0, 0.0, 0.0, 1.5, 0.0, 0.0, 0.0, 0.0, 1.4, 2.0, 0.1, 0.0, -0.2, 1.0,
    ])
}

#[test]
fn single_triangles_agree_with_the_plain_rasteriser() {
    let mut r = RasterRandom(0x9e37_79b9_7f4a_7c15);
    for i in 0..3000 {
        let (positions, triangles) = soup(i % KINDS..i % KINDS + 1, 1, &mut r);
        let mut draw = draw_of(&positions, &triangles);
        if i % 3 == 0 {
            draw.clip_from_world = perspective();
        }
        compare(&draw, &format!("triangle {i}: {positions:?}"));
    }
}

#[test]
fn triangle_soups_agree_with_every_setting() {
    let mut r = RasterRandom(42);
    for i in 0..60 {
        let (positions, triangles) = soup(0..KINDS, 100, &mut r);
        let mut draw = draw_of(&positions, &triangles);
        draw.cull = [Cull::None, Cull::Front, Cull::Back][i % 3];
        draw.simd = [Simd::Native, Simd::Baseline][i % 2];
        draw.size = [
            UVec2::new(150, 75),
            UVec2::new(64, 64),
            UVec2::new(1, 130),
            UVec2::new(257, 3),
        ][i % 4];
        draw.bias = RasterBias {
            constant: [0, 2, -70_000, 1 << 20][i / 3 % 4],
            slope: [0.0, 4.0, -1.5][i / 2 % 3],
            clamp: [0.0, 1e-3, -1e-3][i / 4 % 3],
        };
        draw.clip_from_world = [Mat4::IDENTITY, perspective()][i / 5 % 2];
        compare(&draw, &format!("soup {i}"));
    }
}

/// Returns all roundings of vertices.
fn snappings() -> impl Iterator<Item = Snapping> + Clone {
    let planes = [DepthPlanes::Unsnapped, DepthPlanes::Snapped];
    Snapping::BITS.flat_map(move |sub_pixel_bits| {
        planes.map(|planes| Snapping {
            sub_pixel_bits,
            planes,
            ..Snapping::default()
        })
    })
}

#[test]
fn every_rounding_agrees_with_the_plain_rasteriser() {
    let mut r = RasterRandom(1_616);
    for (i, snapping) in snappings().cycle().take(60).enumerate() {
        let (positions, triangles) = soup(0..KINDS, 60, &mut r);
        let mut draw = draw_of(&positions, &triangles);
        draw.mode = Mode::DepthWithIds;
        draw.bias = RasterBias {
            constant: 3,
            slope: [0.0, 2.0][i % 2],
            clamp: 0.0,
        };
        draw.clip_from_world = [Mat4::IDENTITY, perspective()][i / 2 % 2];
        draw.simd = [Simd::Native, Simd::Baseline][i / 4 % 2];
        let (plain, quick) = (
            reference::draw_on(snapping, &draw, &[]),
            fast_on(snapping, &draw, &[]),
        );
        assert!(
            bits(&plain.0) == bits(&quick.0) && plain.1 == quick.1,
            "soup {i}: {snapping}"
        );
    }
}

/// Draws on the coarsest grid, with shifted depths of triangles.
fn shifted_depths(plane_shift: PlaneShift, draw: &Draw<'_, Vec4>) -> Vec<f32> {
    let n = (draw.size.x * draw.size.y) as usize;
    let mut texels = vec![0.0; n];
    let target = Target {
        width: draw.size.x as usize,
        texels: &mut texels,
        ids: &mut [],
        other: &[],
        clear: true,
    };
    let rounding = Rounding {
        snapping: Snapping::COARSEST,
        plane_shift,
        ..Rounding::default()
    };
    Rasterizer::new(rounding).draw(draw, target);
    texels
}

#[test]
fn triangles_of_even_and_odd_numbers_are_moved_apart() {
    // Draw two slanted triangles, left and right of the centre.
    let positions = [
        Vec4::new(-1.0, -1.0, 0.25, 1.0),
        Vec4::new(0.0, -1.0, 0.25, 1.0),
        Vec4::new(-1.0, 1.0, 0.75, 1.0),
        Vec4::new(0.0, -1.0, 0.25, 1.0),
        Vec4::new(1.0, -1.0, 0.25, 1.0),
        Vec4::new(0.0, 1.0, 0.75, 1.0),
    ];
    let draw = Draw {
        first_id: 0,
        size: UVec2::splat(32),
        ..draw_of(&positions, &[[0, 1, 2], [3, 4, 5]])
    };
    let plain = shifted_depths(PlaneShift::NONE, &draw);
    let apart = PlaneShift {
        even: 1.0,
        odd: -1.0,
    };
    let moved = shifted_depths(apart, &draw);
    let below_middle = 28 * 32;
    let even = below_middle + 2;
    let odd = below_middle + 18;
    assert!(moved[even] > plain[even] && moved[even] < plain[even] + 1e-4);
    assert!(moved[odd] < plain[odd] && moved[odd] > plain[odd] - 1e-4);
}

/// A floor starts behind the eye, just below it. All its corners snap to one row of the grid, but
/// its part in front of the eye covers pixels. Devices may draw these with any depth, or not at
/// all.
#[test]
fn triangles_without_area_on_the_grid_may_have_any_depth() {
    let positions = [
        Vec4::new(-4.0, -0.006, -5.505, -5.5),
        Vec4::new(4.0, -0.006, -5.505, -5.5),
        Vec4::new(3.0, -0.006, 6.495, 6.5),
    ];
    let all = |even: f32| PlaneShift { even, odd: even };
    let covered = |depth: Vec<f32>| depth.iter().filter(|z| **z < 0.01).count();
    // The visible face is undefined.
    for cull in [Cull::None, Cull::Front, Cull::Back] {
        let draw = Draw {
            size: UVec2::splat(32),
            cull,
            ..draw_of(&positions, &[[0, 1, 2]])
        };
        assert_eq!(covered(shifted_depths(PlaneShift::NONE, &draw)), 0);
        assert!(covered(shifted_depths(all(-1.0), &draw)) > 100, "{cull:?}");
        assert_eq!(covered(shifted_depths(all(1.0), &draw)), 0);
    }
}

/// The right edge of a triangle is slightly right of a column of pixel centres. Snapping moves it
/// onto the column or a whole step farther right. Depths change only if planes go through snapped
/// vertices.
#[test]
fn coarse_grids_move_edges_and_some_planes() {
    let (size, column) = (UVec2::splat(64), 40);
    for snapping in snappings() {
        // 0.4 steps right of the column, the edge snaps onto it and the column is not covered. At
        // 0.6 steps, it snaps a whole step to the right.
        for (steps, covered) in [(0.4, false), (0.6, true)] {
            let right = column as f32 + 0.5 + steps * snapping.step();
            let corner = |x: f32, y: f32, z: f32| Vec3::new(x / 32.0 - 1.0, 1.0 - y / 32.0, z);
            let positions = [
                corner(8.5, 32.5, 0.25),
                corner(right, 64.0, 0.75),
                corner(right, 0.0, 0.75),
            ];
            let draw = Draw {
                size,
                ..draw_of(&positions, &[[0, 1, 2]])
            };
            let depth = fast_on(snapping, &draw, &[]).0;
            assert_eq!(
                depth[32 * 64 + column] < 1.0,
                covered,
                "{snapping}: {steps} steps"
            );
            let width = match snapping.planes {
                DepthPlanes::Unsnapped => right - 8.5,
                DepthPlanes::Snapped => right - 8.5 + (steps.round() - steps) * snapping.step(),
            };
            // With a plane that is half a step of the finest grid off, the depth would be 8e-6 off.
            // Rounding is below 1e-6.
            let expected = 0.25 + 0.5 * 30.0 / width;
            assert!(
                (depth[32 * 64 + 38] - expected).abs() < 1e-6,
                "{snapping}: {steps} steps"
            );
        }
    }
}

#[test]
fn the_widest_and_the_highest_images_agree() {
    let mut r = RasterRandom(3);
    for size in [UVec2::new(16_384, 2), UVec2::new(2, 16_384)] {
        let (positions, triangles) = soup(0..KINDS, 40, &mut r);
        compare(
            &Draw {
                size,
                ..draw_of(&positions, &triangles)
            },
            &format!("{size}"),
        );
    }
}

#[test]
fn a_spoilt_triangle_is_noticed() {
    let mut r = RasterRandom(1);
    let (positions, triangles) = soup(0..2, 20, &mut r);
    let mut moved = positions.clone();
    moved[0].x += 2.0 / 150.0;
    let (plain, _) = reference::draw(&draw_of(&positions, &triangles), &[]);
    assert!(bits(&plain) != bits(&depth(&draw_of(&moved, &triangles))));
}

#[test]
fn many_batches_and_shared_vertices_agree() {
    // Draw more triangles than a batch of a small image, with vertices both shared and far apart in
    // the list.
    let mut r = RasterRandom(77);
    let side = 60_u32;
    let positions: Vec<Vec3> = (0..side * side)
        .map(|i| {
            Vec3::new(
                (i % side) as f32 / 30.0 - 1.0,
                (i / side) as f32 / 30.0 - 1.0,
                r.range(0.2, 0.8),
            )
        })
        .collect();
    let cells = (0..side - 1).flat_map(|y| (0..side - 1).map(move |x| y * side + x));
    let mut triangles: Vec<[u32; 3]> = cells
        .flat_map(|i| [[i, i + 1, i + side], [i + side, i + 1, i + side + 1]])
        .collect();
    triangles.extend((0..300).map(|i| [i, side * side - 1 - i, 7 * i % 3000]));
    compare(&draw_of(&positions, &triangles), "grid");
}

#[test]
fn the_top_left_rule_leaves_neither_gaps_nor_doubles() {
    // Each pixel of a fan whose edges run through pixel centres belongs to one triangle: the sum of
    // covers is 1.
    let corner = |x: f32, y: f32| Vec3::new(x / 32.0 - 1.0, 1.0 - y / 32.0, 0.5);
    let middle = corner(32.5, 32.5);
    let rim = [
        [0.5, 0.5],
        [32.5, 0.5],
        [63.5, 0.5],
        [63.5, 32.5],
        [63.5, 63.5],
        [32.5, 63.5],
        [0.5, 63.5],
        [0.5, 32.5],
    ];
    let mut covers = vec![0; 64 * 64];
    for i in 0..rim.len() {
        let [a, b] = [rim[i], rim[(i + 1) % rim.len()]].map(|p: [f32; 2]| corner(p[0], p[1]));
        let positions = [middle, a, b];
        let draw = Draw {
            size: UVec2::splat(64),
            ..draw_of(&positions, &[[0, 1, 2]])
        };
        depth(&draw)
            .iter()
            .zip(&mut covers)
            .for_each(|(&z, n)| *n += u32::from(z < 1.0));
    }
    for (i, &n) in covers.iter().enumerate() {
        // The fan's own right and bottom border at 63.5 is outside.
        let inside = i % 64 < 63 && i / 64 < 63;
        assert_eq!(n, u32::from(inside), "pixel {}, {}", i % 64, i / 64);
    }
}

#[test]
fn faces_are_culled_by_their_turn_on_screen() {
    let positions = [
        Vec3::new(-0.5, -0.5, 0.5),
        Vec3::new(0.5, -0.5, 0.5),
        Vec3::new(0.0, 0.5, 0.5),
    ];
    let drawn = |triangle: [u32; 3], cull| {
        depth(&Draw {
            cull,
            ..draw_of(&positions, &[triangle])
        })
        .iter()
        .any(|&z| z < 1.0)
    };
    let (front, back) = ([0, 1, 2], [0, 2, 1]);
    assert!(drawn(front, Cull::None) && drawn(back, Cull::None));
    assert!(!drawn(front, Cull::Front) && drawn(back, Cull::Front));
    assert!(drawn(front, Cull::Back) && !drawn(back, Cull::Back));
}

/// A wall seen edge-on by a vertical sun extends beyond the far plane and the image. Clipping
/// rounds a piece of it to a front face, the grid to a back face. Mesa's drivers draw it only
/// without culling. (Found by a random scene.)
#[test]
fn pieces_are_culled_as_clipped_and_as_moved_to_the_grid() {
    let positions = [
        Vec3::new(-0.649_832_96, -0.824_291_77, 1.031_084_5),
        Vec3::new(-0.741_049_77, 1.256_222_4, 0.260_613_02),
        Vec3::new(-0.649_832_96, -0.824_291_77, 0.260_613_02),
    ];
    for (cull, covered) in [(Cull::None, 1), (Cull::Front, 0), (Cull::Back, 0)] {
        let draw = Draw {
            size: UVec2::splat(44),
            cull,
            ..draw_of(&positions, &[[0, 1, 2]])
        };
        let count = depth(&draw).iter().filter(|&&z| z < 1.0).count();
        assert_eq!(count, covered, "{cull:?}");
        compare(&draw, "a wall");
    }
}

#[test]
fn slope_bias_moves_a_slanted_plane_by_its_slope() {
    // z grows by 1/64 per pixel to the right over 32 pixels: slope 2 adds 2/64 everywhere, and the
    // clamp limits it.
    let positions = [
        Vec3::new(-1.0, -3.0, 0.25),
        Vec3::new(-1.0, 3.0, 0.25),
        Vec3::new(1.0, 0.0, 0.75),
    ];
    let biased = |slope, clamp| {
        let bias = RasterBias {
            constant: 0,
            slope,
            clamp,
        };
        depth(&Draw {
            size: UVec2::splat(32),
            bias,
            ..draw_of(&positions, &[[0, 1, 2]])
        })[16 * 32 + 10]
    };
    let plain = biased(0.0, 0.0);
    assert!((biased(2.0, 0.0) - plain - 2.0 / 64.0).abs() < 1e-6);
    assert!((biased(2.0, 0.01) - plain - 0.01).abs() < 1e-6);
    assert!((biased(-2.0, -0.01) - plain + 0.01).abs() < 1e-6);
}

#[test]
fn equal_depths_show_the_first_triangle() {
    let positions = [
        Vec3::new(-1.0, -1.0, 0.5),
        Vec3::new(1.0, -1.0, 0.5),
        Vec3::new(0.0, 1.0, 0.5),
    ];
    let triangles = [[0, 1, 2], [2, 0, 1], [0, 2, 1]];
    let (_, ids) = fast(
        &Draw {
            mode: Mode::DepthWithIds,
            holes: None,
            ..draw_of(&positions, &triangles)
        },
        &[],
    );
    assert!(ids.iter().all(|&id| id == 7 || id == NO_TRIANGLE) && ids.contains(&7));
}

#[test]
fn drawing_again_without_clearing_keeps_the_least() {
    let near = [
        Vec3::new(-1.0, -1.0, 0.25),
        Vec3::new(0.0, -1.0, 0.25),
        Vec3::new(-1.0, 1.0, 0.25),
    ];
    let far = [
        Vec3::new(-1.0, -1.0, 0.75),
        Vec3::new(1.0, -1.0, 0.75),
        Vec3::new(0.0, 1.0, 0.75),
    ];
    let (mut depth, size) = (vec![0.0; 64 * 64], UVec2::splat(64));
    for (positions, clear) in [(&near, true), (&far, false)] {
        let target = Target {
            width: 64,
            texels: &mut depth,
            ids: &mut [],
            other: &[],
            clear,
        };
        Rasterizer::default().draw(
            &Draw {
                size,
                ..draw_of(positions, &[[0, 1, 2]])
            },
            target,
        );
    }
    let both: Vec<Vec3> = near.into_iter().chain(far).collect();
    let expected = reference::draw(
        &Draw {
            size,
            ..draw_of(&both, &[[0, 1, 2], [3, 4, 5]])
        },
        &[],
    );
    assert!(bits(&depth) == bits(&expected.0));
}
