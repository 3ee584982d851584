//! Fits of light spaces: the area that a shadow map covers.
//!
//! [`Fit::Tight`] covers the casters that can shadow visible receivers (`cull.rs`: a grid of 64 x
//! 64 over the map). [`Fit::Stable`] covers a sphere and moves by whole texels,
//! [`Fit::AroundCamera`] does so around the camera. [`Fit::Whole`] covers everything, and
//! [`Fit::Manual`] is set by the caller. Clip depth is linear in the rank defined in
//! `map_space.rs`: the depth for parallel light, minus one over it for lights with a position. Both
//! kinds therefore share the code.
//!
//! Fits search for extremes, using boxes. `BoxTree` has a box around every 64 triangles, around
//! every 8 boxes, and so on, once per geometry. `SeenPoints` is the same over tiles of 8 x 8
//! visible points, once per view. `BoxTree::least` visits boxes in the order of their bounds until
//! no other box can contain a smaller value. Bounds include a margin for rounding
//! (`ViewBox::padded_box`), so results are bit-equal to a search through all points. Use one
//! [`FitMemory`] when evaluating many settings for the same view.

mod cascades;
mod cull;
pub(crate) mod frustum;
mod input;
mod kind;
mod lamp;
mod map_space;
pub(crate) mod memory;
mod parallel;
mod perspective;
mod points;
mod receiver_split;
#[cfg(feature = "testing")]
mod relevant;
mod stable;
#[cfg(test)]
mod tests;

pub use crate::light_space::fit::kind::Fit;
pub use crate::light_space::fit::memory::FitMemory;
#[cfg(feature = "testing")]
pub use crate::light_space::fit::relevant::relevant_casters;

use crate::{
    invalid::{self, Invalid},
    light_space::{
        Extents, LightSpace,
        cascades::{Cascades, SliceEnds},
        fit::{cascades::CascadeInput, input::FitInput, memory::FitKey, stable::SphereCenter},
        layers::{Layout, LightSpaces},
        look_along, orthographic,
    },
    recipe_error::RecipeError,
    scene::light::Light,
    view::View,
};
use glam::Vec3;

impl Fit {
    /// Returns a short description for tables; empty for the tight fit.
    pub fn label(&self) -> String {
        match self {
            Self::Tight => String::new(),
            Self::Whole => "whole fit".to_owned(),
            Self::Stable { range } => format!("stable fit to {range} m"),
            Self::AroundCamera { range } => format!("fit around the camera to {range} m"),
            Self::Manual { .. } => "manual fit".to_owned(),
        }
    }

    /// Returns one light space for the view. `size` is the side of the map in texels; `margin` is
    /// the reach of a kernel, in texels, beyond the texel that contains the receiver.
    ///
    /// # Errors
    /// Errors with `Unsupported` if the geometry that matters surrounds the light, so that one map
    /// can't cover it. Errors with `Invalid` for bad input.
    pub fn light_space(
        &self,
        view: &View<'_>,
        size: u32,
        margin: f32,
    ) -> Result<LightSpace, RecipeError> {
        view.validate()?;
        self.validate()?;
        let input = FitInput::new(self.without_what_it_ignores(view));
        self.single(&input, size, margin)
    }

    /// Returns the light space of a valid fit.
    fn single(
        &self,
        input: &FitInput<'_>,
        size: u32,
        margin: f32,
    ) -> Result<LightSpace, RecipeError> {
        let direction = match *input.view.light {
            Light::Directional { direction, .. } => direction,
            Light::Spot { .. } | Light::Point { .. } | Light::Rect { .. } | Light::Disc { .. } => {
                return perspective::single(self, input, size, margin);
            }
        };
        Ok(match *self {
            Self::Tight => parallel::tight(input, direction, size, margin, true)?,
            Self::Whole => parallel::tight(input, direction, size, margin, false)?,
            Self::Stable { range } | Self::AroundCamera { range } => {
                let center = SphereCenter::of_fit(self);
                stable::parallel(&input.view, direction, range, center, size, margin)?
            }
            Self::Manual { eye, extents } => LightSpace {
                view_from_world: look_along(eye, direction, Vec3::Y)?,
                clip_from_view: orthographic(extents)?,
            },
        })
    }

    /// Errors if a number is not finite. Values that depend on the light are checked when its light
    /// space is computed.
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
        for (name, value) in [
            ("left", left),
            ("right", right),
            ("bottom", bottom),
            ("top", top),
            ("near", near),
            ("far", far),
        ] {
            invalid::finite(&format!("manual fit's {name}"), &[value])?;
        }
        Ok(())
    }

    /// Returns the view without the visible receivers, for fits that don't depend on them.
    fn without_what_it_ignores<'a>(&self, view: &View<'a>) -> View<'a> {
        match self {
            Self::Tight | Self::Manual { .. } => *view,
            Self::Whole | Self::Stable { .. } | Self::AroundCamera { .. } => View {
                receivers: None,
                ..*view
            },
        }
    }

    /// Returns the light spaces of a layout; parameters as for [`Fit::light_space`].
    ///
    /// # Errors
    /// Errors if [`Fit::light_space`] does. Errors with `Unsupported` for a cube around a
    /// directional light, and for cascades of a light with a position. Errors with `Invalid` for
    /// cascades with numbers out of range, or with a fit that doesn't follow the camera.
    pub fn light_spaces(
        &self,
        layout: Layout,
        view: &View<'_>,
        size: u32,
        margin: f32,
    ) -> Result<LightSpaces, RecipeError> {
        let Some(memory) = view.fits else {
            return self.find(layout, view, size, margin);
        };
        let key = FitKey {
            fit: *self,
            layout,
            size,
            margin,
        };
        memory.recall(key, || self.find(layout, view, size, margin))
    }

    /// Computes [`Fit::light_spaces`] without the view's cache.
    fn find(
        &self,
        layout: Layout,
        view: &View<'_>,
        size: u32,
        margin: f32,
    ) -> Result<LightSpaces, RecipeError> {
        view.validate()?;
        self.validate()?;
        let mut spaces = match layout {
            Layout::Cascades(cascades) => self.cascades(&cascades, view, size, margin)?,
            Layout::Auto | Layout::Single | Layout::Cube => {
                self.one_or_six(layout, view, size, margin)?
            }
        };
        if let Some(geometry) = view.geometry {
            spaces.leave_out_outside_casters(geometry, size);
        }
        Ok(spaces)
    }

    /// Returns the light spaces of any layout but [`Layout::Cascades`].
    fn one_or_six(
        &self,
        layout: Layout,
        view: &View<'_>,
        size: u32,
        margin: f32,
    ) -> Result<LightSpaces, RecipeError> {
        let input = &FitInput::new(self.without_what_it_ignores(view));
        match (layout, view.light.position()) {
            (Layout::Cube, None) => Err(RecipeError::unsupported_because(
                "a directional light has no position for a cube",
            )),
            (Layout::Cube, Some(eye)) => perspective::cube(self, input, eye, size, margin),
            (Layout::Auto, Some(eye)) => self.one_or_cube(input, eye, size, margin),
            (Layout::Single | Layout::Cascades(_), _) | (Layout::Auto, None) => {
                self.one(input, size, margin)
            }
        }
    }

    fn cascades(
        &self,
        cascades: &Cascades,
        view: &View<'_>,
        size: u32,
        margin: f32,
    ) -> Result<LightSpaces, RecipeError> {
        let input = self.cascade_input(cascades, view)?;
        if cascades.count > 1 {
            return input.spaces(size, margin);
        }
        // One slice covers everything.
        self.one(
            &FitInput::new(self.without_what_it_ignores(view)),
            size,
            margin,
        )
    }

    fn cascade_input<'a>(
        &self,
        cascades: &Cascades,
        view: &View<'a>,
    ) -> Result<CascadeInput<'a>, RecipeError> {
        let Light::Directional { direction, .. } = *view.light else {
            return Err(RecipeError::unsupported_because(format!(
                "cascades require a directional light, and this is a {} light: use `Layout::Auto`",
                view.light.kind()
            )));
        };
        Ok(CascadeInput::new(self, cascades, view, direction)?)
    }

    /// Returns the ends of the slices of cascades, for programs that keep them stable over many
    /// frames, see [`SliceEnds::stabilized`].
    ///
    /// # Errors
    /// Errors if [`Fit::light_spaces`] with [`Layout::Cascades`] does.
    pub fn slice_ends(
        &self,
        cascades: &Cascades,
        view: &View<'_>,
    ) -> Result<SliceEnds, RecipeError> {
        view.validate()?;
        Ok(self.cascade_input(cascades, view)?.ends())
    }

    fn one(
        &self,
        input: &FitInput<'_>,
        size: u32,
        margin: f32,
    ) -> Result<LightSpaces, RecipeError> {
        let space = self.single(input, size, margin)?;
        Ok(LightSpaces::with_all_casters(vec![space]))
    }

    /// Returns one space if it suffices (see [`Layout::Auto`]), otherwise a cube's six.
    fn one_or_cube(
        &self,
        input: &FitInput<'_>,
        eye: Vec3,
        size: u32,
        margin: f32,
    ) -> Result<LightSpaces, RecipeError> {
        let cube = || perspective::cube(self, input, eye, size, margin);
        let one = match self.one(input, size, margin) {
            Err(RecipeError::Unsupported(_)) => return cube(),
            other => other?,
        };
        if perspective::suffices(&one.spaces[0], input, eye, size, margin) {
            return Ok(one);
        }
        // Fall back to one map: a kernel may be too wide for the faces of a cube.
        cube().or(Ok(one))
    }
}
