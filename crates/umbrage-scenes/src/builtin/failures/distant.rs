//! Long planes, hills, scenes far from the origin, a view towards the light.

use super::SMALL;
use crate::{
    builtin::noise::fractal,
    primitives::{block, grid, icosphere, pillar},
    stage::{Stage, bulb, sun},
};
use umbrage_core::glam::{Affine3A, Vec3};
use umbrage_core::{Light, Scene};

/// Balls along 300 m of floor under one bias. The scale of near receivers in the image is a hundred
/// times that of far ones.
fn long_plane(name: &str, light: Light) -> Scene {
    let places = (0..14).map(|i| {
        let x = -1.5 + (i % 3) as f32;
        let z = -21.0 * i as f32;
        Affine3A::from_translation(Vec3::new(x, 1.0, z))
    });
    Stage::new(name)
        .put_many(
            grid([60.0, 160.0], [1, 1], |_, _| 0.0),
            [Affine3A::from_translation(Vec3::Z * -145.0)],
        )
        .put_many(icosphere(Vec3::ZERO, 1.0, 3), places)
        .light(light)
        .shoot([6.0, 5.0, 11.0], [-1.0, 0.0, -14.0], 45.0, SMALL)
}

pub(crate) fn long_plane_sun() -> Scene {
    long_plane("long-plane", sun(0.5, -0.8, -0.4))
}

/// A point light 12 m up at the near end. Its light is at a grazing angle towards the far end.
pub(crate) fn long_plane_lamp() -> Scene {
    long_plane("long-plane-lamp", bulb(8.0, 12.0, 2.0))
}

/// Cells along each side: 8,192 triangles, few enough for shadow volumes in every frame.
const CELLS: u32 = 64;

/// Returns the height of the hills at a position, metres.
fn hill_height(x: f32, z: f32) -> f32 {
    14.0 * fractal(Vec3::new(x, 3.0, z) / 60.0, 5)
}

/// Hills of 160 m with posts on them and the sun 14 degrees high, moved along x and z by `offset`
/// metres. Positions far from the origin are rounded: to 8 mm at 1e5 m, to 6 cm at 1e6 m.
fn hills_at(name: &str, offset: f32) -> Scene {
    let place = Affine3A::from_translation(Vec3::new(offset, 0.0, -offset));
    let posts = (0..9).map(|i| {
        let x = -36.0 + 9.0 * i as f32;
        let z = 12.0 - 22.0 * (i % 3) as f32;
        place * Affine3A::from_translation(Vec3::new(x, hill_height(x, z) - 1.0, z))
    });
    let away = Vec3::from(place.translation);
    Stage::new(name)
        .put_many(grid([80.0, 80.0], [CELLS, CELLS], hill_height), [place])
        .put_many(pillar(0.5, 8.0, 16), posts)
        .light(sun(0.8, -0.23, 0.45))
        .shoot(
            away + Vec3::new(-14.0, 20.0, 62.0),
            away + Vec3::new(0.0, -2.0, 0.0),
            45.0,
            SMALL,
        )
}

pub(crate) fn hills() -> Scene {
    hills_at("hills", 0.0)
}

pub(crate) fn hills_1e5() -> Scene {
    hills_at("hills-1e5", 1e5)
}

pub(crate) fn hills_1e6() -> Scene {
    hills_at("hills-1e6", 1e6)
}

/// A view towards the sun over posts whose shadows point at the camera. The camera and the light
/// face each other, which is the degenerate case of perspective warps.
pub(crate) fn into_light() -> Scene {
    // Place three rows of five.
    let posts = (0..15).map(|i| {
        let x = -7.0 + 3.5 * (i % 5) as f32;
        let z = -4.0 - 7.0 * (i / 5) as f32;
        Affine3A::from_translation(Vec3::new(x, 0.0, z))
    });
    Stage::new("into-light")
        .put(grid([30.0, 40.0], [1, 1], |_, _| 0.0))
        .put_many(pillar(0.25, 2.2, 24), posts)
        .put(block([-1.6, 0.0, -2.2], [-0.6, 0.9, -1.2]))
        .light(sun(0.05, -0.42, 1.0))
        .shoot([0.0, 2.4, 7.0], [0.0, 0.4, -6.0], 50.0, SMALL)
}
