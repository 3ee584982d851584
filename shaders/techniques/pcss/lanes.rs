//! Loops of [`Pcss`](crate::Pcss) over many receivers, with an array for each field.
//!
//! There is one vector lane per receiver. All receivers of a batch take their first tap, then all
//! take their second. Each lane adds its taps in the shader's order, so both halves agree bit for
//! bit. Functions with the parameter `N` compute the first `N` lanes.

#![expect(
    clippy::needless_range_loop,
    reason = "compilers vectorise one index into many arrays"
)]

use crate::{
    filtering::{
        pattern_taps::{AxisLanes, Comparisons, HALF_BATCH, ReceiverLanes},
        sample_pattern::{TapSet, closer_by, from_middle, tap_weight, wrapped},
    },
    lanes::batch::{BATCH, Lanes},
};
use glam::Vec3;

/// Bounds of a receiver's search and filter, as differences of clip depth.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PenumbraBounds {
    /// Greatest difference that is followed.
    pub(crate) max: f32,
    /// Difference that moves the light's edge by a texel.
    pub(crate) texel: f32,
    /// Difference over which blockers are searched.
    pub(crate) search: f32,
    /// Heights of the light's points over the receiver's plane: see
    /// [`turned_heights`](crate::filtering::horizon::turned_heights).
    pub(crate) heights: Vec3,
}

/// Values of [`PenumbraBounds`] of up to [`BATCH`] receivers, in the order of their
/// [`ReceiverLanes`], with an array for each field.
pub(crate) struct BoundsLanes {
    count: usize,
    /// Value of [`PenumbraBounds::max`].
    max: Lanes<f32>,
    /// Value of [`PenumbraBounds::texel`].
    texel: Lanes<f32>,
    /// Value of [`PenumbraBounds::search`].
    search: Lanes<f32>,
    /// Height of the light's centre: x of [`PenumbraBounds::heights`].
    height: Lanes<f32>,
    /// Change of the height along the first half axis: y of [`PenumbraBounds::heights`].
    height_u: Lanes<f32>,
    /// Change of the height along the second half axis: z of [`PenumbraBounds::heights`].
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

/// Tap of the pattern after each receiver's shift: its position, -1..1, and its distance from the
/// centre.
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

/// Computes steps 2 and 3 of [`Pcss`](crate::Pcss). Returns the weighted mean of how much nearer to
/// the light the blockers are than each receiver, clip depth. Returns the whole search range if
/// there are none.
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
    let axes = r.axes.scaled_axes(search);
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
            let nearer = r.own_depth(i) - depths.stored[i];
            let lit = depths.receiver[i] <= depths.stored[i];
            // The blocker must be so much nearer that the light's point through the tap is within
            // the light.
            let within_light = nearer >= search[i] * (m[i] * closer_by(m[i]));
            let hides = !lit & within_light;
            // Limit the penumbra to at least a texel; this also keeps the weight finite.
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

/// Number of each receiver's filter taps above its horizon.
pub(crate) struct TapCounts {
    /// Number of lit taps.
    pub(crate) lit: Lanes<f32>,
    /// Number of all taps.
    pub(crate) above: Lanes<f32>,
}

/// Computes steps 4 and 5 of [`Pcss`](crate::Pcss): returns the counts of taps for the penumbra of
/// `mean`.
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
    let axes = r.axes.scaled_axes(&reach);
    let height = &bounds.height;
    let height_u = &bounds.height_u;
    let height_v = &bounds.height_v;
    let mut lit = [0.0; BATCH];
    let mut above = [0.0; BATCH];
    for &tap in &set.taps {
        let tap = ShiftedTap::new::<N>(r, tap);
        let hidden = hides::<N>(map, r, &axes, mean, &tap);
        for i in 0..N {
            // Compute the height of the light's point over the receiver's plane.
            let tap_height = height[i] + height_u[i] * tap.x[i] + height_v[i] * tap.y[i];
            let counts = if tap_height > 0.0 { 1.0 } else { 0.0 };
            above[i] += counts;
            lit[i] += if hidden[i] == 0 { counts } else { 0.0 };
        }
    }
    TapCounts { lit, above }
}

/// Returns 1 if the light's point at the tap is hidden, else 0. A surface at the tap that is too
/// low to block the ray is looked up again where the ray is at its height.
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
        nearer[i] = r.own_depth(i) - depths.stored[i];
        let lit = depths.receiver[i] <= depths.stored[i];
        let in_the_way = nearer[i] >= mean[i] * tap.from_middle[i];
        hidden[i] = u32::from(!lit & in_the_way);
        low[i] = u32::from(!lit & !in_the_way & (nearer[i] > 0.0));
        any_low |= low[i];
    }
    if any_low == 0 {
        return hidden;
    }
    let lower = map.depths_at_point::<N>(r, &r.axes.scaled_axes(&nearer), &tap.x, &tap.y);
    for i in 0..N {
        // A solid caster is wide at its base: it is at least half as high where the ray is at that
        // height.
        let lit = lower.receiver[i] <= lower.stored[i];
        let as_high = r.own_depth(i) - lower.stored[i] >= nearer[i] * 0.5;
        hidden[i] |= low[i] & u32::from(!lit & as_high);
    }
    hidden
}
