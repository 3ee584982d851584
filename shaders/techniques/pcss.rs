//! Percentage-closer soft shadows: search blockers, estimate the penumbra, filter with its width.
//!
//! Fernando 2005, "Percentage-closer soft shadows". A light of width w over a blocker at distance
//! d_b casts a penumbra of width w (d_r - d_b) / d_b on a receiver at distance d_r. Viewed from the
//! light, that is w (1/d_b - 1/d_r) in tangents. Clip depth is linear in 1/d with perspective.
//! (Without, it is linear in d, as is the penumbra.) So all steps use differences of clip depth z,
//! and the light's half axes U and V in texels per unit of clip depth ([`LightExtent`]). **For a
//! receiver that is deeper by z, the ray to the light's point (x, y) passes through the texel at z
//! (x U + y V) from its own.**
//!
//! 1. **Bound** z by the nearest caster that may hide part of the light, from a coarse grid over
//!    the map ([`DepthInReachKernel`](crate::DepthInReachKernel)). If there is none, the receiver
//!    is lit. So the width of the search follows from nearby blockers, independent of the map's
//!    near plane. Most lit receivers need no search.
//! 2. **Search** the taps of a pattern over that z times (U, V). Taps are denser towards the
//!    centre, where blockers near the receiver must be. A tap counts if its surface hides part of
//!    the light. The surface must be before the receiver's plane and nearer to the light than the
//!    receiver. The light's point through it must be within the light.
//! 3. **Penumbra**: the mean of z_r - z_b over these taps, weighted by the fraction of the light
//!    that each hides. If no tap counts, use the search's own z. The search then missed only
//!    blockers that hide little of the light. The filter has more taps, distributed evenly over the
//!    light, and measures them. If the receiver's plane is followed, z_r is the plane's depth at
//!    the tap.
//! 4. **Filter**: the fraction of lit taps over that mean times (U, V), which is at least a texel.
//!    A tap that finds a surface too low to block the ray looks again where the ray is that low. A
//!    wall next to the receiver rises below the rays. A solid caster, wide at its base, does block
//!    them. (The second lookup identifies the wall by a height of less than half.)
//! 5. **Horizon**: taps at points of the light below the receiver's plane do not count. The result
//!    is multiplied by the fraction of the light above the plane, which is computed exactly
//!    ([`Horizon`]).
//!
//! The rule that only blockers that hide part of the light count is that of backprojection
//! (Guennebaud, Barthe and Paulin 2006, "Real-time soft shadow mapping by backprojection").
//! Rectangles are sampled over the light's parallelogram on the map, and discs over its ellipse. So
//! with all blockers in one plane, the result is exact up to texels and taps under a condition.
//! That plane must be parallel to the map, or to the receiver whose plane is followed. Otherwise,
//! on a slanting map, blockers on one side of an edge are nearer in the mean than the edge. Ideal
//! lights have no width, and use one hard comparison, the recipe of [`Hard`].
//!
//! Known failures, all caused by assuming a single blocker:
//!
//! - Blockers at several depths are merged into a mean that fits none of them. Where a pole's
//!   shadow crosses a wall's, the pole's becomes sharp and the wall's soft.
//! - An outline before nearer parts of the same caster has too wide a penumbra (around a pot's
//!   shadow).
//! - Surfaces behind the nearest one are not in the map. So shadows of two casters, one below the
//!   other, do not add up correctly.
//! - With few taps, the search misses a blocker that hides little of the light. If nearer blockers
//!   are in reach, the filter underestimates it, and light leaks through leaves. More taps help.
//! - The search is limited to half a map for wide lights or casters near them, and does not leave
//!   cube faces. The outermost receivers are then too bright. Under a ball as wide as a seventh of
//!   a room, two faces of a cube differ by a few hundredths of the light.
//! - Under ideal lights, the failures are those of [`Hard`] and of every map: see
//!   [`shadow_map`](crate::shadow_map).
//!
//! Bias: taps are far from the receiver, so a constant is too small for wide lights or too large
//! for narrow ones. The default, [`Bias::ADAPTIVE`](crate::Bias::ADAPTIVE), compares each tap with
//! the receiver's plane there, which is exact on planes for any width. Biases also shift z_r by
//! their own amount in the steps above.

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

/// Penumbrae with the width that the light causes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct Pcss {
    /// Number of search taps, 1 to [`MAX_TAPS`](crate::filtering::sample_pattern::MAX_TAPS). Ideal
    /// lights use none.
    pub blocker_taps: u32,
    /// Number of filter taps, with the same range. Ideal lights use one.
    pub filter_taps: u32,
    /// Distribution of both.
    pub pattern: Pattern,
    /// True if each pixel rotates (or shifts) the pattern by its own noise.
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
    const SUMMARY: &'static str =
        "soft shadows: a blocker search, then a filter as wide as the penumbra (Fernando 2005)";

    fn recipe(&self, map: &ShadowMap, view: &View<'_>) -> Result<Recipe, RecipeError> {
        let pattern = self.pattern_table(view)?;
        if view.light.is_ideal() {
            return Hard {}.recipe(map, view);
        }
        let size = map.size;
        let spaces = light_extent::spaces(map, view)?;
        let extent = LightExtent::new(view.light, &spaces, size);
        // Wide taps find blockers that are deeper than the receiver but above its plane, as on any
        // slope under a plate that is parallel to it. Only the receiver's plane distinguishes those
        // from its own surface.
        let mut lookup = ShadowMapUniforms::new(map, view, &spaces);
        for layer in &mut lookup.layers {
            layer.deepest_tap = 1.0;
        }
        // Build the kernel's uniforms.
        let uniforms = PcssUniforms {
            lookup,
            extent,
            horizon: Horizon::new(view.light, &spaces),
            blocker_taps: self.blocker_taps,
            filter_taps: self.filter_taps,
            turns: if self.rotate { TURNS - 1 } else { 0 },
            square: u32::from(pattern.shape == PatternShape::Square),
            cell: Cells::over_size(size).side(),
        };
        // Add the map and the grid of least depths.
        let mut maps = map.maps(&spaces, CompareMethod::Taps { reach: 1.0 });
        let depths = maps.map;
        let packed = map.format == MapFormat::Rgba8;
        let in_reach = depth_in_reach::add(&mut maps, size, packed, pattern.shape, extent);
        let table = pattern.table.clone();
        // Add the lookup and its table of taps.
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
        /// Layers of the map and how they are compared.
        pub lookup: ShadowMapUniforms,
        /// Extent of the light on the map.
        pub extent: LightExtent,
        /// Extent of the light in the world.
        pub horizon: Horizon,
        /// Number of search taps; they are first in the table.
        pub blocker_taps: u32,
        /// Number of filter taps; they are next in the table.
        pub filter_taps: u32,
        /// Greatest turn of the pattern: one less than the number of turns, or 0.
        pub turns: u32,
        /// Set to 1 if the light's projection is a parallelogram, 0 if it is an ellipse.
        pub square: u32,
        /// Side of a cell of the second image, texels of the first.
        pub cell: u32,
    }
}

/// Receive kernel of PCSS: bounds the search, searches blockers, estimates the penumbra, and
/// filters.
#[derive(Clone, Debug)]
pub struct PcssKernel {
    /// Uniforms.
    pub uniforms: PcssUniforms,
    pattern: Arc<PatternTable>,
}

impl PcssKernel {
    /// Returns the reach, in texels beyond its own, of the lookup of a receiver at `position`
    /// (world space) with the unit `normal`. It is the greatest reach of a search or a filter. The
    /// filter may be wider if the receiver's plane is deeper under a blocker than under the
    /// receiver. It is at least a texel.
    pub fn lookup_reach(&self, position: Vec3, normal: Vec3) -> f32 {
        let u = &self.uniforms;
        let l = shadow_coord(&u.lookup, position, normal);
        let half_axis_u = u.extent.half_axis_u[l.layer as usize];
        let half_axis_v = u.extent.half_axis_v[l.layer as usize];
        let from_middle = l.texel - Vec2::splat(u.lookup.size * 0.5);
        let per_depth =
            light_extent::reach_at(self.pattern.shape, half_axis_u, half_axis_v, from_middle);
        let search = bounded_depth(l.own_depth(), half_axis_v.w) * per_depth;
        let deepest = l.own_depth() + (l.gradient.x.abs() + l.gradient.y.abs()) * search;
        (bounded_depth(deepest, half_axis_v.w) * per_depth).max(1.0)
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

/// Blocker search for the receivers of a span.
#[derive(Clone, Copy)]
struct Search<'a> {
    kernel: &'a PcssKernel,
    simd: Simd,
    comparisons: Comparisons<'a>,
    /// Least depth in reach of each cell: see [`DepthInReachKernel`](crate::DepthInReachKernel).
    in_reach: &'a ImageView<'a>,
    span: &'a Span<'a>,
}

impl BatchTaps for Search<'_> {
    fn visibilities(&self, batch: &Batch, first: usize, out: &mut [f32]) {
        // A separate task, which is compiled once for all kinds of projection.
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
        // Start from the fraction of the light above the horizon.
        for (batch_index, out) in out.iter_mut().enumerate() {
            *out = search.share(first + batch_index);
        }
        // Collect the receivers that a blocker may reach.
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
        // Estimate their penumbrae, and filter.
        let mean = mean_nearer(&comparisons, &receivers, &bounds, &pattern.sets[0]);
        let counts = count_taps(&comparisons, &receivers, &bounds, &mean, &pattern.sets[1]);
        for i in 0..receivers.count {
            // If no tap is above the horizon, use the fraction of the light above it.
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
    /// Returns the fraction of the light above the horizon, 0..=1, of the pixel `offset` in the
    /// span.
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

    /// Returns the placement of the pattern on the map for a receiver at `l`, and its bounds;
    /// `None` if nothing can hide the `share` of the light above the horizon.
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
        // Bound the search by the nearest caster in reach.
        let max = half_axis_v.w;
        let search = bounded_depth(l.own_depth() - self.depth_in_reach(l), max);
        if share == 0.0 || search == 0.0 {
            return None;
        }
        // Rotate the light's half axes by the pixel's noise.
        let rotation =
            PixelRotation::rotation_at(&self.kernel.pattern, u.turns, self.span.first, offset);
        let cos_sin = rotation.cos_sin;
        let axes = turned(light_axes(half_axis_u, half_axis_v, from_middle), cos_sin);
        let texel = texel_depth(reach_along(u.square, axes));
        // If the whole light is above the horizon, all its points have the height 1, so every tap
        // counts.
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
    /// the centre of its layer.
    #[inline(always)]
    fn heights(&self, layer: usize, offset: usize, from_middle: Vec2) -> Vec3 {
        let u = &self.kernel.uniforms;
        // Tangent that a texel from the centre spans, and that of half the layer's angle.
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

    /// Returns the least clip depth at which a surface may hide part of the light from a receiver
    /// at `l`.
    #[inline(always)]
    fn depth_in_reach(&self, l: &ShadowCoord) -> f32 {
        let last = (self.comparisons.map.size - 1) as f32;
        let cell = self.kernel.uniforms.cell as i32;
        // Clamp first, so that the conversion rounds down.
        let x = l.texel.x.max(0.0).min(last) as i32;
        let y = l.texel.y.max(0.0).min(last) as i32;
        self.in_reach.load(x / cell, y / cell, l.layer as u32)
    }
}

/// Clamps a difference of clip depths to 0..=max, and NaN to 0.
#[inline(always)]
fn bounded_depth(depth: f32, max: f32) -> f32 {
    let depth = if depth > 0.0 { depth } else { 0.0 };
    if depth < max { depth } else { max }
}
