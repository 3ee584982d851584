//! The loops of [`Pcss`](crate::Pcss) over many receivers, with an array for each field.
//!
//! One vector lane per receiver: all receivers of a batch take their first tap, then all their
//! second. Each lane adds up its taps in the shader's order, so both halves agree to the bit.
//! Functions with the parameter `N` compute the first `N` lanes.

#![expect(
    clippy::needless_range_loop,
    reason = "one index into many arrays: that is what compilers turn into vector lanes"
)]

use crate::{
    filtering::{
        pattern_taps::{AxisLanes, Comparisons, HALF_BATCH, ReceiverLanes},
        sample_pattern::{TapSet, closer_by, from_middle, tap_weight, wrapped},
    },
    lanes::batch::{BATCH, Lanes},
};
use glam::Vec3;

/// A receiver's bounds for the search and the filter, as differences of clip depth.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PenumbraBounds {
    /// The greatest difference that is followed.
    pub(crate) max: f32,
    /// The difference that moves the light's rim by a texel.
    pub(crate) texel: f32,
    /// The difference over which blockers are searched.
    pub(crate) search: f32,
    /// Heights of the light's points over the receiver's plane: see
    /// [`turned_heights`](crate::filtering::horizon::turned_heights).
    pub(crate) heights: Vec3,
}

/// The [`PenumbraBounds`] of up to [`BATCH`] receivers, in the order of their [`ReceiverLanes`], an
/// array for each field.
pub(crate) struct BoundsLanes {
    count: usize,
    /// [`PenumbraBounds::max`].
    max: Lanes<f32>,
    /// [`PenumbraBounds::texel`].
    texel: Lanes<f32>,
    /// [`PenumbraBounds::search`].
    search: Lanes<f32>,
    /// x of [`PenumbraBounds::heights`]: the height of the light's middle.
    height: Lanes<f32>,
    /// y of [`PenumbraBounds::heights`]: the change of the height along the first half axis.
    height_u: Lanes<f32>,
    /// z of [`PenumbraBounds::heights`]: the change of the height along the second half axis.
    height_v: Lanes<f32>,
}

impl BoundsLanes {
    /// Returns the bounds of no receivers.
    #[inline(always)]
    pub(crate) fn new() -> Self {
        let zero = [0.0; BATCH];
        Self {
            count: 0,
            max: zero,
            texel: zero,
            search: zero,
            height: zero,
            height_u: zero,
            height_v: zero,
        }
    }

    /// Adds the next receiver's bounds.
    ///
    /// Panics if there are [`BATCH`] already.
    #[inline(always)]
    pub(crate) fn push(&mut self, bounds: &PenumbraBounds) {
        let i = self.count;
        self.max[i] = bounds.max;
        self.texel[i] = bounds.texel;
        self.search[i] = bounds.search;
        self.height[i] = bounds.heights.x;
        self.height_u[i] = bounds.heights.y;
        self.height_v[i] = bounds.heights.z;
        self.count += 1;
    }
}

/// One tap of the pattern as each receiver shifts it: its place, -1..1, and its distance from the
/// middle.
struct ShiftedTap {
    x: Lanes<f32>,
    y: Lanes<f32>,
    from_middle: Lanes<f32>,
}

impl ShiftedTap {
    #[inline(always)]
    fn new<const N: usize>(r: &ReceiverLanes, tap: Vec3) -> Self {
        let mut shifted = Self {
            x: [0.0; BATCH],
            y: [0.0; BATCH],
            from_middle: [0.0; BATCH],
        };
        for i in 0..N {
            shifted.x[i] = wrapped(tap.x + r.shift_x[i]);
            shifted.y[i] = wrapped(tap.y + r.shift_y[i]);
            shifted.from_middle[i] = from_middle(shifted.x[i], shifted.y[i], tap.z);
        }
        shifted
    }
}

/// Step 2 and 3 of [`Pcss`](crate::Pcss): returns by how much blockers are nearer to the light than
/// each receiver in the weighted mean, clip depth; the whole search where it found none.
#[inline(always)]
pub(crate) fn mean_nearer(
    map: &Comparisons<'_>,
    r: &ReceiverLanes,
    bounds: &BoundsLanes,
    set: &TapSet,
) -> Lanes<f32> {
    if r.count <= HALF_BATCH {
        mean_nearer_lanes::<HALF_BATCH>(map, r, bounds, set)
    } else {
        mean_nearer_lanes::<BATCH>(map, r, bounds, set)
    }
}

#[inline(always)]
fn mean_nearer_lanes<const N: usize>(
    map: &Comparisons<'_>,
    r: &ReceiverLanes,
    bounds: &BoundsLanes,
    set: &TapSet,
) -> Lanes<f32> {
    let search = &bounds.search;
    let texel = &bounds.texel;
    let axes = r.axes.scaled(search);
    let mut sum = [0.0; BATCH];
    let mut weights = [0.0; BATCH];
    for &tap in &set.taps {
        let mut shifted = ShiftedTap::new::<N>(r, tap);
        let m = &shifted.from_middle;
        for i in 0..N {
            shifted.x[i] *= closer_by(m[i]);
            shifted.y[i] *= closer_by(m[i]);
        }
        let depths = map.depths_at_point::<N>(r, &axes, &shifted.x, &shifted.y);
        for i in 0..N {
            let nearer = r.depth[i] - depths.stored[i];
            let lit = depths.receiver[i] <= depths.stored[i];
            // Nearer by so much that the light's point through the tap is within the light.
            let within_light = nearer >= search[i] * (m[i] * closer_by(m[i]));
            let hides = !lit & within_light;
            // No penumbra is narrower than a texel; this also keeps the weight finite.
            let counted = if nearer > texel[i] { nearer } else { texel[i] };
            let weight = if hides {
                tap_weight(m[i], counted)
            } else {
                0.0
            };
            sum[i] += weight * (depths.receiver[i] - depths.stored[i]);
            weights[i] += weight;
        }
    }
    let mut mean = [0.0; BATCH];
    for i in 0..N {
        mean[i] = if weights[i] > 0.0 {
            sum[i] / weights[i]
        } else {
            search[i]
        };
    }
    mean
}

/// Counts of each receiver's filter taps that lie above its horizon.
pub(crate) struct TapCounts {
    /// Those through which the light is seen.
    pub(crate) lit: Lanes<f32>,
    /// All of them.
    pub(crate) above: Lanes<f32>,
}

/// Step 4 and 5 of [`Pcss`](crate::Pcss): returns the counts of taps for a penumbra that `mean`
/// makes.
#[inline(always)]
pub(crate) fn count_taps(
    map: &Comparisons<'_>,
    r: &ReceiverLanes,
    bounds: &BoundsLanes,
    mean: &Lanes<f32>,
    set: &TapSet,
) -> TapCounts {
    if r.count <= HALF_BATCH {
        count_taps_lanes::<HALF_BATCH>(map, r, bounds, mean, set)
    } else {
        count_taps_lanes::<BATCH>(map, r, bounds, mean, set)
    }
}

#[inline(always)]
fn count_taps_lanes<const N: usize>(
    map: &Comparisons<'_>,
    r: &ReceiverLanes,
    bounds: &BoundsLanes,
    mean: &Lanes<f32>,
    set: &TapSet,
) -> TapCounts {
    let texel = &bounds.texel;
    let max = &bounds.max;
    let mut reach = [0.0; BATCH];
    for i in 0..N {
        let wide = if mean[i] > texel[i] {
            mean[i]
        } else {
            texel[i]
        };
        reach[i] = if wide < max[i] { wide } else { max[i] };
    }
    let axes = r.axes.scaled(&reach);
    let height = &bounds.height;
    let height_u = &bounds.height_u;
    let height_v = &bounds.height_v;
    let mut lit = [0.0; BATCH];
    let mut above = [0.0; BATCH];
    for &tap in &set.taps {
        let tap = ShiftedTap::new::<N>(r, tap);
        let hidden = hides::<N>(map, r, &axes, mean, &tap);
        for i in 0..N {
            // The height of the light's point over the receiver's plane.
            let tap_height = height[i] + height_u[i] * tap.x[i] + height_v[i] * tap.y[i];
            let counts = if tap_height > 0.0 { 1.0 } else { 0.0 };
            above[i] += counts;
            lit[i] += if hidden[i] == 0 { counts } else { 0.0 };
        }
    }
    TapCounts { lit, above }
}

/// Returns 1 where something hides the light's point at the tap, else 0: what is found there, or,
/// if that is too low to be in the ray's way, what the ray passes where it is as low.
#[inline(always)]
fn hides<const N: usize>(
    map: &Comparisons<'_>,
    r: &ReceiverLanes,
    axes: &AxisLanes,
    mean: &Lanes<f32>,
    tap: &ShiftedTap,
) -> Lanes<u32> {
    let depths = map.depths_at_point::<N>(r, axes, &tap.x, &tap.y);
    let mut hidden = [0; BATCH];
    let mut low = [0; BATCH];
    let mut nearer = [0.0; BATCH];
    let mut any_low = 0;
    for i in 0..N {
        nearer[i] = r.depth[i] - depths.stored[i];
        let lit = depths.receiver[i] <= depths.stored[i];
        let in_the_way = nearer[i] >= mean[i] * tap.from_middle[i];
        hidden[i] = u32::from(!lit & in_the_way);
        low[i] = u32::from(!lit & !in_the_way & (nearer[i] > 0.0));
        any_low |= low[i];
    }
    if any_low == 0 {
        return hidden;
    }
    let lower = map.depths_at_point::<N>(r, &r.axes.scaled(&nearer), &tap.x, &tap.y);
    for i in 0..N {
        // A solid caster is wide below: it is at least half as high where the ray is as low.
        let lit = lower.receiver[i] <= lower.stored[i];
        let as_high = r.depth[i] - lower.stored[i] >= nearer[i] * 0.5;
        hidden[i] |= low[i] & u32::from(!lit & as_high);
    }
    hidden
}
