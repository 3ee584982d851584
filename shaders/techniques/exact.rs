//! The answer of one ray, from lists of the casters that touch each cell of a grid over the light: no bias, no map, no error.
//!
//! The light buffer of Haines and Greenberg 1986, "The Light Buffer: A Shadow-Testing Accelerator"; Wyman, Hoetzlein and Lefohn
//! 2015, "Frustum-Traced Raster Shadows" keep lists of receivers instead. A grid of two levels, as in Kalojanov, Billeter and
//! Slusallek 2011, "Two-Level Grids for Ray Tracing on GPUs": tiles over the faces of a [`LightFrame`], each cut into as many cells as
//! its casters are worth. A cell's list holds the casters that touch it, from near to far, up to the first one behind
//! a caster that covers all of the cell.
//!
//! A receiver asks the list of its cell. Each caster's outline (`exact/outline.rs`) says that the ray to the light surely meets it,
//! or surely misses it, with margins for all rounding; between, the triangle test of [`Traced`](crate::Traced) decides. So the
//! answer is that of `traced` with one ray, bit for bit, though lists, outlines and both backends round as they like: they only have
//! to leave no true hit out.
//!
//! Lights with an extent are taken for their middle.

mod light_frame;
mod lists;
mod outline;
mod tile;
mod touches;

use crate::{
    listing::{Candidate, ClosedFormDemand, ListedTechnique},
    shadow_map::ShadowMap,
};
use lists::{Lists, Rows};
use outline::Outline;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use touches::DEPTH_UNKNOWN;
use umbrage_core::{
    Aabb, Fit, Geometry, Inputs, Kernel, KernelCost, Light, Module, Receive, ReceiveKernel, Recipe,
    RecipeError, ShadowTechnique, Span, Table, UniformBlock, View,
    bvh::{RAY_BOX, RAY_TRIANGLE, segment_hits},
    glam::{UVec4, Vec2, Vec3, Vec4},
    light_sample::{LIGHT_SAMPLE, LightSampler, origin_offset, segment},
    math::dot3,
    uniforms,
};

/// Greatest length of rays towards directional lights, metres: what is within the range of 32 bits after a division.
const FARTHEST: f32 = 1e38;

/// Lists of casters in the light's cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Exact {}

impl ShadowTechnique for Exact {
    fn name(&self) -> &'static str {
        "exact"
    }

    fn settings(&self) -> String {
        "lists".to_owned()
    }

    fn recipe(&self, view: &View<'_>) -> Result<Recipe, RecipeError> {
        view.validate()?;
        let Some(geometry) = view.geometry else {
            return Err(RecipeError::unsupported(
                "lists need the scene's triangles, and this view has none",
            ));
        };
        let lists = Lists::of(view.light, geometry);
        let table = |label: &'static str, rows: &Rows| Table {
            label,
            rows: rows.clone(),
        };
        let tables = vec![
            table("tiles", &lists.tiles),
            table("cells", &lists.cells),
            table("items", &lists.items),
            table("outlines", &lists.outlines),
            table("corners", &lists.corners),
        ];
        Ok(Recipe {
            images: Vec::new(),
            receive: Receive {
                kernel: Arc::new(ExactKernel::new(view, geometry, lists)),
                inputs: Vec::new(),
                tables: (0..tables.len()).collect(),
            },
            tables,
            casts: Vec::new(),
            filters: Vec::new(),
            shade: None,
            keep_images: false,
        })
    }
}

impl ListedTechnique for Exact {
    const SUMMARY: &'static str =
        "lists of casters in the light's cells (Haines, Greenberg 1986): traced's answer";

    fn candidates(_: ShadowMap, _: &Light) -> Vec<Candidate<Self>> {
        vec![Candidate::One(Self {})]
    }

    fn compared(_: &[u32], _: Fit) -> Vec<Self> {
        vec![Self {}]
    }

    fn why_chosen(&self, _: f64, _: &Recipe) -> Option<String> {
        Some("its answer is that of rays, without a map or a bias".to_owned())
    }

    fn closed_form(_: ShadowMap) -> Option<ClosedFormDemand<Self>> {
        Some(ClosedFormDemand::new(Self {}, 0.0))
    }
}

uniforms! {
    /// Uniforms of [`ExactKernel`].
    pub struct ExactUniforms {
        /// The light's middle, as an ideal light.
        pub light: LightSampler,
        /// The camera's position; w is unused.
        pub eye: Vec4,
        /// Rows of the matrix from the world, less the origin, to frame space; the fourth of the third is what is subtracted of a sun's depth.
        pub across: Vec4,
        /// The second row.
        pub down: Vec4,
        /// The third row.
        pub away: Vec4,
        /// World position of frame space's origin; w: one over the margin in depth.
        pub origin: Vec4,
        /// Half the size of a face, across and down; tiles a unit of a direction; the greatest extent of a receiving triangle, metres.
        pub grid: Vec4,
        /// Tiles of a face, across and down; whether the light is a lamp.
        pub tiles: UVec4,
        /// Length of rays towards directional lights, metres.
        pub far: f32,
    }
}

/// Asks the lists.
#[derive(Clone, Debug)]
pub struct ExactKernel {
    uniforms: ExactUniforms,
    lists: Arc<Lists>,
}

impl ExactKernel {
    fn new(view: &View<'_>, geometry: &Geometry, lists: Arc<Lists>) -> Self {
        let eye = view.camera.eye();
        let all = geometry.bounds().union(&Aabb::around([eye]));
        let frame = &lists.frame;
        let [across, down, away] = frame.rows;
        let per_margin = 1.0 / frame.depth_margin();
        let extent = geometry.max_receiver_extent();
        let uniforms = ExactUniforms {
            light: LightSampler::new(&view.light.without_extent()),
            eye: eye.extend(0.0),
            across: across.extend(0.0),
            down: down.extend(0.0),
            away: away.extend(frame.nearest),
            origin: frame.origin.extend(per_margin),
            grid: Vec4::new(frame.half.x, frame.half.y, frame.tiles_a_unit, extent),
            tiles: UVec4::new(frame.tiles.x, frame.tiles.y, u32::from(frame.is_lamp), 0),
            far: (2.0 * all.diagonal()).min(FARTHEST),
        };
        Self { uniforms, lists }
    }

    /// The origin of a receiver's ray: as [`Traced`](crate::Traced) has it.
    #[inline(always)]
    fn lifted(&self, p: Vec3, n: Vec3) -> Vec3 {
        let u = &self.uniforms;
        let to_eye = (u.eye.truncate() - p).abs();
        let reach = to_eye.max_element().max(u.grid.w);
        p + n * origin_offset(p, reach)
    }

    /// Returns whether the segment from `o` along `d` meets a caster other than triangle `own`.
    #[inline(always)]
    fn is_shadowed(&self, o: Vec3, d: Vec3, own: u32) -> bool {
        let lists = &*self.lists;
        let frame = &lists.frame;
        let point = frame.look_up(frame.place(o));
        let at = (point.on_face + frame.half) * frame.tiles_a_unit;
        let [wide, high] = [frame.tiles.x as f32, frame.tiles.y as f32];
        // Written so that what is not a number is outside.
        let is_inside = at.x >= 0.0 && at.y >= 0.0 && at.x < wide && at.y < high;
        // A lamp's faces end where others begin.
        let at = if frame.is_lamp {
            at.clamp(Vec2::ZERO, Vec2::new(wide, high) - 0.001)
        } else if is_inside {
            at
        } else {
            return false;
        };
        let tile = at.as_uvec2();
        let number = ((point.face * frame.tiles.y + tile.y) * frame.tiles.x + tile.x) as usize;
        let pair = &lists.tiles[number / 2];
        let [first_cell, side_log2] = if number % 2 == 0 {
            [pair[0], pair[1]]
        } else {
            [pair[2], pair[3]]
        };
        let within = (at - at.floor()) * (1_u32 << side_log2) as f32;
        let cell = within.as_uvec2();
        let [first, count, covered_behind, _] =
            lists.cells[(first_cell + (cell.y << side_log2) + cell.x) as usize];
        if point.depth > f32::from_bits(covered_behind) {
            return true;
        }
        let [factor, summand] = frame.depth_terms(point.depth, self.uniforms.origin.w);
        for i in first..first + count {
            let pair = &lists.items[i as usize / 2];
            let [word, nearest] = if i % 2 == 0 {
                [pair[0], pair[1]]
            } else {
                [pair[2], pair[3]]
            };
            if f32::from_bits(nearest) > point.depth {
                return false;
            }
            let caster = word & !DEPTH_UNKNOWN;
            if caster == own {
                continue;
            }
            let outline = Outline::of_caster(&lists.outlines, caster);
            let mut value = outline.at(point.direction) * factor + summand;
            if word != caster {
                value.w = 0.0;
            }
            if value.cmplt(Vec4::NEG_ONE).any() {
                continue;
            }
            if value.cmpgt(Vec4::ONE).all() || self.meets(o, d, caster) {
                return true;
            }
        }
        false
    }

    /// The triangle test.
    #[inline(never)]
    fn meets(&self, o: Vec3, d: Vec3, caster: u32) -> bool {
        let first = 3 * caster as usize;
        let rows = &self.lists.corners[first..first + 3];
        let corner = |i: usize| {
            let row = rows[i].map(f32::from_bits);
            Vec3::new(row[0], row[1], row[2])
        };
        segment_hits(o, d, corner(0), corner(1), corner(2))
    }
}

impl Kernel for ExactKernel {
    fn modules(&self) -> Vec<Module> {
        vec![
            RAY_BOX,
            RAY_TRIANGLE,
            LIGHT_SAMPLE,
            Module {
                name: "exact",
                text: include_str!("exact.wgsl"),
            },
        ]
    }

    fn uniforms(&self) -> Option<&dyn UniformBlock> {
        Some(&self.uniforms)
    }
}

impl ReceiveKernel for ExactKernel {
    fn receive(&self, _: &Inputs<'_>, span: &Span<'_>, out: &mut [f32]) {
        let u = &self.uniforms;
        for (i, out) in out.iter_mut().enumerate() {
            let n = span.normal(i);
            let o = self.lifted(span.position(i), n);
            let d = segment(&u.light, o, Vec2::ZERO, u.far);
            let is_lit = dot3(n, d) > 0.0 && !self.is_shadowed(o, d, span.triangle[i]);
            *out = f32::from(u8::from(is_lit));
        }
    }

    fn cost_per_receiver(&self) -> KernelCost {
        KernelCost::taps(4)
    }
}
