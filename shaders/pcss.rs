//! Percentage-closer soft shadows: look for blockers, conclude how wide the penumbra is, filter that widely.
//!
//! Fernando 2005, "Percentage-closer soft shadows". A light of width w over a blocker at distance d_b throws on a receiver
//! at distance d_r a penumbra of width w (d_r - d_b) / d_b. Seen from the light, that is w (1/d_b - 1/d_r) in tangents;
//! and clip depth with perspective is linear in 1/d (without, in d, as the penumbra then is). So all three steps follow
//! from differences of clip depth z, with the light's half axes U and V in texels per unit of it ([`LightExtent`]):
//!
//! 1. **Search** the taps of a pattern over z_r (U, V): what anything between the map's near plane (z = 0) and the
//!    receiver could hide of the light. The near plane is where the first caster is, so no radius is guessed.
//! 2. **Penumbra**: the mean of z_r - z_b over the taps whose depth z_b is nearer than the receiver; none of them: lit.
//!    Where the receiver's plane is followed, z_r is the plane's depth at the tap.
//! 3. **Filter**: the share of lit taps over that mean times (U, V).
//!
//! Rectangles are sampled over the parallelogram and discs over the ellipse that the light makes on the map, so with all
//! blockers in one plane the answer is exact up to texels and taps, if that plane is parallel to the map, or to the
//! receiver whose plane is followed: on a slanting map, blockers on one side of an edge are otherwise nearer in the mean
//! than the edge. There is no least width: where
//! blocker and receiver meet, or under an ideal light, this is one hard comparison.
//!
//! Known failures, all of them from speaking of *the* blocker: blockers at several depths are merged into a mean that fits
//! none of them (a pole before a wall: its sharp shadow grows soft, the wall's soft one sharp; a canopy over a trunk);
//! what lies behind the nearest surface is not in the map, so shadows of two casters under one another do not add up as
//! they should; with few taps a small blocker, or the foot of a tall one, is missed by the search and light leaks at
//! contacts; lights so wide or casters so near to them that the search would leave the map are followed only half a map
//! far, and cube faces are never left: their outermost receivers are then too bright. Heights are told by few taps: the
//! widths of penumbrae are off by a quarter to a half with 16 taps of search. Under ideal lights it fails as
//! [`Hard`](crate::Hard) does, and as every map: see [`shadow_map`](crate::shadow_map).
//!
//! Bias: taps wander far from the receiver, so anything constant is too little for wide lights or too much for narrow
//! ones. [`Bias::ADAPTIVE`](crate::Bias::ADAPTIVE) compares each tap with the receiver's plane there, which is exact on planes of any width,
//! and is the default. Biases also shift z_r in the steps above, by themselves.

use crate::{
    batch::{BATCH, Batch, BatchTaps, look_up_span},
    bias::Footprint,
    light_extent::{self, LIGHT_EXTENT, LightExtent, light_axes},
    lookup::{Lookup, MapLookup, look_up},
    pattern::{PATTERN, Pattern, PatternTable, TURNS, turned},
    shadow_map::ShadowMap,
    soft_taps::{Comparisons, Laid, Lanes, PLACED, Receivers, SOFT_TAPS, turn_at},
};
use glam::{UVec2, Vec2, Vec3};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use umbrage_core::{
    Asks, Inputs, Kernel, Module, PlanError, ReceiveKernel, Recipe, ShadowTechnique, Simd, SimdTask, Span,
    UniformLayout, Uniforms, View, uniforms,
};

/// Steps of depth in which blockers are summed: whole numbers add in any order. 2^23, so that
/// [`MAX_TAPS`](crate::pattern::MAX_TAPS) of them fit in 31 bits.
pub const DEPTH_UNITS: f32 = 8_388_608.0;

/// Penumbrae as wide as the light makes them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Pcss {
    /// The map looked up.
    pub map: ShadowMap,
    /// Taps of the search, 1 to [`MAX_TAPS`](crate::pattern::MAX_TAPS). Ideal lights take one.
    pub blocker_taps: u32,
    /// Taps of the filter, likewise.
    pub filter_taps: u32,
    /// How both are spread.
    pub pattern: Pattern,
    /// Whether each pixel turns (or shifts) the pattern by its own noise.
    pub rotate: bool,
}

impl Default for Pcss {
    fn default() -> Self {
        let map = ShadowMap::default();
        Self { map, blocker_taps: 16, filter_taps: 32, pattern: Pattern::Vogel, rotate: true }
    }
}

impl ShadowTechnique for Pcss {
    fn name(&self) -> &'static str {
        "pcss"
    }

    fn settings(&self) -> String {
        let still = if self.rotate { "" } else { " still" };
        let taps = format!("{} + {} taps,{still} {}", self.blocker_taps, self.filter_taps, self.pattern.name());
        format!("{taps}, {}", self.map.label())
    }

    fn plan(&self, view: &View<'_>) -> Result<Recipe, PlanError> {
        let pattern = self.pattern_table(view)?;
        let spaces = light_extent::spaces(&self.map, view)?;
        let ideal = view.light.is_ideal();
        let mut lookup = MapLookup::new(&self.map, view, &spaces);
        if !ideal {
            // Wide taps meet blockers that lie deeper than the receiver, yet above its plane, as on any slope under a plate that
            // is parallel to it. Only its plane tells those from the receiver's own surface.
            lookup.deepest_tap = 1.0;
        }
        let uniforms = PcssUniforms {
            lookup,
            extent: LightExtent::new(view.light, &spaces, self.map.size),
            blocker_taps: pattern.sets[0].count,
            filter_taps: pattern.sets[1].count,
            turns: if self.rotate { TURNS - 1 } else { 0 },
        };
        let table = pattern.table.clone();
        let mut recipe = self
            .map
            .maps(&spaces, Footprint::Taps { reach: if ideal { 0.0 } else { 1.0 } })
            .recipe(PcssKernel { uniforms, pattern });
        recipe.tables.push(table);
        recipe.receive.tables.push(0);
        Ok(recipe)
    }

    /// As wide as the penumbra, which differs everywhere; a texel is the least.
    fn kernel_reach(&self) -> Option<f32> {
        Some(1.0)
    }
}

impl Pcss {
    fn pattern_table(&self, view: &View<'_>) -> Result<Arc<PatternTable>, PlanError> {
        let make = |blocker, filter| {
            let sets = [("pcss blocker taps", blocker), ("pcss filter taps", filter)];
            PatternTable::new(self.pattern, light_extent::shape(view.light), &sets)
        };
        let asked = make(self.blocker_taps, self.filter_taps)?;
        // All taps of an ideal light fall on the receiver's own texel.
        Ok(if view.light.is_ideal() { make(1, 1)? } else { asked })
    }
}

uniforms! {
    /// Uniforms of [`PcssKernel`].
    pub struct PcssUniforms {
        /// The way to the map.
        pub lookup: MapLookup,
        /// The light on the map.
        pub extent: LightExtent,
        /// Taps of the search: the table's first.
        pub blocker_taps: u32,
        /// Taps of the filter: the table's next.
        pub filter_taps: u32,
        /// Greatest turn of the pattern: one less than the number of turns, or 0.
        pub turns: u32,
    }
}

/// Search, estimate, filter.
#[derive(Clone, Debug)]
pub struct PcssKernel {
    uniforms: PcssUniforms,
    pattern: Arc<PatternTable>,
}

impl Kernel for PcssKernel {
    fn modules(&self) -> Vec<Module> {
        let own = Module { name: "pcss", text: include_str!("pcss.wgsl") };
        self.uniforms.lookup.modules().into_iter().chain([LIGHT_EXTENT, PATTERN, PLACED, SOFT_TAPS, own]).collect()
    }

    fn uniform_bytes(&self) -> Vec<u8> {
        self.uniforms.to_bytes()
    }

    fn layout(&self) -> UniformLayout {
        PcssUniforms::layout()
    }
}

impl ReceiveKernel for PcssKernel {
    fn receive(&self, inputs: &Inputs<'_>, span: &Span<'_>, out: &mut [f32]) {
        let (lookup, simd) = (&self.uniforms.lookup, inputs.simd);
        let (map, shape) = (lookup.map(&inputs.images[0]), self.pattern.shape);
        let at = Comparisons { map, shape, plane: lookup.receiver_plane > 0.0 };
        look_up_span(simd, lookup, span, out, &Search { kernel: self, simd, at, pixel: span.first });
    }

    fn asks(&self) -> Asks {
        Asks::taps(self.uniforms.blocker_taps + self.uniforms.filter_taps)
    }

    /// As far as the search goes, or a filter, which may be wider where the receiver's plane lies deeper under a blocker than
    /// under the receiver.
    fn reach(&self, position: Vec3, normal: Vec3) -> Option<f32> {
        let u = &self.uniforms;
        let l = look_up(&u.lookup, position, normal);
        let (across, along) = (u.extent.across[l.layer as usize], u.extent.along[l.layer as usize]);
        let from_middle = l.texel - Vec2::splat(u.lookup.size * 0.5);
        let per_depth = light_extent::reach_at(self.pattern.shape, across, along, from_middle);
        let search = bounded(l.depth, along.w) * per_depth;
        let deepest = l.depth + (l.gradient.x.abs() + l.gradient.y.abs()) * search;
        Some(bounded(deepest, along.w) * per_depth)
    }
}

/// What is looked for in one span, whose first pixel is `pixel`.
#[derive(Clone, Copy)]
struct Search<'a> {
    kernel: &'a PcssKernel,
    simd: Simd,
    at: Comparisons<'a>,
    pixel: UVec2,
}

impl BatchTaps for Search<'_> {
    fn visibilities(&self, batch: &Batch, first: usize, out: &mut [f32]) {
        // Its own task: once compiled for all ways to project.
        self.simd.run_task(SearchBatch { search: *self, batch, first, out });
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
        let Self { search, batch, first, out } = self;
        let PcssKernel { uniforms: u, pattern } = search.kernel;
        let lay = |l: &Lookup, number| search.lay(l, first + number);
        let mut receivers = Receivers::seen(batch, out.len(), search.at.map.size, lay);
        out.fill(1.0);
        let reach = search.blocked(&mut receivers);
        let lit = search.at.lit(&receivers, &receivers.scaled(&reach), &pattern.sets[1]);
        for i in 0..receivers.count {
            out[receivers.number[i]] = lit[i] as f32 / u.filter_taps as f32;
        }
    }
}

impl Search<'_> {
    /// The light's axes at a receiver, with the most that they are multiplied by, and the pattern's shift.
    #[inline(always)]
    fn lay(&self, l: &Lookup, offset: usize) -> Laid {
        let PcssKernel { uniforms: u, pattern } = self.kernel;
        let turn = turn_at(pattern, u.turns, self.pixel, offset);
        let (face, half) = (l.layer as usize, u.lookup.size * 0.5);
        let (across, along) = (u.extent.across[face], u.extent.along[face]);
        let from_middle = Vec2::new(l.texel.x - half, l.texel.y - half);
        let axes = turned(light_axes(across, along, from_middle), Vec2::new(turn.x, turn.y));
        Laid { axes, shift: Vec2::new(turn.z, turn.w), most: along.w }
    }

    /// Keeps the receivers that something blocks, and says how far their filters reach.
    #[inline(always)]
    fn blocked(&self, r: &mut Receivers) -> Lanes<f32> {
        let mut reach = [0.0; BATCH];
        for (i, reach) in reach.iter_mut().enumerate() {
            *reach = bounded(r.depth[i], r.most[i]);
        }
        let [count, sum] = self.at.blockers(r, &r.scaled(&reach), &self.kernel.pattern.sets[0]);
        for i in 0..BATCH {
            let nearer = sum[i] as f32 / (count[i] as f32 * DEPTH_UNITS);
            reach[i] = bounded(nearer, r.most[i]);
        }
        r.retain(&mut reach, |i| count[i] > 0);
        reach
    }
}

/// A difference of clip depths between nothing and what is followed.
#[inline(always)]
fn bounded(depth: f32, most: f32) -> f32 {
    let depth = if depth > 0.0 { depth } else { 0.0 };
    if depth < most { depth } else { most }
}
