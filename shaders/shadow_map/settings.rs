//! Settings of a shadow map, and the images, casts and filters that produce it.

use crate::shadow_map::{Bias, CompareMethod, between, layers::ShadowMapUniforms, packing};
use glam::UVec2;
use std::sync::Arc;
use umbrage_core::{
    Cast, CastMode, Filter, FilterKernel, Fit, Format, ImageDesc, ImageId, Invalid, Layout, Light,
    LightSpaces, MAX_SIDE, RasterBias, Receive, ReceiveKernel, Receivers, Recipe, RecipeError,
    Source, View, footprint::side_for,
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

    /// Returns the images, casts and filters that produce the map: a recipe without its lookup.
    /// `compare` is the comparison method of the lookup.
    pub fn maps(&self, spaces: &LightSpaces, compare: CompareMethod) -> Maps {
        let depth = if self.format == MapFormat::Depth16 {
            Format::Depth16
        } else {
            Format::Depth32
        };
        let mut maps = Maps::default();
        let nearest = maps.image(self.desc("shadow map", depth, spaces));
        maps.map = nearest;
        // Peeling compares depths of one surface with itself, which a polygon offset would
        // separate.
        let peeled = self.surface == Surface::Midpoint;
        let raster = if peeled {
            RasterBias::default()
        } else {
            self.bias.raster_for(compare)
        };
        // Draw the nearest depths.
        self.cast(&mut maps, spaces, nearest, CastMode::Depth, raster);
        // Peel the second surface, and store the mean of both.
        if self.surface == Surface::Midpoint {
            let second = maps.image(self.desc("second depth", depth, spaces));
            self.cast(
                &mut maps,
                spaces,
                second,
                CastMode::DepthPeel(nearest),
                raster,
            );
            let middle = maps.image(self.desc("midpoint", Format::R32, spaces));
            maps.filter(between::depth_mean_filter(), vec![nearest, second], middle);
            maps.map = middle;
        }
        // Pack the depths.
        if self.format == MapFormat::Rgba8 {
            let packed = maps.image(self.desc("packed depth", Format::Rgba8, spaces));
            maps.filter(packing::pack(), vec![maps.map], packed);
            maps.map = packed;
        }
        maps
    }

    fn desc(&self, label: &'static str, format: Format, spaces: &LightSpaces) -> ImageDesc {
        ImageDesc {
            label,
            size: UVec2::splat(self.size),
            layers: spaces.spaces.len() as u32,
            format,
        }
    }

    fn cast(
        &self,
        maps: &mut Maps,
        spaces: &LightSpaces,
        image: ImageId,
        mode: CastMode,
        bias: RasterBias,
    ) {
        let layers = spaces.spaces.iter().zip(&spaces.casters);
        for (layer, (&space, casters)) in (0..).zip(layers) {
            if casters.is_empty() {
                continue;
            }
            maps.casts.push(Cast {
                source: Source::from(casters),
                mode,
                cull: self.bias.cull,
                bias,
                ..Cast::nearest(image, layer, space)
            });
        }
    }

    /// Returns the recipe of a technique that draws maps and looks them up. `kernel` builds the
    /// kernel from the maps' uniforms. It reaches `reach` texels beyond the receiver's own.
    ///
    /// # Errors
    /// Errors if [`ShadowMap::spaces`] does.
    pub fn recipe<K: ReceiveKernel + 'static>(
        &self,
        view: &View<'_>,
        reach: f32,
        kernel: impl FnOnce(ShadowMapUniforms) -> K,
    ) -> Result<Recipe, RecipeError> {
        let spaces = self.spaces(view, reach)?;
        Ok(self.recipe_in(&spaces, view, reach, kernel))
    }

    /// Returns the recipe with layers for these spaces, which may differ from those of the map's
    /// layout.
    ///
    /// Panics if there are no spaces.
    pub fn recipe_in<K: ReceiveKernel + 'static>(
        &self,
        spaces: &LightSpaces,
        view: &View<'_>,
        reach: f32,
        kernel: impl FnOnce(ShadowMapUniforms) -> K,
    ) -> Recipe {
        let kernel = kernel(ShadowMapUniforms::new(self, view, spaces));
        let compare = if kernel.compares() {
            CompareMethod::Samples
        } else {
            CompareMethod::Taps { reach }
        };
        self.maps(spaces, compare).recipe(kernel)
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

/// Images and passes that produce a map: see [`ShadowMap::maps`].
#[derive(Clone, Debug, Default)]
pub struct Maps {
    /// Image that is looked up: depth, `R32` ([`Surface::Midpoint`]), or `Rgba8`
    /// ([`MapFormat::Rgba8`]). Set this to the result of any further filter.
    pub map: ImageId,
    /// Images of the recipe: see [`Recipe::images`].
    pub images: Vec<ImageDesc>,
    /// Casts of the recipe: see [`Recipe::casts`].
    pub casts: Vec<Cast>,
    /// Filters of the recipe: see [`Recipe::filters`].
    pub filters: Vec<Filter>,
}

impl Maps {
    /// Adds an image and returns its id.
    pub fn image(&mut self, desc: ImageDesc) -> ImageId {
        self.images.push(desc);
        self.images.len() - 1
    }

    /// Adds a filter that computes the image `output` from the images `inputs`.
    pub fn filter(&mut self, kernel: Arc<dyn FilterKernel>, inputs: Vec<ImageId>, output: ImageId) {
        self.filters.push(Filter {
            kernel,
            inputs,
            tables: Vec::new(),
            output,
        });
    }

    /// Returns the recipe whose kernel only looks up [`Maps::map`].
    pub fn recipe<K: ReceiveKernel + 'static>(self, kernel: K) -> Recipe {
        let inputs = vec![self.map];
        Recipe {
            images: self.images,
            tables: Vec::new(),
            casts: self.casts,
            filters: self.filters,
            receive: Receive {
                kernel: Arc::new(kernel),
                inputs,
                tables: Vec::new(),
            },
            shade: None,
            keep_images: false,
        }
    }
}
