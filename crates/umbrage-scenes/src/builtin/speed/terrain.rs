//! A million triangles of hills.

use super::SIZE;
use crate::{
    builtin::noise::fractal,
    primitives::grid,
    stage::{Stage, sun},
};
use umbrage_core::Scene;
use umbrage_core::glam::Vec3;

/// Cells along each side, two triangles each: 1,002,528.
const CELLS: u32 = 708;

pub(crate) fn terrain() -> Scene {
    let height = |x: f32, z: f32| 90.0 * fractal(Vec3::new(x, 0.0, z) / 180.0, 8);
    Stage::new("terrain")
        .put(grid([500.0, 500.0], [CELLS, CELLS], height))
        .light(sun(0.8, -0.45, 0.4))
        .shoot([-120.0, 190.0, 560.0], [0.0, -30.0, 0.0], 50.0, SIZE)
}
