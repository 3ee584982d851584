//! Slice ends that follow the visible receivers, see [`Split::Receivers`](crate::Split::Receivers).
//!
//! Visible receivers are sorted into bins by their distance along the view. The map of a slice
//! covers the receivers of its bins. The side of the map determines the size of its texels, which
//! is larger in the image the nearer the receiver is. The cost of a slice is its side times the sum
//! of one over the distances of its receivers. Dynamic programming over the bins finds the cheapest
//! cuts (Bellman 1954).

use crate::{
    light_space::fit::{cascades::CascadeInput, frustum::Slice},
    math::dot3,
};
use glam::{DAffine3, DVec3};

/// Number of bins per doubling of the distance. Ends are those of bins, so that small moves of the
/// camera rarely change them.
const BINS_PER_OCTAVE: f64 = 8.0;
/// Greatest number of bins: more doublings than the range of 32-bit coordinates.
const MAX_BINS: i64 = 1024;

/// The visible receivers in a range of distances.
#[derive(Clone, Copy, Debug)]
struct Bin {
    /// Sum of a pixel's share of a metre over the receivers that face the light.
    pixels_per_metre: f64,
    /// Least and greatest coordinates, in the light's view.
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

/// Consecutive bins, the first at the index `first`.
struct Bins {
    first: i64,
    bins: Vec<Bin>,
}

/// Returns the ends of `count` slices, metres along the camera's view. `None` if receivers aren't
/// known, or none is visible.
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

/// Returns the index of the bin of a positive distance.
fn bin_of(distance: f64) -> i64 {
    (distance.log2() * BINS_PER_OCTAVE).floor() as i64
}

/// Returns the distance at which a bin begins.
fn distance_of(bin: i64) -> f64 {
    (bin as f64 / BINS_PER_OCTAVE).exp2()
}

/// Returns the bins of the visible receivers; `None` if there are none.
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
    // Receivers nearer than the nearest distance share its bin.
    let first = bin_of(range.begin.max(nearest).min(range.end));
    let last = bin_of(range.end).clamp(first, first + MAX_BINS - 1);
    let mut bins = vec![Bin::EMPTY; (last - first + 1) as usize];
    let light_from_world = DAffine3::from_mat4(input.view_from_world.as_dmat4());
    // Add each receiver to the bin of its distance.
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
    // `cost[a][b]` is the cost of a slice from bin `a` to bin `b`.
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
    // `least[b]` is the least cost of the bins up to `b` with the slices so far; `from[slice][b]`
    // is the first bin of the last of them.
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
