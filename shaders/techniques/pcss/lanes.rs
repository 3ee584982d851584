//! The loops of [`Pcss`](crate::Pcss) over many receivers, an array a field: all receivers of a batch go to their first tap,
//! then all to their second. Each lane adds up its taps in the shader's order, so both agree to the bit.

use crate::{
    filtering::{
        pattern_taps::{Axes, Comparisons, HALF, KernelPlacement, Lanes, ReceiverLanes},
        sample_pattern::{TapSet, closer_by, from_middle, tap_weight, wrapped},
    },
    lanes::batch::BATCH,
};
use glam::{Vec2, Vec3, Vec4};

/// What a receiver needs besides its place on the map.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Soft {
    /// Greatest difference of clip depths that is followed.
    pub(crate) most: f32,
    /// The one that moves the light's rim by a texel.
    pub(crate) texel: f32,
    /// The one over which blockers are searched.
    pub(crate) widest: f32,
    /// How the light's points lie over the receiver's plane: [`turned_heights`](crate::filtering::horizon::turned_heights).
    pub(crate) heights: Vec3,
}

/// Places of [`Soft`]'s numbers in [`ReceiverLanes::more`].
const MOST: usize = 0;
const TEXEL: usize = 1;
const WIDEST: usize = 2;
const HEIGHTS: [usize; 3] = [3, 4, 5];

impl Soft {
    pub(crate) fn placement(self, axes: Vec4, shift: Vec2) -> KernelPlacement {
        let h = self.heights;
        KernelPlacement {
            axes,
            shift,
            more: [self.most, self.texel, self.widest, h.x, h.y, h.z],
        }
    }
}

/// A tap of the pattern, as each receiver shifts it: its place, and how far that is from the middle.
struct Spot {
    x: Lanes<f32>,
    y: Lanes<f32>,
    from_middle: Lanes<f32>,
}

impl Spot {
    #[inline(always)]
    fn new<const N: usize>(r: &ReceiverLanes, tap: Vec3) -> Self {
        let mut spot = Self {
            x: [0.0; BATCH],
            y: [0.0; BATCH],
            from_middle: [0.0; BATCH],
        };
        for i in 0..N {
            spot.x[i] = wrapped(tap.x + r.shift[0][i]);
            spot.y[i] = wrapped(tap.y + r.shift[1][i]);
            spot.from_middle[i] = from_middle(spot.x[i], spot.y[i], tap.z);
        }
        spot
    }
}

/// By how much blockers are nearer in the mean; the whole search where it found none.
#[inline(always)]
pub(crate) fn mean_nearer(at: &Comparisons<'_>, r: &ReceiverLanes, set: &TapSet) -> Lanes<f32> {
    if r.count <= HALF {
        mean_nearer_in::<HALF>(at, r, set)
    } else {
        mean_nearer_in::<BATCH>(at, r, set)
    }
}

#[inline(always)]
fn mean_nearer_in<const N: usize>(
    at: &Comparisons<'_>,
    r: &ReceiverLanes,
    set: &TapSet,
) -> Lanes<f32> {
    let (widest, texel) = (&r.more[WIDEST], &r.more[TEXEL]);
    let axes = r.scaled(widest);
    let (mut sum, mut weights) = ([0.0; BATCH], [0.0; BATCH]);
    for &tap in &set.taps {
        let Spot {
            mut x,
            mut y,
            from_middle: m,
        } = Spot::new::<N>(r, tap);
        for i in 0..N {
            x[i] *= closer_by(m[i]);
            y[i] *= closer_by(m[i]);
        }
        let d = at.depths_at::<N>(r, &axes, [&x, &y]);
        for i in 0..N {
            let nearer = r.depth[i] - d.stored[i];
            let lit = d.receiver[i] <= d.stored[i];
            let hides = !lit & (nearer >= widest[i] * (m[i] * closer_by(m[i])));
            let counted = if nearer > texel[i] { nearer } else { texel[i] };
            let weight = if hides {
                tap_weight(m[i], counted)
            } else {
                0.0
            };
            sum[i] += weight * (d.receiver[i] - d.stored[i]);
            weights[i] += weight;
        }
    }
    let mut mean = [0.0; BATCH];
    for i in 0..N {
        mean[i] = if weights[i] > 0.0 {
            sum[i] / weights[i]
        } else {
            widest[i]
        };
    }
    mean
}

/// Of the taps that lie above each receiver's horizon: how many are seen, and how many there are.
#[inline(always)]
pub(crate) fn seen_above(
    at: &Comparisons<'_>,
    r: &ReceiverLanes,
    mean: &Lanes<f32>,
    set: &TapSet,
) -> [Lanes<f32>; 2] {
    if r.count <= HALF {
        seen_above_in::<HALF>(at, r, mean, set)
    } else {
        seen_above_in::<BATCH>(at, r, mean, set)
    }
}

#[inline(always)]
fn seen_above_in<const N: usize>(
    at: &Comparisons<'_>,
    r: &ReceiverLanes,
    mean: &Lanes<f32>,
    set: &TapSet,
) -> [Lanes<f32>; 2] {
    let mut reach = [0.0; BATCH];
    for i in 0..N {
        let wide = if mean[i] > r.more[TEXEL][i] {
            mean[i]
        } else {
            r.more[TEXEL][i]
        };
        reach[i] = if wide < r.more[MOST][i] {
            wide
        } else {
            r.more[MOST][i]
        };
    }
    let axes = r.scaled(&reach);
    let [h, hx, hy] = HEIGHTS.map(|i| &r.more[i]);
    let (mut lit, mut above) = ([0.0; BATCH], [0.0; BATCH]);
    for &tap in &set.taps {
        let q = Spot::new::<N>(r, tap);
        let hidden = hides::<N>(at, r, &axes, mean, &q);
        for i in 0..N {
            let counts = if h[i] + hx[i] * q.x[i] + hy[i] * q.y[i] > 0.0 {
                1.0
            } else {
                0.0
            };
            above[i] += counts;
            lit[i] += if hidden[i] == 0 { counts } else { 0.0 };
        }
    }
    [lit, above]
}

/// Whether something hides the light's point at the tap, as 1 or 0: what is found there, or, if that is too low to be in the
/// way, what the ray passes where it is as low.
#[inline(always)]
fn hides<const N: usize>(
    at: &Comparisons<'_>,
    r: &ReceiverLanes,
    axes: &Axes,
    mean: &Lanes<f32>,
    q: &Spot,
) -> Lanes<u32> {
    let d = at.depths_at::<N>(r, axes, [&q.x, &q.y]);
    let (mut hidden, mut low, mut nearer) = ([0; BATCH], [0; BATCH], [0.0; BATCH]);
    let mut any = 0;
    for i in 0..N {
        nearer[i] = r.depth[i] - d.stored[i];
        let lit = d.receiver[i] <= d.stored[i];
        let in_the_way = nearer[i] >= mean[i] * q.from_middle[i];
        hidden[i] = u32::from(!lit & in_the_way);
        low[i] = u32::from(!lit & !in_the_way & (nearer[i] > 0.0));
        any |= low[i];
    }
    if any == 0 {
        return hidden;
    }
    let lower = at.depths_at::<N>(r, &r.scaled(&nearer), [&q.x, &q.y]);
    for i in 0..N {
        let lit = lower.receiver[i] <= lower.stored[i];
        let as_high = r.depth[i] - lower.stored[i] >= nearer[i] * 0.5;
        hidden[i] |= low[i] & u32::from(!lit & as_high);
    }
    hidden
}
