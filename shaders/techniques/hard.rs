//! Hard shadows: one comparison with one texel.
//!
//! Lit if the receiver's depth, less the bias, is at most the stored depth. Williams 1978, "Casting curved shadows on
//! curved surfaces". Fails by jagged edges as wide as a texel, by acne without bias, by shadows that come loose with
//! too much of it, by penumbrae without width, and as every map does: see [`shadow_map`](crate::shadow_map).

use crate::{
    lanes::{batch::look_up_span, single::OwnTexel},
    listing::ListedTechnique,
    shadow_map::{ShadowMap, layers::MapOnlyUniforms},
};
use umbrage_core::{
    Inputs, Kernel, Light, Module, ReceiveKernel, Recipe, RecipeError, ShadowTechnique, Span,
    UniformBlock, View,
};

/// One comparison a receiver.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct Hard {
    /// The map looked up.
    pub map: ShadowMap,
}

impl ShadowTechnique for Hard {
    fn name(&self) -> &'static str {
        "hard"
    }

    fn recipe(&self, view: &View<'_>) -> Result<Recipe, RecipeError> {
        self.map
            .recipe(view, 0.0, |lookup| HardKernel(MapOnlyUniforms { lookup }))
    }

    fn follows_camera(&self, light: &Light) -> bool {
        self.map.follows_camera(light)
    }
}

impl ListedTechnique for Hard {
    const SUMMARY: &'static str = "one comparison with one texel (Williams 1978)";

    fn map(&self) -> Option<&ShadowMap> {
        Some(&self.map)
    }

    fn with_map(self, map: ShadowMap) -> Self {
        Self { map }
    }
}

/// The receive kernel.
#[derive(Clone, Copy, Debug)]
pub struct HardKernel(
    /// Uniforms.
    pub MapOnlyUniforms,
);

impl Kernel for HardKernel {
    fn modules(&self) -> Vec<Module> {
        self.0
            .lookup
            .modules()
            .into_iter()
            .chain([Module {
                name: "hard",
                text: include_str!("hard.wgsl"),
            }])
            .collect()
    }

    fn uniforms(&self) -> Option<&dyn UniformBlock> {
        Some(&self.0)
    }
}

impl ReceiveKernel for HardKernel {
    fn receive(&self, inputs: &Inputs<'_>, span: &Span<'_>, out: &mut [f32]) {
        let taps = OwnTexel {
            map: self.0.lookup.map(&inputs.images[0]),
        };
        look_up_span(inputs.simd, &self.0.lookup, span, out, &taps);
    }
}
