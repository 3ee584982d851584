//! Percentage-closer soft shadows: look for blockers, conclude how wide the penumbra is, filter
//! that widely.
//!
//! Fernando 2005, "Percentage-closer soft shadows". A light of width w over a blocker at distance
//! d_b throws on a receiver at distance d_r a penumbra of width w (d_r - d_b) / d_b. Seen from the
//! light, that is w (1/d_b - 1/d_r) in tangents; and clip depth with perspective is linear in 1/d
//! (without, in d, as the penumbra then is). So all steps follow from differences of clip depth z,
//! with the light's half axes U and V in texels per unit of it ([`LightExtent`]): **through the
//! texel at z (x U + y V) from its own, a receiver that is deeper by z sees the light's point (x,
//! y).**
//!
//! 1. **Bound** z by the nearest caster that may hide some of the light, from a coarse grid over
//!    the map ([`DepthInReachKernel`](crate::DepthInReachKernel)). None is: lit. So the search is
//!    as wide as the blockers there ask for, wherever the map's near plane lies, and most of what
//!    is lit needs no search.
//! 2. **Search** the taps of a pattern over that z times (U, V), closer together towards the
//!    middle: where blockers near the receiver must lie. A tap counts if what it finds hides some
//!    of the light: if it lies before the receiver's plane, is nearer to the light than the
//!    receiver, and by so much that the light's point through it is within the light.
//! 3. **Penumbra**: the mean of z_r - z_b over them, each weighed by how much of the light it
//!    hides. If no tap counts, the search's own z: then what the search missed hides little of the
//!    light, and the filter's taps, which are spread evenly over the light and more, tell how much.
//!    Where the receiver's plane is followed, z_r is the plane's depth at the tap.
//! 4. **Filter**: the share of lit taps over that mean times (U, V), which is a texel at least. A
//!    tap that finds something too low to be in the ray's way looks again where the ray is as low:
//!    a wall beside the receiver rises under the rays, a solid caster, wide below, does not let
//!    them through. (The wall is known by lying less than half as high there.)
//! 5. **Horizon**: taps at points of the light below the receiver's plane do not count, and the
//!    answer is multiplied by the share of the light above it, which is known without error
//!    ([`Horizon`]).
//!
//! That only blockers count that hide some of the light is backprojection's rule (Guennebaud,
//! Barthe and Paulin 2006, "Real-time soft shadow mapping by backprojection"). Rectangles are
//! sampled over the parallelogram and discs over the ellipse that the light makes on the map, so
//! with all blockers in one plane the answer is exact up to texels and taps, if that plane is
//! parallel to the map, or to the receiver whose plane is followed: on a slanting map, blockers on
//! one side of an edge are otherwise nearer in the mean than the edge. Ideal lights have no width:
//! there this is one hard comparison, the recipe of [`Hard`].
//!
//! Known failures, all of them from speaking of *the* blocker: blockers at several depths are
//! merged into a mean that fits none of them (where a pole's shadow crosses a wall's, the pole's
//! grows sharp and the wall's soft); an outline seen against nearer parts of the same caster has
//! too wide a penumbra (around a pot's shadow); what lies behind the nearest surface is not in the
//! map, so shadows of two casters under one another do not add up as they should. With few taps a
//! blocker that hides little of the light is missed by the search; where nearer ones are in reach,
//! the filter then takes it for less than it hides, and light leaks through leaves: more taps help.
//! Lights so wide or casters so near to them that the search would leave the map are followed only
//! half a map far, and cube faces are never left: their outermost receivers are then too bright.
//! Under a ball as wide as a seventh of a room, a few hundredths of the light differ between two
//! faces of a cube. Under ideal lights it fails as [`Hard`] does, and as every map: see
//! [`shadow_map`](crate::shadow_map).
//!
//! Bias: taps wander far from the receiver, so anything constant is too little for wide lights or
//! too much for narrow ones. [`Bias::ADAPTIVE`](crate::Bias::ADAPTIVE) compares each tap with the
//! receiver's plane there, which is exact on planes of any width, and is the default. Biases also
//! shift z_r in the steps above, by themselves.

mod lanes;

use crate::{
    filtering::{
        depth_in_reach::{self, Cells},
        horizon::{HORIZON, Horizon, turned_heights},
        light_extent::{self, LIGHT_EXTENT, LightExtent, light_axes, reach_along, texel_depth},
        pattern_taps::{Comparisons, KernelPlacement, PATTERN_TAPS, PixelRotation, ReceiverLanes},
        sample_pattern::{PATTERN, Pattern, PatternShape, PatternTable, TURNS, turned},
    },
    lanes::batch::{Batch, BatchTaps, look_up_span},
    shadow_map::{
        CompareMethod, MapFormat, ShadowMap,
        coord::{ShadowCoord, shadow_coord},
        layers::ShadowMapUniforms,
    },
    techniques::map_technique::MapFilter,
    techniques::{
        hard::Hard,
        pcss::lanes::{BoundsLanes, PenumbraBounds, count_taps, mean_nearer},
    },
};
use glam::{Vec2, Vec3};
use std::sync::Arc;
use umbrage_core::{
    ImageView, Inputs, Kernel, Module, ReceiveKernel, Recipe, RecipeError, Simd, SimdTask, Span,
    UniformBlock, View, module, uniforms,
};

/// Penumbrae as wide as the light makes them.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct Pcss {
    /// Taps of the search, 1 to [`MAX_TAPS`](crate::filtering::sample_pattern::MAX_TAPS). Ideal
    /// lights take none.
    pub blocker_taps: u32,
    /// Taps of the filter, likewise. Ideal lights take one.
    pub filter_taps: u32,
    /// How both are spread.
    pub pattern: Pattern,
    /// Whether each pixel turns (or shifts) the pattern by its own noise.
    pub rotate: bool,
}

impl Default for Pcss {
    fn default() -> Self {
        Self {
            blocker_taps: 16,
            filter_taps: 32,
            pattern: Pattern::Vogel,
            rotate: true,
        }
    }
}

impl MapFilter for Pcss {
    const NAME: &'static str = "pcss";
    const SUMMARY: &'static str = "soft shadows: looks for blockers, then filters with a width that follows from their distance (Fernando 2005)";

    fn recipe(&self, map: &ShadowMap, view: &View<'_>) -> Result<Recipe, RecipeError> {
        let pattern = self.pattern_table(view)?;
        if view.light.is_ideal() {
            return Hard {}.recipe(map, view);
        }
        let size = map.size;
        let spaces = light_extent::spaces(map, view)?;
        let extent = LightExtent::new(view.light, &spaces, size);
        // Wide taps meet blockers that lie deeper than the receiver, yet above its plane, as on any
        // slope under a plate that is parallel to it. Only its plane tells those from the
        // receiver's own surface.
        let mut lookup = ShadowMapUniforms::new(map, view, &spaces);
        for layer in &mut lookup.layers {
            layer.deepest_tap = 1.0;
        }
        let uniforms = PcssUniforms {
            lookup,
            extent,
            horizon: Horizon::new(view.light, &spaces),
            blocker_taps: self.blocker_taps,
            filter_taps: self.filter_taps,
            turns: if self.rotate { TURNS - 1 } else { 0 },
            square: u32::from(pattern.shape == PatternShape::Square),
            cell: Cells::over(size).side(),
        };
        let mut maps = map.maps(&spaces, CompareMethod::Taps { reach: 1.0 });
        let depths = maps.map;
        let packed = map.format == MapFormat::Rgba8;
        let in_reach = depth_in_reach::add(&mut maps, size, packed, pattern.shape, extent);
        let table = pattern.table.clone();
        let mut recipe = maps.recipe(PcssKernel { uniforms, pattern });
        recipe.receive.inputs = vec![depths, in_reach];
        recipe.tables.push(table);
        recipe.receive.tables.push(0);
        Ok(recipe)
    }

    fn label(&self) -> String {
        let still = if self.rotate { "" } else { " still" };
        format!(
            "{} + {} taps,{still} {}",
            self.blocker_taps,
            self.filter_taps,
            self.pattern.name()
        )
    }
}

impl Pcss {
    fn pattern_table(&self, view: &View<'_>) -> Result<Arc<PatternTable>, RecipeError> {
        let sets = [
            ("pcss blocker taps", self.blocker_taps),
            ("pcss filter taps", self.filter_taps),
        ];
        Ok(PatternTable::new(
            self.pattern,
            light_extent::shape(view.light),
            &sets,
        )?)
    }
}

uniforms! {
    /// Uniforms of [`PcssKernel`].
    pub struct PcssUniforms {
        /// The map: its layers, and how it is compared with.
        pub lookup: ShadowMapUniforms,
        /// The light on the map.
        pub extent: LightExtent,
        /// The light in the world.
        pub horizon: Horizon,
        /// Taps of the search: the table's first.
        pub blocker_taps: u32,
        /// Taps of the filter: the table's next.
        pub filter_taps: u32,
        /// Greatest turn of the pattern: one less than the number of turns, or 0.
        pub turns: u32,
        /// 1 if the light is a square's image, 0 if it is a disc's.
        pub square: u32,
        /// Side of a cell of the second image, texels of the first.
        pub cell: u32,
    }
}

/// The receive kernel: it bounds the search, searches blockers, estimates the penumbra, and
/// filters.
#[derive(Clone, Debug)]
pub struct PcssKernel {
    /// Uniforms.
    pub uniforms: PcssUniforms,
    pattern: Arc<PatternTable>,
}

impl PcssKernel {
    /// Returns how far, in texels, the lookup of a receiver at `position` (world space) with the
    /// unit `normal` goes beyond its own texel: as far as a search could go, or a filter, which may
    /// be wider where the receiver's plane lies deeper under a blocker than under the receiver, and
    /// is a texel wide at least.
    pub fn lookup_reach(&self, position: Vec3, normal: Vec3) -> f32 {
        let u = &self.uniforms;
        let l = shadow_coord(&u.lookup, position, normal);
        let half_axis_u = u.extent.half_axis_u[l.layer as usize];
        let half_axis_v = u.extent.half_axis_v[l.layer as usize];
        let from_middle = l.texel - Vec2::splat(u.lookup.size * 0.5);
        let per_depth =
            light_extent::reach_at(self.pattern.shape, half_axis_u, half_axis_v, from_middle);
        let search = bounded(l.depth, half_axis_v.w) * per_depth;
        let deepest = l.depth + (l.gradient.x.abs() + l.gradient.y.abs()) * search;
        (bounded(deepest, half_axis_v.w) * per_depth).max(1.0)
    }
}

impl Kernel for PcssKernel {
    fn modules(&self) -> Vec<Module> {
        let own = [
            LIGHT_EXTENT,
            HORIZON,
            PATTERN,
            PATTERN_TAPS,
            module!("pcss"),
        ];
        self.uniforms.lookup.modules_without_full_light(&own)
    }

    fn uniforms(&self) -> Option<&dyn UniformBlock> {
        Some(&self.uniforms)
    }
}

impl ReceiveKernel for PcssKernel {
    fn receive(&self, inputs: &Inputs<'_>, span: &Span<'_>, out: &mut [f32]) {
        let lookup = &self.uniforms.lookup;
        let search = Search {
            kernel: self,
            simd: inputs.simd,
            comparisons: Comparisons {
                map: lookup.map(&inputs.images[0]),
                shape: self.pattern.shape,
                follows_plane: lookup.layers[0].follows_plane(),
            },
            in_reach: &inputs.images[1],
            span,
        };
        look_up_span(inputs.simd, lookup, span, out, &search);
    }
}

/// The search for blockers of one span's receivers.
#[derive(Clone, Copy)]
struct Search<'a> {
    kernel: &'a PcssKernel,
    simd: Simd,
    comparisons: Comparisons<'a>,
    /// The least depth in reach of each cell: see
    /// [`DepthInReachKernel`](crate::DepthInReachKernel).
    in_reach: &'a ImageView<'a>,
    span: &'a Span<'a>,
}

impl BatchTaps for Search<'_> {
    fn visibilities(&self, batch: &Batch, first: usize, out: &mut [f32]) {
        // Its own task: once compiled for all ways to project.
        self.simd.run_task(SearchBatch {
            search: *self,
            batch,
            first,
            out,
        });
    }
}

struct SearchBatch<'a> {
    search: Search<'a>,
    batch: &'a Batch,
    first: usize,
    out: &'a mut [f32],
}

impl SimdTask for SearchBatch<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self {
            search,
            batch,
            first,
            out,
        } = self;
        let comparisons = search.comparisons;
        let pattern = &search.kernel.pattern;
        for (batch_index, out) in out.iter_mut().enumerate() {
            *out = search.share(first + batch_index);
        }
        let size = comparisons.map.size;
        let mut bounds = BoundsLanes::new();
        let mut receivers = ReceiverLanes::none();
        for (batch_index, &share) in out.iter().enumerate() {
            let l = batch.lookup(batch_index);
            if !l.covered {
                continue;
            }
            if let Some((placement, its_bounds)) = search.placement(&l, first + batch_index, share)
            {
                bounds.push(&its_bounds);
                receivers.push(&l, batch_index, size, placement);
            }
        }
        let mean = mean_nearer(&comparisons, &receivers, &bounds, &pattern.sets[0]);
        let counts = count_taps(&comparisons, &receivers, &bounds, &mean, &pattern.sets[1]);
        for i in 0..receivers.count {
            // No tap above the horizon says nothing: the share of the light above it stands.
            let seen = if counts.above[i] > 0.0 {
                counts.lit[i] / counts.above[i]
            } else {
                1.0
            };
            out[receivers.batch_index[i]] *= seen;
        }
    }
}

impl Search<'_> {
    /// Returns the share of the light above the horizon, 0..=1, of the pixel `offset` in the span.
    #[inline(always)]
    fn share(&self, offset: usize) -> f32 {
        let u = &self.kernel.uniforms;
        u.horizon.share(
            u.square,
            u.lookup.light,
            self.span.position(offset),
            self.span.normal(offset),
        )
    }

    /// Returns how the pattern is laid over the map for a receiver at `l`, and its bounds; `None`
    /// where nothing may hide any of the `share` of the light above the horizon.
    #[inline(always)]
    fn placement(
        &self,
        l: &ShadowCoord,
        offset: usize,
        share: f32,
    ) -> Option<(KernelPlacement, PenumbraBounds)> {
        let u = &self.kernel.uniforms;
        let layer = l.layer as usize;
        let half = u.lookup.size * 0.5;
        let half_axis_u = u.extent.half_axis_u[layer];
        let half_axis_v = u.extent.half_axis_v[layer];
        let from_middle = Vec2::new(l.texel.x - half, l.texel.y - half);
        let max = half_axis_v.w;
        let search = bounded(l.depth - self.depth_in_reach(l), max);
        if share == 0.0 || search == 0.0 {
            return None;
        }
        let rotation = PixelRotation::at(&self.kernel.pattern, u.turns, self.span.first, offset);
        let cos_sin = rotation.cos_sin;
        let axes = turned(light_axes(half_axis_u, half_axis_v, from_middle), cos_sin);
        let texel = texel_depth(reach_along(u.square, axes));
        // Where all of the light is above the horizon, all of its points have the height 1, so that
        // every tap counts.
        let heights = if share < 1.0 {
            turned_heights(self.heights(layer, offset, from_middle), cos_sin)
        } else {
            Vec3::X
        };
        let bounds = PenumbraBounds {
            max,
            texel,
            search,
            heights,
        };
        let placement = KernelPlacement {
            axes,
            shift: rotation.shift,
        };
        Some((placement, bounds))
    }

    /// Returns [`Horizon::heights`] of the pixel `offset` in the span, `from_middle` texels from
    /// the middle of its layer.
    #[inline(always)]
    fn heights(&self, layer: usize, offset: usize, from_middle: Vec2) -> Vec3 {
        let u = &self.kernel.uniforms;
        // The tangent that a texel from the middle spans, and that of half the layer's angle.
        let texel_tangent = u.extent.half_axis_u[layer].w;
        let half_tangent = texel_tangent * (u.lookup.size * 0.5);
        u.horizon.heights(
            u.lookup.light,
            &u.lookup.layers[layer].clip_from_world,
            self.span.position(offset),
            self.span.normal(offset),
            from_middle * texel_tangent,
            half_tangent,
        )
    }

    /// Returns the least clip depth at which something may hide some of the light from a receiver
    /// at `l`.
    #[inline(always)]
    fn depth_in_reach(&self, l: &ShadowCoord) -> f32 {
        let last = (self.comparisons.map.size - 1) as f32;
        let cell = self.kernel.uniforms.cell as i32;
        // Bounded first: then conversion rounds down.
        let x = l.texel.x.max(0.0).min(last) as i32;
        let y = l.texel.y.max(0.0).min(last) as i32;
        self.in_reach.load(x / cell, y / cell, l.layer as u32)
    }
}

/// Returns a difference of clip depths bounded to 0..=max, and 0 for NaN.
#[inline(always)]
fn bounded(depth: f32, max: f32) -> f32 {
    let depth = if depth > 0.0 { depth } else { 0.0 };
    if depth < max { depth } else { max }
}
