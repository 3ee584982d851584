//! Fitting light spaces: where a shadow map's texels go.

mod cull;
mod lamp;
mod map_space;
mod memory;
mod parallel;
mod perspective;
mod points;
mod polygon;
mod relevant;
mod stable;
#[cfg(test)]
mod tests;

pub use memory::FitMemory;
pub use relevant::relevant_casters;

use crate::{
    Invalid, Light, PlanError, View, invalid,
    layout::{Layout, LightSpaces},
    light_space::{Extents, LightSpace, look_along, orthographic},
};
use glam::Vec3;

/// How light spaces are laid around a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Fit {
    /// Culled to need: as tight as it goes without changing any shadow. Of the casters, only those count that can shadow a
    /// seen receiver; sideways the map covers what they share with what is seen to receive, in depth it runs from the
    /// first of them to the last seen receiver. A spot's map covers no more of its cone than that, other lamps need a cube
    /// only if that surrounds them.
    ///
    /// What is seen is [`View::receivers`]; all receivers where those are unknown. Triangles of which only a box is known
    /// are not culled. Bias may move receivers away from the light by 1/64 of the map's range or more: see
    /// [`relevant_casters`].
    #[default]
    Tight,
    /// As tight as it goes around all that casts and receives, seen or not: it stands still while the camera moves, and
    /// wastes texels on what nobody sees.
    Whole,
    /// For moving cameras, without shimmer: of directional light, a map around the bounding sphere of what the camera may
    /// see up to a distance; it neither turns nor grows with the camera, and moves by whole texels (Valient 2008, "Stable
    /// rendering of cascaded shadow maps"). Where the sphere around all casters, or all receivers, is smaller, that one
    /// counts, and the map stands still. The depth range, too, changes in rare large steps.
    ///
    /// The sphere's size depends on the camera's projection: shadows shimmer while a field of view changes, and while the
    /// light turns. Lamps stand still, so theirs is [`Fit::Whole`].
    Stable {
        /// How far from the camera shadows are wanted, metres along its view. Beyond, everything is lit.
        range: f32,
    },
    /// Textbook style: from `eye` along the light, with explicit extents. Perspective lights use `near` and `far` alone.
    Manual {
        /// Where depth is counted from, world space. Lights with a position use theirs instead.
        eye: Vec3,
        /// The volume, in the light's view space.
        extents: Extents,
    },
}

/// Widest half angle, degrees, of the cone that one perspective map may have to cover.
const WIDEST_HALF_ANGLE: f32 = 75.0;

impl Fit {
    /// A few words for tables; empty for the tight fit.
    pub fn label(&self) -> String {
        match self {
            Self::Tight => String::new(),
            Self::Whole => "whole fit".to_owned(),
            Self::Stable { range } => format!("stable fit to {range} m"),
            Self::Manual { .. } => "manual fit".to_owned(),
        }
    }

    /// One light space for the view. `size` is the map's side in texels; `margin` is how far, in texels, a kernel
    /// reaches beyond the texel that a receiver falls on.
    ///
    /// # Errors
    /// `Unsupported` when what matters surrounds the light, so that no single map can see it all; `Invalid` for bad input.
    pub fn light_space(
        &self,
        view: &View<'_>,
        size: u32,
        margin: f32,
    ) -> Result<LightSpace, PlanError> {
        view.validate()?;
        self.validate()?;
        self.single(view, size, margin)
    }

    /// The light space of a valid fit for a valid view.
    fn single(&self, view: &View<'_>, size: u32, margin: f32) -> Result<LightSpace, PlanError> {
        let view = &self.known(view);
        let Light::Directional { direction, .. } = *view.light else {
            return perspective::single(self, view, size, margin);
        };
        Ok(match *self {
            Self::Tight => parallel::tight(view, direction, size, margin, true)?,
            Self::Whole => parallel::tight(view, direction, size, margin, false)?,
            Self::Stable { range } => stable::parallel(view, direction, range, size, margin)?,
            Self::Manual { eye, extents } => LightSpace {
                view_from_world: look_along(eye, direction, Vec3::Y)?,
                clip_from_view: orthographic(extents)?,
            },
        })
    }

    /// Objects to numbers that are not finite; what depends on the light is left to its light space.
    fn validate(&self) -> Result<(), Invalid> {
        let Self::Manual { eye, extents } = self else {
            return Ok(());
        };
        invalid::finite("manual fit's eye", &eye.to_array())?;
        let Extents {
            left,
            right,
            bottom,
            top,
            near,
            far,
        } = *extents;
        let named = [
            ("left", left),
            ("right", right),
            ("bottom", bottom),
            ("top", top),
            ("near", near),
            ("far", far),
        ];
        named.iter().try_for_each(|(name, value)| {
            invalid::finite(&format!("manual fit's {name}"), &[*value])
        })
    }

    /// What a fit may look at: those that stand still do not look at what is seen.
    fn known<'a>(&self, view: &View<'a>) -> View<'a> {
        match self {
            Self::Tight | Self::Manual { .. } => *view,
            Self::Whole | Self::Stable { .. } => View {
                receivers: None,
                ..*view
            },
        }
    }

    /// The light spaces of a layout; parameters as [`Fit::light_space`].
    ///
    /// # Errors
    /// As [`Fit::light_space`]; and `Unsupported` for a cube around a light without a position.
    pub fn light_spaces(
        &self,
        layout: Layout,
        view: &View<'_>,
        size: u32,
        margin: f32,
    ) -> Result<LightSpaces, PlanError> {
        let find = || self.find(layout, view, size, margin);
        match view.fits {
            Some(memory) => memory.recall(
                memory::Asked {
                    fit: *self,
                    layout,
                    size,
                    margin,
                },
                find,
            ),
            None => find(),
        }
    }

    fn find(
        &self,
        layout: Layout,
        view: &View<'_>,
        size: u32,
        margin: f32,
    ) -> Result<LightSpaces, PlanError> {
        view.validate()?;
        self.validate()?;
        let single = || {
            Ok(LightSpaces {
                spaces: vec![self.single(view, size, margin)?],
                needed: vec![true],
            })
        };
        let cube = |eye| perspective::cube(self, &self.known(view), eye, size, margin);
        let suffices = |one: &LightSpaces, eye| {
            perspective::suffices(&one.spaces[0], &self.known(view), eye, size, margin)
        };
        match (layout, view.light.position()) {
            (Layout::Single, _) | (Layout::Auto, None) => single(),
            (Layout::Cube, None) => Err(PlanError::unsupported(
                "a directional light has no place to put a cube around",
            )),
            (Layout::Cube, Some(eye)) => cube(eye),
            (Layout::Auto, Some(eye)) => match single() {
                Err(PlanError::Unsupported(_)) => cube(eye),
                // A kernel may be too wide for a cube's faces.
                Ok(one) if !suffices(&one, eye) => cube(eye).or(Ok(one)),
                other => other,
            },
        }
    }
}
