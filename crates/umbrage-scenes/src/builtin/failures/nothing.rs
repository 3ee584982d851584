//! Scenes without casters, without receivers, or without visible geometry.

use crate::{
    builtin::SIZE,
    primitives::{block, grid},
    stage::{Stage, sun},
};
use umbrage_core::Scene;
use umbrage_core::glam::Vec3;

fn block_on_floor(name: &str) -> Stage {
    Stage::new(name)
        .put(grid([4.0, 4.0], [1, 1], |_, _| 0.0))
        .put(block([-0.5, 0.0, -0.5], [0.5, 1.0, 0.5]))
        .light(sun(0.6, -1.0, 0.3))
}

const EYE: Vec3 = Vec3::new(2.5, 2.5, 4.0);

pub(crate) fn no_casters() -> Scene {
    block_on_floor("no-casters")
        .roles(false, true)
        .shoot(EYE, Vec3::ZERO, 45.0, SIZE)
}

pub(crate) fn no_receivers() -> Scene {
    block_on_floor("no-receivers")
        .roles(true, false)
        .shoot(EYE, Vec3::ZERO, 45.0, SIZE)
}

pub(crate) fn only_sky() -> Scene {
    block_on_floor("only-sky").shoot(EYE, EYE + Vec3::new(0.2, 1.0, 0.5), 45.0, SIZE)
}
