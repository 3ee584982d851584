//! Ten thousand boxes along streets.

use super::{SIZE, area_sun};
use crate::{
    builtin::noise::uniform,
    primitives::{block, grid},
    stage::{Stage, sun},
};
use umbrage_core::glam::{Affine3A, IVec3, Quat, Vec3};
use umbrage_core::{Light, Scene};

/// Number of houses along each side of the town.
const SIDE: i32 = 100;
/// Distance between houses, metres.
const PITCH: f32 = 14.0;

pub(crate) fn town() -> Scene {
    lit_by("town", sun(0.75, -0.5, 0.35))
}

pub(crate) fn town_soft() -> Scene {
    lit_by("town-soft", area_sun(0.75, -0.5, 0.35))
}

fn lit_by(name: &str, light: Light) -> Scene {
    let half = 0.5 * PITCH * (SIDE as f32 + 2.0);
    let houses = (0..SIDE).flat_map(|i| (0..SIDE).map(move |k| house(i, k)));
    Stage::new(name)
        .put(grid([half, half], [32, 32], |_, _| 0.0))
        .put_many(block([-0.5, 0.0, -0.5], [0.5, 1.0, 0.5]), houses)
        .light(light)
        .shoot([-260.0, 170.0, 520.0], [0.0, 0.0, 40.0], 45.0, SIZE)
}

/// Returns the placement of a unit box. Every fifth row and column is shifted, for a wider street.
fn house(i: i32, k: i32) -> Affine3A {
    let random = |what: i32| uniform(IVec3::new(i, k, what));
    // Apply a power, so that most houses are low.
    let height = 5.0 + 45.0 * random(0).powi(6) + 6.0 * random(1);
    let size = Vec3::new(7.0 + 3.0 * random(2), height, 7.0 + 3.0 * random(3));
    let turn = Quat::from_rotation_y(0.08 * (random(4) - 0.5));
    let place = Vec3::new(along_town(i), 0.0, along_town(k));
    Affine3A::from_scale_rotation_translation(size, turn, place)
}

/// Returns the x or z of a row or column of houses, metres.
fn along_town(i: i32) -> f32 {
    let push = if i % 5 == 0 { 1.5 } else { 0.0 };
    PITCH * (i as f32 - 0.5 * (SIDE as f32 - 1.0)) + push
}
