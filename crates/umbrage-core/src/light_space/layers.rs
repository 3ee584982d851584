//! Layouts: the number and arrangement of the light spaces of a shadow map.

use crate::{
    geometry::Geometry,
    invalid::Invalid,
    light_space::{LightSpace, cascades::Cascades, caster_set::CasterSet, look_along},
    math::transform,
};
use glam::{Mat4, Vec3};

/// Division of the space around a light into light spaces. Each light space has its own layer of a
/// map.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum Layout {
    /// One space if it can cover all geometry that matters with texels no larger than a cube's, or
    /// if it can cover all casters; otherwise a cube.
    #[default]
    Auto,
    /// One space.
    Single,
    /// Six spaces around a light with a position, along the world's axes: +x, -x, +y, -y, +z, -z.
    /// Each is wider than 90 degrees by the reach of kernels. Lookups therefore stay in one face,
    /// and there are no seams.
    Cube,
    /// One space for each slice of the camera's view, for directional light: see [`Cascades`].
    ///
    /// With [`Fit::Stable`](crate::Fit::Stable) each space is as stable as that fit's single map,
    /// and the last slice ends at its range. With [`Fit::Tight`](crate::Fit::Tight) each space
    /// covers the visible receivers in its slice, and the last slice ends at the farthest one. If
    /// they are unknown, it covers the slice itself, clipped by the box around all receivers. Other
    /// fits don't follow the camera, and are rejected.
    Cascades(Cascades),
}

/// Rule by which receivers select their layer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Arrangement {
    /// A single layer.
    #[default]
    Single,
    /// The layer of the axis along which the receiver is farthest from the light: six layers, in
    /// the order of [`Layout::Cube`].
    Cube,
    /// The first layer that contains the receiver with the kernel's reach; the last one if none
    /// does.
    Cascades(CascadePick),
}

/// Parameters for the selection of a cascade.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CascadePick {
    /// Reach of kernels beyond the texel that contains the receiver, in texels of each cascade. If
    /// kernels apply a normal offset, the reach includes it, as the layer is selected before the
    /// offset.
    pub reach: f32,
    /// See [`Cascades::blend`].
    pub blend: f32,
}

/// The spaces of a layout, one per layer.
#[derive(Clone, Debug, PartialEq)]
pub struct LightSpaces {
    /// One space; six in the order of [`Layout::Cube`]; or those of slices, from the nearest on.
    pub spaces: Vec<LightSpace>,
    /// For each space, the casters to draw; empty if the layer can contain no shadow.
    pub casters: Vec<CasterSet>,
    /// Rule by which receivers select their space.
    pub arrangement: Arrangement,
}

impl LightSpaces {
    /// Returns spaces with all casters in each. Several spaces are treated as the faces of a cube.
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

    /// Returns the spaces of cascades, from the nearest on, with all casters in each.
    pub fn cascades(spaces: Vec<LightSpace>, pick: CascadePick) -> Self {
        Self {
            arrangement: Arrangement::Cascades(pick),
            ..Self::with_all_casters(spaces)
        }
    }

    /// Removes from each layer the casters outside its sides. `size` is the layers' side, texels.
    pub(crate) fn leave_out_outside_casters(&mut self, geometry: &Geometry, size: u32) {
        for (space, casters) in self.spaces.iter().zip(&mut self.casters) {
            if *casters == CasterSet::All {
                *casters = CasterSet::shown_in(geometry, space, size);
            }
        }
    }

    /// Returns whether a layer has anything to draw.
    ///
    /// Panics if there is no such layer.
    pub fn is_needed(&self, layer: usize) -> bool {
        !self.casters[layer].is_empty()
    }
}

/// Selects the layers in which receivers are looked up, for statistics. Kernels have a separate
/// implementation, which is bit-exact.
#[derive(Clone, Debug)]
pub struct LayerPicker<'a> {
    layers: &'a LightSpaces,
    clip_from_world: Vec<Mat4>,
    /// For cascades: half the width, in clip space, of the area of a layer that is used for
    /// receivers.
    half_side: f32,
}

impl<'a> LayerPicker<'a> {
    /// Returns a picker for maps of `size` x `size` texels.
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

    /// Returns the index of the layer in which a receiver at `p` (world space) is looked up; `None`
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

/// Returns the face of a cube that contains a point: the one along whose view it is farthest.
fn farthest_along_view(spaces: &[LightSpace], p: Vec3) -> usize {
    let distances = spaces
        .iter()
        .map(|space| -transform(space.view_from_world, p).z);
    let farthest = distances
        .enumerate()
        .max_by(|(_, a), (_, b)| a.total_cmp(b));
    farthest.map_or(0, |(layer, _)| layer)
}

/// Returns the views of the faces of a cube around `eye`.
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
