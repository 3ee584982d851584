//! No shadows: all is lit but what faces away from the light.
//!
//! Known failures: every shadow. Where nothing casts onto what is seen it is exact and costs next
//! to nothing, so it is what all others are measured against: a shadow that nobody misses need not
//! be made. Lights with an extent count as their middle.

use crate::{
    listing::ListedTechnique,
    shading::facing::{FACING, homogeneous, turned_away},
};
use glam::Vec4;
use std::sync::Arc;
use umbrage_core::{
    Inputs, Kernel, Light, Module, Receive, ReceiveKernel, Recipe, RecipeError, ShadowTechnique,
    Span, UniformBlock, View, module, uniforms,
};

/// No shadows. There is nothing to set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct Unshadowed {}

impl ShadowTechnique for Unshadowed {
    fn name(&self) -> &'static str {
        "none"
    }

    fn recipe(&self, view: &View<'_>) -> Result<Recipe, RecipeError> {
        view.validate()?;
        let kernel = Arc::new(UnshadowedKernel(UnshadowedUniforms {
            light: homogeneous(view.light),
        }));
        Ok(Recipe {
            images: Vec::new(),
            tables: Vec::new(),
            casts: Vec::new(),
            filters: Vec::new(),
            receive: Receive {
                kernel,
                inputs: Vec::new(),
                tables: Vec::new(),
            },
            shade: None,
            keep_images: false,
        })
    }

    fn follows_camera(&self, _: &Light) -> bool {
        false
    }
}

impl ListedTechnique for Unshadowed {
    const SUMMARY: &'static str = "no shadows: for scenes in which nothing casts onto what is seen";

    fn settings(&self) -> String {
        "no shadows".to_owned()
    }
}

uniforms! {
    /// Uniforms of [`UnshadowedKernel`].
    pub struct UnshadowedUniforms {
        /// The light's middle, homogeneous: a unit direction to it (w = 0) or its position (w = 1).
        pub light: Vec4,
    }
}

/// Lit if the surface does not face away.
#[derive(Clone, Copy, Debug)]
pub struct UnshadowedKernel(
    /// Uniforms.
    pub UnshadowedUniforms,
);

impl Kernel for UnshadowedKernel {
    fn modules(&self) -> Vec<Module> {
        vec![FACING, module!("unshadowed")]
    }

    fn uniforms(&self) -> Option<&dyn UniformBlock> {
        Some(&self.0)
    }
}

impl ReceiveKernel for UnshadowedKernel {
    fn receive(&self, _: &Inputs<'_>, span: &Span<'_>, out: &mut [f32]) {
        for (i, out) in out.iter_mut().enumerate() {
            let away = turned_away(self.0.light, span.position(i), span.normal(i));
            *out = if away == 0 { 1.0 } else { 0.0 };
        }
    }
}
