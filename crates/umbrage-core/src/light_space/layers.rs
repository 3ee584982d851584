//! Layouts: how many light spaces a map technique takes, and which.

use crate::{
    geometry::Geometry,
    invalid::Invalid,
    light_space::{LightSpace, cascades::Cascades, caster_set::CasterSet, look_along},
    math::transform,
};
use glam::{Mat4, Vec3};

/// Into how many light spaces the surroundings of a light are divided. Each has its own layer of a
/// map.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum Layout {
    /// One space where one can hold all that matters with texels no larger than a cube's, or all
    /// casters; else a cube.
    #[default]
    Auto,
    /// One space.
    Single,
    /// Six spaces around a light with a position, along the world's axes: +x, -x, +y, -y, +z, -z.
    /// Each is wider than 90 degrees by what kernels reach, so lookups never cross from one to
    /// another and there are no seams.
    Cube,
    /// A space for each of some slices of what the camera sees, for directional light: see
    /// [`Cascades`].
    ///
    /// With [`Fit::Stable`](crate::Fit::Stable) each is as stable as that fit's one map, and the
    /// last slice ends at its range. With [`Fit::Tight`](crate::Fit::Tight) each goes around what
    /// is seen in its slice (around the slice itself, cut by the box around all receivers, where
    /// that is unknown), and the last slice ends at the farthest that can be seen. Other fits don't
    /// follow the camera, and are refused.
    Cascades(Cascades),
}

/// How receivers find the layer in which they are looked up.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Arrangement {
    /// There is one.
    #[default]
    Single,
    /// That of the axis along which they are farthest from the light: six, in the order of
    /// [`Layout::Cube`].
    Cube,
    /// The first that holds them with all that a kernel reaches; the last where none does.
    Cascades(CascadePick),
}

/// What picks one of several cascades.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CascadePick {
    /// How far kernels reach beyond the texel on which a receiver falls, texels of each cascade.
    /// Receivers on which a normal offset acts are picked where they are, so it counts, too.
    pub reach: f32,
    /// See [`Cascades::blend`].
    pub blend: f32,
}

/// The spaces of a layout, one a layer.
#[derive(Clone, Debug, PartialEq)]
pub struct LightSpaces {
    /// One; six in the order of [`Layout::Cube`]; or those of slices, from the nearest on.
    pub spaces: Vec<LightSpace>,
    /// For each, the casters that are to be drawn there: none where nothing can fall on anything.
    pub casters: Vec<CasterSet>,
    /// How receivers find theirs.
    pub arrangement: Arrangement,
}

impl LightSpaces {
    /// Returns spaces into each of which all casters are drawn. Several are taken for the faces of
    /// a cube.
    pub fn with_all_casters(spaces: Vec<LightSpace>) -> Self {
        let arrangement = if spaces.len() > 1 {
            Arrangement::Cube
        } else {
            Arrangement::Single
        };
        let casters = vec![CasterSet::All; spaces.len()];
        Self {
            spaces,
            casters,
            arrangement,
        }
    }

    /// Returns the spaces of cascades, from the nearest on, into each of which all casters are
    /// drawn.
    pub fn cascades(spaces: Vec<LightSpace>, pick: CascadePick) -> Self {
        Self {
            arrangement: Arrangement::Cascades(pick),
            ..Self::with_all_casters(spaces)
        }
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

/// Finds the layers in which receivers are looked up. Kernels have a rule of their own, whose bits
/// count: this one is for figures.
#[derive(Clone, Debug)]
pub struct LayerPicker<'a> {
    layers: &'a LightSpaces,
    clip_from_world: Vec<Mat4>,
    /// For cascades: how far from the middle, clip space, a layer holds receivers.
    half_side: f32,
}

impl<'a> LayerPicker<'a> {
    /// Returns what finds layers of maps of `size` x `size` texels.
    pub fn new(layers: &'a LightSpaces, size: u32) -> Self {
        let reach = match layers.arrangement {
            Arrangement::Single | Arrangement::Cube => 0.0,
            Arrangement::Cascades(pick) => pick.reach,
        };
        let matrices = layers.spaces.iter().map(LightSpace::clip_from_world);
        Self {
            layers,
            clip_from_world: matrices.collect(),
            half_side: 1.0 - 2.0 * reach / size.max(1) as f32,
        }
    }

    /// Returns the index of the layer in which a receiver at `p` (world space) is looked up; none
    /// if there are no layers.
    pub fn layer_at(&self, p: Vec3) -> Option<usize> {
        let last = self.clip_from_world.len().checked_sub(1)?;
        Some(match self.layers.arrangement {
            Arrangement::Single => 0,
            Arrangement::Cube => farthest_along_view(&self.layers.spaces, p),
            Arrangement::Cascades(_) => {
                let mut earlier = self.clip_from_world[..last].iter();
                earlier
                    .position(|space| self.holds(*space, p))
                    .unwrap_or(last)
            }
        })
    }

    /// Returns the transform of a layer from world space to clip space.
    ///
    /// Panics if there is no such layer.
    pub fn clip_from_world(&self, layer: usize) -> Mat4 {
        self.clip_from_world[layer]
    }

    fn holds(&self, clip_from_world: Mat4, p: Vec3) -> bool {
        let clip = transform(clip_from_world, p);
        clip.x.abs().max(clip.y.abs()) < self.half_side && clip.z <= 1.0
    }
}

/// Returns which of a cube's faces a point lies in: that along whose view it is farthest.
fn farthest_along_view(spaces: &[LightSpace], p: Vec3) -> usize {
    let distances = spaces
        .iter()
        .map(|space| -transform(space.view_from_world, p).z);
    let farthest = distances
        .enumerate()
        .max_by(|(_, a), (_, b)| a.total_cmp(b));
    farthest.map_or(0, |(layer, _)| layer)
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
