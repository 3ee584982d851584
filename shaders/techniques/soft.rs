//! Soft shadows with a stated error: the fraction of a light that is visible from a receiver, from
//! one search for all casters that may hide any of it.
//!
//! All rays from a receiver to a light are within a shaft (Haines and Wallace 1991, "Shaft Culling
//! for Efficient Ray-Traced Radiosity"). One traversal of the hierarchy finds the casters that
//! reach into it. With none, the receiver is lit. With one that covers the light alone, it is in
//! the umbra. Both are certain and need no sample. Otherwise each caster hides a run of points in
//! each row of a lattice over the light: bits, set row by row (`soft/hidden.rs`). So hundreds of
//! points cost about as much as a few rays. On the CPU, neighbours share the traversal.
//!
//! Finding conservative blockers first, and then sampling, follows Wang et al. 2014, "GEARS: A
//! General and Efficient Algorithm for Rendering Shadows", and Laine et al. 2005, "Soft Shadow
//! Volumes for Ray Tracing". Bit masks for sampling lights are those of Schwarz and Stamminger
//! 2007, "Bitmask Soft Shadows", and Kalbertodt 2023.
//!
//! **Error.** [`Soft::error`] is the requested root mean square error at straight edges, which
//! determines the number of points. Each edge crosses at most 2 k - 1 of the cells around the
//! points in k rows. Errors occur only there: [`Soft::bound`]. If several edges cross a light, the
//! errors add up like noise.
//!
//! Surfaces are opaque and two-sided, as with [`Traced`](crate::Traced). Ideal lights have a single
//! point.
//!
//! For alpha-tested casters, the points that such a triangle's outline covers are tested one by one
//! (`soft/holes.rs`), which is as slow as tracing rays.
//!
//! Known failures: directional lights more than [`MAX_SUN_DEGREES`] wide are refused. Their points
//! are distributed evenly over a plane instead of over the sky, so they are up to a tenth sparser
//! at the edge.
//!
//! Modules in `soft/`:
//!
//! - `lattice.rs`: the points, in rows
//! - `light_plane.rs`: the light as viewed from a receiver
//! - `hidden.rs`: the points that a triangle hides
//! - `footprint.rs`: the rows that a box or a triangle can touch
//! - `holes.rs`: points that pass the alpha test
//! - `search.rs`: the CPU half, in which eight neighbours traverse the hierarchy together

mod footprint;
mod hidden;
mod holes;
mod lattice;
mod light_plane;
pub mod search;

use crate::{
    listing::ListedTechnique,
    techniques::{exact::longest_ray, traced::check_stack},
};
use footprint::FOOTPRINT;
use hidden::{HIDDEN, sort_corners};
use holes::{HOLES, NO_HOLES};
use lattice::{LATTICE, LATTICES, Lattices, rows_for};
use light_plane::{LIGHT_PLANE, domain_of, spread_of};
use search::{Search, look_up_span};
use std::sync::Arc;
use umbrage_core::{
    Bvh, CutOuts, Geometry, Inputs, Invalid, Kernel, Light, Module, Receive, ReceiveKernel, Recipe,
    RecipeError, ShadowTechnique, Span, Table, UniformBlock, View,
    bvh::{RAY_BOX, RAY_TRIANGLE, SHAFT},
    cut_out::{CUT_OUT, HOLE},
    glam::Vec4,
    light_sample::{LIGHT_SAMPLE, LightSampler},
    module, uniforms,
};

/// Greatest supported angular diameter of directional lights, degrees. Points at the edge are then
/// a tenth too sparse.
pub const MAX_SUN_DEGREES: f32 = 30.0;

/// Range of [`Soft::error`].
pub const SOFT_ERRORS: [f32; 2] = [0.002, 0.2];

/// Light points hidden by the casters in a shaft.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct Soft {
    /// Root mean square error at straight edges, as a fraction of the light, within
    /// [`SOFT_ERRORS`]. It determines the number of points.
    pub error: f32,
}

impl Default for Soft {
    fn default() -> Self {
        Self { error: 0.006 }
    }
}

impl Soft {
    /// Returns the approximate number of points of the light that are tested; one for ideal lights.
    pub fn points(&self, light: &Light) -> u32 {
        let lattices = self.lattices(&LightSampler::new(light));
        lattices.of_noise(0).points
    }

    /// Returns the greatest error that one straight edge can cause, as a fraction of the light. The
    /// edge crosses at most 2 k - 1 of the cells around the points in k rows.
    pub fn bound(&self, light: &Light) -> f32 {
        self.lattices(&LightSampler::new(light)).bound()
    }

    fn lattices(&self, sampler: &LightSampler) -> Lattices {
        let domain = domain_of(sampler);
        let rows = if sampler.is_ideal() {
            1
        } else {
            rows_for(self.error, domain)
        };
        Lattices::new(domain, rows)
    }
}

impl ShadowTechnique for Soft {
    fn name(&self) -> &'static str {
        "soft"
    }

    fn recipe(&self, view: &View<'_>) -> Result<Recipe, RecipeError> {
        // Check the settings, the geometry and the light.
        let [least, greatest] = SOFT_ERRORS;
        if !(least..=greatest).contains(&self.error) {
            let why = format!("is {}", self.error);
            let help = format!("use {least} to {greatest}");
            return Err(Invalid::new("soft error", why, help).into());
        }
        view.validate()?;
        let Some(geometry) = view.geometry else {
            return Err(RecipeError::unsupported_because(
                "the view has no triangles to search: make it with `View::new`",
            ));
        };
        if let Light::Directional {
            angular_diameter, ..
        } = view.light
            && *angular_diameter > MAX_SUN_DEGREES.to_radians()
        {
            return Err(RecipeError::unsupported_because(format!(
                "directional lights are supported up to {MAX_SUN_DEGREES} degrees across, but this one has {}: use `traced`",
                angular_diameter.to_degrees()
            )));
        }
        check_stack(geometry)?;
        // Build the kernel and its tables.
        let kernel = self.kernel(view, geometry);
        let [nodes, triangles] = geometry.bvh_tables();
        let sorted = geometry.derive_once(|_| SortedTriangles::from_rows(triangles));
        let table = |label: &'static str, rows: &SoftRows| Table {
            label,
            rows: rows.clone().into(),
        };
        let mut tables = vec![
            table("hierarchy", nodes),
            table("sorted triangles", &sorted.0),
            table("light points", &kernel.lattices.table().into()),
        ];
        if let Some(cut_outs) = &kernel.cut_outs {
            tables.push(table("triangles", triangles));
            tables.push(table("cut-outs", cut_outs.rows()));
        }
        let table_ids = (0..tables.len()).collect();
        Ok(Recipe {
            images: Vec::new(),
            tables,
            casts: Vec::new(),
            filters: Vec::new(),
            receive: Receive {
                kernel: Arc::new(kernel),
                inputs: Vec::new(),
                tables: table_ids,
            },
            shade: None,
            hierarchy: None,
            keep_images: false,
        })
    }
}

/// Rows of four words.
type SoftRows = Arc<[[u32; 4]]>;

/// Triangles of the hierarchy. The corners of each have the order that the edge functions expect.
struct SortedTriangles(SoftRows);

impl SortedTriangles {
    /// Builds the table; `rows` are three per triangle: a corner, and the triangle's id as the
    /// fourth word.
    fn from_rows(rows: &[[u32; 4]]) -> Self {
        let mut out = Vec::with_capacity(rows.len());
        for triangle in rows.chunks_exact(3) {
            let corners = [0, 1, 2]
                .map(|i: usize| Vec4::from_array(triangle[i].map(f32::from_bits)).truncate());
            let id = triangle[0][3];
            for corner in sort_corners(corners) {
                let [x, y, z] = corner.to_array().map(f32::to_bits);
                out.push([x, y, z, id]);
            }
        }
        Self(out.into())
    }
}

impl ListedTechnique for Soft {
    const SUMMARY: &'static str =
        "light points hidden by the casters in a shaft (Haines, Wallace 1991; Wang 2014)";

    fn settings(&self) -> String {
        format!("error {}", self.error)
    }
}

impl Soft {
    fn kernel(&self, view: &View<'_>, geometry: &Geometry) -> SoftKernel {
        let eye = view.camera.eye();
        let light = LightSampler::new(view.light);
        let slope = match *view.light {
            Light::Directional {
                angular_diameter, ..
            } => (0.5 * f64::from(angular_diameter)).tan() as f32,
            _ => 0.0,
        };
        let lattices = self.lattices(&light);
        let uniforms = SoftUniforms {
            light,
            eye: eye.extend(0.0),
            spread: spread_of(&light, slope).extend(slope),
            plane_reach: geometry.receiver_reach(),
            far: longest_ray(view, geometry),
            shift: lattices.shift,
            rows: lattices.rows,
            lattices: LATTICES,
        };
        let cut_outs = geometry
            .cut_outs()
            .filter(|_| geometry.has_cut_out_casters());
        SoftKernel {
            uniforms,
            lattices,
            bvh: geometry.bvh().clone(),
            cut_outs: cut_outs.cloned(),
        }
    }
}

uniforms! {
    /// Uniforms of [`SoftKernel`].
    pub struct SoftUniforms {
        /// The light.
        pub light: LightSampler,
        /// The camera's position; w is unused.
        pub eye: Vec4,
        /// Extent of the light from its centre along each axis: metres, or a fraction of the
        /// distance for directional lights. w: the tangent of half a directional light's angular
        /// diameter.
        pub spread: Vec4,
        /// [`Geometry::receiver_reach`], metres.
        pub plane_reach: f32,
        /// Length of rays towards directional lights, metres.
        pub far: f32,
        /// Maximum number of points by which rows of a lattice are shifted.
        pub shift: f32,
        /// Number of rows of a lattice.
        pub rows: u32,
        /// Number of lattices.
        pub lattices: u32,
    }
}

/// Receive kernel: light points hidden by the casters in a shaft.
#[derive(Clone, Debug)]
pub struct SoftKernel {
    /// Uniforms.
    pub uniforms: SoftUniforms,
    lattices: Lattices,
    bvh: Arc<Bvh>,
    /// Alpha test of casters; `None` if none is alpha-tested.
    cut_outs: Option<Arc<CutOuts>>,
}

impl SoftKernel {
    fn search(&self) -> Search<'_> {
        Search {
            uniforms: &self.uniforms,
            lattices: &self.lattices,
            bvh: &self.bvh,
            cut_outs: self.cut_outs.as_deref(),
        }
    }

    /// Returns the error bound, 0..=1, of the light's fraction above a receiver's horizon. Points
    /// of the light are counted, and the horizon is one straight edge.
    pub fn share_error(&self) -> f32 {
        if self.uniforms.light.is_ideal() {
            0.0
        } else {
            self.lattices.bound()
        }
    }
}

impl Kernel for SoftKernel {
    fn modules(&self) -> Vec<Module> {
        let mut modules = vec![
            RAY_BOX,
            SHAFT,
            LIGHT_SAMPLE,
            LIGHT_PLANE,
            LATTICE,
            FOOTPRINT,
        ];
        if self.cut_outs.is_some() {
            modules.extend([RAY_TRIANGLE, CUT_OUT, HOLE, HOLES]);
        } else {
            modules.push(NO_HOLES);
        }
        modules.push(HIDDEN);
        modules.push(module!("soft"));
        modules
    }

    fn uniforms(&self) -> Option<&dyn UniformBlock> {
        Some(&self.uniforms)
    }
}

impl ReceiveKernel for SoftKernel {
    fn receive(&self, inputs: &Inputs<'_>, span: &Span<'_>, out: &mut [f32]) {
        look_up_span(inputs.simd, &self.search(), span, out);
    }

    fn in_compute(&self) -> bool {
        true
    }
}
