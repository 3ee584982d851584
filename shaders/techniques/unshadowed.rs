//! No shadows: everything is lit except surfaces that face away from the light.
//!
//! Known failures: every shadow. It is exact if nothing casts onto visible geometry, and costs
//! almost nothing. So it is the reference for the cost of all others: a shadow without a visible
//! effect need not be drawn. Area lights count as their centre.

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

/// No shadows. It has no settings.
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
            hierarchy: None,
            keep_images: false,
        })
    }

    fn follows_camera(&self, _: &Light) -> bool {
        false
    }
}

impl ListedTechnique for Unshadowed {
    const SUMMARY: &'static str = "no shadows: for views in which no shadow is visible";

    fn settings(&self) -> String {
        "no shadows".to_owned()
    }
}

uniforms! {
    /// Uniforms of [`UnshadowedKernel`].
    pub struct UnshadowedUniforms {
        /// Centre of the light, homogeneous: a unit direction to it (w = 0) or its position (w =
        /// 1).
        pub light: Vec4,
    }
}

/// Receive kernel: lit if the surface does not face away.
#[derive(Clone, Copy, Debug)]
pub struct UnshadowedKernel(
    /// Direction or position of the light.
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
