//! Dithered percentage-closer filtering: four comparisons, placed by the pixel's parity.
//!
//! Bunnell and Pellacini 2004, "Shadow map antialiasing" (GPU Gems, chapter 11): taps at (-1.5, .5), (.5, .5),
//! (-1.5, -1.5) and (.5, -1.5) texels, moved by (0 or 1, 0 or 1) so that each block of 2x2 pixels covers sixteen texels.
//! Cheap, at the price of a fine pattern in the penumbra; its levels are fourths. Known failures: single pixels of acne
//! where light grazes curved or creased surfaces, as some taps are 2.5 texels away; light leaks into contacts as far;
//! and those of every map: see [`shadow_map`](crate::shadow_map).

use crate::{
    lanes::batch::{Taps, look_up_span},
    listing::{ListedTechnique, sweeps},
    shadow_map::{ShadowMap, coord::ShadowCoord, layers::MapOnlyUniforms, texel_compare::DepthMap},
};
use glam::{UVec2, Vec3};
use serde::{Deserialize, Serialize};
use umbrage_core::{
    Fit, Inputs, Kernel, KernelCost, Light, Module, ReceiveKernel, Recipe, RecipeError,
    ShadowTechnique, Span, UniformBlock, View,
};

/// Four dithered comparisons.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PcfDithered {
    /// The map looked up.
    pub map: ShadowMap,
}

impl ShadowTechnique for PcfDithered {
    fn name(&self) -> &'static str {
        "pcf_dithered"
    }

    fn settings(&self) -> String {
        format!("4 taps, {}", self.map.label())
    }

    fn recipe(&self, view: &View<'_>) -> Result<Recipe, RecipeError> {
        self.map.recipe(view, 2.0, |lookup| {
            PcfDitheredKernel(MapOnlyUniforms { lookup })
        })
    }

    fn kernel_reach(&self) -> Option<f32> {
        Some(1.5)
    }

    fn follows_camera(&self, light: &Light) -> bool {
        self.map.follows_camera(light)
    }
}

impl ListedTechnique for PcfDithered {
    const SUMMARY: &'static str =
        "four comparisons, placed by the pixel's parity (Bunnell, Pellacini 2004)";

    fn map(&self) -> Option<&ShadowMap> {
        Some(&self.map)
    }

    fn with_map(self, map: ShadowMap) -> Self {
        Self { map }
    }

    fn compared(map_sizes: &[u32], fit: Fit) -> Vec<Self> {
        sweeps::sweep(map_sizes, fit, &sweeps::two_biases(1.5), |map| Self { map })
    }

    const RANDOM_WEIGHT: u32 = 2;
}

/// The receive kernel.
#[derive(Clone, Copy, Debug)]
pub struct PcfDitheredKernel(
    /// Uniforms.
    pub MapOnlyUniforms,
);

impl Kernel for PcfDitheredKernel {
    fn modules(&self) -> Vec<Module> {
        self.0
            .lookup
            .modules()
            .into_iter()
            .chain([Module {
                name: "pcf_dithered",
                text: include_str!("pcf_dithered.wgsl"),
            }])
            .collect()
    }

    fn uniforms(&self) -> Option<&dyn UniformBlock> {
        Some(&self.0)
    }
}

impl ReceiveKernel for PcfDitheredKernel {
    fn receive(&self, inputs: &Inputs<'_>, span: &Span<'_>, out: &mut [f32]) {
        let taps = DitheredTaps {
            map: self.0.lookup.map(&inputs.images[0]),
            first: span.first,
        };
        look_up_span(inputs.simd, &self.0.lookup, span, out, &taps);
    }

    fn cost_per_receiver(&self) -> KernelCost {
        KernelCost::taps(4)
    }

    fn layer(&self, position: Vec3) -> Option<u32> {
        self.0.lookup.layer_of(position)
    }
}

struct DitheredTaps<'a> {
    map: DepthMap<'a>,
    first: UVec2,
}

impl Taps for DitheredTaps<'_> {
    #[inline(always)]
    fn visibility(&self, l: &ShadowCoord, offset: usize) -> f32 {
        let pixel_x = self.first.x + offset as u32;
        let pixel_y = self.first.y;
        // Each pixel of a block of 2x2 moves its taps by its own one of (0 or 1, 0 or 1) texels.
        let shift_x = (pixel_x & 1) as f32;
        let shift_y = ((pixel_x ^ pixel_y) & 1) as f32;
        let left = (l.texel.x + (shift_x - 1.5)).floor() as i32;
        let right = (l.texel.x + (shift_x + 0.5)).floor() as i32;
        let top = (l.texel.y + (shift_y - 1.5)).floor() as i32;
        let bottom = (l.texel.y + (shift_y + 0.5)).floor() as i32;
        let lit = self.map.tap(l, left, top)
            + self.map.tap(l, right, top)
            + self.map.tap(l, left, bottom)
            + self.map.tap(l, right, bottom);
        lit / 4.0
    }
}
