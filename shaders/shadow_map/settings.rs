//! The settings of a shadow map, and the images, casts and filters that make it.

use crate::shadow_map::{Bias, CompareMethod, between, layers::ShadowMapUniforms, packing};
use glam::UVec2;
use std::sync::Arc;
use umbrage_core::{
    Cast, CastMode, Filter, FilterKernel, Fit, Format, ImageDesc, ImageId, Invalid, Layout, Light,
    LightSpaces, MAX_SIDE, RasterBias, Receive, ReceiveKernel, Receivers, Recipe, RecipeError,
    Source, View, footprint::side_for,
};

/// Sides that [`ShadowMap::sized_for`] answers are multiples of this, texels.
pub const SIDE_STEP: u32 = 16;

/// Which depth a map keeps of the surfaces that its texels show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum Surface {
    /// The nearest surface's.
    #[default]
    Nearest,
    /// The mean of the nearest two: see [`Midpoint`](crate::Midpoint).
    Midpoint,
}

/// How a map stores depth.
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

/// What a lookup beside the map finds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum Border {
    /// Nothing: it is lit, as if the map had a border of depth 1.
    #[default]
    Lit,
    /// The nearest texel of the map's edge, repeated: casters at the edge throw shadow bands
    /// without end.
    Clamp,
}

/// What becomes of receivers beyond the map's far plane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum BeyondFar {
    /// They are lit.
    #[default]
    Lit,
    /// They are compared as all others; no stored depth is beyond 1, so they are dark.
    Compared,
}

/// Square depth maps of a light, one a light space.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct ShadowMap {
    /// Side, texels.
    pub size: u32,
    /// How the map is fitted to the view.
    pub fit: Fit,
    /// What keeps receivers from shadowing themselves. Midpoints take no polygon offset.
    pub bias: Bias,
    /// How many spaces, and which.
    pub layout: Layout,
    /// Which depth is kept.
    pub surface: Surface,
    /// How it is stored.
    pub format: MapFormat,
    /// What lookups beside it find.
    pub border: Border,
    /// What becomes of receivers behind it.
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
            beyond_far: BeyondFar::Lit,
        }
    }
}

impl ShadowMap {
    /// Returns a few words for tables.
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
            (self.beyond_far == BeyondFar::Compared, "dark beyond far"),
        ];
        for (is_on, word) in others {
            if is_on {
                words.push(word.to_owned());
            }
        }
        let mut bias = self.bias;
        if self.surface == Surface::Midpoint {
            // Midpoints take no polygon offset.
            bias.raster = RasterBias::default();
        }
        words.push(bias.label());
        words.join(", ")
    }

    /// Returns the light spaces for a kernel that reaches `reach` texels beyond the receiver's own.
    ///
    /// # Errors
    /// Errors if [`Fit::light_spaces`] does; and with `Invalid` if a setting is out of its range.
    pub fn spaces(&self, view: &View<'_>, reach: f32) -> Result<LightSpaces, RecipeError> {
        self.validate()?;
        // Receivers are moved along their normals by this many texels.
        let margin = reach + self.bias.normal_offset.abs();
        self.fit.light_spaces(self.layout, view, self.size, margin)
    }

    /// Returns whether the map moves with the camera, where it isn't known what the camera sees.
    pub fn follows_camera(&self, light: &Light) -> bool {
        if matches!(self.layout, Layout::Cascades(_)) {
            return true;
        }
        match self.fit {
            // Lamps stay where they are, and with them their maps.
            Fit::Stable { .. } | Fit::AroundCamera { .. } => light.position().is_none(),
            Fit::Tight | Fit::Whole | Fit::Manual { .. } => false,
        }
    }

    /// Returns the same map with the side that a view needs: on it, for a share `quantile` (0..=1)
    /// of the `receivers` that face the light, no texel is larger than a pixel, in whichever
    /// direction it is stretched (see [`side_for`]). More is finer than the screen shows; less
    /// shows texels as steps along edges. 0.9 is a good quantile: near 1, a few receivers that the
    /// light grazes decide.
    ///
    /// `receivers` are what the view's camera sees. The side is a multiple of [`SIDE_STEP`]; where
    /// nothing that is seen faces the light, it stays as it is.
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
        // Fits leave a border of some texels, which is wider on a coarser map: the second fit has
        // the border of the new side.
        for _ in 0..2 {
            let side = side_for(&view, receivers, &map.spaces(&view, 0.0)?, quantile);
            map.size = side.map_or(map.size, |side| {
                side.next_multiple_of(SIDE_STEP).min(MAX_SIDE)
            });
        }
        Ok(map)
    }

    /// Returns the images, casts and filters that make the map: a recipe still without its lookup.
    /// `compare` is how the lookup will compare with it.
    pub fn maps(&self, spaces: &LightSpaces, compare: CompareMethod) -> Maps {
        let depth = if self.format == MapFormat::Depth16 {
            Format::Depth16
        } else {
            Format::Depth32
        };
        let mut maps = Maps::default();
        let nearest = maps.image(self.desc("shadow map", depth, spaces));
        maps.map = nearest;
        // Peeling compares depths of one surface with itself, which a polygon offset would part.
        let peeled = self.surface == Surface::Midpoint;
        let raster = if peeled {
            RasterBias::default()
        } else {
            self.bias.raster_for(compare)
        };
        self.cast(&mut maps, spaces, nearest, CastMode::Depth, raster);
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
            maps.filter(between::between(), vec![nearest, second], middle);
            maps.map = middle;
        }
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

    /// Returns the recipe of a technique that draws maps and looks them up with the kernel that
    /// `kernel` makes of their uniforms. It reaches `reach` texels beyond the receiver's own.
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

    /// Returns the same recipe with layers that lie in these spaces, which needn't be those of the
    /// map's layout.
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
        self.bias.validate().map_err(|e| e.within("shadow map"))
    }
}

/// What makes a map: see [`ShadowMap::maps`].
#[derive(Clone, Debug, Default)]
pub struct Maps {
    /// The image that is looked up: of depth, or `R32` ([`Surface::Midpoint`]), or `Rgba8`
    /// ([`MapFormat::Rgba8`]). Whoever filters it further puts the result here.
    pub map: ImageId,
    /// As [`Recipe::images`].
    pub images: Vec<ImageDesc>,
    /// As [`Recipe::casts`].
    pub casts: Vec<Cast>,
    /// As [`Recipe::filters`].
    pub filters: Vec<Filter>,
}

impl Maps {
    /// Adds an image and returns its id.
    pub fn image(&mut self, desc: ImageDesc) -> ImageId {
        self.images.push(desc);
        self.images.len() - 1
    }

    /// Adds a filter that makes the image `output` from the images `inputs`.
    pub fn filter(&mut self, kernel: Arc<dyn FilterKernel>, inputs: Vec<ImageId>, output: ImageId) {
        self.filters.push(Filter {
            kernel,
            inputs,
            tables: Vec::new(),
            output,
        });
    }

    /// Returns the recipe whose kernel looks up [`Maps::map`] alone.
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
