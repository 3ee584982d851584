//! Single comparisons for each receiver of a batch.

use crate::{
    lanes::{
        batch::{BATCH, Batch, BatchTaps, Lanes},
        square::{Places, places_at},
        whole::floor,
    },
    shadow_map::texel_compare::{DepthMap, depth_at_texel},
};
use glam::Vec2;

/// One comparison for each receiver of a batch.
pub(crate) struct SingleTaps {
    /// 1 where the receiver isn't behind its texel, or has none, else 0.
    pub(crate) lit: Lanes<f32>,
    /// Whether the texel lies on the map, and the receiver is covered.
    pub(crate) is_known: Lanes<bool>,
}

/// Compares the receivers of a batch with the texels (x, y), whole numbers, of a map that is not packed.
///
/// It goes over them three times, as [`level_squares`](super::square::level_squares) does: for places, then for loads alone, so that many
/// are under way at once, then for comparisons.
#[inline(always)]
pub(crate) fn single_taps(
    map: &DepthMap<'_>,
    batch: &Batch,
    x: &Lanes<f32>,
    y: &Lanes<f32>,
) -> SingleTaps {
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
    SingleTaps { lit, is_known }
}

/// The comparison with the receiver's own texel.
pub(crate) struct OwnTexel<'a> {
    pub(crate) map: DepthMap<'a>,
}

impl BatchTaps for OwnTexel<'_> {
    #[inline(always)]
    fn visibilities(&self, batch: &Batch, _: usize, out: &mut [f32]) {
        if self.map.packed {
            self.one_by_one(batch, out);
            return;
        }
        let [mut x, mut y] = [[0.0; BATCH]; 2];
        for i in 0..BATCH {
            x[i] = floor(batch.x[i]);
            y[i] = floor(batch.y[i]);
        }
        let taps = single_taps(&self.map, batch, &x, &y);
        let mut is_complete = true;
        for (i, out) in out.iter_mut().enumerate() {
            *out = taps.lit[i];
            is_complete &= taps.is_known[i] | !batch.covered[i];
        }
        // Beside the map all is lit, unless its edge repeats.
        if self.map.clamped && !is_complete {
            self.one_by_one(batch, out);
        }
    }
}

impl OwnTexel<'_> {
    #[inline(never)]
    fn one_by_one(&self, batch: &Batch, out: &mut [f32]) {
        batch.one_by_one(out, |l, _| {
            let [x, y] = [l.texel.x.floor() as i32, l.texel.y.floor() as i32];
            self.map.tap(l, x, y)
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        lanes::fixtures::{batch, map, texels},
        shadow_map::packing::pack_depth,
    };

    /// Returns how many taps two texels right of the receiver's own were known, and how many of these answer otherwise than the plain
    /// comparison in `judged`.
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
        // The control: a map that is deeper by a little answers otherwise.
        let spoilt: Vec<f32> = texels.iter().map(|depth| depth + 0.1).collect();
        let (_, other) = known_and_other(&spoilt);
        assert!(other > known / 20, "{other} of {known}");
    }

    /// Beside the map receivers are lit, or its edge repeats; packed maps and batches that are not full are answered, too.
    #[test]
    fn own_texels_are_as_the_plain_comparison() {
        let texels = texels();
        let packed: Vec<f32> = texels
            .iter()
            .flat_map(|&depth| pack_depth(depth).to_array())
            .collect();
        for (clamped, is_packed) in [(false, false), (true, false), (false, true), (true, true)] {
            let map = DepthMap {
                packed: is_packed,
                ..map(if is_packed { &packed } else { &texels }, clamped)
            };
            for turn in 0..40 {
                let batch = batch(turn, turn % 2 == 0);
                let mut out = [9.0; BATCH];
                let count = if turn % 3 == 0 { 13 } else { BATCH };
                OwnTexel { map }.visibilities(&batch, 0, &mut out[..count]);
                for (i, out) in out[..count].iter().enumerate() {
                    let l = batch.lookup(i);
                    let [x, y] = [l.texel.x.floor() as i32, l.texel.y.floor() as i32];
                    let expected = if l.covered { map.tap(&l, x, y) } else { 1.0 };
                    assert_eq!(*out, expected, "{clamped} {is_packed} {x} {y}");
                }
            }
        }
    }
}
