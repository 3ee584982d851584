//! The rooms of the textbooks' later chapters: a point light among cubes, and a point light in
//! front of a brick wall.

use super::SIZE;
use crate::{
    looks::{Bricks, wood},
    primitives::{block, grid, pillar, room, tile_mesh},
    stage::{Stage, bulb},
};
use umbrage_core::glam::{Affine3A, Mat3, Quat, Vec2, Vec3, Vec4};
use umbrage_core::light_space::Extents;
use umbrage_core::{Fit, Mesh, Scene};

/// The textbook's planes for a point light: near 1, far 25. They belong to the scene
/// `textbook-room`. Only near and far are used.
pub(crate) const ROOM_FIT: Fit = Fit::Manual {
    eye: Vec3::ZERO,
    extents: Extents {
        left: -25.0,
        right: 25.0,
        bottom: -25.0,
        top: 25.0,
        near: 1.0,
        far: 25.0,
    },
};

/// A room of 10 m with five cubes around a point light at its centre.
pub(crate) fn textbook_room() -> Scene {
    let turned = Quat::from_axis_angle(Vec3::new(1.0, 0.0, 1.0).normalize(), 60.0_f32.to_radians());
    let cubes = [
        (0.5, Quat::IDENTITY, Vec3::new(4.0, -3.5, 0.0)),
        (0.75, Quat::IDENTITY, Vec3::new(2.0, 3.0, 1.0)),
        (0.5, Quat::IDENTITY, Vec3::new(-3.0, -1.0, 0.0)),
        (0.5, Quat::IDENTITY, Vec3::new(-1.5, 1.0, 1.5)),
        (0.75, turned, Vec3::new(-1.5, 2.0, -3.0)),
    ];
    let places = cubes.map(|(half, turn, at)| {
        Affine3A::from_scale_rotation_translation(Vec3::splat(half), turn, at)
    });
    Stage::new("textbook-room")
        .put(tile_mesh(
            room(Vec3::splat(-5.0), Vec3::splat(5.0)),
            Vec2::splat(2.0),
        ))
        .look(wood())
        .put_many(block(Vec3::NEG_ONE, Vec3::ONE), places)
        .look(wood())
        .light(bulb(0.0, 0.0, 0.0))
        .shoot([0.6, 0.9, 4.8], [-0.1, 0.0, 0.0], 72.0, SIZE)
}

/// A brick wall with a normal map, half a metre behind a point light. The wall's relief is only
/// visible as shading; a shelf and a bar cast shadows.
pub(crate) fn textbook_wall() -> Scene {
    let bricks = Bricks {
        tile: 1.5,
        depth: 0.04,
    };
    let sheet = tile_mesh(grid([3.0, 1.5], [1, 1], |_, _| 0.0), Vec2::new(4.0, 2.0));
    let tangents = vec![Vec4::new(1.0, 0.0, 0.0, 1.0); sheet.positions.len()];
    let upright = Mat3::from_cols(Vec3::X, Vec3::Z, Vec3::NEG_Y);
    let place = Affine3A::from_mat3_translation(upright, Vec3::new(0.0, 1.5, 0.0));
    Stage::new("textbook-wall")
        .put_many(Mesh { tangents, ..sheet }, [place])
        .look(bricks.bumpy())
        .put(tile_mesh(
            grid([3.0, 1.6], [1, 1], |_, _| 0.0),
            Vec2::new(3.0, 1.6),
        ))
        .look(wood())
        .put(block([0.4, 1.0, 0.0], [1.5, 1.06, 0.3]))
        .put_many(
            pillar(0.05, 1.2, 24),
            [Affine3A::from_translation(Vec3::new(-0.8, 0.0, 0.3))],
        )
        .light(bulb(-0.2, 1.7, 0.5))
        .shoot([0.8, 1.6, 3.6], [0.0, 1.1, 0.0], 46.0, SIZE)
}
