//! Variance shadow maps, written like a technique of a user of the library: Donnelly and Lauritzen
//! 2006, "Variance shadow maps". Depth and its square are averaged over a square of texels.
//! Chebyshev's inequality bounds the fraction that is farther than the receiver. Light bleeds where
//! casters overlap in depth.

use serde::{Deserialize, Serialize};
use std::sync::Arc;
use umbrage::{
    FilterKernel, Format, ImageDesc, ImageView, Inputs, Kernel, Layout, Module, ReceiveKernel,
    Recipe, RecipeError, ShadowTechnique, Span, UniformBlock, View,
    glam::{IVec2, UVec2},
    module,
    techniques::{
        CompareMethod, ListedTechnique, MapFormat, ShadowMap, Surface,
        lanes::batch::{Taps, look_up_span},
        shadow_map::{coord::ShadowCoord, layers::ShadowMapUniforms},
    },
    uniforms,
};
use umbrage_plan::catalogue::CataloguedTechnique;

/// The technique. Its fields are its parameters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Variance {
    /// Settings of the depth map for the moments.
    pub map: ShadowMap,
    /// Blur radius, texels.
    pub radius: u32,
    /// Least variance, squared clip depth. It hides rounding errors.
    pub least_variance: f32,
}

impl Default for Variance {
    fn default() -> Self {
        Self {
            map: ShadowMap::default(),
            radius: 2,
            least_variance: 1e-6,
        }
    }
}

/// Makes the technique available in presets and lists, like those of the library.
impl ListedTechnique for Variance {
    const SUMMARY: &'static str =
        "Chebyshev's bound on blurred moments of depth (Donnelly, Lauritzen 2006)";

    fn settings(&self) -> String {
        format!("blur {}, {}", self.radius, self.map.label())
    }

    fn map(&self) -> Option<&ShadowMap> {
        Some(&self.map)
    }

    fn with_map(self, map: ShadowMap) -> Self {
        Self { map, ..self }
    }
}

/// Adds its default settings to `compare`, `stability` and `plan`.
impl CataloguedTechnique for Variance {
    /// Returns the radius of the blur, since the lookup reads one blurred texel.
    fn kernel_reach(&self) -> Option<f32> {
        Some(self.radius as f32)
    }
}

impl ShadowTechnique for Variance {
    fn name(&self) -> &'static str {
        "variance"
    }

    fn recipe(&self, view: &View<'_>) -> Result<Recipe, RecipeError> {
        // One map of plain depth. The filters below would also work for six.
        let map = ShadowMap {
            layout: Layout::Single,
            surface: Surface::Nearest,
            format: MapFormat::Depth32,
            ..self.map
        };
        let spaces = map.spaces(view, self.radius as f32)?;
        let image = |label| ImageDesc {
            label,
            size: UVec2::splat(map.size),
            layers: 1,
            format: Format::Rg32,
        };
        let blur = |x, y| {
            Arc::new(Blur(BlurUniforms {
                step: IVec2::new(x, y),
                radius: self.radius as i32,
                size: map.size as i32,
            }))
        };
        let reach = self.radius as f32;
        let mut maps = map.maps(&spaces, CompareMethod::Taps { reach });
        let moments = maps.image(image("moments"));
        let blurred_once = maps.image(image("blurred once"));
        maps.filter(Arc::new(Moments), vec![maps.map], moments);
        maps.filter(blur(1, 0), vec![moments], blurred_once);
        maps.filter(blur(0, 1), vec![blurred_once], moments);
        maps.map = moments;
        Ok(maps.recipe(Chebyshev(ChebyshevUniforms {
            lookup: ShadowMapUniforms::new(&map, view, &spaces),
            least_variance: self.least_variance,
        })))
    }
}

/// Maps depth to depth and its square.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moments;

impl Kernel for Moments {
    fn modules(&self) -> Vec<Module> {
        vec![module!("moments")]
    }
}

impl FilterKernel for Moments {
    fn filter(&self, inputs: &Inputs<'_>, start: UVec2, layer: u32, out: &mut [f32]) {
        for (x, texel) in out.chunks_exact_mut(2).enumerate() {
            let depth = inputs.images[0].load(start.x as i32 + x as i32, start.y as i32, layer);
            texel.copy_from_slice(&[depth, depth * depth]);
        }
    }
}

uniforms! {
    /// Uniforms of [`Blur`].
    pub struct BlurUniforms {
        /// Direction: (1, 0) along rows, (0, 1) along columns.
        pub step: IVec2,
        /// Radius in texels.
        pub radius: i32,
        /// Side of the image, texels.
        pub size: i32,
    }
}

/// The mean along a row or a column, edges repeated.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Blur(BlurUniforms);

impl Kernel for Blur {
    fn modules(&self) -> Vec<Module> {
        vec![module!("blur")]
    }

    fn uniforms(&self) -> Option<&dyn UniformBlock> {
        Some(&self.0)
    }
}

impl FilterKernel for Blur {
    fn filter(&self, inputs: &Inputs<'_>, start: UVec2, layer: u32, out: &mut [f32]) {
        let u = self.0;
        let image = inputs.images[0];
        let side = (2 * u.radius + 1) as f32;
        for (x, texel) in out.chunks_exact_mut(2).enumerate() {
            let mut sum = [0.0, 0.0];
            for i in -u.radius..=u.radius {
                let at = start.as_ivec2() + IVec2::new(x as i32, 0) + u.step * i;
                let at = at.clamp(IVec2::ZERO, IVec2::splat(u.size - 1));
                let first = image.index(at.x, at.y, layer);
                sum = [
                    sum[0] + image.texels[first],
                    sum[1] + image.texels[first + 1],
                ];
            }
            texel.copy_from_slice(&[sum[0] / side, sum[1] / side]);
        }
    }
}

uniforms! {
    /// Uniforms of [`Chebyshev`].
    pub struct ChebyshevUniforms {
        /// The map: its layers and comparison settings.
        pub lookup: ShadowMapUniforms,
        /// Least variance, squared clip depth.
        pub least_variance: f32,
    }
}

/// The bound on the lit fraction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Chebyshev(ChebyshevUniforms);

impl Kernel for Chebyshev {
    fn modules(&self) -> Vec<Module> {
        self.0.lookup.modules(&[module!("receive")])
    }

    fn uniforms(&self) -> Option<&dyn UniformBlock> {
        Some(&self.0)
    }
}

impl ReceiveKernel for Chebyshev {
    fn receive(&self, inputs: &Inputs<'_>, span: &Span<'_>, out: &mut [f32]) {
        let bound = Bound {
            uniforms: &self.0,
            moments: inputs.images[0],
        };
        // Find each receiver's position on the map, in vector lanes, like the library's techniques.
        look_up_span(inputs.simd, &self.0.lookup, span, out, &bound);
    }
}

/// The bound at one receiver.
struct Bound<'a> {
    uniforms: &'a ChebyshevUniforms,
    moments: ImageView<'a>,
}

impl Taps for Bound<'_> {
    #[inline(always)]
    fn visibility(&self, l: &ShadowCoord, _: usize) -> f32 {
        let x = l.texel.x.floor() as i32;
        let y = l.texel.y.floor() as i32;
        let size = self.uniforms.lookup.size as i32;
        if x < 0 || y < 0 || x >= size || y >= size {
            return 1.0;
        }
        let first = self.moments.index(x, y, 0);
        let mean = self.moments.texels[first];
        let square = self.moments.texels[first + 1];
        // Receivers beyond the map are compared at its far end.
        let depth = l.own_depth();
        if depth <= mean {
            return 1.0;
        }
        let variance = (square - mean * mean).max(self.uniforms.least_variance);
        let d = depth - mean;
        variance / (variance + d * d)
    }
}
