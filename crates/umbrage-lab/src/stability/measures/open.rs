//! Errors away from shadow edges: acne, leaks, and acne by distance.
//!
//! Every map is wrong near a shadow's edge; beyond the reach of kernels nothing may be wrong.
//! Pixels that far away are *open*: see [`CaseTruth::open`](crate::stability::CaseTruth).

use umbrage_core::metrics::ERROR_THRESHOLD;

/// Returns the acne: the percentage of the open lit pixels that the mask darkens by more than
/// [`ERROR_THRESHOLD`].
pub fn acne(mask: &[f32], truth: &[f32], open: &[bool]) -> f64 {
    share(
        (0..mask.len())
            .filter(|&i| open[i] && truth[i] == 1.0)
            .map(|i| truth[i] - mask[i] > ERROR_THRESHOLD),
    )
}

/// Returns the leaks: the percentage of the open dark pixels that the mask lights by more than
/// [`ERROR_THRESHOLD`].
pub fn leak(mask: &[f32], truth: &[f32], open: &[bool]) -> f64 {
    share(
        (0..mask.len())
            .filter(|&i| open[i] && truth[i] == 0.0)
            .map(|i| mask[i] - truth[i] > ERROR_THRESHOLD),
    )
}

/// Returns the lost shadow: the percentage of the counted pixels dark in truth (below 0.5) that the
/// mask lights (above 0.5), including those along edges.
///
/// A kernel that blurs an edge evenly leaves its midpoint in place, and so loses nothing. Moving,
/// shrinking or dropping a shadow loses some. Exactly 0.5 is on neither side: four taps give it on
/// both sides of an edge.
pub fn lost_shadow(mask: &[f32], truth: &[f32], counts: impl Fn(usize) -> bool) -> f64 {
    let dark = (0..mask.len()).filter(|&i| counts(i) && truth[i] < 0.5);
    share(dark.map(|i| mask[i] > 0.5))
}

/// Returns acne and leaks together: the percentage of the open pixels that are wrong by more than
/// [`ERROR_THRESHOLD`].
pub fn wrong(mask: &[f32], truth: &[f32], open: &[bool]) -> f64 {
    share(
        (0..mask.len())
            .filter(|&i| open[i])
            .map(|i| (mask[i] - truth[i]).abs() > ERROR_THRESHOLD),
    )
}

/// Number of bins that pixels are sorted into by distance.
pub const BINS: usize = 5;

/// Returns the [`acne`] in [`BINS`] bins of distance from the eye (`distance`, metres), near first.
/// All bins have the same number of open lit pixels.
pub fn acne_by_distance(
    mask: &[f32],
    truth: &[f32],
    open: &[bool],
    distance: &[f32],
) -> [f64; BINS] {
    let mut lit: Vec<usize> = (0..mask.len())
        .filter(|&i| open[i] && truth[i] == 1.0)
        .collect();
    lit.sort_by(|a, b| distance[*a].total_cmp(&distance[*b]));
    std::array::from_fn(|bin| {
        let start = bin * lit.len() / BINS;
        let end = (bin + 1) * lit.len() / BINS;
        let in_bin = lit[start..end].iter();
        share(in_bin.map(|&i| truth[i] - mask[i] > ERROR_THRESHOLD))
    })
}

/// Returns the percentage of the flags that are true; 0 without flags.
pub fn share(wrong: impl Iterator<Item = bool>) -> f64 {
    let mut wrong_count = 0_u64;
    let mut count = 0_u64;
    for is_wrong in wrong {
        wrong_count += u64::from(is_wrong);
        count += 1;
    }
    100.0 * wrong_count as f64 / count.max(1) as f64
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
        assert_eq!(
            [acne(&mask, &truth, &open), leak(&mask, &truth, &open)],
            [third, 50.0]
        );
        assert_eq!(wrong(&mask, &truth, &open), 40.0);
        assert_eq!(
            [
                acne(&truth, &truth, &open),
                leak(&truth, &truth, &open),
                acne(&[], &[], &[])
            ],
            [0.0; 3]
        );
    }

    #[test]
    fn shadow_that_shrinks_is_lost_and_shadow_that_blurs_is_not() {
        let truth = [1.0, 1.0, 0.0, 0.0, 0.0, 0.0];
        let lost = |mask: [f32; 6]| lost_shadow(&mask, &truth, |i| i < 5);
        let third = 100.0 / 3.0;
        assert_eq!(lost([1.0, 1.0, 1.0, 0.0, 0.0, 1.0]), third);
        assert_eq!(lost([0.9, 0.6, 0.5, 0.1, 0.0, 0.0]), 0.0);
        assert_eq!(lost([1.0; 6]), 100.0);
        // Acne is not lost shadow.
        assert_eq!(lost([0.0; 6]), 0.0);
    }

    #[test]
    fn acne_in_the_distance_shows_in_the_last_bin_alone() {
        let distance: Vec<f32> = (0..800).map(|i| 1.01_f32.powi(i)).collect();
        let mask: Vec<f32> = (0..800).map(|i| if i >= 720 { 0.0 } else { 1.0 }).collect();
        let bins = acne_by_distance(&mask, &[1.0; 800], &[true; 800], &distance);
        assert_eq!(bins, [0.0, 0.0, 0.0, 0.0, 50.0]);
    }
}
