//! Relief under grazing light.

use super::SMALL;
use crate::{
    looks::{Bricks, Look},
    primitives::{block, grid, pillar, tile_mesh},
    stage::{Stage, sun},
};
use umbrage_core::glam::{Affine3A, Mat3, Vec2, Vec3, Vec4};
use umbrage_core::{Mesh, Scene};

const HALF: [f32; 2] = [1.8, 1.2];
/// Quads of 20 cm.
const CELLS: [u32; 2] = [18, 12];
const BRICKS: Bricks = Bricks {
    tile: 1.2,
    depth: 0.05,
};
/// Subdivisions of each quad: its sides are cut in 8, so that a joint of 5 cm is two triangles
/// wide.
const SUBDIVISIONS: u32 = 3;

/// Distance of the flat caster behind the deepest joint, metres.
const BEHIND: f32 = 0.005;

/// A flat sheet of the wall's size in x and z.
fn sheet() -> Mesh {
    let tiles = Vec2::from(HALF) * 2.0 / BRICKS.tile;
    let mesh = tile_mesh(grid(HALF, CELLS, |_, _| 0.0), tiles);
    Mesh {
        name: "wall".to_owned(),
        tangents: vec![Vec4::new(1.0, 0.0, 0.0, 1.0); mesh.positions.len()],
        ..mesh
    }
}

/// Turns a sheet upright: its upper side faces +z, and the top of its texture is at the top.
fn upright(z: f32) -> Affine3A {
    let turn = Mat3::from_cols(Vec3::X, Vec3::Z, Vec3::NEG_Y);
    Affine3A::from_mat3_translation(turn, Vec3::new(0.0, HALF[1], z))
}

/// Adds a floor in front of the wall, a ledge on it and a post in front of it. The sun is nearly
/// parallel to the wall.
fn scene_around(stage: Stage) -> Scene {
    stage
        .put(grid([2.4, 1.5], [1, 1], |_, _| 0.0))
        .put(block([-0.3, 1.5, -0.02], [0.9, 1.58, 0.22]))
        .put_many(
            pillar(0.08, 2.0, 24),
            [Affine3A::from_translation(Vec3::new(-0.9, 0.0, 0.3))],
        )
        .light(sun(1.0, -0.45, -0.3))
        .shoot([1.2, 1.7, 3.6], [0.05, 1.0, 0.0], 40.0, SMALL)
}

fn wall(name: &str, look: Look) -> Stage {
    Stage::new(name)
        .put_many(sheet(), [upright(0.0)])
        .look(look)
}

/// Bricks as geometry that protrude by 5 cm. Each casts a shadow into the joint behind it.
pub(crate) fn displaced_wall() -> Scene {
    scene_around(wall("displaced-wall", BRICKS.carve_surface(SUBDIVISIONS)))
}

/// Bricks of the same relief as a normal map: the wall and its shadows are flat. A bias along the
/// shading normal would bend them.
pub(crate) fn normal_mapped_wall() -> Scene {
    scene_around(wall("normal-mapped-wall", BRICKS.bumpy()))
}

/// The result of a depth pass without displacement. The relief of `displaced-wall` receives, and a
/// flat wall right behind it, invisible to the camera, casts in its place. Bricks cast no shadow
/// into the joints.
pub(crate) fn without_depth_pass() -> Scene {
    let stage = wall(
        "relief-without-depth-pass",
        BRICKS.carve_surface(SUBDIVISIONS),
    )
    .last_roles(false, true);
    scene_around(
        stage
            .put_many(sheet(), [upright(-0.5 * BRICKS.depth - BEHIND)])
            .look(BRICKS.flat())
            .last_roles(true, false),
    )
}
