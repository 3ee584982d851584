//! Relief under grazing light.

use super::SMALL;
use crate::{
    looks::{Bricks, Look},
    primitives::{block, grid, pillar, tiled},
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
/// Each quad's sides are cut in 8, so that a joint of 5 cm is two triangles wide.
const SUBDIVISIONS: u32 = 3;

/// How far the flat caster is behind the deepest joint, metres.
const BEHIND: f32 = 0.005;

/// A flat sheet of the wall's size that lies in x and z.
fn sheet() -> Mesh {
    let tiles = Vec2::from(HALF) * 2.0 / BRICKS.tile;
    let mesh = tiled(grid(HALF, CELLS, |_, _| 0.0), tiles);
    Mesh {
        name: "wall".to_owned(),
        tangents: vec![Vec4::new(1.0, 0.0, 0.0, 1.0); mesh.positions.len()],
        ..mesh
    }
}

/// Upright: what faced up faces +z, and the texture's top is on top.
fn upright(z: f32) -> Affine3A {
    let turn = Mat3::from_cols(Vec3::X, Vec3::Z, Vec3::NEG_Y);
    Affine3A::from_mat3_translation(turn, Vec3::new(0.0, HALF[1], z))
}

/// A floor before the wall, a ledge on it and a post before it, the sun nearly along it.
fn around(stage: Stage) -> Scene {
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

/// Bricks that stand out by 5 cm, as geometry: each throws a shadow into the joint behind it.
pub(crate) fn displaced_wall() -> Scene {
    around(wall("displaced-wall", BRICKS.carved(SUBDIVISIONS)))
}

/// The same relief as shading alone: the wall is flat, and so are its shadows. A bias along the
/// shading normal would bend them.
pub(crate) fn normal_mapped_wall() -> Scene {
    around(wall("normal-mapped-wall", BRICKS.bumpy()))
}

/// What comes out when the depth pass leaves out displacement: the relief of `displaced-wall`
/// receives, and a flat wall right behind it, where the camera doesn't see it, casts in its place.
/// Bricks throw no shadow into the joints.
pub(crate) fn without_depth_pass() -> Scene {
    let stage =
        wall("relief-without-depth-pass", BRICKS.carved(SUBDIVISIONS)).last_roles(false, true);
    around(
        stage
            .put_many(sheet(), [upright(-0.5 * BRICKS.depth - BEHIND)])
            .look(BRICKS.flat())
            .last_roles(true, false),
    )
}
