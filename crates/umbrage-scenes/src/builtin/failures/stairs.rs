//! Stairs with a post through them, and a caster beyond the light.

use crate::{
    builtin::SIZE,
    primitives::{block, grid, icosphere, pillar, prism},
    stage::{Stage, sun},
};
use umbrage_core::glam::{Affine3A, Vec3};
use umbrage_core::{Light, Scene};

/// Eight steps of .3 x .18 m that climb towards -x.
fn steps() -> Vec<(f32, f32)> {
    const STEPS: i32 = 8;
    let mut outline = vec![(-1.2, 0.0), (1.2, 0.0)];
    for i in 0..STEPS {
        let rise = 0.18 * (i + 1) as f32;
        outline.extend([
            (1.2 - 0.3 * i as f32, rise),
            (1.2 - 0.3 * (i + 1) as f32, rise),
        ]);
    }
    outline
}

fn staircase(name: &str) -> Stage {
    Stage::new(name)
        .put(grid([5.0, 5.0], [1, 1], |_, _| 0.0))
        .put(prism(&steps(), 1.0, -1.0))
        .put_many(
            pillar(0.05, 2.2, 24),
            [Affine3A::from_translation(Vec3::new(0.1, 0.0, 0.3))],
        )
        .put(icosphere([0.75, 0.79, -0.4], 0.25, 4))
        .put(block([-0.9, 1.44, -0.7], [-0.5, 1.9, -0.2]))
}

pub(crate) fn stairs() -> Scene {
    staircase("stairs")
        .light(sun(0.7, -1.3, 0.8))
        .shoot(EYE, TARGET, 38.0, SIZE)
}

/// A light above the steps, and a slab above the light, which must not cast a shadow downwards.
pub(crate) fn stairs_lamp() -> Scene {
    let [inner, outer] = [40.0_f32, 45.0].map(f32::to_radians);
    let position = Vec3::new(0.2, 3.4, -0.2);
    let direction = Vec3::new(0.05, -1.0, 0.1);
    staircase("stairs-lamp")
        .put(block([-0.4, 3.9, -0.8], [0.8, 4.0, 0.4]))
        .light(Light::Spot {
            position,
            direction,
            inner,
            outer,
            radius: 0.0,
        })
        .shoot(EYE, TARGET, 38.0, SIZE)
}

const EYE: Vec3 = Vec3::new(4.2, 3.2, 4.0);
const TARGET: Vec3 = Vec3::new(0.2, 0.6, 0.1);
