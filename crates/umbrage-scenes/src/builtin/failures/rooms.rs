//! A room without openings, and a caster close to its light.

use crate::{
    builtin::SIZE,
    primitives::{block, grid, pillar, slabs_around},
    stage::{Stage, sun},
};
use umbrage_core::glam::{Affine3A, Vec3};
use umbrage_core::{Light, Scene};

/// Thickness of the walls: about one texel of a map of 1,024 that is fitted to the room.
const WALL: f32 = 0.008;

/// Six slabs around a space of 4 x 3 x 4 m, a table inside, the sun outside.
pub(crate) fn sealed_room() -> Scene {
    let at = Vec3::new;
    slabs_around(at(-2.0, 0.0, -2.0), at(2.0, 3.0, 2.0), WALL)
        .into_iter()
        .fold(Stage::new("sealed-room"), Stage::put)
        .put(block(at(-1.4, 0.7, -1.0), at(-0.2, 0.75, 0.4)))
        .light(sun(1.0, -2.0, 0.5))
        .shoot(at(1.8, 1.7, 1.8), at(-0.6, 1.2, -0.6), 70.0, SIZE)
}

/// A bar 1 cm below the light and 4 mm wide, whose shadow is more than a metre wide. A near plane
/// beyond the bar loses it.
pub(crate) fn bar_at_lamp() -> Scene {
    let lamp = Vec3::new(0.0, 3.0, 0.0);
    let bar = block(
        lamp + Vec3::new(-0.002, -0.011, -0.02),
        lamp + Vec3::new(0.002, -0.01, 0.02),
    );
    let [inner, outer] = [35.0_f32, 40.0].map(f32::to_radians);
    Stage::new("bar-at-lamp")
        .put(grid([4.0, 4.0], [1, 1], |_, _| 0.0))
        .put(bar)
        .put_many(
            pillar(0.2, 0.8, 32),
            [Affine3A::from_translation(Vec3::new(1.2, 0.0, 0.4))],
        )
        .light(Light::Spot {
            position: lamp,
            direction: Vec3::NEG_Y,
            inner,
            outer,
            radius: 0.0,
        })
        .shoot([2.2, 2.4, 4.6], [0.0, 0.1, 0.0], 46.0, SIZE)
}
