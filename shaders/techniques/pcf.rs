//! Percentage-closer filtering on a grid: the mean of (2r + 1)² comparisons around the receiver's
//! texel.
//!
//! Reeves, Salesin and Cook 1987, "Rendering antialiased shadows with depth maps": compare first,
//! then average; r = 1 is the textbooks' 3x3. All penumbrae have the same width in texels. Wide
//! kernels need more bias, since their outer taps compare with the receiver's own surface r texels
//! away.
//!
//! Known failures: light leaks into contacts and under feet as far as the kernel reaches. At
//! creases the receiver's plane misleads outer taps (acne on stairs and hills). A constant penumbra
//! width is wrong for every area light. The failures of every map also apply: see
//! [`shadow_map`](crate::shadow_map).

use crate::{
    lanes::{
        batch::{Batch, BatchTaps, look_up_span},
        square,
    },
    shadow_map::{
        ShadowMap, coord::ShadowCoord, layers::ShadowMapUniforms, texel_compare::DepthMap,
        variants::constant,
    },
    techniques::{hard::OwnTexel, map_technique::MapFilter},
};
use umbrage_core::{
    Inputs, Invalid, Kernel, Module, ReceiveKernel, Recipe, RecipeError, Span, UniformBlock, View,
    module, uniforms,
};

/// Greatest radius accepted: 1,089 taps.
pub const MAX_RADIUS: u32 = 16;
/// Greatest radius that can be unrolled: 81 taps.
pub const MAX_UNROLLED_RADIUS: u32 = 4;

/// A square of comparisons.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct Pcf {
    /// Number of texels on each side, 0 to [`MAX_RADIUS`]; 1 is the textbooks' 3x3.
    pub radius: u32,
    /// Whether the radius is a constant of the WGSL, so that compilers unroll the loops and load
    /// several texels at once. Results are the same. If true, `radius` is at most
    /// [`MAX_UNROLLED_RADIUS`], and another radius needs another pipeline. If false, one text serves
    /// all radii; 3x3 is unrolled in a branch of it.
    #[cfg_attr(feature = "presets", serde(skip_serializing_if = "std::ops::Not::not"))]
    pub unrolled: bool,
}

impl Pcf {
    /// Returns the filter of a radius, texels, with the text for all radii.
    pub const fn new(radius: u32) -> Self {
        Self {
            radius,
            unrolled: false,
        }
    }

    /// Returns the filter of a radius, texels, with a text of its own: see the field `unrolled`.
    pub const fn unrolled(radius: u32) -> Self {
        Self {
            radius,
            unrolled: true,
        }
    }

    /// Returns the filter of a radius; for 0, with a text of its own, since a single comparison needs
    /// no loop.
    pub(super) const fn single_or_square(radius: u32) -> Self {
        match radius {
            0 => Self::unrolled(0),
            _ => Self::new(radius),
        }
    }
}

impl Default for Pcf {
    fn default() -> Self {
        Self::new(1)
    }
}

impl MapFilter for Pcf {
    const NAME: &'static str = "pcf";
    const SUMMARY: &'static str =
        "the mean of a square of comparisons (Reeves, Salesin, Cook 1987)";

    fn recipe(&self, map: &ShadowMap, view: &View<'_>) -> Result<Recipe, RecipeError> {
        if self.radius > MAX_RADIUS {
            let why = format!("is {} texels", self.radius);
            return Err(Invalid::new("pcf radius", why, format!("use 0 to {MAX_RADIUS}")).into());
        }
        if self.unrolled && self.radius > MAX_UNROLLED_RADIUS {
            let why = format!(
                "is {} texels, which is too much to be unrolled",
                self.radius
            );
            let help = format!("use 0 to {MAX_UNROLLED_RADIUS}, or `unrolled = false`");
            return Err(Invalid::new("pcf radius", why, help).into());
        }
        let radius = self.radius as i32;
        map.recipe(view, radius as f32, |lookup| PcfKernel {
            uniforms: PcfUniforms { lookup, radius },
            unrolled: self.unrolled,
        })
    }

    fn label(&self) -> String {
        let side = 2 * u64::from(self.radius) + 1;
        let unrolled = if self.unrolled { " unrolled" } else { "" };
        format!("{side}x{side}{unrolled}")
    }
}

uniforms! {
    /// Uniforms of [`PcfKernel`].
    pub struct PcfUniforms {
        /// Layers of the map and how they are compared.
        pub lookup: ShadowMapUniforms,
        /// Number of texels on each side.
        pub radius: i32,
    }
}

/// Receive kernel of PCF.
#[derive(Clone, Copy, Debug)]
pub struct PcfKernel {
    /// Map and filter radius.
    pub uniforms: PcfUniforms,
    /// Whether the radius is a constant of the WGSL, if it is in 0..=[`MAX_UNROLLED_RADIUS`].
    pub unrolled: bool,
}

const UNIFORM_RADIUS: Module = constant!("IS_RADIUS_UNIFORM = true");
const CONSTANT_RADIUS: Module = constant!("IS_RADIUS_UNIFORM = false");
/// The radius whose loops compilers unroll: the constant one, or that of a branch.
const UNROLLED_RADIUS: [Module; MAX_UNROLLED_RADIUS as usize + 1] = [
    constant!("UNROLLED_RADIUS = 0"),
    constant!("UNROLLED_RADIUS = 1"),
    constant!("UNROLLED_RADIUS = 2"),
    constant!("UNROLLED_RADIUS = 3"),
    constant!("UNROLLED_RADIUS = 4"),
];
/// The textbooks' 3x3.
const MOST_COMMON_RADIUS: usize = 1;

impl PcfKernel {
    fn constants(&self) -> [Module; 2] {
        let radius = UNROLLED_RADIUS.get(self.uniforms.radius as usize);
        match radius.filter(|_| self.unrolled) {
            Some(&radius) => [CONSTANT_RADIUS, radius],
            None => [UNIFORM_RADIUS, UNROLLED_RADIUS[MOST_COMMON_RADIUS]],
        }
    }
}

impl Kernel for PcfKernel {
    fn modules(&self) -> Vec<Module> {
        let [is_uniform, unrolled_radius] = self.constants();
        let own = [is_uniform, unrolled_radius, module!("pcf")];
        self.uniforms.lookup.modules(&own)
    }

    fn uniforms(&self) -> Option<&dyn UniformBlock> {
        Some(&self.uniforms)
    }
}

impl ReceiveKernel for PcfKernel {
    fn receive(&self, inputs: &Inputs<'_>, span: &Span<'_>, out: &mut [f32]) {
        let PcfUniforms { lookup, radius } = self.uniforms;
        let map = lookup.map(&inputs.images[0]);
        let side = (2 * radius + 1) as f32;
        let count = side * side;
        let simd = inputs.simd;
        // Specialise common radii, so that the compiler unrolls rows. All others share one loop.
        match radius {
            0 => look_up_span(simd, &lookup, span, out, &OwnTexel { map }),
            1 => look_up_span(
                simd,
                &lookup,
                span,
                out,
                &SquareOfTaps::<3, 4> { map, radius, count },
            ),
            2 => look_up_span(
                simd,
                &lookup,
                span,
                out,
                &SquareOfTaps::<5, 8> { map, radius, count },
            ),
            3 => look_up_span(
                simd,
                &lookup,
                span,
                out,
                &SquareOfTaps::<7, 8> { map, radius, count },
            ),
            4 => look_up_span(
                simd,
                &lookup,
                span,
                out,
                &SquareOfTaps::<9, 16> { map, radius, count },
            ),
            _ => look_up_span(
                simd,
                &lookup,
                span,
                out,
                &SquareOfTaps::<0, 0> { map, radius, count },
            ),
        }
    }
}

/// Square of taps. `SIDE` and `LANES` are those of [`square::level_squares`]; 0 means any side.
struct SquareOfTaps<'a, const SIDE: usize, const LANES: usize> {
    map: DepthMap<'a>,
    radius: i32,
    count: f32,
}

impl<const SIDE: usize, const LANES: usize> BatchTaps for SquareOfTaps<'_, SIDE, LANES> {
    /// Processes a row of texels at a time: 2.8 to 11 times as fast as one receiver after the other
    /// (3x3 to 9x9, 1280x720, `street`, a map of 2048, AVX2). The result equals that of
    /// `visibility`.
    #[inline(always)]
    fn visibilities(&self, batch: &Batch, _: usize, out: &mut [f32]) {
        if SIDE == 0 || self.map.packed {
            self.one_by_one(batch, out);
            return;
        }
        let taps = if batch.is_level() {
            square::level_squares::<SIDE, LANES>(&self.map, batch)
        } else {
            square::sloped_squares::<SIDE, LANES>(&self.map, batch)
        };
        let mut is_complete = true;
        for (i, out) in out.iter_mut().enumerate() {
            let is_known = taps.is_known[i];
            *out = if is_known {
                taps.lit[i] / self.count
            } else {
                1.0
            };
            is_complete &= is_known | !batch.covered[i];
        }
        if !is_complete {
            self.complete(batch, &taps.is_known, out);
        }
    }
}

impl<const SIDE: usize, const LANES: usize> SquareOfTaps<'_, SIDE, LANES> {
    #[inline(always)]
    fn one_by_one(&self, batch: &Batch, out: &mut [f32]) {
        batch.one_by_one(out, |l, _| self.visibility(l));
    }

    /// Computes the visibility of covered receivers whose count isn't known.
    #[inline(never)]
    fn complete(&self, batch: &Batch, is_known: &[bool], out: &mut [f32]) {
        for (i, out) in out.iter_mut().enumerate() {
            let l = batch.lookup(i);
            if l.covered && !is_known[i] {
                *out = self.visibility(&l);
            }
        }
    }

    /// Returns the visibility of a receiver that the map covers. Twin of `visibility` in pcf.wgsl.
    #[inline(always)]
    fn visibility(&self, l: &ShadowCoord) -> f32 {
        let x = l.texel.x.floor() as i32 - self.radius;
        let y = l.texel.y.floor() as i32 - self.radius;
        square::one_by_one(&self.map, l, x, y, 2 * self.radius + 1) / self.count
    }
}
