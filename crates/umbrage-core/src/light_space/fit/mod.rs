//! Fitting light spaces: where a shadow map's texels go.

mod cull;
mod kind;
mod lamp;
mod map_space;
mod memory;
mod parallel;
mod perspective;
mod points;
mod relevant;
mod stable;
#[cfg(test)]
mod tests;

pub use crate::light_space::fit::kind::Fit;
pub use crate::light_space::fit::memory::FitMemory;
pub use crate::light_space::fit::relevant::relevant_casters;

use crate::{
    Invalid, Light, RecipeError, View, invalid,
    light_space::{
        Extents, LightSpace,
        layers::{Layout, LightSpaces},
        look_along, orthographic,
    },
};
use glam::Vec3;

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
    ) -> Result<LightSpace, RecipeError> {
        view.validate()?;
        self.validate()?;
        self.single(view, size, margin)
    }

    /// The light space of a valid fit for a valid view.
    fn single(&self, view: &View<'_>, size: u32, margin: f32) -> Result<LightSpace, RecipeError> {
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
    ) -> Result<LightSpaces, RecipeError> {
        let find = || {
            let mut spaces = self.find(layout, view, size, margin)?;
            if let Some(geometry) = view.geometry {
                spaces.leave_out_casters_beside(geometry, size);
            }
            Ok(spaces)
        };
        match view.fits {
            Some(memory) => memory.recall(
                memory::FitKey {
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
    ) -> Result<LightSpaces, RecipeError> {
        view.validate()?;
        self.validate()?;
        let single = || {
            let space = self.single(view, size, margin)?;
            Ok(LightSpaces::with_all_casters(vec![space]))
        };
        let cube = |eye| perspective::cube(self, &self.known(view), eye, size, margin);
        let suffices = |one: &LightSpaces, eye| {
            perspective::suffices(&one.spaces[0], &self.known(view), eye, size, margin)
        };
        match (layout, view.light.position()) {
            (Layout::Single, _) | (Layout::Auto, None) => single(),
            (Layout::Cube, None) => Err(RecipeError::unsupported(
                "a directional light has no place to put a cube around",
            )),
            (Layout::Cube, Some(eye)) => cube(eye),
            (Layout::Auto, Some(eye)) => match single() {
                Err(RecipeError::Unsupported(_)) => cube(eye),
                // A kernel may be too wide for a cube's faces.
                Ok(one) if !suffices(&one, eye) => cube(eye).or(Ok(one)),
                other => other,
            },
        }
    }
}
