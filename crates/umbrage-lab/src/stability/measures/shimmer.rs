//! Shimmer: what changes from frame to frame though it should not.

/// Mean of |V_t - V_(t-1)| over all pairs of neighbouring frames and all marked points, 0..=1. Each frame holds the
/// visibility of the same world-locked points.
pub fn change(frames: &[Vec<f32>], marked: &[bool]) -> f64 {
    let pairs = frames.len().saturating_sub(1);
    let points = marked.iter().filter(|m| **m).count();
    let step = |[a, b]: &[Vec<f32>; 2]| -> f64 {
        (0..marked.len()).filter(|&i| marked[i]).map(|i| f64::from((a[i] - b[i]).abs())).sum()
    };
    frames.array_windows().map(step).sum::<f64>() / (pairs * points).max(1) as f64
}

/// Shimmer beyond truth's own: a method's mean change less truth's; negative where the method hides true changes.
pub fn shimmer(frames: &[Vec<f32>], truth: &[Vec<f32>], marked: &[bool]) -> f64 {
    change(frames, marked) - change(truth, marked)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crawling_edges_shimmer_and_true_motion_does_not() {
        let still = vec![vec![0.0, 1.0, 1.0]; 3];
        let crawling = vec![vec![0.0, 1.0, 1.0], vec![0.0, 0.0, 1.0], vec![0.0, 1.0, 1.0]];
        let all = [true; 3];
        assert_eq!(shimmer(&still, &still, &all), 0.0);
        assert!((shimmer(&crawling, &still, &all) - 1.0 / 3.0).abs() < 1e-12);
        assert_eq!(shimmer(&crawling, &crawling, &all), 0.0);
        assert!(shimmer(&still, &crawling, &all) < 0.0);
        // Only marked points count, and none is no shimmer.
        assert_eq!(shimmer(&crawling, &still, &[true, false, true]), 0.0);
        assert_eq!(change(&crawling, &[false; 3]), 0.0);
    }
}
