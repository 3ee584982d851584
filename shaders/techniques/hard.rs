//! Hard shadows: one comparison with one texel.
//!
//! Lit if the receiver's depth, less the bias, is at most the stored depth. Williams 1978, "Casting curved shadows on
//! curved surfaces". Fails by jagged edges as wide as a texel, by acne without bias, by shadows that come loose with
//! too much of it, by penumbrae without width, and as every map does: see [`shadow_map`](crate::shadow_map).

use crate::{
    lanes::batch::{Taps, look_up_span},
    shadow_map::{
        ShadowMap,
        coord::ShadowCoord, layers::ShadowMapUniforms, texel_compare::DepthMap,
    },
};
use glam::Vec3;
use serde::{Deserialize, Serialize};
use umbrage_core::{
    Inputs, Kernel, Module, PlanError, ReceiveKernel, Recipe, ShadowTechnique, Span, UniformLayout,
    Uniforms, View,
};

/// One comparison a receiver.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Hard {
    /// The map looked up.
    pub map: ShadowMap,
}

impl ShadowTechnique for Hard {
    fn name(&self) -> &'static str {
        "hard"
    }

    fn settings(&self) -> String {
        self.map.label()
    }

    fn plan(&self, view: &View<'_>) -> Result<Recipe, PlanError> {
        self.map.recipe(view, 0.0, HardKernel)
    }

    fn kernel_reach(&self) -> Option<f32> {
        Some(0.0)
    }
}

/// The lookup.
#[derive(Clone, Copy, Debug)]
pub struct HardKernel(
    /// Uniforms.
    pub ShadowMapUniforms,
);

impl Kernel for HardKernel {
    fn modules(&self) -> Vec<Module> {
        self.0
            .modules()
            .into_iter()
            .chain([
                Module {
                    name: "hard",
                    text: include_str!("hard.wgsl"),
                },
            ])
            .collect()
    }

    fn uniform_bytes(&self) -> Vec<u8> {
        self.0.to_bytes()
    }

    fn layout(&self) -> UniformLayout {
        ShadowMapUniforms::layout()
    }
}

impl ReceiveKernel for HardKernel {
    fn receive(&self, inputs: &Inputs<'_>, span: &Span<'_>, out: &mut [f32]) {
        let taps = OneTap {
            map: self.0.map(&inputs.images[0]),
        };
        look_up_span(inputs.simd, &self.0, span, out, &taps);
    }

    /// Never beyond the receiver's own texel, also where a technique that reaches farther falls back on this kernel.
    fn reach(&self, _: Vec3, _: Vec3) -> Option<f32> {
        Some(0.0)
    }
}

struct OneTap<'a> {
    map: DepthMap<'a>,
}

impl Taps for OneTap<'_> {
    #[inline(always)]
    fn visibility(&self, l: &ShadowCoord, _: usize) -> f32 {
        self.map
            .tap(l, l.texel.x.floor() as i32, l.texel.y.floor() as i32)
    }
}
