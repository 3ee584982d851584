//! Bodies of few facets.

use super::SMALL;
use crate::{
    primitives::{grid, icosphere},
    stage::{Stage, sun},
};
use umbrage_core::Scene;
use umbrage_core::glam::{Affine3A, Vec3};

/// Balls of 80 facets with different turns in a sun 20 degrees high. Near the terminator, light
/// grazes whole facets. These cover a large range of depths in each texel.
pub(crate) fn low_poly() -> Scene {
    let balls = (0..6).map(|i| {
        let x = -2.4 + 2.4 * (i % 3) as f32;
        let z = if i < 3 { -1.2 } else { 1.2 };
        Affine3A::from_translation(Vec3::new(x, 1.0, z))
            * Affine3A::from_rotation_y(0.37 * i as f32)
            * Affine3A::from_rotation_x(0.21 * i as f32)
    });
    Stage::new("low-poly")
        .put(grid([6.0, 5.0], [1, 1], |_, _| 0.0))
        .put_many(icosphere(Vec3::ZERO, 0.9, 1), balls)
        .light(sun(0.85, -0.36, -0.38))
        .shoot([1.4, 4.2, 8.2], [0.2, 0.7, 0.0], 40.0, SMALL)
}
