//! Ray-traced shadows: the fraction of the light that is visible from a receiver, by any-hit rays,
//! without map or bias.
//!
//! Whitted 1980, "An improved illumination model for shaded display"; Cook, Porter and Carpenter
//! 1984, "Distributed ray tracing" for area lights. Surfaces are two-sided and opaque, except where
//! an alpha test lets rays pass. A light point below the receiver's tangent plane is not visible.
//! Exact for ideal lights; noisy with few samples of wide ones. Four rays are too few for smooth
//! penumbrae (the noise of 16 independent rays) where many casters overlap. Costs one traversal per
//! sample.

use crate::{listing::ListedTechnique, techniques::exact::longest_ray};
use std::sync::Arc;
use umbrage_core::{
    Bvh, Geometry, Inputs, Invalid, Kernel, Module, Receive, ReceiveKernel, Recipe, RecipeError,
    ShadowTechnique, Span, Table, UniformBlock, View,
    bvh::{RAY_BOX, RAY_TRIANGLE},
    cut_out::{CUT_OUT, HOLE},
    glam::Vec4,
    light_sample::{LIGHT_SAMPLE, LightSampler, ray_origin, seed, segment, unit_square},
    math::dot3,
    module, uniforms,
};

/// Maximum number of samples accepted per receiver.
pub const MAX_SAMPLES: u32 = 65_536;

/// Capacity of the shaders' traversal stack: `STACK` in traced.wgsl and soft.wgsl. Each level of
/// the hierarchy pushes one node.
const STACK: usize = 64;

/// Any-hit rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct Traced {
    /// Number of rays per receiver for area lights, 1 to [`MAX_SAMPLES`]; powers of two are best.
    /// Ideal lights use one.
    pub samples: u32,
}

impl Default for Traced {
    fn default() -> Self {
        Self { samples: 16 }
    }
}

impl ShadowTechnique for Traced {
    fn name(&self) -> &'static str {
        "traced"
    }

    fn recipe(&self, view: &View<'_>) -> Result<Recipe, RecipeError> {
        // Check the settings and the geometry.
        if !(1..=MAX_SAMPLES).contains(&self.samples) {
            let why = format!("are {}", self.samples);
            return Err(
                Invalid::new("traced samples", why, format!("use 1 to {MAX_SAMPLES}")).into(),
            );
        }
        view.validate()?;
        let Some(geometry) = view.geometry else {
            return Err(RecipeError::unsupported_because(
                "the view has no triangles to trace: make it with `View::new`",
            ));
        };
        check_stack(geometry)?;
        // Build the tables.
        let [nodes, triangles] = geometry.bvh_tables();
        let mut tables = vec![
            Table {
                label: "hierarchy",
                rows: nodes.clone().into(),
            },
            Table {
                label: "triangles",
                rows: triangles.clone().into(),
            },
        ];
        if let Some(cut_outs) = geometry.cut_outs() {
            tables.push(Table {
                label: "cut-outs",
                rows: cut_outs.rows().clone().into(),
            });
        }
        let table_ids = (0..tables.len()).collect();
        Ok(Recipe {
            images: Vec::new(),
            tables,
            casts: Vec::new(),
            filters: Vec::new(),
            receive: Receive {
                kernel: Arc::new(self.kernel(view, geometry)),
                inputs: Vec::new(),
                tables: table_ids,
            },
            shade: None,
            hierarchy: None,
            keep_images: false,
        })
    }
}

impl ListedTechnique for Traced {
    const SUMMARY: &'static str =
        "any-hit rays, no map (Whitted 1980; Cook, Porter, Carpenter 1984)";

    fn settings(&self) -> String {
        format!("{} rays", self.samples)
    }
}

impl Traced {
    fn kernel(&self, view: &View<'_>, geometry: &Geometry) -> TracedKernel {
        let eye = view.camera.eye();
        let light = LightSampler::new(view.light);
        let uniforms = TracedUniforms {
            light,
            eye: eye.extend(0.0),
            plane_reach: geometry.receiver_reach(),
            far: longest_ray(view, geometry),
            samples: if light.is_ideal() { 1 } else { self.samples },
        };
        TracedKernel {
            uniforms,
            bvh: geometry.bvh().clone(),
            has_holes: geometry.cut_outs().is_some(),
        }
    }
}

/// Errors if the scene's hierarchy is deeper than a shader's stack.
pub(super) fn check_stack(geometry: &Geometry) -> Result<(), RecipeError> {
    let depth = geometry.bvh().depth();
    if depth <= STACK {
        return Ok(());
    }
    Err(RecipeError::unsupported_because(format!(
        "the scene's hierarchy is {depth} nodes deep, but the shader's stack holds {STACK}: use a technique with a map"
    )))
}

uniforms! {
    /// Uniforms of [`TracedKernel`].
    pub struct TracedUniforms {
        /// The light.
        pub light: LightSampler,
        /// The camera's position; w is unused.
        pub eye: Vec4,
        /// [`Geometry::receiver_reach`], metres.
        pub plane_reach: f32,
        /// Length of rays towards directional lights, metres.
        pub far: f32,
        /// Number of rays per receiver.
        pub samples: u32,
    }
}

/// Receive kernel: any-hit rays through the hierarchy.
#[derive(Clone, Debug)]
pub struct TracedKernel {
    /// Uniforms.
    pub uniforms: TracedUniforms,
    bvh: Arc<Bvh>,
    /// True if the geometry has alpha-tested casters.
    has_holes: bool,
}

/// Leaf intersection for opaque casters.
const LEAF_OPAQUE: Module = module!("leaf_opaque", "traced/leaf_opaque.wgsl");

/// Leaf intersection for alpha-tested casters.
const LEAF_CUT_OUT: Module = module!("leaf_cut_out", "traced/leaf_cut_out.wgsl");

impl Kernel for TracedKernel {
    fn modules(&self) -> Vec<Module> {
        let mut modules = vec![RAY_BOX, RAY_TRIANGLE, LIGHT_SAMPLE];
        if self.has_holes {
            modules.extend([CUT_OUT, HOLE, LEAF_CUT_OUT]);
        } else {
            modules.push(LEAF_OPAQUE);
        }
        modules.push(module!("traced"));
        modules
    }

    fn uniforms(&self) -> Option<&dyn UniformBlock> {
        Some(&self.uniforms)
    }
}

impl ReceiveKernel for TracedKernel {
    fn receive(&self, _: &Inputs<'_>, span: &Span<'_>, out: &mut [f32]) {
        let u = &self.uniforms;
        for (i, out) in out.iter_mut().enumerate() {
            let p = span.position(i);
            let n = span.normal(i);
            let origin = ray_origin(p, n, u.eye.truncate(), u.plane_reach);
            let scramble = seed(span.first.x + i as u32, span.first.y);
            let mut seen = 0_u32;
            for sample in 0..u.samples {
                let ray = segment(&u.light, origin, unit_square(sample, scramble), u.far);
                // Points of the light below the receiver's tangent plane are not visible.
                if dot3(n, ray) > 0.0 && !self.bvh.is_occluded(origin, ray, span.triangle[i]) {
                    seen += 1;
                }
            }
            *out = seen as f32 / u.samples as f32;
        }
    }

    fn in_compute(&self) -> bool {
        true
    }
}
