//! Differential tests of peeling and counting many faces, compared with drawing each face
//! separately.

use crate::scene::{BackendScene, gpu};
use glam::{DMat4, UVec2, Vec3, Vec4};
use std::sync::Arc;
use umbrage_core::{Cast, CastMode, Faces, Format, ImageDesc, LightSpace, Recipe, Source};

const COUNT: usize = 60;
const SIDE: u32 = 48;

/// Returns a small integer hash, -1 to 1.
fn noise(i: usize) -> f32 {
    let h = (i as u32).wrapping_mul(0x9e37_79b9);
    ((h ^ (h >> 15)).wrapping_mul(0x85eb_ca6b) >> 8) as f32 / (1 << 23) as f32 - 1.0
}

/// Returns triangles around the origin. Some cross the frustum's planes, and every seventh has a
/// corner at infinity.
fn triangles() -> Vec<[Vec4; 3]> {
    let mut out = Vec::new();
    for i in 0..COUNT {
        let mut last = corner(3 * i + 2);
        if i % 7 == 3 {
            last.w = 0.0;
        }
        out.push([corner(3 * i), corner(3 * i + 1), last]);
    }
    out
}

fn corner(i: usize) -> Vec4 {
    let p = Vec3::new(noise(3 * i), noise(3 * i + 1), noise(3 * i + 2));
    (p * 5.0).extend(1.0)
}

fn faces(triangles: &[[Vec4; 3]]) -> Source {
    let indices = (0..triangles.len() as u32)
        .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
        .collect();
    Source::Faces(Arc::new(Faces {
        vertices: triangles.concat(),
        triangles: indices,
    }))
}

fn image(label: &'static str, layers: u32, format: Format) -> ImageDesc {
    ImageDesc {
        label,
        size: UVec2::splat(SIDE),
        layers,
        format,
    }
}

/// Renders the depths of each triangle separately.
fn render_alone(stage: &BackendScene, space: LightSpace, format: Format) -> Vec<Vec<f32>> {
    let mut casts = Vec::new();
    for (layer, triangle) in (0..).zip(triangles()) {
        casts.push(Cast {
            source: faces(&[triangle]),
            ..Cast::nearest(0, layer, space)
        });
    }
    let recipe = Recipe {
        images: vec![image("alone", COUNT as u32, format)],
        casts,
        ..stage.recipe(SIDE)
    };
    let images = stage.render(&mut gpu(), &recipe).images;
    images[0]
        .texels
        .chunks_exact((SIDE * SIDE) as usize)
        .map(<[f32]>::to_vec)
        .collect()
}

#[test]
fn peels_are_the_least_the_second_least_and_so_on() {
    let stage = BackendScene::new();
    for (space, format) in [
        (stage.camera.space(), Format::Depth32),
        (stage.tilted_space(), Format::Depth32),
        (stage.camera.space(), Format::Depth16),
    ] {
        let alone = render_alone(&stage, space, format);
        let all = triangles();
        let nearest = Cast {
            source: faces(&all),
            ..Cast::nearest(0, 0, space)
        };
        let mut casts = vec![nearest.clone()];
        for image in 1..4 {
            casts.push(Cast {
                image,
                mode: CastMode::DepthPeel(image - 1),
                ..nearest.clone()
            });
        }
        let recipe = Recipe {
            images: vec![image("peel", 1, format); 4],
            casts,
            ..stage.recipe(SIDE)
        };
        let images = stage.render(&mut gpu(), &recipe).images;
        let mut layered = 0;
        for texel in 0..(SIDE * SIDE) as usize {
            let mut depths: Vec<f32> = alone
                .iter()
                .map(|layer| layer[texel])
                .filter(|&d| d < 1.0)
                .collect();
            depths.sort_by(f32::total_cmp);
            depths.dedup();
            for (peel, image) in images.iter().enumerate() {
                let expected = depths.get(peel).copied().unwrap_or(1.0);
                assert_eq!(
                    image.texels[texel], expected,
                    "{format:?}, texel {texel}, peel {peel}"
                );
            }
            layered += usize::from(depths.len() > 3);
        }
        assert!(layered > 500, "{layered} texels have all four layers");
    }
}

/// Returns 1 for a visible front face, -1 for a visible back face: counter-clockwise on screen is
/// front.
fn facing_sign(clip_from_world: DMat4, triangle: &[Vec4; 3]) -> i32 {
    let [a, b, c] = triangle
        .map(|v| clip_from_world * v.as_dvec4())
        .map(|v| glam::DVec3::new(v.x, v.y, v.w));
    if a.dot(b.cross(c)) > 0.0 { 1 } else { -1 }
}

#[test]
fn counts_are_backs_minus_fronts_that_are_not_before() {
    let stage = BackendScene::new();
    let space = stage.camera.space();
    let alone = render_alone(&stage, space, Format::Depth32);
    let all = triangles();
    let mode = CastMode::StencilDepthFail { depth: 0 };
    let recipe = Recipe {
        images: vec![
            image("depth", 1, Format::Depth32),
            image("counts", 1, Format::Stencil8),
        ],
        casts: vec![
            Cast::nearest(0, 0, space),
            Cast {
                mode,
                source: faces(&all[..20]),
                ..Cast::nearest(1, 0, space)
            },
            Cast {
                mode,
                source: faces(&all[20..]),
                ..Cast::nearest(1, 0, space)
            },
        ],
        ..stage.recipe(SIDE)
    };
    let images = stage.render(&mut gpu(), &recipe).images;
    let clip_from_world = space.clip_from_world().as_dmat4();
    let mut kinds = std::collections::BTreeSet::new();
    for (texel, &stored) in images[0].texels.iter().enumerate() {
        // Skip texels at depth 1: they are empty, or at that depth.
        if stored == 1.0 {
            continue;
        }
        let fails = all
            .iter()
            .zip(&alone)
            .filter(|(_, z)| z[texel] < 1.0 && z[texel] >= stored);
        let sum: i32 = fails.map(|(t, _)| -facing_sign(clip_from_world, t)).sum();
        assert_eq!(
            images[1].texels[texel],
            sum.rem_euclid(256) as f32,
            "texel {texel}"
        );
        kinds.insert(sum);
    }
    assert!(
        kinds.len() > 4 && kinds.iter().any(|&k| k < 0),
        "only these sums occur: {kinds:?}"
    );
}
