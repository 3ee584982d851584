//! Detail near the size of a texel: thin slices, thin wires, feet just above the floor.

use super::SMALL;
use crate::{
    primitives::{block, grid, icosphere, lathe, pillar},
    stage::{Stage, sun},
};
use umbrage_core::glam::{Affine3A, Vec3};
use umbrage_core::{Mesh, Scene};

/// Six slices of 6 mm, 5 cm above each other. Each is smaller than the one below, so that a rim of
/// every slice is visible: lit outside, dark in the shadow of the slices above. Moments of several
/// depths blend; a bias of 5 cm confuses neighbouring slices.
pub(crate) fn stacked_slices() -> Scene {
    let mut stage = Stage::new("stacked-slices").put(grid([3.0, 3.0], [1, 1], |_, _| 0.0));
    for i in 0..6 {
        let y = 0.1 + 0.05 * i as f32;
        let half = 1.1 - 0.16 * i as f32;
        stage = stage.put(block([-half, y, -half], [half, y + 0.006, half]));
    }
    stage
        .put_many(
            pillar(0.04, 1.1, 16),
            [Affine3A::from_translation(Vec3::new(-0.1, 0.3, 0.1))],
        )
        .light(sun(0.7, -1.0, -0.3))
        .shoot([1.5, 1.7, 2.4], [0.05, 0.2, 0.0], 42.0, SMALL)
}

/// Height of the feet's soles over the floor, metres.
const HOVER: f32 = 0.01;

/// Pairs of feet 1 cm above the floor under bodies at 1 m. Near the rim of each foot, a filter
/// finds both depths, and light leaks at the contact, where it is most visible.
pub(crate) fn hovering_feet() -> Scene {
    let foot = [
        (0.0, HOVER),
        (0.1, HOVER),
        (0.11, HOVER + 0.05),
        (0.05, 0.3),
        (0.05, 0.9),
        (0.0, 0.9),
    ];
    let places = [
        Affine3A::from_translation(Vec3::new(-0.9, 0.0, 0.2)),
        Affine3A::from_translation(Vec3::new(-0.6, 0.0, 0.0)),
        Affine3A::from_translation(Vec3::new(0.4, 0.0, 0.3)),
        Affine3A::from_translation(Vec3::new(0.7, 0.0, 0.1)),
    ];
    Stage::new("hovering-feet")
        .put(grid([3.0, 3.0], [1, 1], |_, _| 0.0))
        .put_many(lathe(&foot, 32), places)
        .put(icosphere([-0.75, 1.2, 0.1], 0.4, 3))
        .put(block([0.3, 0.9, 0.0], [0.8, 1.5, 0.4]))
        .light(sun(0.45, -1.0, -0.35))
        .shoot([0.5, 1.1, 2.3], [0.0, 0.2, 0.05], 42.0, SMALL)
}

/// Returns a rail whose underside is `y` metres above the floor.
fn fence_rail(y: f32) -> Mesh {
    block([-2.45, y, -0.01], [2.45, y + 0.02, 0.01])
}

/// A fence of upright wires 12 mm thick and three rails. Each is one to two pixels wide in the
/// image, and about as many texels in a map of 1,024.
pub(crate) fn fence() -> Scene {
    let wires = (0..61).map(|i| {
        let x = -2.4 + 0.08 * i as f32;
        Affine3A::from_translation(Vec3::new(x, 0.0, 0.0))
    });
    Stage::new("fence")
        .put(grid([4.0, 4.0], [1, 1], |_, _| 0.0))
        .put_many(pillar(0.006, 1.2, 8), wires)
        .put(fence_rail(0.15))
        .put(fence_rail(0.6))
        .put(fence_rail(1.1))
        .light(sun(0.35, -1.0, 0.9))
        .shoot([1.2, 1.9, 3.4], [0.0, 0.25, 0.4], 44.0, SMALL)
}
