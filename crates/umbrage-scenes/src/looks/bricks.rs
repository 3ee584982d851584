//! A brick wall: colour, relief, and the normals of the relief.

use super::{Look, texture, textured_look};
use crate::builtin::noise::uniform;
use umbrage_core::glam::{IVec3, Vec2, Vec3};
use umbrage_core::{Displacement, Material, Texture};

const SIDE: u32 = 128;
/// Courses in a tile, each with half as many bricks.
const COURSES: f32 = 4.0;
/// Half the width of a joint, and the width of a brick's sloping rim, as fractions of a tile.
const JOINT: f32 = 0.02;
const RIM: f32 = 0.025;

/// A wall in running bond.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bricks {
    /// Side of a tile of the texture on the wall, metres.
    pub(crate) tile: f32,
    /// Depth of the joints below the bricks' faces, metres.
    pub(crate) depth: f32,
}

impl Bricks {
    /// Returns a look with colour alone.
    pub(crate) fn flat(self) -> Look {
        textured_look(texture("bricks", SIDE, color))
    }

    /// Returns a look with colour and normals: relief without an effect on shadows.
    pub(crate) fn bumpy(self) -> Look {
        let look = self.flat();
        let material = Material {
            normal_map: Some(1),
            ..look.material
        };
        Look {
            material,
            textures: [look.textures, vec![self.normals()]].concat(),
        }
    }

    /// Returns a look with colour and relief. The wall's plane is half way between joints and
    /// faces.
    pub(crate) fn carve_surface(self, subdivisions: u32) -> Look {
        let look = self.flat();
        let relief = Displacement {
            texture: 1,
            lambda: 0.5 * self.depth,
            subdivisions,
        };
        let heights = texture("brick heights", SIDE, |uv| Vec3::splat(height(uv)));
        let material = Material {
            displacement: Some(relief),
            ..look.material
        };
        Look {
            material,
            textures: [look.textures, vec![heights]].concat(),
        }
    }

    /// Returns tangent-space normals of the relief, from differences over two texels, green up.
    fn normals(self) -> Texture {
        let step = 1.0 / SIDE as f32;
        let slope = |uv: Vec2, d: Vec2| {
            (height(uv + d) - height(uv - d)) * self.depth / (2.0 * step * self.tile)
        };
        texture("brick normals", SIDE, |uv| {
            // v points down in the image, green up.
            let along_u = slope(uv, Vec2::new(step, 0.0));
            let along_v = slope(uv, Vec2::new(0.0, step));
            0.5 + 0.5 * Vec3::new(-along_u, along_v, 1.0).normalize()
        })
    }
}

/// Returns the brick at a point, and the position in it, both from 0 to 1.
fn brick(uv: Vec2) -> (IVec3, Vec2) {
    let wrapped = uv - uv.floor();
    let course = (wrapped.y * COURSES).floor();
    let along = wrapped.x * COURSES * 0.5 + 0.5 * (course % 2.0);
    // A brick may cross the texture's edge.
    let number = along.floor() % (0.5 * COURSES);
    (
        IVec3::new(number as i32, course as i32, 3),
        Vec2::new(along.fract(), (wrapped.y * COURSES).fract()),
    )
}

/// Returns the distance from the centre of the nearest joint, as a fraction of a tile.
fn from_joint(uv: Vec2) -> f32 {
    let (_, p) = brick(uv);
    let edge = p.min(1.0 - p) * Vec2::new(2.0 / COURSES, 1.0 / COURSES);
    edge.min_element()
}

/// Returns 0 in the joints and 1 on the bricks.
fn height(uv: Vec2) -> f32 {
    ((from_joint(uv) - JOINT) / RIM).clamp(0.0, 1.0)
}

fn color(uv: Vec2) -> Vec3 {
    if from_joint(uv) < JOINT {
        return Vec3::splat(0.42);
    }
    let tone = uniform(brick(uv).0);
    Vec3::new(0.36 + 0.16 * tone, 0.12 + 0.05 * tone, 0.07 + 0.02 * tone)
}
