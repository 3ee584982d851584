//! Percentage-closer filtering with the comparison sampler: the mean of n² samples, one texel
//! apart. Each blends four comparisons bilinearly.
//!
//! One sample is a "hardware shadow map". n² of them form a square of (n + 1)² texels with linear
//! edges. It has no steps, unlike [`Pcf`](crate::Pcf): visibility is continuous, as the filter
//! follows the receiver within a texel (Reeves, Salesin and Cook 1987, "Rendering antialiased
//! shadows with depth maps", in the form of graphics chips). Depth less than or equal to the stored
//! one is lit. Outside the map everything is lit, as for a sampler with a border of depth 1,
//! blended at the edge. [`Border::Clamp`](crate::Border) repeats the edge instead, like
//! `CLAMP_TO_EDGE`.
//!
//! Known failures: graphics chips store the weights in 8 bits, so masks of two devices may differ
//! by [`WEIGHT_ERROR`](crate::WEIGHT_ERROR). Four texels share one depth. So the receiver's plane
//! is only followed from sample to sample, and the bias for the rest grows with the slope. Depth
//! must be stored as depth, neither packed nor averaged. Light leaks into contacts as far as the
//! samples reach. The failures of every map also apply: see [`shadow_map`](crate::shadow_map).

use crate::{
    filtering::comparison_sampler::{self, Axis, LANES, Samples},
    lanes::batch::{Taps, look_up_span},
    shadow_map::{
        MapFormat, ShadowMap, Surface, coord::ShadowCoord, layers::ShadowMapUniforms,
        texel_compare::DepthMap,
    },
    techniques::map_technique::MapFilter,
};
use umbrage_core::{
    Inputs, Invalid, Kernel, Module, ReceiveKernel, Recipe, RecipeError, Span, UniformBlock, View,
    module, uniforms,
};

/// Square of comparison samples.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct PcfHardware {
    /// Number of samples per side, 1 to 4.
    pub samples: u32,
}

impl Default for PcfHardware {
    fn default() -> Self {
        Self { samples: 1 }
    }
}

impl PcfHardware {
    /// Returns the reach of the samples' texels beyond the receiver's own, texels, for
    /// [`Bias::normal_offset`](crate::Bias::normal_offset) and
    /// [`Bias::polygon_offset`](crate::Bias::polygon_offset).
    pub const fn reach(samples: u32) -> f32 {
        samples as f32 * 0.5
    }
}

impl MapFilter for PcfHardware {
    const NAME: &'static str = "pcf_hardware";
    const SUMMARY: &'static str = "comparison samples, each a blend of 2x2 texels";

    fn recipe(&self, map: &ShadowMap, view: &View<'_>) -> Result<Recipe, RecipeError> {
        check_samples("pcf_hardware", self.samples, 1)?;
        check_map(map)?;
        let samples = self.samples as i32;
        let reach = self.samples.div_ceil(2) as f32;
        map.recipe(view, reach, |lookup| {
            HardwareKernel(HardwareUniforms { lookup, samples })
        })
    }

    fn label(&self) -> String {
        format!("{0}x{0}", self.samples)
    }
}

/// Checks the number of samples along a side.
///
/// # Errors
/// Errors if there are fewer than `least`, or more than [`LANES`].
pub(crate) fn check_samples(what: &str, samples: u32, least: u32) -> Result<(), Invalid> {
    if (least..=LANES as u32).contains(&samples) {
        return Ok(());
    }
    let why = format!("takes {samples} samples a side");
    Err(Invalid::new(
        what.to_owned(),
        why,
        format!("use {least} to {LANES}"),
    ))
}

/// Checks that samplers can compare with a map, which requires depth images.
///
/// # Errors
/// Errors if the map's depth is packed or averaged.
pub(crate) fn check_map(map: &ShadowMap) -> Result<(), RecipeError> {
    if map.format == MapFormat::Rgba8 || map.surface == Surface::Midpoint {
        return Err(RecipeError::unsupported_because(
            "comparison samplers need depth images, but this map's depth is packed or averaged: use `pcf`",
        ));
    }
    Ok(())
}

uniforms! {
    /// Uniforms of [`HardwareKernel`].
    pub struct HardwareUniforms {
        /// Layers of the map and how they are compared.
        pub lookup: ShadowMapUniforms,
        /// Number of samples per side.
        pub samples: i32,
    }
}

/// Receive kernel of hardware PCF.
#[derive(Clone, Copy, Debug)]
pub struct HardwareKernel(
    /// Map and number of samples.
    pub HardwareUniforms,
);

impl Kernel for HardwareKernel {
    fn modules(&self) -> Vec<Module> {
        comparison_sampler::modules(&self.0.lookup, module!("pcf_hardware"))
    }

    fn uniforms(&self) -> Option<&dyn UniformBlock> {
        Some(&self.0)
    }

    fn compares(&self) -> bool {
        true
    }
}

impl ReceiveKernel for HardwareKernel {
    fn receive(&self, inputs: &Inputs<'_>, span: &Span<'_>, out: &mut [f32]) {
        let HardwareUniforms { lookup, samples } = self.0;
        match samples {
            1 => look_up_square::<1>(&lookup, inputs, span, out),
            2 => look_up_square::<2>(&lookup, inputs, span, out),
            3 => look_up_square::<3>(&lookup, inputs, span, out),
            _ => look_up_square::<4>(&lookup, inputs, span, out),
        }
    }
}

/// Fills `out` with the visibilities of squares of `N` by `N` samples.
fn look_up_square<const N: usize>(
    lookup: &ShadowMapUniforms,
    inputs: &Inputs<'_>,
    span: &Span<'_>,
    out: &mut [f32],
) {
    let map = lookup.map(&inputs.images[0]);
    if lookup.layers[0].follows_plane() {
        let taps = SquareOfSamples::<N, true> { map };
        look_up_span(inputs.simd, lookup, span, out, &taps);
    } else {
        let taps = SquareOfSamples::<N, false> { map };
        look_up_span(inputs.simd, lookup, span, out, &taps);
    }
}

struct SquareOfSamples<'a, const N: usize, const FOLLOWS_PLANE: bool> {
    map: DepthMap<'a>,
}

impl<const N: usize, const FOLLOWS_PLANE: bool> Taps for SquareOfSamples<'_, N, FOLLOWS_PLANE> {
    #[inline(always)]
    fn visibility(&self, l: &ShadowCoord, _: usize) -> f32 {
        let side = N as f32;
        let samples = Samples::<N, 1, FOLLOWS_PLANE> { map: self.map };
        samples.sum(l, &axis::<N>(l.texel.x), &axis::<N>(l.texel.y)) / (side * side)
    }
}

/// Returns samples one texel apart along one axis, centred on `texel`.
#[inline(always)]
fn axis<const N: usize>(texel: f32) -> Axis {
    let first = texel + (0.5 - 0.5 * N as f32);
    Axis {
        at: std::array::from_fn(|i| first + i as f32),
        weight: std::array::from_fn(|i| if i < N { 1.0 } else { 0.0 }),
    }
}
