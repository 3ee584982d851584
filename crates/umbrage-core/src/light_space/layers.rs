//! Layouts: how many light spaces a map technique takes, and which.

use crate::{CasterSet, Geometry, Invalid, LightSpace, light_space::look_along};
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
    /// For each, the casters that are to be drawn there: none where nothing can fall on anything.
    pub casters: Vec<CasterSet>,
}

impl LightSpaces {
    /// Returns spaces into each of which all casters are drawn.
    pub fn with_all_casters(spaces: Vec<LightSpace>) -> Self {
        let casters = vec![CasterSet::All; spaces.len()];
        Self { spaces, casters }
    }

    /// Leaves out of each layer the casters that lie beside it. `size` is the layers' side, texels.
    pub(crate) fn leave_out_casters_beside(&mut self, geometry: &Geometry, size: u32) {
        for (space, casters) in self.spaces.iter().zip(&mut self.casters) {
            if *casters == CasterSet::All {
                *casters = CasterSet::shown_in(geometry, space, size);
            }
        }
    }

    /// Returns whether anything is to be drawn into a layer.
    ///
    /// Panics if there is no such layer.
    pub fn is_needed(&self, layer: usize) -> bool {
        !self.casters[layer].is_empty()
    }
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
