//! A point light among its casters.

use super::SMALL;
use crate::{
    primitives::{block, grid, icosphere, pillar, room},
    stage::{Stage, bulb},
};
use umbrage_core::glam::{Affine3A, Vec3};
use umbrage_core::{Light, Scene};

const LAMP: Vec3 = Vec3::new(0.0, 1.5, 0.0);

/// Returns a position relative to the light.
fn from_lamp(x: f32, y: f32, z: f32) -> Vec3 {
    LAMP + Vec3::new(x, y, z)
}

/// Casters at the seams of a cube map around the light: posts where |x| = |z|, beams where |x| =
/// |y| and |y| = |z|, and a ball where all three are equal, relative to the light. The floor is two
/// triangles, so that a map which bends straight lines between vertices has no other vertices to
/// follow.
fn at_seams(name: &str, light: Light) -> Scene {
    let posts = [
        Affine3A::from_translation(Vec3::new(-1.0, 0.0, -1.0)),
        Affine3A::from_translation(Vec3::new(1.1, 0.0, -1.1)),
        Affine3A::from_translation(Vec3::new(-0.8, 0.0, 0.8)),
        Affine3A::from_translation(Vec3::new(1.2, 0.0, 1.2)),
    ];
    Stage::new(name)
        .put(room(Vec3::new(-2.2, 0.0, -2.2), Vec3::new(2.2, 3.0, 2.2)))
        .put_many(pillar(0.05, 3.0, 16), posts)
        .put(block(
            from_lamp(-1.04, -1.04, -0.6),
            from_lamp(-0.96, -0.96, 0.5),
        ))
        .put(block(
            from_lamp(-0.7, 0.86, -0.94),
            from_lamp(0.8, 0.94, -0.86),
        ))
        .put(block(
            from_lamp(-0.5, -0.74, -0.74),
            from_lamp(0.3, -0.66, -0.66),
        ))
        .put(icosphere(from_lamp(0.6, -0.6, -0.6), 0.14, 3))
        .light(light)
        .shoot([0.35, 2.1, 2.1], [-0.1, 1.15, -0.6], 88.0, SMALL)
}

pub(crate) fn lamp_in_room() -> Scene {
    at_seams("lamp-in-room", bulb(LAMP.x, LAMP.y, LAMP.z))
}

pub(crate) fn glowing_lamp_in_room() -> Scene {
    at_seams(
        "glowing-lamp-in-room",
        Light::Point {
            position: LAMP,
            radius: 0.1,
        },
    )
}

/// Only planes receive: a floor and a wall. Casters, which don't, are wholly and partly below the
/// floor, through the wall, beyond the light, and at normal positions.
pub(crate) fn flat_receivers() -> Scene {
    let wall = block([-3.0, 0.0, -2.6], [3.0, 3.0, -2.5]);
    let casters = [
        block([-1.9, -0.4, -0.7], [-1.2, 0.5, 0.1]),
        block([1.3, -1.2, 0.2], [2.1, -0.3, 1.0]),
        block([1.0, 0.7, -2.9], [1.3, 1.0, -1.9]),
        // Point reflections of these two at the light would darken the centres of the floor and the
        // wall.
        block([-0.6, 4.1, -0.4], [0.6, 4.2, 0.9]),
        block([-0.4, 3.5, 2.2], [0.5, 4.3, 2.3]),
        icosphere([0.5, 0.9, 0.1], 0.35, 3),
        block([-0.9, 1.1, -1.6], [-0.2, 1.2, -0.9]),
    ];
    let mut stage = Stage::new("flat-receivers")
        .put(grid([3.0, 2.5], [1, 1], |_, _| 0.0))
        .last_roles(false, true)
        .put(wall)
        .last_roles(false, true);
    for caster in casters {
        stage = stage.put(caster).last_roles(true, false);
    }
    stage
        .light(bulb(0.1, 3.2, 0.7))
        .shoot([2.6, 2.9, 5.3], [-0.05, 0.85, -0.8], 44.0, SMALL)
}

/// Returns a spot light 4 m above the floor that points at the caster of [`two_lights`].
fn spot_on_caster(x: f32, z: f32) -> Light {
    let position = Vec3::new(x, 4.0, z);
    Light::Spot {
        position,
        direction: Vec3::Y * 0.5 - position,
        inner: 30.0_f32.to_radians(),
        outer: 34.0_f32.to_radians(),
        radius: 0.0,
    }
}

/// Two spot lights on one caster with a shadow each. Errors of either shadow are also errors of
/// their sum.
pub(crate) fn two_lights() -> Scene {
    Stage::new("two-lights")
        .put(grid([4.0, 4.0], [1, 1], |_, _| 0.0))
        .put(block([-0.4, 0.0, -0.4], [0.4, 1.0, 0.4]))
        .put(icosphere([0.0, 1.3, 0.0], 0.3, 3))
        .light(spot_on_caster(-2.2, 0.9))
        .light(spot_on_caster(1.8, 1.4))
        .shoot([0.6, 3.2, 4.6], [0.0, 0.3, -0.3], 44.0, SMALL)
}
