//! The answer of one ray, from lists of the casters that touch each cell of a grid over the light:
//! no bias, no map, no error.
//!
//! The light buffer of Haines and Greenberg 1986, "The Light Buffer: A Shadow-Testing Accelerator";
//! Wyman, Hoetzlein and Lefohn 2015, "Frustum-Traced Raster Shadows" keep lists of receivers
//! instead. A grid of two levels, as in Kalojanov, Billeter and Slusallek 2011, "Two-Level Grids
//! for Ray Tracing on GPUs": tiles over the faces of a frame around the light, each cut into as
//! many cells as its casters are worth. A cell's list holds the casters that touch it, from near to
//! far, up to the first one behind a caster that covers all of the cell.
//!
//! A receiver asks the list of its cell with the triangle test of [`Traced`](crate::Traced), and
//! any hit will do. So the answer is that of `traced` with one ray, bit for bit, in whatever order
//! lists are walked and however cells are rounded: lists only have to leave no true hit out
//! (`exact/light_frame.rs` says how they make sure). A caster with holes covers no cell, and a hit
//! in a hole is none.
//!
//! Lights with an extent are taken for their middle.
//!
//! In `exact/`: `light_frame.rs` (where a point lies on the light's grid, and the margins that make
//! lists complete), `touches.rs` (which tiles a triangle touches), `outline.rs` (edges and plane of
//! triangles larger than a cell), `tile.rs` (a tile's cells and their lists), `lists.rs` (all of it
//! as tables, made when they are first read), `lookup.rs` (the CPU half), `at_once.rs` (the CPU's
//! way while there are no lists), `on_device.rs` (lists that a device makes of vertices that only
//! it holds).

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
use lists::{KeptLists, Lists, Rows};
use lookup::{Asked, cells_of_span, look_up_span};
pub use on_device::ListsGrid;
use std::{
    fmt::{Debug, Formatter},
    sync::Arc,
};
use umbrage_core::{
    Aabb, CutOuts, DeviceRecipe, Geometry, Inputs, Kernel, Module, Receive, ReceiveKernel,
    Receivers, Recipe, RecipeError, ShadowTechnique, Simd, Span, Table, TableRows, UniformBlock,
    View,
    bvh::{RAY_BOX, RAY_TRIANGLE},
    cut_out::{CUT_OUT, HOLE},
    glam::{UVec4, Vec4},
    light_sample::{LIGHT_SAMPLE, LightSampler},
    module, uniforms,
};

/// What item_key.rs and shaders know of items.
const ITEM_KEY: Module = module!("item_key", "exact/item_key.wgsl");

/// What meets casters without holes.
const CASTER_OPAQUE: Module = module!("caster_opaque", "exact/caster_opaque.wgsl");

/// What meets casters with holes.
const CASTER_CUT_OUT: Module = module!("caster_cut_out", "exact/caster_cut_out.wgsl");

/// Receivers whose lists are looked at to find their mean length, about.
const SAMPLED_RECEIVERS: usize = 2048;

/// Lists of casters in the light's cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct Exact {}

impl ShadowTechnique for Exact {
    fn name(&self) -> &'static str {
        "exact"
    }

    fn recipe(&self, view: &View<'_>) -> Result<Recipe, RecipeError> {
        view.validate()?;
        let Some(geometry) = view.geometry else {
            return Err(RecipeError::unsupported(
                "lists need the scene's triangles, and this view has none",
            ));
        };
        Ok(recipe_of(ExactKernel::new(view, geometry)))
    }

    fn device_recipe(&self, view: &View<'_>) -> Option<Result<DeviceRecipe, RecipeError>> {
        Some(on_device::device_recipe(view))
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
    if let Some(cut_outs) = &kernel.cut_outs {
        tables.push(Table {
            label: "cut-outs",
            rows: cut_outs.rows().clone().into(),
        });
    }
    Recipe {
        images: Vec::new(),
        receive: Receive {
            kernel: Arc::new(kernel),
            inputs: Vec::new(),
            tables: (0..tables.len()).collect(),
        },
        tables,
        casts: Vec::new(),
        filters: Vec::new(),
        shade: None,
        keep_images: false,
    }
}

impl ListedTechnique for Exact {
    const SUMMARY: &'static str =
        "lists of casters in the light's cells (Haines, Greenberg 1986): traced's answer";

    fn settings(&self) -> String {
        "lists".to_owned()
    }
}

/// The cell that is asked for a receiver: to look at what lookups cost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AskedCell {
    /// Its number among all cells of the light.
    pub number: u32,
    /// Casters in its list.
    pub length: u32,
    /// Whether one caster hides the light from all receivers of the cell that are as deep as this
    /// one, so that its list isn't asked.
    pub is_covered: bool,
}

impl Exact {
    /// Returns the light's visibility for each of a view's receivers, without lists, for any light
    /// and any casters: as the CPU has it of many casters that were not asked before.
    ///
    /// # Errors
    /// Errors if the view has no receivers or no triangles, or something in it can't be used.
    pub fn answers_without_lists(
        &self,
        simd: Simd,
        view: &View<'_>,
    ) -> Result<Vec<f32>, RecipeError> {
        view.validate()?;
        let (Some(geometry), Some(receivers)) = (view.geometry, view.receivers) else {
            return Err(RecipeError::unsupported(
                "without lists, known receivers are asked by triangles",
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

    /// Returns the cells that are asked for a view's receivers, pixel by pixel: none where a
    /// receiver faces away from the light, where no caster can be in its way, or where nothing
    /// receives.
    ///
    /// # Errors
    /// Errors if the view has no receivers or no triangles, or something in it can't be used.
    pub fn asked_cells(&self, view: &View<'_>) -> Result<Vec<Option<AskedCell>>, RecipeError> {
        view.validate()?;
        let (Some(geometry), Some(receivers)) = (view.geometry, view.receivers) else {
            return Err(RecipeError::unsupported(
                "cells are asked for known receivers, by triangles",
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

/// Greatest length of rays towards directional lights, metres: what is within the range of 32 bits
/// after a division.
const FARTHEST: f32 = 1e38;

/// Returns the length of rays towards directional lights, metres: from the eye or any triangle they
/// leave the scene.
pub(super) fn longest_ray(view: &View<'_>, geometry: &Geometry) -> f32 {
    let all = geometry.bounds().union(&Aabb::around([view.camera.eye()]));
    (2.0 * all.diagonal()).min(FARTHEST)
}

uniforms! {
    /// Uniforms of [`ExactKernel`].
    pub struct ExactUniforms {
        /// The light's middle, as an ideal light.
        pub light: LightSampler,
        /// The camera's position; w is unused.
        pub eye: Vec4,
        /// First row of the matrix from the world, less the origin, to frame space; w is unused.
        pub across: Vec4,
        /// The second row, likewise.
        pub down: Vec4,
        /// The third row; w: what is subtracted from a sun's depth.
        pub away: Vec4,
        /// World position of frame space's origin; w is unused.
        pub origin: Vec4,
        /// Half the size of a face, across and down; tiles a unit of a direction; the greatest
        /// extent of a receiving triangle, metres.
        pub grid: Vec4,
        /// Tiles of a face, across and down; whether the light is a lamp; whether a device lists
        /// casters that it counts itself.
        pub tiles: UVec4,
        /// Length of rays towards directional lights, metres.
        pub far: f32,
    }
}

/// Asks the lists.
#[derive(Clone)]
pub struct ExactKernel {
    uniforms: ExactUniforms,
    lists: Arc<KeptLists>,
    /// The casters; none where a device knows them.
    geometry: Geometry,
    /// Their holes; none if none has any.
    cut_outs: Option<Arc<CutOuts>>,
}

impl Debug for ExactKernel {
    /// Lists follow from the uniforms and the casters.
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ExactKernel")
            .field("uniforms", &self.uniforms)
            .field("casters", &self.geometry.fingerprint())
            .finish_non_exhaustive()
    }
}

impl ExactKernel {
    fn new(view: &View<'_>, geometry: &Geometry) -> Self {
        let extent = geometry.max_receiver_extent();
        let far = longest_ray(view, geometry);
        let lists = KeptLists::of(view.light, geometry);
        let cut_outs = geometry
            .cut_outs()
            .filter(|_| geometry.has_cut_out_casters());
        Self {
            geometry: geometry.clone(),
            cut_outs: cut_outs.cloned(),
            ..Self::of_lists(view, lists, extent, far)
        }
    }

    fn of_lists(view: &View<'_>, lists: Arc<KeptLists>, extent: f32, far: f32) -> Self {
        let eye = view.camera.eye();
        let frame = &lists.frame;
        let [across, down, away] = frame.rows;
        let uniforms = ExactUniforms {
            light: LightSampler::new(&view.light.without_extent()),
            eye: eye.extend(0.0),
            across: across.extend(0.0),
            down: down.extend(0.0),
            away: away.extend(frame.nearest),
            origin: frame.origin.extend(0.0),
            grid: Vec4::new(frame.half.x, frame.half.y, frame.tiles_a_unit, extent),
            tiles: UVec4::new(frame.tiles.x, frame.tiles.y, u32::from(frame.is_lamp), 0),
            far,
        };
        Self {
            uniforms,
            lists,
            geometry: Geometry::default(),
            cut_outs: None,
        }
    }

    /// Returns the lists, which are made on first use.
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

    /// Returns how many triangles were placed on the grid and in lists, each as often as it was.
    pub fn triangles_listed(&self) -> u64 {
        self.lists().triangles_listed()
    }

    /// Returns the mean length of the lists that some of these receivers query; 0 if none queries
    /// one.
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
                let asked = cell.filter(|cell| !cell.is_covered);
                items += asked.map_or(0, |cell| u64::from(cell.length));
            }
        }
        items as f32 / looked_at.max(1) as f32
    }
}

impl ExactKernel {
    /// The same, for lists that a device makes.
    fn on_device(mut self) -> Self {
        self.uniforms.tiles.w = 1;
        self
    }
}

impl Kernel for ExactKernel {
    fn modules(&self) -> Vec<Module> {
        let mut modules = vec![RAY_BOX, RAY_TRIANGLE, LIGHT_SAMPLE, ITEM_KEY];
        if self.cut_outs.is_some() {
            modules.extend([CUT_OUT, HOLE, CASTER_CUT_OUT]);
        } else {
            modules.push(CASTER_OPAQUE);
        }
        modules.push(module!("exact"));
        modules
    }

    fn uniforms(&self) -> Option<&dyn UniformBlock> {
        Some(&self.uniforms)
    }
}

impl ReceiveKernel for ExactKernel {
    fn receive(&self, inputs: &Inputs<'_>, span: &Span<'_>, out: &mut [f32]) {
        let asked = Asked {
            uniforms: &self.uniforms,
            lists: self.lists(),
            holes: self.holes(),
        };
        look_up_span(inputs.simd, asked, span, out);
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
}
