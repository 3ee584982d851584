//! Single comparisons for each receiver of a batch.

use crate::{
    lanes::{
        batch::{BATCH, Batch, Lanes},
        square::{LitTaps, Places, places_at},
    },
    shadow_map::texel_compare::{DepthMap, depth_at_texel},
};
use glam::Vec2;

/// Compares the receivers of a batch with the texels (x, y), integer-valued, of an unpacked map.
/// Receivers whose comparison isn't known count as lit.
///
/// Runs in three passes, like [`level_squares`](super::square::level_squares). The first finds
/// texel indices; the second only loads, so that many loads are in flight; the third compares.
#[inline(always)]
pub(crate) fn single_taps(
    map: &DepthMap<'_>,
    batch: &Batch,
    x: &Lanes<f32>,
    y: &Lanes<f32>,
) -> LitTaps {
    let Places { first, is_inside } = places_at::<1>(map, batch, x, y);
    let mut is_known = is_inside;
    let mut stored = [0.0; BATCH];
    for i in 0..BATCH {
        match map.plain_depth(first[i] as usize) {
            Some(depth) => stored[i] = depth,
            None => is_known[i] = false,
        }
    }
    let mut lit = [1.0; BATCH];
    for i in 0..BATCH {
        let from = Vec2::new(batch.x[i], batch.y[i]);
        let gradient = Vec2::new(batch.right[i], batch.down[i]);
        let texel = Vec2::new(x[i], y[i]);
        let depth = depth_at_texel(batch.depth[i], gradient, batch.deepest[i], from, texel);
        let is_lit = (depth <= stored[i]) | !is_known[i];
        lit[i] = if is_lit { 1.0 } else { 0.0 };
    }
    LitTaps { lit, is_known }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::fixtures::{batch, map, texels};

    /// Returns how many taps two texels right of the receiver's own were known. The second number
    /// counts those that differ from the plain comparison in `judged`.
    fn known_and_other(judged: &[f32]) -> (usize, usize) {
        let texels = texels();
        let found = map(&texels, false);
        let expected = map(judged, false);
        let mut known = 0;
        let mut other = 0;
        for turn in 0..40 {
            let batch = batch(turn, turn % 2 == 0);
            let x = batch.x.map(|x| x.floor() + 2.0);
            let y = batch.y.map(f32::floor);
            let taps = single_taps(&found, &batch, &x, &y);
            for i in 0..BATCH {
                let l = batch.lookup(i);
                let [x, y] = [x[i] as i32, y[i] as i32];
                assert_eq!(taps.is_known[i], l.covered && found.has(x, y));
                if taps.is_known[i] {
                    known += 1;
                    other += usize::from(taps.lit[i] != expected.tap(&l, x, y));
                } else {
                    assert_eq!(taps.lit[i], 1.0);
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
        // Negative control: a slightly deeper map must give different results.
        let spoilt: Vec<f32> = texels.iter().map(|depth| depth + 0.1).collect();
        let (_, other) = known_and_other(&spoilt);
        assert!(other > known / 20, "{other} of {known}");
    }
}
