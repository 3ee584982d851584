//! One comparison for each receiver of a batch, with the receiver's own texel.

#![expect(
    clippy::needless_range_loop,
    reason = "one index into many arrays: that is what compilers turn into vector lanes"
)]

use crate::{
    filtering::pattern_taps::floor,
    lanes::{
        batch::{BATCH, Batch, Lanes},
        square::places,
    },
    shadow_map::texel_compare::{DepthMap, depth_at_texel},
};
use glam::Vec2;

/// What receivers' own texels say.
pub(crate) struct SingleTaps {
    /// Whether the receiver isn't behind its texel; meaningless where that isn't known.
    pub(crate) is_lit: Lanes<bool>,
    /// Whether the texel lies on the map, so that the answer is known.
    pub(crate) is_known: Lanes<bool>,
}

/// Compares the receivers of a batch with their own texels, of a map that is not packed.
///
/// In three loops, as [`level_squares`](super::square::level_squares): places, then nothing but loads, so that many are under way at
/// once, then comparisons.
#[inline(always)]
pub(crate) fn single_taps(map: &DepthMap<'_>, batch: &Batch) -> SingleTaps {
    let places = places::<1>(map, batch);
    let mut is_known = places.is_inside;
    let mut stored = [0.0; BATCH];
    for i in 0..BATCH {
        match map.plain_depth(places.first[i] as usize) {
            Some(depth) => stored[i] = depth,
            None => is_known[i] = false,
        }
    }
    let mut is_lit = [false; BATCH];
    for i in 0..BATCH {
        let from = Vec2::new(batch.x[i], batch.y[i]);
        let texel = Vec2::new(floor(from.x), floor(from.y));
        let gradient = Vec2::new(batch.right[i], batch.down[i]);
        let depth = depth_at_texel(batch.depth[i], gradient, batch.deepest[i], from, texel);
        is_lit[i] = depth <= stored[i];
    }
    SingleTaps { is_lit, is_known }
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

    fn map(texels: &[f32]) -> DepthMap<'_> {
        DepthMap {
            texels,
            size: SIZE,
            packed: false,
            clamped: false,
            sample_gain: 1.0,
        }
    }

    /// Receivers on the map, at its edges and beside it, on level planes and on steep ones; every fifth isn't covered.
    fn batch(turn: usize) -> Batch {
        let mut batch = Batch::new();
        for i in 0..BATCH {
            let k = (turn * BATCH + i) as f32;
            batch.x[i] = (k * 0.73) % 45.0 - 4.0;
            batch.y[i] = (k * 1.37) % 45.0 - 4.0;
            batch.depth[i] = (k * 0.11) % 1.0;
            batch.deepest[i] = 0.9;
            batch.right[i] = (k * 0.017) % 0.8 - 0.4;
            batch.down[i] = if i % 3 == 0 { 0.0 } else { 0.3 };
            batch.layer[i] = i as i32 % LAYERS;
            batch.covered[i] = i % 5 != 0;
        }
        batch
    }

    /// Returns how many texels were known, and how many of these answer otherwise than the plain comparison in `judged`.
    fn known_and_other(judged: &[f32]) -> (usize, usize) {
        let texels = texels();
        let mut known = 0;
        let mut other = 0;
        for turn in 0..40 {
            let batch = batch(turn);
            let taps = single_taps(&map(&texels), &batch);
            for i in 0..BATCH {
                let l = batch.lookup(i);
                let x = l.texel.x.floor() as i32;
                let y = l.texel.y.floor() as i32;
                assert_eq!(taps.is_known[i], l.covered && map(&texels).has(x, y));
                if taps.is_known[i] {
                    known += 1;
                    let is_lit = map(judged).tap(&l, x, y) == 1.0;
                    other += usize::from(taps.is_lit[i] != is_lit);
                }
            }
        }
        (known, other)
    }

    #[test]
    fn single_taps_are_as_the_plain_comparison() {
        let texels = texels();
        let (known, other) = known_and_other(&texels);
        assert!(known > 1000 && other == 0, "{known} {other}");
        // The control: a map that is deeper by a little answers otherwise.
        let spoilt: Vec<f32> = texels.iter().map(|depth| depth + 0.1).collect();
        let (_, other) = known_and_other(&spoilt);
        assert!(other > known / 20, "{other} of {known}");
    }
}
