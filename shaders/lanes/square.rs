//! Counting lit texels of a square, a row of lanes at a time. Counts are small integers in floats, which add exactly in
//! any order: so the lanes agree with the shader's loop to the bit.

#![expect(
    clippy::needless_range_loop,
    reason = "one index into many arrays: that is what compilers turn into vector lanes"
)]

use crate::{
    filtering::pattern_taps::{floor, whole_to_u32},
    lanes::batch::{BATCH, Batch, Lanes},
    shadow_map::{coord::ShadowCoord, texel_compare::DepthMap},
};

/// How many taps of each receiver's square are lit.
pub(crate) struct LitTaps {
    /// The count; meaningless where it isn't known.
    pub(crate) lit: Lanes<f32>,
    /// Whether the square lies wholly within the map, so that the count is known.
    pub(crate) is_known: Lanes<bool>,
}

/// Counts the lit taps of the squares of `SIDE` texels a side around the texels of a batch, whose depths are the same at all taps.
///
/// Maps are larger than the nearest caches, so lookups wait for them. The processor goes on to the next receivers meanwhile, as far as it
/// looks ahead; so places are found before, sums are made after, and the loop between them holds little but the loads.
#[inline(always)]
pub(crate) fn level_squares<const SIDE: usize, const LANES: usize>(
    map: &DepthMap<'_>,
    batch: &Batch,
) -> LitTaps {
    let places = places::<SIDE>(map, batch);
    let mut is_known = places.is_inside;
    let stride = map.size as usize;
    let length = (SIDE - 1) * stride + LANES;
    let mut counts = [[0_u32; LANES]; BATCH];
    for i in 0..BATCH {
        let first = places.first[i] as usize;
        let Some(window) = map.texels.get(first..first + length) else {
            is_known[i] = false;
            continue;
        };
        let depth = batch.depth[i];
        // All lanes are kept, also those that aren't counted: else the compiler would take texels one by one.
        let mut count = [0_u32; LANES];
        for row in 0..SIDE {
            let Some(stored) = window[row * stride..].first_chunk::<LANES>() else {
                continue;
            };
            for lane in 0..LANES {
                count[lane] += u32::from(depth <= stored[lane]);
            }
        }
        counts[i] = count;
    }
    let mut lit = [0.0; BATCH];
    for i in 0..BATCH {
        let mut sum = 0_u32;
        for lane in 0..SIDE {
            sum += counts[i][lane];
        }
        lit[i] = sum as i32 as f32;
    }
    LitTaps { lit, is_known }
}

/// Where the squares of a batch lie.
struct Places {
    /// The number of the least texel among all of the map; 0 where the square isn't looked up.
    first: Lanes<u32>,
    /// Whether the receiver is covered, and its square lies within the map.
    is_inside: Lanes<bool>,
}

/// Returns where the squares of `SIDE` texels around the texels of a batch lie.
#[inline(always)]
fn places<const SIDE: usize>(map: &DepthMap<'_>, batch: &Batch) -> Places {
    let size = map.size as u32;
    let radius = (SIDE / 2) as f32;
    // The greatest place of a least texel.
    let last = map.size as f32 - SIDE as f32;
    let mut first = [0; BATCH];
    let mut is_inside = [false; BATCH];
    for i in 0..BATCH {
        let x = floor(batch.x[i]) - radius;
        let y = floor(batch.y[i]) - radius;
        // `&` and not `&&`, so that this loop is vectorised.
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

/// Returns how many taps of the square of `SIDE` texels a side whose least texel is (x, y) are lit; `None` unless it lies wholly
/// within the map and its rows may be read `LANES` wide. Lanes beyond `SIDE` are not counted.
#[inline(always)]
pub fn square<const SIDE: usize, const LANES: usize>(
    map: &DepthMap<'_>,
    l: &ShadowCoord,
    x: i32,
    y: i32,
) -> Option<f32> {
    let texels = map.layer(l.layer)?;
    let size = map.size;
    let side = SIDE as i32;
    if x < 0 || y < 0 || x + side > size || y + side > size {
        return None;
    }
    let stride = size as usize;
    let first = y as usize * stride + x as usize;
    let window = texels.get(first..first + (SIDE - 1) * stride + LANES)?;
    let mut lit = [0_u32; LANES];
    if l.gradient == glam::Vec2::ZERO {
        for row in 0..SIDE {
            let stored: &[f32; LANES] = window[row * stride..][..LANES].first_chunk()?;
            for (lit, stored) in lit.iter_mut().zip(stored) {
                *lit += u32::from(l.depth <= *stored);
            }
        }
    } else {
        for row in 0..SIDE {
            let stored: &[f32; LANES] = window[row * stride..][..LANES].first_chunk()?;
            // `depth_on_plane` of the row's texels: its term for y is the same for all of them.
            let down = l.gradient.y * ((y + row as i32) as f32 + 0.5 - l.texel.y);
            for (lane, lit) in lit.iter_mut().enumerate() {
                let right = l.gradient.x * ((x + lane as i32) as f32 + 0.5 - l.texel.x);
                let depth = (l.depth + right + down).min(l.deepest);
                *lit += u32::from(depth <= stored[lane]);
            }
        }
    }
    Some(lit[..SIDE].iter().sum::<u32>() as f32)
}

/// Counts the lit taps of the square with `side` texels a side whose least texel is (x, y): [`square`] of any side, anywhere.
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

    const SIZE: i32 = 37;
    const LAYERS: i32 = 2;

    /// Depths 0..1, in no order.
    fn texels() -> Vec<f32> {
        let value = |i: i32| (i.wrapping_mul(7919) % 1009) as f32 / 1009.0;
        (0..SIZE * SIZE * LAYERS).map(value).collect()
    }

    /// Receivers on the map, at its edges and beside it; every fifth isn't covered.
    fn batch(turn: usize) -> Batch {
        let mut batch = Batch::new();
        for i in 0..BATCH {
            let k = (turn * BATCH + i) as f32;
            batch.x[i] = (k * 0.73) % 45.0 - 4.0;
            batch.y[i] = (k * 1.37) % 45.0 - 4.0;
            batch.depth[i] = (k * 0.11) % 1.0;
            batch.deepest[i] = 1.0;
            batch.layer[i] = i as i32 % LAYERS;
            batch.covered[i] = i % 5 != 0;
        }
        batch
    }

    /// Returns how many squares were known, and how many of these have another count than the plain loop finds in `judged`.
    fn known_and_other<const SIDE: usize, const LANES: usize>(judged: &[f32]) -> (usize, usize) {
        let texels = texels();
        let map = |texels| DepthMap {
            texels,
            size: SIZE,
            packed: false,
            clamped: false,
            sample_gain: 1.0,
        };
        let radius = SIDE as i32 / 2;
        let mut known = 0;
        let mut other = 0;
        for turn in 0..40 {
            let batch = batch(turn);
            assert!(batch.is_level());
            let taps = level_squares::<SIDE, LANES>(&map(&texels), &batch);
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
                let expected = one_by_one(&map(judged), &l, x, y, SIDE as i32);
                other += usize::from(taps.lit[i] != expected);
            }
        }
        (known, other)
    }

    #[test]
    fn level_squares_count_as_the_plain_loop() {
        let texels = texels();
        for (known, other) in [
            known_and_other::<3, 4>(&texels),
            known_and_other::<5, 8>(&texels),
            known_and_other::<7, 8>(&texels),
            known_and_other::<9, 16>(&texels),
        ] {
            assert!(known > 800 && other == 0, "{known} {other}");
        }
        // The control: a map that is deeper by a little has other counts.
        let spoilt: Vec<f32> = texels.iter().map(|depth| depth + 0.1).collect();
        let (known, other) = known_and_other::<3, 4>(&spoilt);
        assert!(other > known / 4, "{known} {other}");
    }
}
