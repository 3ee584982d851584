//! Shimmer: changes from frame to frame that truth lacks, and true changes that are missing.

use std::collections::BTreeMap;

/// Returns the mean of |V_t - V_(t-1)| over all pairs of neighbouring frames and all marked points,
/// 0..=1. Each frame holds the visibility of the same world-space points.
pub fn change(frames: &[Vec<f32>], marked: &[bool]) -> f64 {
    mean(&steps(frames, marked))
}

/// Returns the shimmer: a method's mean change minus truth's, -1..=1. It is negative if the method
/// hides true changes.
pub fn shimmer(frames: &[Vec<f32>], truth: &[Vec<f32>], marked: &[bool]) -> f64 {
    change(frames, marked) - change(truth, marked)
}

/// Side of the blocks of pixels in which [`change_error`] compares changes. Steps of texels and the
/// noise of edges cancel within a block. Crawl in one block can't offset missing movement in
/// another.
pub const BLOCK: usize = 16;

/// Returns the difference between a method's change and truth's, 0..=2.
///
/// In each block of [`BLOCK`] x [`BLOCK`] pixels it sums the increases of visibility from one frame
/// to the next, and separately the decreases, for the method and for truth. The result is the sum
/// of the absolute differences of these sums, divided by the number of marked points, in the mean
/// over all pairs of frames.
///
/// A shadow that stands still while truth's moves is as wrong as one that crawls. One that moves
/// backwards is wrong twice. Points are the pixels of an image `width` wide, rows from the top.
pub fn change_error(frames: &[Vec<f32>], truth: &[Vec<f32>], marked: &[bool], width: usize) -> f64 {
    let blocks = blocks(marked, width);
    let count = blocks.iter().map(Vec::len).sum::<usize>().max(1) as f64;
    let mut errors = Vec::new();
    let frame_pairs = frames.windows(2).zip(truth.windows(2));
    for (frame_pair, truth_pair) in frame_pairs {
        let differences = blocks.iter().map(|points| {
            let change = BlockChange::between_masks(&frame_pair[0], &frame_pair[1], points);
            let true_change = BlockChange::between_masks(&truth_pair[0], &truth_pair[1], points);
            change.difference(true_change)
        });
        errors.push(differences.sum::<f64>() / count);
    }
    mean(&errors)
}

/// Returns the marked points of each block that has some.
fn blocks(marked: &[bool], width: usize) -> Vec<Vec<usize>> {
    let width = width.max(1);
    let mut blocks = BTreeMap::<[usize; 2], Vec<usize>>::new();
    for i in (0..marked.len()).filter(|&i| marked[i]) {
        let row = i / width;
        let column = i % width;
        blocks
            .entry([row / BLOCK, column / BLOCK])
            .or_default()
            .push(i);
    }
    blocks.into_values().collect()
}

/// Change of visibility from one frame to the next, summed over the points of a block.
#[derive(Clone, Copy, Debug)]
struct BlockChange {
    /// Sum over the points that brighten.
    brightened: f64,
    /// Sum over the points that darken, as a positive number.
    darkened: f64,
}

impl BlockChange {
    fn between_masks(before: &[f32], after: &[f32], points: &[usize]) -> Self {
        let mut change = Self {
            brightened: 0.0,
            darkened: 0.0,
        };
        for &i in points {
            let step = f64::from(after[i] - before[i]);
            change.brightened += step.max(0.0);
            change.darkened -= step.min(0.0);
        }
        change
    }

    fn difference(self, other: Self) -> f64 {
        (self.brightened - other.brightened).abs() + (self.darkened - other.darkened).abs()
    }
}

/// Returns the mean of |V_t - V_(t-1)| over all marked points, for each pair of neighbouring
/// frames.
fn steps(frames: &[Vec<f32>], marked: &[bool]) -> Vec<f64> {
    let points: Vec<usize> = (0..marked.len()).filter(|&i| marked[i]).collect();
    let mut steps = Vec::new();
    for pair in frames.windows(2) {
        let before = &pair[0];
        let after = &pair[1];
        let changes: Vec<f64> = points
            .iter()
            .map(|&i| f64::from((before[i] - after[i]).abs()))
            .collect();
        steps.push(mean(&changes));
    }
    steps
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crawling_edges_shimmer_and_true_motion_does_not() {
        let still = vec![vec![0.0, 1.0, 1.0]; 3];
        let crawling = vec![
            vec![0.0, 1.0, 1.0],
            vec![0.0, 0.0, 1.0],
            vec![0.0, 1.0, 1.0],
        ];
        let all = [true; 3];
        assert_eq!(shimmer(&still, &still, &all), 0.0);
        assert!((shimmer(&crawling, &still, &all) - 1.0 / 3.0).abs() < 1e-12);
        assert_eq!(shimmer(&crawling, &crawling, &all), 0.0);
        assert!(shimmer(&still, &crawling, &all) < 0.0);
        // Only marked points count, and no marked point means no shimmer.
        assert_eq!(shimmer(&crawling, &still, &[true, false, true]), 0.0);
        assert_eq!(change(&crawling, &[false; 3]), 0.0);
    }

    #[test]
    fn standing_still_is_as_wrong_as_crawling() {
        let still = vec![vec![0.0, 1.0]; 3];
        let moving = vec![vec![0.0, 1.0], vec![0.0, 0.5], vec![0.5, 0.5]];
        let all = [true; 2];
        assert_eq!(change_error(&moving, &moving, &all, 2), 0.0);
        assert_eq!(change_error(&still, &moving, &all, 2), 0.25);
        assert_eq!(change_error(&moving, &still, &all, 2), 0.25);
        // A jump doesn't offset a rest: each frame is wrong, although the changes of all frames
        // have the same sum.
        let jumping = vec![vec![0.0, 1.0], vec![0.0, 1.0], vec![0.5, 0.5]];
        assert_eq!(change(&jumping, &all), change(&moving, &all));
        assert_eq!(change_error(&jumping, &moving, &all, 2), 0.25);
        assert_eq!(change_error(&still, &moving, &[true, false], 2), 0.25);
        assert_eq!(change_error(&still, &moving, &[false; 2], 2), 0.0);
    }

    /// Side of the images below, pixels: two blocks.
    const SIDE: usize = 2 * BLOCK;

    /// Returns an image of visibility 0.5 with two other pixels, each as (x, y, visibility).
    fn picture(set: [(usize, usize, f32); 2]) -> Vec<f32> {
        let mut out = vec![0.5; SIDE * SIDE];
        for (x, y, visibility) in set {
            out[y * SIDE + x] = visibility;
        }
        out
    }

    /// Returns the change error of two frames, summed over all points.
    fn summed_error(mask: &[Vec<f32>], truth: &[Vec<f32>]) -> f64 {
        let points = SIDE * SIDE;
        change_error(mask, truth, &vec![true; points], SIDE) * points as f64
    }

    #[test]
    fn crawl_in_one_place_does_not_pay_for_rest_in_another() {
        let far = SIDE - 1;
        // Truth darkens the pixel in the first block. The mask changes one in the block to its
        // right, below it, or both.
        for (x, y) in [(far, 0), (0, far), (far, far)] {
            let lit_then_dark = [
                picture([(0, 0, 1.0), (x, y, 0.0)]),
                picture([(0, 0, 0.0), (x, y, 0.0)]),
            ];
            let brightened_elsewhere = [
                picture([(0, 0, 1.0), (x, y, 0.0)]),
                picture([(0, 0, 1.0), (x, y, 1.0)]),
            ];
            assert_eq!(summed_error(&brightened_elsewhere, &lit_then_dark), 2.0);
            let darkened_elsewhere = [
                picture([(0, 0, 1.0), (x, y, 1.0)]),
                picture([(0, 0, 1.0), (x, y, 0.0)]),
            ];
            assert_eq!(summed_error(&darkened_elsewhere, &lit_then_dark), 2.0);
        }
    }

    /// Within a block, an edge pixel more or less is noise, but a change in the other direction is
    /// not.
    #[test]
    fn changes_within_a_block_make_up_for_each_other_in_one_direction_alone() {
        let far = SIDE - 1;
        let first_darkens = [
            picture([(0, 0, 1.0), (far, far, 0.0)]),
            picture([(0, 0, 0.0), (far, far, 0.0)]),
        ];
        let neighbor_darkens = [
            picture([(1, 0, 1.0), (far, far, 0.0)]),
            picture([(1, 0, 0.0), (far, far, 0.0)]),
        ];
        let first_brightens = [
            picture([(0, 0, 0.0), (far, far, 0.0)]),
            picture([(0, 0, 1.0), (far, far, 0.0)]),
        ];
        assert_eq!(summed_error(&neighbor_darkens, &first_darkens), 0.0);
        assert_eq!(summed_error(&first_brightens, &first_darkens), 2.0);
    }
}
