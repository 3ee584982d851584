//! Counts of lit texels in squares, one row of lanes at a time. Counts are small integers in
//! floats, which add exactly in any order. So the lanes agree with the shader's loop bit for bit.

#![expect(
    clippy::needless_range_loop,
    reason = "compilers vectorise one index into many arrays"
)]

use crate::{
    lanes::{
        batch::{BATCH, Batch, Lanes},
        whole::{floor, whole_to_u32},
    },
    shadow_map::{coord::ShadowCoord, texel_compare::DepthMap},
};
use umbrage_core::math::lesser;

/// Number of lit taps of each receiver of a batch.
pub(crate) struct LitTaps {
    /// Count; for squares, meaningless if it isn't known.
    pub(crate) lit: Lanes<f32>,
    /// True if the count is known: the receiver is covered, its taps are within the map, and the
    /// rows of a square can be read a whole vector at a time.
    pub(crate) is_known: Lanes<bool>,
}

/// Counts the lit taps of the squares of `SIDE` texels a side around the texels of a batch. The
/// compared depth is the same at all taps. Rows are read `LANES` wide, at least `SIDE`; lanes
/// beyond `SIDE` are not counted.
///
/// Maps exceed the fastest caches, so lookups wait for memory. Meanwhile the processor executes the
/// next receivers, as far as its reorder window allows. So texel indices are computed before the
/// main loop and sums after it, and the main loop does little more than load.
#[inline(always)]
pub(crate) fn level_squares<const SIDE: usize, const LANES: usize>(
    map: &DepthMap<'_>,
    batch: &Batch,
) -> LitTaps {
    let places = places::<SIDE>(map, batch);
    let mut is_known = places.is_inside;
    let mut counts = [[0_u32; LANES]; BATCH];
    for i in 0..BATCH {
        let Some(square) = SquareTexels::<SIDE, LANES>::from(map, places.first[i]) else {
            is_known[i] = false;
            continue;
        };
        let depth = lesser(batch.depth[i], batch.deepest[i]);
        // Keep all lanes, also those that aren't counted. Otherwise the compiler loads texels one
        // by one.
        let mut count = [0_u32; LANES];
        for row in 0..SIDE {
            let Some(stored) = square.row(row) else {
                continue;
            };
            for lane in 0..LANES {
                count[lane] += u32::from(depth <= stored[lane]);
            }
        }
        counts[i] = count;
    }
    let lit = sums::<SIDE, LANES>(&counts);
    LitTaps { lit, is_known }
}

/// Counts like [`level_squares`], for receivers whose depths follow their planes.
///
/// The compared depths need more arithmetic here, so the loading loop only copies the loaded
/// texels.
#[inline(always)]
pub(crate) fn sloped_squares<const SIDE: usize, const LANES: usize>(
    map: &DepthMap<'_>,
    batch: &Batch,
) -> LitTaps {
    let places = places::<SIDE>(map, batch);
    let mut is_known = places.is_inside;
    let mut rows = [[[0.0_f32; LANES]; SIDE]; BATCH];
    for i in 0..BATCH {
        let Some(square) = SquareTexels::<SIDE, LANES>::from(map, places.first[i]) else {
            is_known[i] = false;
            continue;
        };
        for row in 0..SIDE {
            if let Some(stored) = square.row(row) {
                rows[i][row] = *stored;
            }
        }
    }
    let mut counts = [[0_u32; LANES]; BATCH];
    for i in 0..BATCH {
        let depths = TapDepths::<LANES>::of_batch::<SIDE>(batch, i);
        let mut count = [0_u32; LANES];
        for row in 0..SIDE {
            for lane in 0..LANES {
                let on_plane = depths.in_first_row[lane] + depths.down[row];
                let depth = lesser(on_plane, depths.deepest);
                count[lane] += u32::from(depth <= rows[i][row][lane]);
            }
        }
        counts[i] = count;
    }
    let lit = sums::<SIDE, LANES>(&counts);
    LitTaps { lit, is_known }
}

/// Texels of a map from the first texel of a square of `SIDE` texels a side to the end of the
/// square's last row. Rows are read `LANES` wide.
struct SquareTexels<'a, const SIDE: usize, const LANES: usize> {
    texels: &'a [f32],
    /// Number of texels from one row to the next.
    stride: usize,
}

impl<'a, const SIDE: usize, const LANES: usize> SquareTexels<'a, SIDE, LANES> {
    /// Returns the square whose first texel has the index `first` in the whole map; `None` if the
    /// map ends before the square does.
    #[inline(always)]
    fn from(map: &DepthMap<'a>, first: u32) -> Option<Self> {
        let first = first as usize;
        let stride = map.size as usize;
        let length = (SIDE - 1) * stride + LANES;
        let texels = map.texels.get(first..first + length)?;
        Some(Self { texels, stride })
    }

    /// Returns one of the `SIDE` rows, with the texels to its right up to `LANES`.
    #[inline(always)]
    fn row(&self, row: usize) -> Option<&'a [f32; LANES]> {
        self.texels[row * self.stride..].first_chunk()
    }
}

/// Returns the sums over the first `SIDE` lanes.
#[inline(always)]
fn sums<const SIDE: usize, const LANES: usize>(counts: &[[u32; LANES]; BATCH]) -> Lanes<f32> {
    let mut out = [0.0; BATCH];
    for i in 0..BATCH {
        let mut sum = 0_u32;
        for lane in 0..SIDE {
            sum += counts[i][lane];
        }
        out[i] = sum as i32 as f32;
    }
    out
}

/// Depths to compare with a square's texels, equal to
/// [`depth_on_plane`](crate::shadow_map::texel_compare::depth_on_plane). Lane `k` of row `r` has
/// the lesser of `in_first_row[k] + down[r]` and `deepest`.
struct TapDepths<const LANES: usize> {
    /// Depth of the receiver plus its change along the row.
    in_first_row: [f32; LANES],
    /// Change of depth down to each row; there are at most as many rows as lanes.
    down: [f32; LANES],
    deepest: f32,
}

impl<const LANES: usize> TapDepths<LANES> {
    /// Returns the depths along the plane of receiver `i`, for the square of `SIDE` texels a side
    /// around its texel.
    #[inline(always)]
    fn of_batch<const SIDE: usize>(batch: &Batch, i: usize) -> Self {
        let radius = (SIDE / 2) as f32;
        let [x, y] = [batch.x[i], batch.y[i]];
        let [first_x, first_y] = [floor(x) - radius, floor(y) - radius];
        let mut in_first_row = [0.0; LANES];
        let mut down = [0.0; LANES];
        for lane in 0..LANES {
            // Sums of integers and a half are exact.
            let center = lane as i32 as f32 + 0.5;
            in_first_row[lane] = batch.depth[i] + batch.right[i] * (first_x + center - x);
            down[lane] = batch.down[i] * (first_y + center - y);
        }
        Self {
            in_first_row,
            down,
            deepest: batch.deepest[i],
        }
    }
}

/// Positions of a batch's squares.
pub(super) struct Places {
    /// Index of the square's first texel in the whole map; 0 if the square isn't looked up.
    pub(super) first: Lanes<u32>,
    /// True if the receiver is covered and its square is within the map.
    pub(super) is_inside: Lanes<bool>,
}

/// Returns the positions of the squares of `SIDE` texels around the texels of a batch.
#[inline(always)]
fn places<const SIDE: usize>(map: &DepthMap<'_>, batch: &Batch) -> Places {
    let radius = (SIDE / 2) as f32;
    let [mut x, mut y] = [[0.0; BATCH]; 2];
    for i in 0..BATCH {
        x[i] = floor(batch.x[i]) - radius;
        y[i] = floor(batch.y[i]) - radius;
    }
    places_at::<SIDE>(map, batch, &x, &y)
}

/// Returns the positions of the squares of `SIDE` texels for the receivers of a batch. Their first
/// texels are (x, y), integer-valued.
#[inline(always)]
pub(super) fn places_at<const SIDE: usize>(
    map: &DepthMap<'_>,
    batch: &Batch,
    x: &Lanes<f32>,
    y: &Lanes<f32>,
) -> Places {
    let size = map.size as u32;
    // The greatest valid coordinate of a first texel.
    let last = map.size as f32 - SIDE as f32;
    let mut first = [0; BATCH];
    let mut is_inside = [false; BATCH];
    for i in 0..BATCH {
        let [x, y] = [x[i], y[i]];
        // Use `&` and not `&&`, so that this loop is vectorised.
        let is_on_map = (x >= 0.0) & (y >= 0.0) & (x <= last) & (y <= last);
        let is_looked_up = is_on_map & batch.covered[i];
        let layer_start = (batch.layer[i] as u32)
            .wrapping_mul(size)
            .wrapping_mul(size);
        let index = layer_start
            .wrapping_add(whole_to_u32(y).wrapping_mul(size))
            .wrapping_add(whole_to_u32(x));
        first[i] = if is_looked_up { index } else { 0 };
        is_inside[i] = is_looked_up;
    }
    Places { first, is_inside }
}

/// Counts the lit taps of one square with `side` texels a side, whose first texel is (x, y). Works
/// for any side and position, one texel at a time.
#[inline]
pub fn one_by_one(map: &DepthMap<'_>, l: &ShadowCoord, x: i32, y: i32, side: i32) -> f32 {
    let mut lit = 0.0;
    for dy in 0..side {
        for dx in 0..side {
            lit += map.tap(l, x + dx, y + dy);
        }
    }
    lit
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::fixtures::{SIZE, batch, map, texels};

    /// Returns how many squares were known. The second number counts those whose count differs from
    /// that of the plain loop in `judged`.
    fn known_and_other<const SIDE: usize, const LANES: usize, const SLOPED: bool>(
        judged: &[f32],
    ) -> (usize, usize) {
        let texels = texels();
        let radius = SIDE as i32 / 2;
        let mut known = 0;
        let mut other = 0;
        for turn in 0..40 {
            let batch = batch(turn, SLOPED);
            assert_eq!(batch.is_level(), !SLOPED);
            let taps = if SLOPED {
                sloped_squares::<SIDE, LANES>(&map(&texels, false), &batch)
            } else {
                level_squares::<SIDE, LANES>(&map(&texels, false), &batch)
            };
            for i in 0..BATCH {
                let l = batch.lookup(i);
                let x = l.texel.x.floor() as i32 - radius;
                let y = l.texel.y.floor() as i32 - radius;
                let least_known = 0..SIZE - LANES as i32;
                if l.covered && least_known.contains(&x) && least_known.contains(&y) {
                    assert!(taps.is_known[i], "{x} {y}");
                }
                if !taps.is_known[i] {
                    continue;
                }
                assert!(l.covered);
                known += 1;
                let expected = one_by_one(&map(judged, false), &l, x, y, SIDE as i32);
                other += usize::from(taps.lit[i] != expected);
            }
        }
        (known, other)
    }

    fn check<const SLOPED: bool>() {
        let texels = texels();
        for (known, other) in [
            known_and_other::<3, 4, SLOPED>(&texels),
            known_and_other::<5, 8, SLOPED>(&texels),
            known_and_other::<7, 8, SLOPED>(&texels),
            known_and_other::<9, 16, SLOPED>(&texels),
        ] {
            assert!(known > 800 && other == 0, "{known} {other}");
        }
        // Negative control: a slightly deeper map must give different counts.
        let spoilt: Vec<f32> = texels.iter().map(|depth| depth + 0.1).collect();
        let (known, other) = known_and_other::<3, 4, SLOPED>(&spoilt);
        assert!(other > known / 4, "{known} {other}");
    }

    #[test]
    fn squares_of_level_receivers_count_as_the_plain_loop() {
        check::<false>();
    }

    #[test]
    fn squares_of_sloped_receivers_count_as_the_plain_loop() {
        check::<true>();
    }
}
