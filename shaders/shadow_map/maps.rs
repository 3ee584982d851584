//! Images, casts and filters that produce a shadow map, and recipes that look it up.

use super::{
    CompareMethod, MapFormat, ShadowMap, Surface, between, layers::ShadowMapUniforms, packing,
};
use glam::UVec2;
use std::sync::Arc;
use umbrage_core::{
    Cast, CastMode, Filter, FilterKernel, Format, ImageDesc, ImageId, LightSpaces, RasterBias,
    Receive, ReceiveKernel, Recipe, RecipeError, Source, View,
};

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
            hierarchy: None,
            keep_images: false,
        }
    }
}

impl ShadowMap {
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
}
