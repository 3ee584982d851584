//! Alpha-tested casters.

use super::SMALL;
use crate::{
    builtin::crowns::{Crown, crown},
    looks::{matte, netting, sprig},
    primitives::{grid, pillar, quad, tile_mesh},
    stage::{Stage, sun},
};
use umbrage_core::Scene;
use umbrage_core::glam::{Affine3A, Quat, Vec2, Vec3};

const STEEL: [f32; 3] = [0.30, 0.31, 0.33];
const BARK: [f32; 3] = [0.22, 0.16, 0.11];
const LEAVES: [f32; 3] = [0.15, 0.32, 0.06];

/// A fence of wires 12 mm thick in meshes of 10 cm: one quad between two posts. The wires are as
/// thin as those of `fence`.
pub(crate) fn wire_fence() -> Scene {
    const HALF: f32 = 2.4;
    const HEIGHT: f32 = 1.2;
    const MESH: f32 = 0.1;
    let corners = [
        Vec3::new(-HALF, 0.0, 0.0),
        Vec3::new(HALF, 0.0, 0.0),
        Vec3::new(HALF, HEIGHT, 0.0),
        Vec3::new(-HALF, HEIGHT, 0.0),
    ];
    let meshes = Vec2::new(2.0 * HALF, HEIGHT) / MESH;
    let posts = [-HALF, HALF].map(|x| Affine3A::from_translation(Vec3::new(x, 0.0, 0.0)));
    Stage::new("wire-fence")
        .put(grid([4.0, 4.0], [1, 1], |_, _| 0.0))
        .put(tile_mesh(quad(corners), meshes))
        .look(netting(STEEL, 0.012 / MESH))
        .put_many(pillar(0.03, 1.3, 12), posts)
        .light(sun(0.35, -1.0, 0.9))
        .shoot([1.2, 1.9, 3.4], [0.0, 0.25, 0.4], 44.0, SMALL)
}

/// Trees of leaf cards on a plain: a pair at 5 m, and pairs at growing distances up to 500 m, each
/// still taller than a pixel.
pub(crate) fn foliage() -> Scene {
    const NEAREST: f32 = 5.0;
    const FARTHEST: f32 = 500.0;
    const PAIRS: i32 = 15;
    let mut places = Vec::new();
    for pair in 0..PAIRS {
        // Increase distances by a constant factor.
        let part = pair as f32 / (PAIRS - 1) as f32;
        let distance = NEAREST * (FARTHEST / NEAREST).powf(part);
        for side in [-1.0, 1.0] {
            let x = side * (1.2 + 0.11 * distance);
            let turn = Quat::from_rotation_y(1.7 * pair as f32 + side);
            let foot = Vec3::new(x, 0.0, -distance);
            places.push(Affine3A::from_rotation_translation(turn, foot));
        }
    }
    let shape = Crown {
        seed: 5,
        middle: Vec3::new(0.0, 2.6, 0.0),
        half: Vec3::new(1.1, 1.3, 1.1),
        cards: 150,
        side: 0.7,
    };
    Stage::new("foliage")
        .put(grid([150.0, 540.0], [1, 1], |_, _| 0.0))
        .put_many(pillar(0.09, 2.4, 12), places.clone())
        .look(matte(BARK))
        .put_many(crown(&shape), places)
        .look(sprig(LEAVES))
        .light(sun(0.5, -0.8, 0.35))
        .shoot([0.0, 1.7, 0.0], [0.0, 1.0, -10.0], 60.0, SMALL)
}
