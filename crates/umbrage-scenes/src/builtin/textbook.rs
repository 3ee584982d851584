//! The three cubes over a wooden floor of typical shadow mapping tutorials.

use super::SIZE;
use crate::{
    looks::wood,
    primitives::{block, grid, tile_mesh},
    stage::{Stage, sun},
};
use umbrage_core::glam::{Affine3A, Quat, Vec2, Vec3};
use umbrage_core::light_space::Extents;
use umbrage_core::{Fit, Scene};

/// The light's position in the textbook, metres. It points at the origin.
const LIGHT: Vec3 = Vec3::new(-2.0, 4.0, -1.0);

/// The textbook's light space: from (-2, 4, -1) towards the origin, 10 m to each side, near 1, far
/// 7.5. It belongs to the scene `cubes`.
pub const TEXTBOOK_FIT: Fit = textbook_fit(1.0);

/// Returns the textbook's light space at another scale.
pub(crate) const fn textbook_fit(scale: f32) -> Fit {
    let side = 10.0 * scale;
    Fit::Manual {
        eye: Vec3::new(LIGHT.x * scale, LIGHT.y * scale, LIGHT.z * scale),
        extents: Extents {
            left: -side,
            right: side,
            bottom: -side,
            top: side,
            near: scale,
            far: 7.5 * scale,
        },
    }
}

pub(crate) fn cubes() -> Scene {
    cubes_at("cubes", 1.0)
}

/// The cubes, with all lengths multiplied by `scale`.
pub(crate) fn cubes_at(name: &str, scale: f32) -> Scene {
    let turned = Quat::from_axis_angle(Vec3::new(1.0, 0.0, 1.0).normalize(), 60.0_f32.to_radians());
    let places = [
        (Vec3::splat(0.5), Quat::IDENTITY, Vec3::new(0.0, 1.5, 0.0)),
        (Vec3::splat(0.5), Quat::IDENTITY, Vec3::new(2.0, 0.0, 1.0)),
        (Vec3::splat(0.25), turned, Vec3::new(-1.0, 0.0, 2.0)),
    ]
    .map(|(size, turn, at)| {
        Affine3A::from_scale_rotation_translation(size * scale, turn, at * scale)
    });
    Stage::new(name)
        .put_many(
            tile_mesh(grid([25.0, 25.0], [1, 1], |_, _| 0.0), Vec2::splat(12.5)),
            [floor_place(scale)],
        )
        .look(wood())
        .put_many(block(Vec3::NEG_ONE, Vec3::ONE), places)
        .light(sun(-LIGHT.x, -LIGHT.y, -LIGHT.z))
        .shoot(
            Vec3::new(1.5, 3.5, 6.5) * scale,
            Vec3::new(0.5, 0.4, 0.5) * scale,
            45.0,
            SIZE,
        )
}

fn floor_place(scale: f32) -> Affine3A {
    Affine3A::from_scale_rotation_translation(
        Vec3::splat(scale),
        Quat::IDENTITY,
        Vec3::new(0.0, -0.5, 0.0) * scale,
    )
}
