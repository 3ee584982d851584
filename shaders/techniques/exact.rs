//! Exact hard shadows from per-cell triangle lists of a grid over the light, or on a device from a
//! hierarchy. The result equals one ray, without bias, map or error.
//!
//! This is the light buffer of Haines and Greenberg 1986, "The Light Buffer: A Shadow-Testing
//! Accelerator". (Wyman, Hoetzlein and Lefohn 2015, "Frustum-Traced Raster Shadows" keep lists of
//! receivers instead.) The grid has two levels, as in Kalojanov, Billeter and Slusallek 2011,
//! "Two-Level Grids for Ray Tracing on GPUs". Tiles cover the faces of a frame around the light.
//! The number of cells of a tile follows from its casters. A cell's list holds the casters that
//! touch it, from near to far. It ends at the first one behind a caster that covers the whole cell.
//!
//! A receiver tests the casters in the list of its cell with the triangle test of
//! [`Traced`](crate::Traced), and stops at any hit. So the result equals that of `traced` with one
//! ray, bit for bit, independent of the order of lists and the rounding of cells. Lists must only
//! contain every true hit (`exact/light_frame.rs` describes how this is ensured). An alpha-tested
//! caster covers no cell, and a hit at a transparent texel does not count.
//!
//! Area lights are replaced by their centre.
//!
//! Modules in `exact/`:
//!
//! - `light_frame.rs`: coordinates on the light's grid, and the margins that make lists complete
//! - `touches.rs`: the tiles that a triangle touches
//! - `outline.rs`: edges and plane of triangles larger than a cell
//! - `tile.rs`: a tile's cells and their lists
//! - `lists.rs`: all lists as tables, built on first use
//! - `lookup.rs`: the CPU half
//! - `at_once.rs`: the CPU's method before lists exist
//! - `on_device.rs`: a hierarchy that a device builds

mod at_once;
mod holes;
mod item_key;
mod light_frame;
mod lists;
mod lookup;
mod on_device;
mod outline;
mod tile;
mod touches;

use crate::listing::ListedTechnique;
use at_once::answer_all;
use holes::CasterHoles;
use item_key::ITEM_KEY;
pub use light_frame::ExactUniforms;
use light_frame::LightFrame;
use lists::{KeptLists, Lists, Rows};
pub use lookup::QueriedCell;
use lookup::{LookupInput, cells_of_span, look_up_span};
pub use on_device::{HierarchyKernel, LightView};
use std::{
    fmt::{Debug, Formatter},
    sync::Arc,
};
use umbrage_core::{
    Aabb, CutOuts, Geometry, Inputs, Kernel, Module, Receive, ReceiveKernel, Receivers, Recipe,
    RecipeError, ShadowTechnique, Simd, Span, Table, TableRows, UniformBlock, View,
    bvh::{RAY_BOX, RAY_TRIANGLE},
    cut_out::{CUT_OUT, HOLE},
    glam::{UVec4, Vec4},
    light_sample::{LIGHT_SAMPLE, LightSampler},
    module,
};

/// Intersection test of opaque casters.
const CASTER_OPAQUE: Module = module!("caster_opaque", "exact/caster_opaque.wgsl");

/// Intersection test of alpha-tested casters.
const CASTER_CUT_OUT: Module = module!("caster_cut_out", "exact/caster_cut_out.wgsl");

/// Uniforms, and coordinates relative to the light.
const FRAME_POINT: Module = module!("frame_point", "exact/frame_point.wgsl");

/// Approximate number of receivers that are sampled for the mean list length.
const SAMPLED_RECEIVERS: usize = 2048;

/// Exact hard shadows: one ray a receiver, bit for bit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct Exact {
    /// The structure that a device queries. The result is the same.
    pub structure: ExactStructure,
}

/// Structure that a device queries for [`Exact`]. The CPU always uses lists.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum ExactStructure {
    /// Lists, which the CPU builds once for each light and geometry. A light set without triangles
    /// on the CPU uses a hierarchy instead.
    #[default]
    Lists,
    /// A hierarchy, which the device builds in every frame.
    Hierarchy,
}

impl ShadowTechnique for Exact {
    fn name(&self) -> &'static str {
        "exact"
    }

    fn recipe(&self, view: &View<'_>) -> Result<Recipe, RecipeError> {
        view.validate()?;
        let Some(geometry) = view.geometry else {
            return Err(RecipeError::unsupported_because(
                "the view has no triangles to build lists from: make it with `View::new`",
            ));
        };
        let kernel = ExactKernel::new(view, geometry);
        Ok(match self.structure {
            ExactStructure::Lists => recipe_of(kernel),
            ExactStructure::Hierarchy => on_device::recipe_with_triangles(view, geometry, kernel),
        })
    }

    fn device_recipe(
        &self,
        view: &View<'_>,
        cut_outs: Option<&CutOuts>,
    ) -> Option<Result<Recipe, RecipeError>> {
        let has_lists = self.structure == ExactStructure::Lists && view.geometry.is_some();
        (!has_lists).then(|| on_device::device_recipe(view, cut_outs))
    }
}

fn recipe_of(kernel: ExactKernel) -> Recipe {
    let table = |label: &'static str, rows_of: fn(&Lists) -> &Rows| {
        let kernel = kernel.clone();
        Table {
            label,
            rows: TableRows::on_first_use(move || rows_of(kernel.lists()).clone()),
        }
    };
    let mut tables = vec![
        table("tiles", |lists| &lists.tiles),
        table("cells", |lists| &lists.cells),
        table("items", |lists| &lists.items),
        table("corners", |lists| &lists.corners),
    ];
    tables.extend(kernel.cut_outs.as_deref().map(cut_out_table));
    recipe_from_tables(Arc::new(kernel), tables)
}

/// Returns the table of the records of alpha-tested casters.
fn cut_out_table(cut_outs: &CutOuts) -> Table {
    Table {
        label: "cut-outs",
        rows: cut_outs.rows().clone().into(),
    }
}

/// Returns the recipe of a kernel that reads all of these tables, and no image.
fn recipe_from_tables(kernel: Arc<dyn ReceiveKernel>, tables: Vec<Table>) -> Recipe {
    Recipe {
        images: Vec::new(),
        receive: Receive {
            kernel,
            inputs: Vec::new(),
            tables: (0..tables.len()).collect(),
        },
        tables,
        casts: Vec::new(),
        filters: Vec::new(),
        shade: None,
        hierarchy: None,
        keep_images: false,
    }
}

impl ListedTechnique for Exact {
    const SUMMARY: &'static str =
        "triangle lists or a hierarchy, equal to one ray of traced (Haines, Greenberg 1986)";

    fn settings(&self) -> String {
        match self.structure {
            ExactStructure::Lists => "lists",
            ExactStructure::Hierarchy => "hierarchy",
        }
        .to_owned()
    }
}

impl Exact {
    /// Returns the light's visibility for each of a view's receivers without lists, for any light
    /// and any casters. The CPU uses this for scenes with many casters that have no lists yet.
    ///
    /// # Errors
    /// Errors if the view has no receivers or no triangles, or is invalid.
    pub fn answers_without_lists(
        &self,
        simd: Simd,
        view: &View<'_>,
    ) -> Result<Vec<f32>, RecipeError> {
        view.validate()?;
        let (Some(geometry), Some(receivers)) = (view.geometry, view.receivers) else {
            return Err(RecipeError::unsupported_because(
                "the view has no triangles or receivers: add both before computing visibility without lists",
            ));
        };
        let kernel = ExactKernel::new(view, geometry);
        let frame = &kernel.lists.frame;
        Ok(answer_all(
            simd,
            &kernel.uniforms,
            frame,
            geometry,
            kernel.holes(),
            receivers,
        ))
    }

    /// Returns the cells that a view's receivers query, pixel by pixel. An entry is `None` if the
    /// receiver faces away from the light, if no caster can block it, or if there is no receiver.
    ///
    /// # Errors
    /// Errors if the view has no receivers or no triangles, or is invalid.
    pub fn queried_cells(&self, view: &View<'_>) -> Result<Vec<Option<QueriedCell>>, RecipeError> {
        view.validate()?;
        let (Some(geometry), Some(receivers)) = (view.geometry, view.receivers) else {
            return Err(RecipeError::unsupported_because(
                "the view has no triangles or receivers: add both before querying cells",
            ));
        };
        let kernel = ExactKernel::new(view, geometry);
        let mut out = vec![None; receivers.len()];
        let width = receivers.size.x as usize;
        for (row, out) in out.chunks_mut(width.max(1)).enumerate() {
            let first = row * width;
            let span = receivers.span(first, width);
            cells_of_span(&kernel.uniforms, kernel.lists(), &span, out);
            for (i, out) in out.iter_mut().enumerate() {
                *out = out.filter(|_| receivers.receives[first + i]);
            }
        }
        Ok(out)
    }
}

/// Greatest length of rays towards directional lights, metres, so that a quotient stays in the
/// range of 32-bit floats.
const FARTHEST: f32 = 1e38;

/// Returns the length of rays towards directional lights, metres. Rays of this length leave the
/// scene from the eye or any triangle.
pub(super) fn longest_ray(view: &View<'_>, geometry: &Geometry) -> f32 {
    let all = geometry
        .bounds()
        .union(&Aabb::from_points([view.camera.eye()]));
    (2.0 * all.diagonal()).min(FARTHEST)
}

/// Kernel that queries the lists.
#[derive(Clone)]
pub struct ExactKernel {
    uniforms: ExactUniforms,
    lists: Arc<KeptLists>,
    /// Casters.
    geometry: Geometry,
    /// Alpha test of the casters; `None` if none is alpha-tested.
    cut_outs: Option<Arc<CutOuts>>,
}

impl Debug for ExactKernel {
    /// Omits the lists, which follow from the uniforms and the casters.
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ExactKernel")
            .field("uniforms", &self.uniforms)
            .field("casters", &self.geometry.fingerprint())
            .finish_non_exhaustive()
    }
}

impl ExactKernel {
    fn new(view: &View<'_>, geometry: &Geometry) -> Self {
        let plane_reach = geometry.receiver_reach();
        let far = longest_ray(view, geometry);
        let lists = KeptLists::of_light(view.light, geometry);
        let uniforms = ExactUniforms::new(view, &lists.frame, plane_reach, far);
        let cut_outs = geometry
            .cut_outs()
            .filter(|_| geometry.has_cut_out_casters());
        Self {
            uniforms,
            lists,
            geometry: geometry.clone(),
            cut_outs: cut_outs.cloned(),
        }
    }

    /// Returns the lists, which are built on first use.
    fn lists(&self) -> &Lists {
        self.lists.get(&self.geometry)
    }

    fn holes(&self) -> Option<CasterHoles<'_>> {
        self.cut_outs.as_ref().map(|cut_outs| CasterHoles {
            cut_outs,
            light: &self.uniforms.light,
            far: self.uniforms.far,
        })
    }

    /// Returns the number of casters in the lists.
    pub fn casters(&self) -> usize {
        self.lists().casters()
    }

    /// Returns how many triangles were placed on the grid and in lists, counting repetitions.
    pub fn triangles_listed(&self) -> u64 {
        self.lists().triangles_listed()
    }

    /// Returns the mean length of the lists that a sample of these receivers queries; 0 if none
    /// queries a list.
    pub fn mean_list_length(&self, receivers: &Receivers) -> f32 {
        let chunk = 64_usize.min(receivers.len().max(1));
        let chunks = (SAMPLED_RECEIVERS / chunk).max(1);
        let step = (receivers.len() / chunks).max(chunk);
        let mut cells = vec![None; chunk];
        let mut looked_at = 0_u32;
        let mut items = 0_u64;
        for first in (0..receivers.len()).step_by(step) {
            let count = chunk.min(receivers.len() - first);
            let span = receivers.span(first, count);
            let cells = &mut cells[..count];
            cells_of_span(&self.uniforms, self.lists(), &span, cells);
            for (i, cell) in cells.iter().enumerate() {
                if !receivers.receives[first + i] {
                    continue;
                }
                looked_at += 1;
                let requested = cell.filter(|cell| !cell.is_covered);
                items += requested.map_or(0, |cell| u64::from(cell.length));
            }
        }
        items as f32 / looked_at.max(1) as f32
    }
}

impl ExactUniforms {
    /// Returns the uniforms of a view in a light's frame. `plane_reach` and `far` are in metres.
    fn new(view: &View<'_>, frame: &LightFrame, plane_reach: f32, far: f32) -> Self {
        let [across, down, away] = frame.rows;
        Self {
            light: LightSampler::new(&view.light.without_extent()),
            eye: view.camera.eye().extend(0.0),
            across: across.extend(0.0),
            down: down.extend(0.0),
            away: away.extend(frame.nearest),
            origin: frame.origin.extend(0.0),
            grid: Vec4::new(frame.half.x, frame.half.y, frame.tiles_a_unit, plane_reach),
            tiles: UVec4::new(frame.tiles.x, frame.tiles.y, u32::from(frame.is_lamp), 0),
            far,
        }
    }
}

impl Kernel for ExactKernel {
    fn modules(&self) -> Vec<Module> {
        let mut modules = vec![RAY_BOX, RAY_TRIANGLE, LIGHT_SAMPLE, ITEM_KEY];
        if self.cut_outs.is_some() {
            modules.extend([CUT_OUT, HOLE, CASTER_CUT_OUT]);
            modules.push(module!("list_records", "exact/list_records.wgsl"));
        } else {
            modules.push(CASTER_OPAQUE);
        }
        modules.extend([module!("exact"), FRAME_POINT]);
        modules
    }

    fn uniforms(&self) -> Option<&dyn UniformBlock> {
        Some(&self.uniforms)
    }
}

impl ReceiveKernel for ExactKernel {
    fn receive(&self, inputs: &Inputs<'_>, span: &Span<'_>, out: &mut [f32]) {
        let requested = LookupInput {
            uniforms: &self.uniforms,
            lists: self.lists(),
            holes: self.holes(),
        };
        look_up_span(inputs.simd, requested, span, out);
    }

    fn receive_all(&self, simd: Simd, receivers: &Receivers) -> Option<Vec<f32>> {
        if !self
            .lists
            .is_answered_without(self.geometry.casters().len())
        {
            return None;
        }
        let frame = &self.lists.frame;
        Some(answer_all(
            simd,
            &self.uniforms,
            frame,
            &self.geometry,
            self.holes(),
            receivers,
        ))
    }

    fn in_compute(&self) -> bool {
        true
    }
}
