//! Layouts: how many light spaces a map technique takes, and which.

use crate::{Invalid, LightSpace, light_space::look_along};
use glam::{Mat4, Vec3};

/// Into how many light spaces the surroundings of a light are divided. Each has its own layer of a map.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize,
)]
#[serde(rename_all = "snake_case")]
pub enum Layout {
    /// One space where one can hold all that matters with texels no larger than a cube's, or all casters; else a cube.
    #[default]
    Auto,
    /// One space.
    Single,
    /// Six spaces around a light with a position, along the world's axes: +x, -x, +y, -y, +z, -z. Each is wider than 90
    /// degrees by what kernels reach, so lookups never cross from one to another and there are no seams.
    Cube,
}

/// The spaces of a layout, one a layer.
#[derive(Clone, Debug, PartialEq)]
pub struct LightSpaces {
    /// One, or six in the order of [`Layout::Cube`].
    pub spaces: Vec<LightSpace>,
    /// For each, whether anything can fall on anything there; the others need not be drawn.
    pub needed: Vec<bool>,
}

/// The view of each face of a cube around `eye`.
pub(crate) fn cube_face_views(eye: Vec3) -> Result<[Mat4; 6], Invalid> {
    let view = |axis: Vec3| look_along(eye, axis, Vec3::Y);
    Ok([
        view(Vec3::X)?,
        view(-Vec3::X)?,
        view(Vec3::Y)?,
        view(-Vec3::Y)?,
        view(Vec3::Z)?,
        view(-Vec3::Z)?,
    ])
}
