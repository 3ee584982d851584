//! What is wrong away from edges: acne, leaks, and acne by distance.
//!
//! Near a shadow's edge every map is wrong; farther away than kernels reach nothing may be. Which pixels are *open* so is
//! [`Ground::open`](crate::stability::Ground).

use umbrage_core::metrics::FALSE;

/// Acne: percent of the open lit pixels that the mask darkens by more than [`FALSE`].
pub fn acne(mask: &[f32], truth: &[f32], open: &[bool]) -> f64 {
    share((0..mask.len()).filter(|&i| open[i] && truth[i] == 1.0).map(|i| truth[i] - mask[i] > FALSE))
}

/// Leaks: percent of the open dark pixels that the mask lights by more than [`FALSE`].
pub fn leak(mask: &[f32], truth: &[f32], open: &[bool]) -> f64 {
    share((0..mask.len()).filter(|&i| open[i] && truth[i] == 0.0).map(|i| mask[i] - truth[i] > FALSE))
}

/// Either: percent of the open pixels that are wrong by more than [`FALSE`].
pub fn wrong(mask: &[f32], truth: &[f32], open: &[bool]) -> f64 {
    share((0..mask.len()).filter(|&i| open[i]).map(|i| (mask[i] - truth[i]).abs() > FALSE))
}

/// Bins that distances are sorted into.
pub const BINS: usize = 8;

/// Fewer open pixels than this tell nothing about a bin.
const LEAST: usize = 50;

/// [`acne`] in bins of distance from the eye (`distance`, metres): [`BINS`] of equal ratio between the nearest and the
/// farthest open pixel, near first. None where a bin has fewer than 50 open lit pixels.
pub fn acne_by_distance(mask: &[f32], truth: &[f32], open: &[bool], distance: &[f32]) -> [Option<f64>; BINS] {
    let lit: Vec<usize> = (0..mask.len()).filter(|&i| open[i] && truth[i] == 1.0).collect();
    let near = lit.iter().map(|&i| distance[i]).fold(f32::MAX, f32::min);
    let far = lit.iter().map(|&i| distance[i]).fold(f32::MIN_POSITIVE, f32::max);
    let span = (far / near).ln().max(f32::MIN_POSITIVE);
    let bin = |i: usize| ((BINS as f32 * (distance[i] / near).ln() / span) as usize).min(BINS - 1);
    std::array::from_fn(|b| {
        let here: Vec<usize> = lit.iter().copied().filter(|&i| bin(i) == b).collect();
        (here.len() >= LEAST).then(|| share(here.iter().map(|&i| truth[i] - mask[i] > FALSE)))
    })
}

/// Percent of true ones; 0 of none.
pub fn share(wrong: impl Iterator<Item = bool>) -> f64 {
    let [hits, all] = wrong.fold([0_u64; 2], |[hits, all], w| [hits + u64::from(w), all + 1]);
    100.0 * hits as f64 / all.max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_kind_counts_its_own_pixels_alone() {
        let truth = [1.0, 1.0, 1.0, 1.0, 0.0, 0.0];
        let open = [true, true, true, false, true, true];
        let mask = [0.0, 0.9, 1.0, 0.0, 0.3, 0.0];
        let third = 100.0 / 3.0;
        assert_eq!([acne(&mask, &truth, &open), leak(&mask, &truth, &open)], [third, 50.0]);
        assert_eq!(wrong(&mask, &truth, &open), 40.0);
        assert_eq!([acne(&truth, &truth, &open), leak(&truth, &truth, &open), acne(&[], &[], &[])], [0.0; 3]);
    }

    #[test]
    fn acne_in_the_distance_shows_in_the_last_bin_alone() {
        let distance: Vec<f32> = (0..800).map(|i| 1.0 * 1.01_f32.powi(i)).collect();
        let truth = vec![1.0; 800];
        let mask: Vec<f32> = (0..800).map(|i| if i >= 750 { 0.0 } else { 1.0 }).collect();
        let bins = acne_by_distance(&mask, &truth, &[true; 800], &distance);
        assert!(bins[..7].iter().all(|b| *b == Some(0.0)), "{bins:?}");
        assert!(bins[7].is_some_and(|b| (45.0..55.0).contains(&b)), "{bins:?}");
    }
}
