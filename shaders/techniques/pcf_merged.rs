//! Percentage-closer filtering with a smooth filter. Each sample of the comparison sampler merges
//! four texels: (r + 1)² samples for a filter of (2r + 1)² texels.
//!
//! Castaño 2013, "Shadow mapping summary, part 1" (The Witness): 3x3 with four samples, 5x5 with
//! nine; 7x7 uses sixteen. See [`bilinear_weights`](crate::filtering::bilinear_weights) for the
//! filter and its merging. The merged sum equals the filter's except for the rounding of texel
//! coordinates. It is smoother than the square of [`PcfHardware`](crate::PcfHardware) with the same
//! number of samples, since the filter falls off towards its edge.
//!
//! Known failures: those of [`PcfHardware`](crate::PcfHardware). Samples are between texels, where
//! chips round the position to 1/256 texel, so the filter has the same error.

use crate::{
    filtering::{
        bilinear_weights::{merged_rows, merged_sample},
        comparison_sampler::{self, Axis, Samples},
    },
    lanes::batch::{Taps, look_up_span},
    shadow_map::{
        ShadowMap, coord::ShadowCoord, layers::ShadowMapUniforms, texel_compare::DepthMap,
    },
    techniques::map_technique::MapFilter,
    techniques::pcf_hardware::{check_map, check_samples},
};
use glam::{Vec2, Vec4};
use umbrage_core::{
    Inputs, Kernel, Module, ReceiveKernel, Recipe, RecipeError, Span, UniformBlock, View, module,
    uniforms,
};

/// Smooth filter of merged samples.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct PcfMerged {
    /// Number of texels on each side, 1 to 3; 1 is 3x3 with four samples.
    pub radius: u32,
}

impl Default for PcfMerged {
    fn default() -> Self {
        Self { radius: 1 }
    }
}

impl PcfMerged {
    /// Returns the reach of the filter: see [`PcfHardware::reach`](crate::PcfHardware::reach).
    pub const fn reach(radius: u32) -> f32 {
        radius as f32 + 0.5
    }
}

impl MapFilter for PcfMerged {
    const NAME: &'static str = "pcf_merged";
    const SUMMARY: &'static str =
        "(2r + 1)² texels in (r + 1)² weighted comparison samples (Castaño 2013)";

    fn recipe(&self, map: &ShadowMap, view: &View<'_>) -> Result<Recipe, RecipeError> {
        check_samples("pcf_merged", self.radius.saturating_add(1), 2)?;
        check_map(map)?;
        let rows = merged_rows(self.radius as usize);
        let samples = self.radius as i32 + 1;
        map.recipe(view, samples as f32, |lookup| {
            MergedKernel(MergedUniforms {
                lookup,
                rows,
                samples,
            })
        })
    }

    fn label(&self) -> String {
        let side = 2 * u64::from(self.radius) + 1;
        format!("{side}x{side}")
    }
}

uniforms! {
    /// Uniforms of [`MergedKernel`].
    pub struct MergedUniforms {
        /// Layers of the map and how they are compared.
        pub lookup: ShadowMapUniforms,
        /// Rows of the filter: see [`merged_rows`].
        pub rows: [Vec4; 4],
        /// Number of samples per side.
        pub samples: i32,
    }
}

/// Receive kernel of merged PCF.
#[derive(Clone, Copy, Debug)]
pub struct MergedKernel(
    /// Map and filter rows.
    pub MergedUniforms,
);

impl Kernel for MergedKernel {
    fn modules(&self) -> Vec<Module> {
        comparison_sampler::modules(&self.0.lookup, module!("pcf_merged"))
    }

    fn uniforms(&self) -> Option<&dyn UniformBlock> {
        Some(&self.0)
    }

    fn compares(&self) -> bool {
        true
    }
}

impl ReceiveKernel for MergedKernel {
    fn receive(&self, inputs: &Inputs<'_>, span: &Span<'_>, out: &mut [f32]) {
        match self.0.samples {
            2 => self.look_up::<2>(inputs, span, out),
            3 => self.look_up::<3>(inputs, span, out),
            _ => self.look_up::<4>(inputs, span, out),
        }
    }
}

impl MergedKernel {
    /// Fills `out` with the visibilities of filters of `N` by `N` samples.
    fn look_up<const N: usize>(&self, inputs: &Inputs<'_>, span: &Span<'_>, out: &mut [f32]) {
        let lookup = &self.0.lookup;
        let rows = self.0.rows;
        let map = lookup.map(&inputs.images[0]);
        if lookup.layers[0].follows_plane() {
            let taps = MergedTaps::<N, true> { map, rows };
            look_up_span(inputs.simd, lookup, span, out, &taps);
        } else {
            let taps = MergedTaps::<N, false> { map, rows };
            look_up_span(inputs.simd, lookup, span, out, &taps);
        }
    }
}

struct MergedTaps<'a, const N: usize, const FOLLOWS_PLANE: bool> {
    map: DepthMap<'a>,
    rows: [Vec4; 4],
}

impl<const N: usize, const FOLLOWS_PLANE: bool> Taps for MergedTaps<'_, N, FOLLOWS_PLANE> {
    #[inline(always)]
    fn visibility(&self, l: &ShadowCoord, _: usize) -> f32 {
        let x = axis::<N>(&self.rows, l.texel.x);
        let y = axis::<N>(&self.rows, l.texel.y);
        // Sum the weights in the order of the shader's loop.
        let mut column_total = 0.0;
        for weight in &y.weight[..N] {
            column_total += weight;
        }
        let mut total = 0.0;
        for weight in &x.weight[..N] {
            total += weight * column_total;
        }
        let samples = Samples::<N, 2, FOLLOWS_PLANE> { map: self.map };
        let lit = samples.sum(l, &x, &y);
        // Rounding may raise the quotient above 1.
        (lit / total).min(1.0)
    }
}

/// Returns samples about two texels apart along one axis, which replace the filter around `texel`.
#[inline(always)]
fn axis<const N: usize>(rows: &[Vec4; 4], texel: f32) -> Axis {
    let centre = (texel - 0.5).floor();
    let part = texel - 0.5 - centre;
    let first = centre + (1.5 - N as f32);
    let merged: [Vec2; 4] = std::array::from_fn(|i| {
        // Lanes after the last repeat it, so that nothing is divided by zero.
        merged_sample(rows[if i < N { i } else { N - 1 }], part)
    });
    Axis {
        at: std::array::from_fn(|i| first + ((2 * i) as f32 + merged[i].y)),
        weight: std::array::from_fn(|i| if i < N { merged[i].x } else { 0.0 }),
    }
}
