//! Moment shadow maps: the mean of the first four powers of depth, blurred once, and the least
//! shadow that is consistent with them.
//!
//! Peters and Klein 2015, "Moment shadow mapping" (I3D). Of all depth distributions with four given
//! moments, the one with the least shadow has three depths. One is the receiver's; the others are
//! the zeros of a quadratic. So two blockers and one receiver, or one blocker and two receivers,
//! are represented exactly; two moments ([`Vsm`](crate::Vsm)) represent one and one. If depths are
//! limited to the map's near and far planes, distributions of four depths leak even less
//! (Hausdorff's moment problem; without limits it is Hamburger's). Depths are from -1 to 1. The
//! bias mixes in the moments (0, 3/8, 0, 3/8) of depths far apart, as in Peters, Münstermann,
//! Wetzstein and Klein 2017, "Improved moment shadow maps for translucent occluders, soft shadows
//! and single scattering".
//!
//! On a sloping plane, the least shadow is up to half. No bound distinguishes the plane from a
//! blocker at the plane's nearest depth. So the receiver is moved nearer by a standard deviation of
//! its plane's depths within the filter. [`Bias::ADAPTIVE`](crate::Bias::ADAPTIVE) and
//! [`Bias::RECEIVER_PLANE`](crate::Bias::RECEIVER_PLANE) provide the plane; with other biases
//! slopes are grey.
//!
//! Known failures: three or more depths in the filter bleed light, but less than with two moments.
//! Fourth powers need most of a float's 24 bits. So `moment_bias` lights receivers within some
//! thousandths of the map's depth behind a blocker: feet and thin slices. All penumbrae have one
//! width, and light leaks into contacts as far as the blur reaches. The failures of every map also
//! apply: see [`shadow_map`](crate::shadow_map). Moments use 16 bytes per texel, 8
//! with 16 bits.

use crate::{
    filtering::moments::{
        hamburger::{HAMBURGER, hamburger},
        hausdorff::{HAUSDORFF, hausdorff},
        look_up::{self, LightBound, look_up, moment_kernel},
        map::{self, BleedingReduction, MomentImages},
        mipmaps::MipmapUniforms,
        of_depth::MomentKind,
        stored::MomentPrecision,
    },
    shadow_map::{ShadowMap, coord::ShadowCoord, layers::ShadowMapUniforms, variants::constant},
    techniques::map_technique::MapFilter,
};
use glam::Vec4;
use umbrage_core::{
    Inputs, Kernel, Module, ReceiveKernel, Recipe, RecipeError, Span, UniformBlock, View, module,
    uniforms,
};

/// Class of depth distributions that the reconstruction assumes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum Reconstruction {
    /// Any distribution, with three depths. Somewhat cheaper.
    Hamburger,
    /// Distributions between the map's near and far plane, with three or four depths.
    #[default]
    Hausdorff,
}

/// Least shadow from four moments.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct Msm {
    /// Number of texels on each side that are averaged, 0 to [`MAX_BLUR`](crate::MAX_BLUR).
    pub blur: u32,
    /// Number of mipmap levels beyond the first, 0 to [`MAX_MIPMAPS`](crate::MAX_MIPMAPS), down to
    /// levels 16 texels wide. They are used for pixels that span several texels. Without them, such
    /// pixels are as noisy under a moving camera as a single texel.
    pub mipmaps: u32,
    /// Bits per moment.
    pub precision: MomentPrecision,
    /// Class of depth distributions.
    pub reconstruction: Reconstruction,
    /// Weight of a fixed distribution that is mixed into the moments, 0 to 1, to hide rounding. If
    /// it is `None`, the precision determines it: 0.000003 with 32 bits, 0.00006 with 16 (the
    /// latter from Peters and others 2017).
    pub moment_bias: Option<f32>,
    /// Light-bleeding reduction, 0 to [`MAX_BLEEDING_REDUCTION`](crate::MAX_BLEEDING_REDUCTION):
    /// light up to this value counts as none, and the rest is stretched.
    pub bleeding_reduction: f32,
}

impl Default for Msm {
    fn default() -> Self {
        Self {
            blur: 3,
            mipmaps: 0,
            precision: MomentPrecision::Bits32,
            reconstruction: Reconstruction::Hausdorff,
            moment_bias: None,
            bleeding_reduction: 0.1,
        }
    }
}

impl MapFilter for Msm {
    const NAME: &'static str = "msm";
    const SUMMARY: &'static str =
        "the least shadow consistent with four blurred powers of depth (Peters, Klein 2015)";

    fn recipe(&self, map: &ShadowMap, view: &View<'_>) -> Result<Recipe, RecipeError> {
        let moment_bias = self.moment_bias.unwrap_or(match self.precision {
            MomentPrecision::Bits32 => MOMENT_BIAS_32,
            MomentPrecision::Bits16 => MOMENT_BIAS_16,
        });
        map::check("moment bias", moment_bias, 0.0, 1.0)?;
        let bleeding =
            BleedingReduction::new(self.bleeding_reduction)?.with_moment_bias(moment_bias);
        let images = self.images();
        let kernel = |lookup, mipmaps| MsmKernel {
            images,
            reconstruction: self.reconstruction,
            uniforms: MsmUniforms {
                lookup,
                mipmaps,
                bleeding: bleeding.amount,
                bleeding_scale: bleeding.scale,
                moment_bias,
                plane_deviation: plane_deviation(self.blur),
            },
        };
        images.recipe(map, view, kernel)
    }

    fn follows_camera(&self) -> bool {
        self.mipmaps > 0
    }

    fn label(&self) -> String {
        let reconstruction = match self.reconstruction {
            Reconstruction::Hamburger => "hamburger",
            Reconstruction::Hausdorff => "hausdorff",
        };
        let mut words = vec![reconstruction.to_owned()];
        words.extend(self.images().words());
        words.extend(self.moment_bias.map(|bias| format!("moment bias {bias}")));
        if self.bleeding_reduction != Self::default().bleeding_reduction {
            words.push(format!("bleeding {}", self.bleeding_reduction));
        }
        words.join(", ")
    }
}

impl Msm {
    fn images(&self) -> MomentImages {
        MomentImages {
            kind: MomentKind::Powers,
            precision: self.precision,
            blur: self.blur,
            mipmaps: self.mipmaps,
        }
    }
}

/// Bias of 32-bit moments.
const MOMENT_BIAS_32: f32 = 3e-6;
/// Bias of 16-bit moments.
const MOMENT_BIAS_16: f32 = 6e-5;

uniforms! {
    /// Uniforms of [`MsmKernel`].
    pub struct MsmUniforms {
        /// Layers of the map and how it is looked up.
        pub lookup: ShadowMapUniforms,
        /// Levels, and the data for selecting them.
        pub mipmaps: MipmapUniforms,
        /// Light that counts as none, 0..1.
        pub bleeding: f32,
        /// Stretch factor of the rest.
        pub bleeding_scale: f32,
        /// Weight of a fixed distribution that is mixed into the moments, 0..=1.
        pub moment_bias: f32,
        /// Standard deviation of the depths of a plane within the filter, relative to the plane's
        /// slope per texel.
        pub plane_deviation: f32,
    }
}

/// Receive kernel of MSM.
#[derive(Clone, Copy, Debug)]
pub struct MsmKernel {
    images: MomentImages,
    reconstruction: Reconstruction,
    /// Uniforms.
    pub uniforms: MsmUniforms,
}

const THREE_DEPTHS: Module = constant!("IS_HAUSDORFF = false");
const THREE_OR_FOUR: Module = constant!("IS_HAUSDORFF = true");

moment_kernel!(MsmKernel);

impl Kernel for MsmKernel {
    fn modules(&self) -> Vec<Module> {
        let own = module!("msm");
        let reconstruction = match self.reconstruction {
            Reconstruction::Hamburger => THREE_DEPTHS,
            Reconstruction::Hausdorff => THREE_OR_FOUR,
        };
        let own = [HAMBURGER, HAUSDORFF, reconstruction, own];
        look_up::modules(self.moment_map(), &own)
    }

    fn uniforms(&self) -> Option<&dyn UniformBlock> {
        Some(&self.uniforms)
    }
}

impl ReceiveKernel for MsmKernel {
    fn receive(&self, inputs: &Inputs<'_>, span: &Span<'_>, out: &mut [f32]) {
        let u = &self.uniforms;
        let map = self.moment_map();
        match self.reconstruction {
            Reconstruction::Hamburger => {
                look_up(inputs, map, span, out, &MsmBound::<false>(u));
            }
            Reconstruction::Hausdorff => {
                look_up(inputs, map, span, out, &MsmBound::<true>(u));
            }
        }
    }
}

/// Moments that are mixed in: three eighths of the depths are at the map's two ends, and the rest
/// at its centre.
const BIAS_MOMENTS: [f32; 4] = [0.0, 0.375, 0.0, 0.375];

impl MsmUniforms {
    /// Returns the moments mixed with [`BIAS_MOMENTS`].
    #[inline(always)]
    fn biased_moments(&self, moments: [f32; 4]) -> Vec4 {
        // Process one at a time, and not four at once, so that a loop over receivers is vectorised.
        let mut out = [0.0; 4];
        for (i, out) in out.iter_mut().enumerate() {
            *out = moments[i] + (BIAS_MOMENTS[i] - moments[i]) * self.moment_bias;
        }
        Vec4::from_array(out)
    }
}

/// Returns the standard deviation of the depths of a plane within the filter, relative to the
/// plane's slope per texel.
///
/// The positions of the n texels of a box have a variance of (n² - 1) / 12 texels² along each axis.
/// A blend of two neighbours adds up to 1/4.
fn plane_deviation(blur: u32) -> f32 {
    let side = (2 * blur + 1) as f32;
    let variance = (side * side + 2.0) / 12.0;
    variance.sqrt()
}

impl MsmUniforms {
    /// Returns the clip depth to compare: nearer than the receiver by a standard deviation of its
    /// plane's depths.
    ///
    /// The depths of a plane are symmetric around their mean. The distribution with their four
    /// moments and the least shadow has depths nearer than the receiver, until the receiver is a
    /// standard deviation nearer than the mean. The plane begins to be lit there; at the mean
    /// itself, up to half of it is dark. (Orthogonal polynomials of a symmetric distribution: the
    /// zeros of the second are one deviation from the mean.)
    #[inline(always)]
    fn compared_depth(&self, l: &ShadowCoord, spread: f32) -> f32 {
        let slope = (l.gradient.x * l.gradient.x + l.gradient.y * l.gradient.y).sqrt();
        l.depth - spread_deviation(self.plane_deviation, spread) * slope
    }
}

/// Returns the standard deviation of a plane's depths if a coarser level adds `spread` to the
/// variance of positions, texels squared.
#[inline(always)]
fn spread_deviation(deviation: f32, spread: f32) -> f32 {
    if spread > 0.0 {
        (deviation * deviation + spread).sqrt()
    } else {
        deviation
    }
}

/// Twin of msm.wgsl, with its constant.
struct MsmBound<'a, const IS_HAUSDORFF: bool>(&'a MsmUniforms);

impl<const IS_HAUSDORFF: bool> LightBound<4> for MsmBound<'_, IS_HAUSDORFF> {
    #[inline(always)]
    fn lit_fraction(&self, moments: [f32; 4], depth: f32) -> f32 {
        let moments = self.0.biased_moments(moments);
        if IS_HAUSDORFF {
            hausdorff(moments, depth)
        } else {
            hamburger(moments, depth)
        }
    }

    #[inline(always)]
    fn compared_depth(&self, l: &ShadowCoord, spread: f32) -> f32 {
        self.0.compared_depth(l, spread)
    }
}
