//! Variance shadow maps: the mean of depth and of its square, blurred once, and Chebyshev's bound
//! of the fraction beyond the receiver.
//!
//! Donnelly and Lauritzen 2006, "Variance shadow maps". Means of depth can be averaged further,
//! unlike comparisons with depth. So a filter of any width is one pass over the map for any
//! number of receivers, and each receiver looks up one blend of four texels. With one blocker
//! before one receiver the bound is exact: visibility equals that of filtering all comparisons.
//!
//! Known failures: if blockers of several depths are in the filter, light bleeds into their common
//! shadow. This occurs around the outline of a near blocker within the shadow of a far one, under
//! stacks of thin slices, and through a hedge. `bleeding_reduction` darkens it and narrows all
//! penumbrae. Like any filter of depths, it has one width for all penumbrae, and leaks light into
//! contacts as far as the blur reaches. Squares of depth have 24 bits: receivers nearer to their
//! blocker than `least_deviation` are partly lit. The failures of every map also apply: see
//! [`shadow_map`](crate::shadow_map). Moments use 8 bytes per texel, 4 with 16 bits,
//! in addition to the depths.

use crate::{
    filtering::moments::{
        bounds::lit_by_variance,
        look_up::{self, LightBound, look_up, moment_kernel},
        map::{self, BleedingReduction, MomentImages},
        mipmaps::MipmapUniforms,
        of_depth::MomentKind,
        stored::MomentPrecision,
    },
    shadow_map::{ShadowMap, layers::ShadowMapUniforms},
    techniques::map_technique::MapFilter,
};
use glam::Vec2;
use umbrage_core::{
    Inputs, Kernel, Module, ReceiveKernel, Recipe, RecipeError, Span, UniformBlock, View, module,
    uniforms,
};

/// Chebyshev's bound from depth and its square.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct Vsm {
    /// Number of texels on each side that are averaged, 0 to [`MAX_BLUR`](crate::MAX_BLUR).
    pub blur: u32,
    /// Number of mipmap levels beyond the first, 0 to [`MAX_MIPMAPS`](crate::MAX_MIPMAPS), down to
    /// levels 16 texels wide. They are used for pixels that span several texels. Without them, such
    /// pixels are as noisy under a moving camera as a single texel.
    pub mipmaps: u32,
    /// Bits per moment.
    pub precision: MomentPrecision,
    /// Least standard deviation of depth, clip depth, 0 to 0.5, which hides rounding on even
    /// surfaces. If it is `None`, the precision determines it: 0.0003 with 32 bits, 0.001 with 16.
    pub least_deviation: Option<f32>,
    /// Light-bleeding reduction, 0 to [`MAX_BLEEDING_REDUCTION`](crate::MAX_BLEEDING_REDUCTION):
    /// light up to this value counts as none, and the rest is stretched.
    pub bleeding_reduction: f32,
}

impl Default for Vsm {
    fn default() -> Self {
        Self {
            blur: 3,
            mipmaps: 0,
            precision: MomentPrecision::Bits32,
            least_deviation: None,
            bleeding_reduction: 0.2,
        }
    }
}

impl MapFilter for Vsm {
    const NAME: &'static str = "vsm";
    const SUMMARY: &'static str =
        "Chebyshev's bound by blurred depth and its square (Donnelly, Lauritzen 2006)";

    fn recipe(&self, map: &ShadowMap, view: &View<'_>) -> Result<Recipe, RecipeError> {
        let least_deviation = self.least_deviation.unwrap_or(match self.precision {
            MomentPrecision::Bits32 => LEAST_DEVIATION_32,
            MomentPrecision::Bits16 => LEAST_DEVIATION_16,
        });
        map::check_deviation(least_deviation)?;
        let bleeding = BleedingReduction::new(self.bleeding_reduction)?;
        // Centred depth has twice the range of clip depth.
        let deviation = 2.0 * least_deviation;
        let images = self.images();
        let kernel = |lookup, mipmaps| VsmKernel {
            images,
            uniforms: VsmUniforms {
                lookup,
                mipmaps,
                bleeding: bleeding.amount,
                bleeding_scale: bleeding.scale,
                least_variance: (deviation * deviation).max(SMALLEST_VARIANCE),
            },
        };
        images.recipe(map, view, kernel)
    }

    fn follows_camera(&self) -> bool {
        self.mipmaps > 0
    }

    fn label(&self) -> String {
        let mut words = self.images().words();
        words.extend(self.least_deviation.map(|d| format!("deviation {d}")));
        if self.bleeding_reduction != Self::default().bleeding_reduction {
            words.push(format!("bleeding {}", self.bleeding_reduction));
        }
        words.join(", ")
    }
}

impl Vsm {
    fn images(&self) -> MomentImages {
        MomentImages {
            kind: MomentKind::Variance,
            precision: self.precision,
            blur: self.blur,
            mipmaps: self.mipmaps,
        }
    }
}

/// Least deviation of 32-bit moments, clip depth.
const LEAST_DEVIATION_32: f32 = 3e-4;
/// Least deviation of 16-bit moments: their means of depth have errors of about 2e-5. At most a
/// thousandth of the light may become dark.
const LEAST_DEVIATION_16: f32 = 1e-3;

/// Least variance, so that a division stays finite.
const SMALLEST_VARIANCE: f32 = 1e-12;

uniforms! {
    /// Uniforms of [`VsmKernel`].
    pub struct VsmUniforms {
        /// Layers of the map and how it is looked up.
        pub lookup: ShadowMapUniforms,
        /// Levels, and the data for selecting them.
        pub mipmaps: MipmapUniforms,
        /// Light that counts as none, 0..1.
        pub bleeding: f32,
        /// Stretch factor of the rest.
        pub bleeding_scale: f32,
        /// Least variance, squared centred depth.
        pub least_variance: f32,
    }
}

/// Receive kernel of VSM.
#[derive(Clone, Copy, Debug)]
pub struct VsmKernel {
    images: MomentImages,
    /// Uniforms.
    pub uniforms: VsmUniforms,
}

moment_kernel!(VsmKernel);

impl Kernel for VsmKernel {
    fn modules(&self) -> Vec<Module> {
        let own = module!("vsm");
        look_up::modules(self.moment_map(), &[own])
    }

    fn uniforms(&self) -> Option<&dyn UniformBlock> {
        Some(&self.uniforms)
    }
}

impl ReceiveKernel for VsmKernel {
    fn receive(&self, inputs: &Inputs<'_>, span: &Span<'_>, out: &mut [f32]) {
        look_up(inputs, self.moment_map(), span, out, &self.uniforms);
    }
}

impl LightBound<2> for VsmUniforms {
    #[inline(always)]
    fn lit_fraction(&self, moments: [f32; 2], depth: f32) -> f32 {
        lit_by_variance(Vec2::from_array(moments), depth, self.least_variance)
    }
}
