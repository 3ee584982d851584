//! Tests of a G-buffer computed from depth alone.

use crate::{
    foreign::{Foreign, read, read_four},
    scene::{BackendScene, gpu},
};
use glam::{Mat4, Vec3, Vec4};
use umbrage_core::{NO_TRIANGLE, Receivers};
use umbrage_wgpu::{DepthBuffer, GBufferFromDepth, wgpu::TextureFormat};

/// Positions, normals, and the number of pixels that have them.
struct SeenPixels {
    positions: Vec<Vec4>,
    normals: Vec<Vec4>,
}

/// Computes a G-buffer. `reverse` maps z to 1 - z, `mirror` flips the world's x, as in a
/// left-handed engine.
fn unproject(stage: &BackendScene, r: &Receivers, reverse_mirror: [bool; 2]) -> SeenPixels {
    let [reverse, mirror] = reverse_mirror;
    let foreign = Foreign::new();
    let depth: Vec<f32> = r
        .depth
        .iter()
        .map(|&z| if reverse { 1.0 - z } else { z })
        .collect();
    let depth = foreign.texture(
        TextureFormat::R32Float,
        r.size,
        bytemuck::cast_slice(&depth),
    );
    let mut clip_from_world = stage.camera.space().clip_from_world();
    if reverse {
        let one_minus_z =
            Mat4::from_cols(Vec4::X, Vec4::Y, Vec4::NEG_Z, Vec4::new(0.0, 0.0, 1.0, 1.0));
        clip_from_world = one_minus_z * clip_from_world;
    }
    if mirror {
        clip_from_world *= Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0));
    }
    let world_from_clip = clip_from_world.as_dmat4().inverse().as_mat4();
    let empty = if reverse { 0.0 } else { 1.0 };
    let mut maker = GBufferFromDepth::new(&foreign.device, &foreign.queue);
    for _ in 0..2 {
        let source = DepthBuffer {
            depth: &depth,
            world_from_clip,
            empty,
        };
        maker.prepare(&source).expect("the camera is a camera");
    }
    assert_eq!(
        (maker.counters().pipelines, maker.counters().textures),
        (1, 2),
        "the second frame makes nothing"
    );
    assert_eq!(maker.size(), r.size);
    let mut encoder = foreign.encoder();
    let gbuffer = maker.encode(&mut encoder).expect("it was prepared");
    let position = gbuffer.position.texture();
    let normal = gbuffer.normal.texture();
    let positions = read_four(&foreign, encoder, position);
    SeenPixels {
        positions,
        normals: read_four(&foreign, foreign.encoder(), normal),
    }
}

/// Returns whether two neighbours in each direction show the same plane: edges may be inaccurate.
fn is_on_one_plane(r: &Receivers, i: usize) -> bool {
    let w = r.size.x as i32;
    let h = r.size.y as i32;
    let x = i as i32 % w;
    let y = i as i32 / w;
    (-2..=2).all(|d| {
        [(x + d, y), (x, y + d)].iter().all(|&(x, y)| {
            let inside = x >= 0 && y >= 0 && x < w && y < h;
            // The planes here, floor and plate, are 1 m apart.
            let same = |j: usize| r.normal(j) == r.normal(i) && (r.y[j] - r.y[i]).abs() < 0.5;
            !inside || same((y * w + x) as usize)
        })
    })
}

#[test]
fn positions_and_normals_come_from_depth() {
    let stage = BackendScene::new();
    let r = stage
        .render(&mut gpu(), &stage.recipe(8))
        .receivers
        .expect("the view had none");
    for (reverse, mirror) in [(false, false), (true, false), (false, true), (true, true)] {
        let seen = unproject(&stage, &r, [reverse, mirror]);
        let flip = Vec3::new(if mirror { -1.0 } else { 1.0 }, 1.0, 1.0);
        let mut tested = 0;
        for i in 0..r.len() {
            assert_eq!(
                seen.positions[i].w,
                f32::from(u8::from(r.triangle[i] != NO_TRIANGLE)),
                "pixel {i}"
            );
            if r.triangle[i] == NO_TRIANGLE || !is_on_one_plane(&r, i) {
                continue;
            }
            // Depth has a step of 6e-8, which is 1e-5 m at 10 m with near at 0.5 m. A position
            // combines three such errors.
            let position = seen.positions[i].truncate() * flip;
            let normal = seen.normals[i].truncate() * flip;
            assert!(
                position.distance(r.position(i)) < 1e-4,
                "{position} is not {}",
                r.position(i)
            );
            // Neighbours are about 0.1 m apart, so their steps turn a normal by up to 1e-3.
            assert!(
                normal.distance(r.normal(i)) < 5e-3,
                "{normal} is not {} at {i}",
                r.normal(i)
            );
            tested += 1;
        }
        assert!(
            tested > r.len() / 4,
            "{tested} of {} pixels tested",
            r.len()
        );
    }
}

#[test]
fn a_singular_camera_is_refused() {
    let stage = BackendScene::new();
    let foreign = Foreign::new();
    let depth = foreign.texture(
        TextureFormat::R32Float,
        stage.camera.size,
        &vec![0; 97 * 61 * 4],
    );
    let source = DepthBuffer {
        depth: &depth,
        world_from_clip: Mat4::ZERO,
        empty: 1.0,
    };
    let mut maker = GBufferFromDepth::new(&foreign.device, &foreign.queue);
    let error = maker.prepare(&source).expect_err("zero is no camera");
    assert!(error.to_string().contains("world from clip"), "{error}");
    assert!(maker.encode(&mut foreign.encoder()).is_err());
    assert!(
        read(&foreign, foreign.encoder(), depth.texture())
            .iter()
            .all(|&v| v == 0.0)
    );
}
