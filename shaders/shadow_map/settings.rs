//! Settings of a shadow map, and its light spaces.

use super::Bias;
#[cfg(doc)]
use super::packing;
use umbrage_core::{
    Fit, Invalid, Layout, Light, LightSpaces, MAX_SIDE, RasterBias, Receivers, RecipeError, View,
    footprint::side_for,
};

/// Granularity of the sides that [`ShadowMap::sized_for`] returns, texels.
pub const SIDE_STEP: u32 = 16;

/// Depth that a map stores per texel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum Surface {
    /// Depth of the nearest surface.
    #[default]
    Nearest,
    /// Mean of the nearest two depths: see [`Midpoint`](crate::Midpoint).
    Midpoint,
}

/// Storage format of depth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum MapFormat {
    /// 32-bit floats.
    #[default]
    Depth32,
    /// 16 bits: half the memory, steps of 1/65535.
    Depth16,
    /// Four 8-bit channels, for devices that cannot read depth images: see [`packing`].
    Rgba8,
}

/// Result of lookups outside the map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum Border {
    /// Lit, as if the map had a border of depth 1.
    #[default]
    Lit,
    /// Nearest texel of the map's edge, repeated: casters at the edge cast endless shadow bands.
    Clamp,
}

/// Result for receivers beyond the map's far plane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum BeyondFar {
    /// Compared as if they were on the far plane. All casters on the map are before it, so these
    /// receivers get the same shadows as if the map were deeper.
    #[default]
    Clamped,
    /// Lit.
    Lit,
    /// Compared like all others. They are dark, since no stored depth exceeds 1.
    Compared,
}

/// Square depth maps of a light, one per light space.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct ShadowMap {
    /// Side, texels.
    pub size: u32,
    /// Fit of the map to the view.
    pub fit: Fit,
    /// Bias that keeps receivers from shadowing themselves. Midpoints ignore its polygon offset.
    pub bias: Bias,
    /// Number and kind of light spaces.
    pub layout: Layout,
    /// Depth that is stored.
    pub surface: Surface,
    /// Storage format.
    pub format: MapFormat,
    /// Result of lookups outside the map.
    pub border: Border,
    /// Result for receivers beyond the far plane.
    pub beyond_far: BeyondFar,
}

impl Default for ShadowMap {
    fn default() -> Self {
        Self {
            size: 1024,
            fit: Fit::Tight,
            bias: Bias::ADAPTIVE,
            layout: Layout::Auto,
            surface: Surface::Nearest,
            format: MapFormat::Depth32,
            border: Border::Lit,
            beyond_far: BeyondFar::Clamped,
        }
    }
}

impl ShadowMap {
    /// Returns a short label for tables.
    pub fn label(&self) -> String {
        let layout = match &self.layout {
            Layout::Auto => String::new(),
            Layout::Single => "one map".to_owned(),
            Layout::Cube => "cube".to_owned(),
            Layout::Cascades(cascades) => cascades.label(),
        };
        let mut words = vec![self.size.to_string(), self.fit.label(), layout];
        words.retain(|word| !word.is_empty());
        let others = [
            (self.surface == Surface::Midpoint, "midpoint"),
            (self.format == MapFormat::Depth16, "16 bit"),
            (self.format == MapFormat::Rgba8, "rgba8"),
            (self.border == Border::Clamp, "edge repeated"),
            (self.beyond_far == BeyondFar::Lit, "lit beyond far"),
            (self.beyond_far == BeyondFar::Compared, "dark beyond far"),
        ];
        for (is_on, word) in others {
            if is_on {
                words.push(word.to_owned());
            }
        }
        let mut bias = self.bias;
        if self.surface == Surface::Midpoint {
            // Midpoints ignore the polygon offset.
            bias.raster = RasterBias::default();
        }
        words.push(bias.label());
        words.join(", ")
    }

    /// Returns the light spaces for a kernel that reaches `reach` texels beyond the receiver's own.
    ///
    /// # Errors
    /// Errors if [`Fit::light_spaces`] does, or with `Invalid` if a setting is out of range.
    pub fn spaces(&self, view: &View<'_>, reach: f32) -> Result<LightSpaces, RecipeError> {
        self.validate()?;
        // Receivers move along their normals by this many texels.
        let margin = reach + self.bias.normal_offset.abs();
        self.fit.light_spaces(self.layout, view, self.size, margin)
    }

    /// Returns whether the map moves with the camera if the visible receivers aren't known.
    pub fn follows_camera(&self, light: &Light) -> bool {
        if matches!(self.layout, Layout::Cascades(_)) {
            return true;
        }
        match self.fit {
            // Lights with a position stay in place, and so do their maps.
            Fit::Stable { .. } | Fit::AroundCamera { .. } => light.position().is_none(),
            Fit::Tight | Fit::Whole | Fit::Manual { .. } => false,
        }
    }

    /// Returns the same map with the side that a view needs. For a fraction `quantile` (0..=1) of
    /// the `receivers` that face the light, no texel is then larger than a pixel in any direction
    /// (see [`side_for`]). A larger side is finer than the screen resolves; a smaller side shows
    /// texels as steps along edges. 0.9 is a good quantile. Near 1, a few receivers at grazing
    /// light dominate.
    ///
    /// `receivers` are the surfaces that are visible from the view's camera. The side is a multiple
    /// of [`SIDE_STEP`]. It is unchanged if no visible receiver faces the light.
    ///
    /// # Errors
    /// Errors if [`ShadowMap::spaces`] does.
    pub fn sized_for(
        &self,
        view: &View<'_>,
        receivers: &Receivers,
        quantile: f32,
    ) -> Result<Self, RecipeError> {
        let view = view.with_receivers(receivers);
        let mut map = *self;
        // Fit twice: fits leave a border of some texels, and the second fit uses the border of the
        // new side.
        for _ in 0..2 {
            let side = side_for(&view, receivers, &map.spaces(&view, 0.0)?, quantile);
            map.size = side.map_or(map.size, |side| {
                side.next_multiple_of(SIDE_STEP).min(MAX_SIDE)
            });
        }
        Ok(map)
    }

    fn validate(&self) -> Result<(), Invalid> {
        if self.size == 0 {
            return Err(Invalid::new(
                "shadow map",
                "has a side of 0 texels",
                "use 1 or more, such as 1024",
            ));
        }
        self.bias
            .validate()
            .map_err(|e| e.within_context("shadow map"))
    }
}
