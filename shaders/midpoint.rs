//! Midpoint shadow mapping: the map holds the mean of the two nearest surfaces' depths, so that the nearest surface lies
//! before it and all behind the second one lies behind it, without a constant to tune.
//!
//! Woo 1992, "The shadow depth map revisited" (Graphics Gems III). The second surface is found by peeling: of all depths
//! greater than the nearest, the least. On closed casters the margin on both sides is half their thickness. Near
//! silhouettes both surfaces meet and the margin vanishes, while the surface slopes most under its texel: so lookups follow
//! the receiver's plane by default ([`Bias::ADAPTIVE`](crate::Bias::ADAPTIVE), of which it takes that half), which takes the slope out and leaves the margin for the rest.
//! No single constant does as well over casters of different thickness. Known failures: open meshes put the middle between
//! one caster and the next thing behind it, or, where nothing is behind, halfway to the far plane, so receivers close
//! behind a lone sheet are lit; facets near the silhouette keep some acne; thin casters have thin margins; and every map's:
//! see [`shadow_map`](crate::shadow_map).

use crate::{Surface, pcf::Pcf, shadow_map::ShadowMap};
use glam::UVec2;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use umbrage_core::{
    FilterKernel, Inputs, Kernel, Module, PlanError, Recipe, ShadowTechnique, UniformLayout,
    Uniforms, View, uniforms,
};

/// Comparisons with the middle between the nearest two surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Midpoint {
    /// The map looked up; [`ShadowMap::surface`] is taken to be [`Surface::Midpoint`].
    pub map: ShadowMap,
    /// As [`Pcf::radius`].
    pub radius: u32,
}

impl Midpoint {
    fn pcf(&self) -> Pcf {
        Pcf {
            map: ShadowMap {
                surface: Surface::Midpoint,
                ..self.map
            },
            radius: self.radius,
        }
    }
}

impl ShadowTechnique for Midpoint {
    fn name(&self) -> &'static str {
        "midpoint"
    }

    fn settings(&self) -> String {
        self.pcf().settings()
    }

    fn plan(&self, view: &View<'_>) -> Result<Recipe, PlanError> {
        self.pcf().plan(view)
    }

    fn kernel_reach(&self) -> Option<f32> {
        self.pcf().kernel_reach()
    }
}

/// From two images of depth to their mean.
pub(crate) fn between() -> Arc<dyn FilterKernel> {
    Arc::new(BetweenKernel)
}

uniforms! {
    /// Uniforms of [`BetweenKernel`]: shaders want something bound.
    pub struct BetweenUniforms {
        /// Not read.
        pub unused: f32,
    }
}

/// The mean of two images.
#[derive(Clone, Copy, Debug)]
pub struct BetweenKernel;

impl Kernel for BetweenKernel {
    fn modules(&self) -> Vec<Module> {
        vec![Module {
            name: "midpoint",
            text: include_str!("midpoint.wgsl"),
        }]
    }

    fn uniform_bytes(&self) -> Vec<u8> {
        BetweenUniforms { unused: 0.0 }.to_bytes()
    }

    fn layout(&self) -> UniformLayout {
        BetweenUniforms::layout()
    }
}

impl FilterKernel for BetweenKernel {
    fn filter(&self, inputs: &Inputs<'_>, start: UVec2, layer: u32, out: &mut [f32]) {
        let [first, second] = [0, 1].map(|i| {
            let image = &inputs.images[i];
            let from = image.index(start.x as i32, start.y as i32, layer);
            &image.texels[from..from + out.len()]
        });
        for ((out, a), b) in out.iter_mut().zip(first).zip(second) {
            *out = (a + b) * 0.5;
        }
    }
}
