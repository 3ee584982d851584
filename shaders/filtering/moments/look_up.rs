//! The lookup in a map of moments. The blend of four texels is written out: samplers round as they like, and those of core WebGPU
//! don't filter 32-bit floats.

use crate::{
    filtering::moments::{
        bounds::{BOUNDS, without_bleeding},
        exp2::EXP2,
        map::BleedingReduction,
        of_depth::{MOMENTS_OF_DEPTH, centred},
        stored::Encoding,
    },
    lanes::batch::{Taps, look_up_span},
    shadow_map::{coord::ShadowCoord, layers::ShadowMapUniforms},
};
use umbrage_core::{Inputs, Module, Span};

/// The WGSL half of the lookup. It reads the kernel's first image.
const LOOK_UP: Module = Module {
    name: "look_up",
    text: include_str!("look_up.wgsl"),
};

/// Returns the WGSL of a kernel that looks up moments: the map's modules, those of moments, and `own`, which declares the uniforms and
/// `fn lit_by_moments(moments: vec4f, depth: f32) -> f32`, the share of light at a centred depth, and
/// `fn compared_depth(l: ShadowCoord) -> f32`, the clip depth that is asked about.
pub(crate) fn modules(
    lookup: &ShadowMapUniforms,
    encoding: Encoding,
    own: &[Module],
) -> Vec<Module> {
    let mut modules = lookup.modules();
    modules.extend([EXP2, MOMENTS_OF_DEPTH, BOUNDS]);
    modules.extend(encoding.modules());
    modules.push(LOOK_UP);
    modules.extend(own);
    modules
}

/// The share of light that `CHANNELS` moments allow at a depth. A trait and not a closure, as [`Taps`] is.
pub(crate) trait LightBound<const CHANNELS: usize> {
    /// Returns the share of light, 0..=1, at a centred depth. WGSL's `lit_by_moments`.
    fn lit(&self, moments: [f32; CHANNELS], depth: f32) -> f32;

    /// Returns the clip depth that is asked about. WGSL's `compared_depth`.
    #[inline(always)]
    fn compared_depth(&self, l: &ShadowCoord) -> f32 {
        l.depth
    }
}

/// The map of moments that a kernel reads.
#[derive(Clone, Copy)]
pub(crate) struct MomentMap<'a> {
    /// Where it lies.
    pub(crate) lookup: &'a ShadowMapUniforms,
    /// What its channels are.
    pub(crate) encoding: Encoding,
}

/// Looks up a span of receivers in the map of moments that is the kernel's first image.
pub(crate) fn look_up<const CHANNELS: usize>(
    inputs: &Inputs<'_>,
    map: MomentMap<'_>,
    span: &Span<'_>,
    out: &mut [f32],
    bound: &impl LightBound<CHANNELS>,
    bleeding: BleedingReduction,
) {
    let lookup = map.lookup;
    let (texels, _) = inputs.images[0].texels.as_chunks();
    let lookups = MomentLookups {
        texels,
        encoding: map.encoding,
        size: lookup.size as i32,
        clamped: lookup.clamped != 0,
        bound,
        bleeding,
    };
    look_up_span(inputs.simd, lookup, span, out, &lookups);
}

/// A map of moments, and what is asked of it.
struct MomentLookups<'a, const CHANNELS: usize, B> {
    /// All layers, row by row.
    texels: &'a [[f32; CHANNELS]],
    encoding: Encoding,
    /// Side of each layer, texels.
    size: i32,
    /// Whether the map's edge repeats; else all beside it is lit.
    clamped: bool,
    bound: &'a B,
    bleeding: BleedingReduction,
}

impl<const CHANNELS: usize, B: LightBound<CHANNELS>> Taps for MomentLookups<'_, CHANNELS, B> {
    #[inline(always)]
    fn visibility(&self, l: &ShadowCoord, _: usize) -> f32 {
        let size = self.size as f32;
        let is_inside =
            l.texel.x >= 0.0 && l.texel.y >= 0.0 && l.texel.x < size && l.texel.y < size;
        if !is_inside && !self.clamped {
            return 1.0;
        }
        // Beyond the far plane, where nothing is stored.
        if l.depth > 1.0 {
            return 0.0;
        }
        let depth = centred(self.bound.compared_depth(l));
        let lit = self.bound.lit(self.blended(l), depth);
        without_bleeding(lit, self.bleeding.amount, self.bleeding.scale)
    }
}

impl<const CHANNELS: usize, B> MomentLookups<'_, CHANNELS, B> {
    /// Returns the moments at a receiver's place, blended between four texels.
    #[inline(always)]
    fn blended(&self, l: &ShadowCoord) -> [f32; CHANNELS] {
        let place = l.texel - 0.5;
        let corner = place.floor();
        let share = place - corner;
        let last = self.size - 1;
        let left = (corner.x as i32).clamp(0, last);
        let right = (corner.x as i32 + 1).clamp(0, last);
        let upper = (corner.y as i32).clamp(0, last);
        let lower = (corner.y as i32 + 1).clamp(0, last);
        let top_left = self.texel(left, upper, l.layer);
        let top_right = self.texel(right, upper, l.layer);
        let bottom_left = self.texel(left, lower, l.layer);
        let bottom_right = self.texel(right, lower, l.layer);
        let mut moments = [0.0; CHANNELS];
        for (i, moment) in moments.iter_mut().enumerate() {
            let top = top_left[i] + (top_right[i] - top_left[i]) * share.x;
            let bottom = bottom_left[i] + (bottom_right[i] - bottom_left[i]) * share.x;
            *moment = top + (bottom - top) * share.y;
        }
        moments
    }

    #[inline(always)]
    fn texel(&self, x: i32, y: i32, layer: i32) -> [f32; CHANNELS] {
        let row = layer as usize * self.size as usize + y as usize;
        let mut moments = self.texels[row * self.size as usize + x as usize];
        self.encoding.load(&mut moments);
        moments
    }
}
