//! Cuts of the camera's view that follow what is seen: see
//! [`Split::Receivers`](crate::Split::Receivers).
//!
//! Seen receivers are sorted into bins by their distance along the view. A slice of some of the
//! bins has a map around their receivers, whose texels are as large as its side says; on the
//! picture a texel is the larger the nearer the receiver. So a slice costs its side times the sum
//! over its receivers of one over their distance, and the cheapest cuts are found by dynamic
//! programming over the bins (Bellman 1954).

use crate::{
    light_space::fit::{cascades::CascadeInput, frustum::Slice},
    math::dot3,
};
use glam::{DAffine3, DVec3};

/// Bins in which a distance doubles. Ends are those of bins, so that small moves of the camera
/// mostly leave them where they are.
const BINS_PER_OCTAVE: f64 = 8.0;
/// Most bins: more doublings than coordinates of 32 bits can tell apart.
const MAX_BINS: i64 = 1024;

/// The seen receivers within some distances.
#[derive(Clone, Copy, Debug)]
struct Bin {
    /// The sum, over those that face the light, of a pixel's share of a metre.
    pixels_per_metre: f64,
    /// Least and greatest coordinates, light's view.
    around: [DVec3; 2],
}

impl Bin {
    const EMPTY: Self = Self {
        pixels_per_metre: 0.0,
        around: [DVec3::INFINITY, DVec3::NEG_INFINITY],
    };

    fn union(&self, other: &Self) -> Self {
        Self {
            pixels_per_metre: self.pixels_per_metre + other.pixels_per_metre,
            around: [
                self.around[0].min(other.around[0]),
                self.around[1].max(other.around[1]),
            ],
        }
    }
}

/// Bins in a row, the first at the index `first`.
struct Bins {
    first: i64,
    bins: Vec<Bin>,
}

/// Returns where `count` slices end, metres along the camera's view; none if receivers aren't
/// known, or none is seen.
pub(super) fn ends(input: &CascadeInput<'_>, count: usize) -> Option<Vec<f64>> {
    let bins = bins(input)?;
    // A stable fit ends at its range.
    let farthest = if input.is_stable() {
        input.range().end
    } else {
        f64::INFINITY
    };
    let end_of = |bin: usize| distance_of(bins.first + bin as i64 + 1).min(farthest);
    let cuts = cheapest_cuts(input, &bins, count);
    Some(cuts.into_iter().map(end_of).collect())
}

/// Returns the index of the bin of a distance, which is positive.
fn bin_of(distance: f64) -> i64 {
    (distance.log2() * BINS_PER_OCTAVE).floor() as i64
}

/// Returns the distance at which a bin begins.
fn distance_of(bin: i64) -> f64 {
    (bin as f64 / BINS_PER_OCTAVE).exp2()
}

/// Returns the seen receivers in bins; none if there are none.
fn bins(input: &CascadeInput<'_>) -> Option<Bins> {
    let receivers = input.input.view.receivers?;
    let range = input.range();
    let nearest = input
        .nearest()
        .max(range.end * f64::from(f32::EPSILON))
        .max(f64::from(f32::MIN_POSITIVE));
    if range.end <= 0.0 {
        return None;
    }
    // What is nearer than the nearest distance shares its bin.
    let first = bin_of(range.begin.max(nearest).min(range.end));
    let last = bin_of(range.end).clamp(first, first + MAX_BINS - 1);
    let mut bins = vec![Bin::EMPTY; (last - first + 1) as usize];
    let light_from_world = DAffine3::from_mat4(input.view_from_world.as_dmat4());
    for i in (0..receivers.len()).filter(|&i| receivers.receives[i]) {
        let position = receivers.position(i);
        let distance = input.frustum.distance(position.as_dvec3());
        let in_range = distance <= range.end && distance >= range.begin;
        if !in_range {
            continue;
        }
        let counted = distance.max(nearest);
        let to_light = input.input.view.light.direction_from(position);
        let faces_light = dot3(receivers.normal(i), to_light) > 0.0;
        let pixel = if input.frustum.has_perspective() {
            counted.recip()
        } else {
            1.0
        };
        let p = light_from_world.transform_point3(position.as_dvec3());
        let one = Bin {
            pixels_per_metre: if faces_light { pixel } else { 0.0 },
            around: [p, p],
        };
        let bin = &mut bins[(bin_of(counted).clamp(first, last) - first) as usize];
        *bin = bin.union(&one);
    }
    Some(Bins { first, bins })
}

/// Returns the last bin of each of `count` slices.
fn cheapest_cuts(input: &CascadeInput<'_>, bins: &Bins, count: usize) -> Vec<usize> {
    let n = bins.bins.len();
    // `cost[a][b]`: that of a slice from bin `a` to bin `b`.
    let mut cost = vec![vec![0.0_f64; n]; n];
    for (a, cost) in cost.iter_mut().enumerate() {
        let mut all = Bin::EMPTY;
        for (b, cost) in cost.iter_mut().enumerate().skip(a) {
            all = all.union(&bins.bins[b]);
            if all.pixels_per_metre > 0.0 {
                let slice = Slice {
                    begin: if a == 0 {
                        0.0
                    } else {
                        distance_of(bins.first + a as i64)
                    },
                    end: distance_of(bins.first + b as i64 + 1),
                };
                *cost = input.side(slice, &all.around) * all.pixels_per_metre;
            }
        }
    }
    // `least[b]`: the least cost of the bins up to `b` in the slices so far; `from[slice][b]`:
    // where the last of them begins.
    let mut least = cost[0].clone();
    let mut from = vec![vec![0; n]];
    for _ in 1..count {
        let mut next = least.clone();
        let mut begins = vec![0; n];
        for b in 0..n {
            // An empty slice costs nothing: it begins behind its end.
            begins[b] = b + 1;
            for a in 1..=b {
                let total = least[a - 1] + cost[a][b];
                if total < next[b] {
                    next[b] = total;
                    begins[b] = a;
                }
            }
        }
        least = next;
        from.push(begins);
    }
    let mut ends = vec![n - 1; count];
    let mut end = n - 1;
    for slice in (1..count).rev() {
        ends[slice] = end;
        // A slice that isn't the first begins at bin 1 or later.
        end = from[slice][end] - 1;
    }
    ends[0] = end;
    ends
}
