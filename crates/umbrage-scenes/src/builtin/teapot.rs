//! A turned pot with a handle and a spout under a square area light.

use crate::{
    looks::{checker, glossy},
    primitives::{grid, lathe, on_circle, tile_mesh, tube},
    stage::Stage,
};
use umbrage_core::glam::{Vec2, Vec3};
use umbrage_core::{Light, Mesh, Scene};

pub(crate) fn teapot_lamp() -> Scene {
    let floor = tile_mesh(grid([12.0, 12.0], [4, 4], |_, _| 0.0), Vec2::splat(6.0));
    let stage = Stage::new("teapot-lamp").put(floor).look(checker());
    let glazed = |stage: Stage, mesh| stage.put(mesh).look(glossy([0.12, 0.34, 0.42]));
    let light = Light::Rect {
        center: Vec3::new(0.0, 9.0, 0.0),
        half_u: Vec3::X,
        half_v: Vec3::Z,
    };
    [body(), lid(), handle(), spout()]
        .into_iter()
        .fold(stage, glazed)
        .light(light)
        .shoot([5.0, 5.2, 9.0], [0.0, 1.0, 0.0], 36.0, [320, 240])
}

fn body() -> Mesh {
    let belly = [
        (0.0, 0.0),
        (1.5, 0.0),
        (1.55, 0.08),
        (1.5, 0.15),
        (1.72, 0.35),
        (1.9, 0.6),
        (1.99, 0.9),
        (1.97, 1.2),
        (1.87, 1.55),
        (1.72, 1.9),
        (1.56, 2.2),
        (1.45, 2.4),
        (1.5, 2.46),
        (1.44, 2.5),
        (1.4, 2.42),
        (0.0, 2.38),
    ];
    lathe(&belly, 96)
}

fn lid() -> Mesh {
    let dome = [
        (0.0, 2.4),
        (1.38, 2.42),
        (1.36, 2.48),
        (1.1, 2.58),
        (0.7, 2.66),
        (0.3, 2.72),
        (0.16, 2.8),
        (0.2, 2.92),
        (0.3, 3.02),
        (0.26, 3.12),
        (0.12, 3.16),
        (0.0, 3.17),
    ];
    lathe(&dome, 64)
}

/// Returns the handle: half a ring on the -x side, its ends inside the body.
fn handle() -> Mesh {
    let path: Vec<_> = (0..=32)
        .map(|i| {
            let (along, out) = on_circle(f64::from(i) / 64.0);
            (
                Vec3::new(-1.65 - 1.35 * out, 1.45 + 0.75 * along, 0.0),
                0.16,
            )
        })
        .collect();
    tube(&path, 24)
}

/// Returns the spout, which bends up on the +x side and tapers.
fn spout() -> Mesh {
    let path: Vec<_> = (0..=24)
        .map(|i| {
            let t = i as f32 / 24.0;
            // Follow an S: level where it leaves the body, steep in the middle, level at its mouth.
            let rise = t * t * (3.0 - 2.0 * t);
            (
                Vec3::new(1.6 + 1.75 * t, 0.85 + 1.55 * rise, 0.0),
                0.48 - 0.28 * t,
            )
        })
        .collect();
    tube(&path, 32)
}
