//! Moment shadow maps: the mean of the first four powers of depth, blurred once, and the least
//! shadow that they allow.
//!
//! Peters and Klein 2015, "Moment shadow mapping" (I3D). Of all distributions of depth with four
//! given moments, the one with the least shadow has three depths, one of them the receiver's: they
//! are the zeros of a quadratic. So two blockers and one receiver, or one blocker and two
//! receivers, are known without doubt, where two moments ([`Vsm`](crate::Vsm)) know one and one.
//! Where depths end at the map's near and far planes (Hausdorff's moment problem; without ends it
//! is Hamburger's), distributions of four depths leak less still. Depths are counted from -1 to 1,
//! and the bias mixes in the moments (0, 3/8, 0, 3/8) of depths far apart, as Peters, Münstermann,
//! Wetzstein and Klein 2017 have it ("Improved moment shadow maps for translucent occluders, soft
//! shadows and single scattering").
//!
//! On a plane that slopes, the least shadow is up to half: no bound tells it from a blocker that is
//! as near as the plane's nearest part. So the receiver counts as nearer by a standard deviation of
//! its own plane's depths within the filter ([`Bias::ADAPTIVE`](crate::Bias::ADAPTIVE) and
//! [`Bias::RECEIVER_PLANE`](crate::Bias::RECEIVER_PLANE) give the plane; with other biases slopes
//! are grey).
//!
//! Known failures: three and more depths in the filter bleed light, less than with two moments;
//! fourth powers need most of a float's 24 bits, so that `moment_bias` lights what lies within some
//! thousandths of the map's depth behind a blocker: feet and thin slices. One width for all
//! penumbrae, light in contacts as far as the blur reaches, and every map's failures: see
//! [`shadow_map`](crate::shadow_map). Maps take 32 bytes a texel while they are blurred.

use crate::{
    filtering::moments::{
        hamburger::{HAMBURGER, hamburger},
        hausdorff::{HAUSDORFF, hausdorff},
        look_up::{self, LightBound, MomentMap, look_up},
        map::{self, BleedingReduction, MomentImages},
        mipmaps::MipmapUniforms,
        of_depth::MomentKind,
        stored::MomentPrecision,
    },
    shadow_map::{ShadowMap, coord::ShadowCoord, layers::ShadowMapUniforms, variants::constant},
    techniques::map_technique::MapFilter,
};
use glam::{Vec3, Vec4};
use umbrage_core::{
    Inputs, Kernel, Module, ReceiveKernel, Recipe, RecipeError, Span, UniformBlock, View, module,
    uniforms,
};

/// Which distributions of depth the moments may belong to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum Reconstruction {
    /// Any: three depths. Somewhat cheaper.
    Hamburger,
    /// Those between the map's near and far plane: three depths, or four.
    #[default]
    Hausdorff,
}

/// The least shadow of four moments.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct Msm {
    /// Texels to each side that are averaged, 0 to [`MAX_BLUR`](crate::MAX_BLUR).
    pub blur: u32,
    /// Levels of coarser texels beyond the map's own, 0 to [`MAX_MIPMAPS`](crate::MAX_MIPMAPS), as
    /// far as these are 16 texels wide. They answer pixels that span several texels, which else is
    /// as noisy under a moving camera as one texel is.
    pub mipmaps: u32,
    /// Bits of each moment.
    pub precision: MomentPrecision,
    /// Which distributions are allowed.
    pub reconstruction: Reconstruction,
    /// Share of a fixed distribution that is mixed into the moments, 0 to 1: hides rounding. Where
    /// it is left out, it is what the precision needs: 0.000003 with 32 bits, 0.00006 with 16 (the
    /// latter by Peters and others 2017).
    pub moment_bias: Option<f32>,
    /// Light up to this much counts as none, 0 to
    /// [`MAX_BLEEDING_REDUCTION`](crate::MAX_BLEEDING_REDUCTION); the rest is stretched.
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
        "the least shadow that four blurred powers of depth allow (Peters, Klein 2015)";

    fn recipe(&self, map: &ShadowMap, view: &View<'_>) -> Result<Recipe, RecipeError> {
        let moment_bias = self.moment_bias.unwrap_or(match self.precision {
            MomentPrecision::Bits32 => MOMENT_BIAS_32,
            MomentPrecision::Bits16 => MOMENT_BIAS_16,
        });
        map::check("moment bias", moment_bias, 0.0, 1.0)?;
        let bleeding = BleedingReduction::new(self.bleeding_reduction)?;
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
/// Bias of 16-bit ones.
const MOMENT_BIAS_16: f32 = 6e-5;

uniforms! {
    /// Uniforms of [`MsmKernel`].
    pub struct MsmUniforms {
        /// The map: its layers, and how it is looked up.
        pub lookup: ShadowMapUniforms,
        /// Its levels, and what chooses them.
        pub mipmaps: MipmapUniforms,
        /// Light that counts as none, 0..1.
        pub bleeding: f32,
        /// What the rest is stretched by.
        pub bleeding_scale: f32,
        /// Share of a fixed distribution that is mixed into the moments, 0..=1.
        pub moment_bias: f32,
        /// Standard deviation of the depths of a plane within the filter, in units of the plane's
        /// slope a texel.
        pub plane_deviation: f32,
    }
}

/// The receive kernel.
#[derive(Clone, Copy, Debug)]
pub struct MsmKernel {
    images: MomentImages,
    reconstruction: Reconstruction,
    /// Uniforms.
    pub uniforms: MsmUniforms,
}

const THREE_DEPTHS: Module = constant!("IS_HAUSDORFF = false");
const THREE_OR_FOUR: Module = constant!("IS_HAUSDORFF = true");

impl MsmKernel {
    fn moment_map(&self) -> MomentMap<'_> {
        MomentMap {
            images: self.images,
            lookup: &self.uniforms.lookup,
            mipmaps: &self.uniforms.mipmaps,
        }
    }

    /// Returns how far, in texels, the lookup of a receiver at `position` (world space) with the
    /// unit `normal` goes beyond its own texel; `None` where it is the same for all.
    pub fn lookup_reach(&self, position: Vec3, normal: Vec3) -> Option<f32> {
        self.moment_map().reach(position, normal)
    }
}

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
        let bleeding = BleedingReduction {
            amount: u.bleeding,
            scale: u.bleeding_scale,
        };
        let map = self.moment_map();
        match self.reconstruction {
            Reconstruction::Hamburger => {
                look_up(inputs, map, span, out, &HamburgerBound(u), bleeding);
            }
            Reconstruction::Hausdorff => {
                look_up(inputs, map, span, out, &HausdorffBound(u), bleeding);
            }
        }
    }
}

/// The moments that are mixed in: of depths of which three eighths lie at the map's two ends, and
/// the rest in its middle.
const BIAS_MOMENTS: [f32; 4] = [0.0, 0.375, 0.0, 0.375];

impl MsmUniforms {
    /// Returns moments, moved a little towards [`BIAS_MOMENTS`].
    #[inline(always)]
    fn biased(&self, moments: [f32; 4]) -> Vec4 {
        // One by one, and not four at once, so that a loop over receivers becomes one of vector
        // instructions.
        let mut out = [0.0; 4];
        for (i, out) in out.iter_mut().enumerate() {
            *out = moments[i] + (BIAS_MOMENTS[i] - moments[i]) * self.moment_bias;
        }
        Vec4::from_array(out)
    }
}

/// Returns the standard deviation of the depths of a plane within the filter, in units of the
/// plane's slope a texel.
///
/// Among the n texels of a box their places have a variance of (n² - 1) / 12 texels² along each
/// axis, and a blend of two neighbours adds up to 1/4.
fn plane_deviation(blur: u32) -> f32 {
    let side = (2 * blur + 1) as f32;
    let variance = (side * side + 2.0) / 12.0;
    variance.sqrt()
}

impl MsmUniforms {
    /// Returns the clip depth that is asked about: nearer than the receiver by a standard deviation
    /// of its own plane's depths.
    ///
    /// A plane's depths lie as far beyond their mean as before it. The distribution with their four
    /// moments and the least shadow has depths nearer than the receiver until this is nearer than
    /// the mean by a standard deviation: there the plane starts to be lit, where at the mean itself
    /// up to half of it is dark. (Orthogonal polynomials of a symmetric distribution: the second
    /// has its zeros one deviation from the mean.)
    #[inline(always)]
    fn compared_depth(&self, l: &ShadowCoord, spread: f32) -> f32 {
        let slope = (l.gradient.x * l.gradient.x + l.gradient.y * l.gradient.y).sqrt();
        l.depth - spread_deviation(self.plane_deviation, spread) * slope
    }
}

/// Returns the standard deviation of a plane's depths where a coarser level adds `spread` to the
/// variance of places, texels squared.
#[inline(always)]
fn spread_deviation(deviation: f32, spread: f32) -> f32 {
    if spread > 0.0 {
        (deviation * deviation + spread).sqrt()
    } else {
        deviation
    }
}

struct HamburgerBound<'a>(&'a MsmUniforms);
struct HausdorffBound<'a>(&'a MsmUniforms);

impl LightBound<4> for HamburgerBound<'_> {
    #[inline(always)]
    fn lit(&self, moments: [f32; 4], depth: f32) -> f32 {
        hamburger(self.0.biased(moments), depth)
    }

    #[inline(always)]
    fn compared_depth(&self, l: &ShadowCoord, spread: f32) -> f32 {
        self.0.compared_depth(l, spread)
    }
}

impl LightBound<4> for HausdorffBound<'_> {
    #[inline(always)]
    fn lit(&self, moments: [f32; 4], depth: f32) -> f32 {
        hausdorff(self.0.biased(moments), depth)
    }

    #[inline(always)]
    fn compared_depth(&self, l: &ShadowCoord, spread: f32) -> f32 {
        self.0.compared_depth(l, spread)
    }
}
