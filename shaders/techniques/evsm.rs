//! Exponential variance shadow maps: like [`Vsm`](crate::Vsm), with exponentials of depth instead
//! of depth.
//!
//! Lauritzen and McCool 2008, "Layered variance shadow maps". An exponential that rises with depth,
//! exp(c z), compresses the depths of blockers and spreads those of receivers. Relative to a
//! receiver, everything somewhat nearer has nearly the same value. So several blockers act like
//! one, and little light bleeds. Its weakness is the far side: if depths behind the receiver vary,
//! their variance is huge, and the receiver is lit. An exponential that falls, exp(-c z), works
//! well there, so the lesser of both bounds is used (four moments, EVSM4; two moments are EVSM2).
//!
//! Exponents beyond 42 overflow: the square of the greatest value is a 32-bit float. Larger
//! exponents reduce bleeding between blockers that are far apart in depth. They also increase light
//! leaks in contacts and on curved receivers.
//!
//! Known failures: with two moments, light leaks around feet if the blur contains floor behind
//! them. Blockers at nearly the same depth still bleed. The falling exponential darkens receivers
//! that curve within the blur. The other failures are those of `vsm` and of every map: see
//! [`shadow_map`](crate::shadow_map). Four moments use 16 bytes per texel, two use 8.

use crate::{
    filtering::moments::{
        bounds::{lit_by_falling, lit_by_rising},
        exp2::power_of_two,
        look_up::{self, LightBound, look_up, moment_kernel},
        map::{self, BleedingReduction, MomentImages},
        mipmaps::MipmapUniforms,
        of_depth::MomentKind,
        stored::MomentPrecision,
    },
    shadow_map::{ShadowMap, layers::ShadowMapUniforms, variants::constant},
    techniques::map_technique::MapFilter,
};
use glam::Vec2;
use std::f32::consts::LOG2_E;
use umbrage_core::{
    Inputs, Kernel, Module, ReceiveKernel, Recipe, RecipeError, Span, UniformBlock, View, module,
    uniforms,
};

/// Greatest exponent accepted. The square of its greatest value, exp(84), is a 32-bit float, and so
/// is 65 times as much.
pub const MAX_EVSM_EXPONENT: f32 = 42.0;

/// Exponentials of depth that a map holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum EvsmMoments {
    /// Exponential that rises with depth, and its square.
    Two,
    /// Additionally the exponential that falls with depth, and its square.
    #[default]
    Four,
}

/// Chebyshev's bound of exponentials of depth.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct Evsm {
    /// Number of texels on each side that are averaged, 0 to [`MAX_BLUR`](crate::MAX_BLUR).
    pub blur: u32,
    /// Number of mipmap levels beyond the first, 0 to [`MAX_MIPMAPS`](crate::MAX_MIPMAPS), down to
    /// levels 16 texels wide. They are used for pixels that span several texels. Without them, such
    /// pixels are as noisy under a moving camera as a single texel.
    pub mipmaps: u32,
    /// Bits per moment.
    pub precision: MomentPrecision,
    /// Exponentials of depth that the map holds.
    pub moments: EvsmMoments,
    /// Exponent of the rising exponential at the far plane, 0 to [`MAX_EVSM_EXPONENT`]; at the near
    /// plane it is negated.
    pub positive_exponent: f32,
    /// Exponent of the falling exponential at the near plane, with the same range.
    pub negative_exponent: f32,
    /// Least standard deviation of depth, clip depth, 0 to 0.5, which hides rounding on even
    /// surfaces. If it is `None`, the precision determines it: 0.00005 with 32 bits, a tenth over
    /// twice the exponent with 16 bits.
    pub least_deviation: Option<f32>,
    /// Light-bleeding reduction, 0 to [`MAX_BLEEDING_REDUCTION`](crate::MAX_BLEEDING_REDUCTION):
    /// light up to this value counts as none, and the rest is stretched.
    pub bleeding_reduction: f32,
}

impl Default for Evsm {
    fn default() -> Self {
        Self {
            blur: 3,
            mipmaps: 0,
            precision: MomentPrecision::Bits32,
            moments: EvsmMoments::Four,
            positive_exponent: 40.0,
            negative_exponent: 5.0,
            least_deviation: None,
            bleeding_reduction: 0.1,
        }
    }
}

impl MapFilter for Evsm {
    const NAME: &'static str = "evsm";
    const SUMMARY: &'static str =
        "Chebyshev's bound by blurred exponentials of depth (Lauritzen, McCool 2008)";

    fn recipe(&self, map: &ShadowMap, view: &View<'_>) -> Result<Recipe, RecipeError> {
        // Check the settings.
        if let Some(deviation) = self.least_deviation {
            map::check_deviation(deviation)?;
        }
        let bleeding = BleedingReduction::new(self.bleeding_reduction)?;
        map::check(
            "positive exponent",
            self.positive_exponent,
            0.0,
            MAX_EVSM_EXPONENT,
        )?;
        map::check(
            "negative exponent",
            self.negative_exponent,
            0.0,
            MAX_EVSM_EXPONENT,
        )?;
        // Build the kernel from the map's uniforms.
        let images = self.images();
        let kernel = |lookup, mipmaps| EvsmKernel {
            images,
            moments: self.moments,
            uniforms: EvsmUniforms {
                lookup,
                mipmaps,
                bleeding: bleeding.amount,
                bleeding_scale: bleeding.scale,
                rising: self.positive_exponent * LOG2_E,
                falling: self.negative_exponent * LOG2_E,
                least_rising: self.least_variance(self.positive_exponent),
                least_falling: self.least_variance(self.negative_exponent),
            },
        };
        images.recipe(map, view, kernel)
    }

    fn follows_camera(&self) -> bool {
        self.mipmaps > 0
    }

    fn label(&self) -> String {
        let moments = match self.moments {
            EvsmMoments::Two => 2,
            EvsmMoments::Four => 4,
        };
        let mut words = vec![format!("{moments} moments")];
        words.extend(self.images().words());
        let default = Self::default();
        let exponents = (self.positive_exponent, self.negative_exponent);
        if exponents != (default.positive_exponent, default.negative_exponent) {
            words.push(format!("exponents {} and {}", exponents.0, exponents.1));
        }
        words.extend(self.least_deviation.map(|d| format!("deviation {d}")));
        if self.bleeding_reduction != default.bleeding_reduction {
            words.push(format!("bleeding {}", self.bleeding_reduction));
        }
        words.join(", ")
    }
}

impl Evsm {
    fn images(&self) -> MomentImages {
        let rising = self.positive_exponent * LOG2_E;
        let falling = self.negative_exponent * LOG2_E;
        let kind = match self.moments {
            EvsmMoments::Two => MomentKind::OneExponential { rising },
            EvsmMoments::Four => MomentKind::TwoExponentials { rising, falling },
        };
        MomentImages {
            kind,
            precision: self.precision,
            blur: self.blur,
            mipmaps: self.mipmaps,
        }
    }

    /// Returns the least variance of an exponential, relative to its squared value. It changes by a
    /// factor of 1 + `exponent` d over a small centred depth d. Centred depth has twice the range
    /// of clip depth.
    fn least_variance(&self, exponent: f32) -> f32 {
        let deviation = match (self.least_deviation, self.precision) {
            (Some(least), _) => 2.0 * exponent * least,
            (None, MomentPrecision::Bits32) => 2.0 * exponent * LEAST_DEVIATION_32,
            (None, MomentPrecision::Bits16) => RELATIVE_DEVIATION_16,
        };
        (deviation * deviation).max(SMALLEST_VARIANCE)
    }
}

/// Least deviation of 32-bit moments, clip depth.
const LEAST_DEVIATION_32: f32 = 5e-5;
/// Least deviation of 16-bit moments, relative to the exponential. Each moment is rounded three
/// times, by up to 2^-9. At most some thousandths of the light may become dark.
const RELATIVE_DEVIATION_16: f32 = 0.1;

/// Least relative variance: it exceeds the rounding of equal values, and keeps a division finite.
const SMALLEST_VARIANCE: f32 = 1e-6;

uniforms! {
    /// Uniforms of [`EvsmKernel`].
    pub struct EvsmUniforms {
        /// Layers of the map and how it is looked up.
        pub lookup: ShadowMapUniforms,
        /// Levels, and the data for selecting them.
        pub mipmaps: MipmapUniforms,
        /// Light that counts as none, 0..1.
        pub bleeding: f32,
        /// Stretch factor of the rest.
        pub bleeding_scale: f32,
        /// Powers of two per unit of centred depth, of the exponential that rises with depth.
        pub rising: f32,
        /// Powers of two per unit of centred depth, of the exponential that falls with depth.
        pub falling: f32,
        /// Least variance of the rising exponential, relative to its squared value.
        pub least_rising: f32,
        /// Least variance of the falling exponential, relative to its squared value.
        pub least_falling: f32,
    }
}

/// Receive kernel of EVSM.
#[derive(Clone, Copy, Debug)]
pub struct EvsmKernel {
    images: MomentImages,
    moments: EvsmMoments,
    /// Uniforms.
    pub uniforms: EvsmUniforms,
}

const TWO: Module = constant!("HAS_FOUR_MOMENTS = false");
const FOUR: Module = constant!("HAS_FOUR_MOMENTS = true");

moment_kernel!(EvsmKernel);

impl Kernel for EvsmKernel {
    fn modules(&self) -> Vec<Module> {
        let own = module!("evsm");
        let count = match self.moments {
            EvsmMoments::Two => TWO,
            EvsmMoments::Four => FOUR,
        };
        look_up::modules(self.moment_map(), &[count, own])
    }

    fn uniforms(&self) -> Option<&dyn UniformBlock> {
        Some(&self.uniforms)
    }
}

impl ReceiveKernel for EvsmKernel {
    fn receive(&self, inputs: &Inputs<'_>, span: &Span<'_>, out: &mut [f32]) {
        let u = &self.uniforms;
        let map = self.moment_map();
        match self.moments {
            EvsmMoments::Two => look_up::<2>(inputs, map, span, out, u),
            EvsmMoments::Four => look_up::<4>(inputs, map, span, out, u),
        }
    }
}

impl LightBound<2> for EvsmUniforms {
    #[inline(always)]
    fn lit_fraction(&self, moments: [f32; 2], depth: f32) -> f32 {
        let receiver = power_of_two(self.rising * depth);
        lit_by_rising(Vec2::from_array(moments), receiver, self.least_rising)
    }
}

impl LightBound<4> for EvsmUniforms {
    #[inline(always)]
    fn lit_fraction(&self, moments: [f32; 4], depth: f32) -> f32 {
        let [up, up_squared, down, down_squared] = moments;
        let receiver = power_of_two(-(self.falling * depth));
        let falling = Vec2::new(down, down_squared);
        let lit = lit_by_falling(falling, receiver, self.least_falling);
        let rising: f32 = LightBound::<2>::lit_fraction(self, [up, up_squared], depth);
        rising.min(lit)
    }
}
