//! Shimmer: what changes from frame to frame though it should not, and what stays though it should change.

/// Mean of |V_t - V_(t-1)| over all pairs of neighbouring frames and all marked points, 0..=1. Each frame holds the
/// visibility of the same world-locked points.
pub fn change(frames: &[Vec<f32>], marked: &[bool]) -> f64 {
    mean(&steps(frames, marked))
}

/// Shimmer beyond truth's own: a method's mean change less truth's; negative where the method hides true changes.
pub fn shimmer(frames: &[Vec<f32>], truth: &[Vec<f32>], marked: &[bool]) -> f64 {
    change(frames, marked) - change(truth, marked)
}

/// How far a method's change is from truth's, either way: the mean, over all pairs of neighbouring frames, of the absolute
/// difference of their mean changes, 0..=1. A shadow that stands still while truth's moves is as wrong as one that crawls.
pub fn change_error(frames: &[Vec<f32>], truth: &[Vec<f32>], marked: &[bool]) -> f64 {
    let pairs = steps(frames, marked).into_iter().zip(steps(truth, marked));
    mean(&pairs.map(|(a, b)| (a - b).abs()).collect::<Vec<_>>())
}

/// The mean of |V_t - V_(t-1)| over all marked points, for each pair of neighbouring frames.
fn steps(frames: &[Vec<f32>], marked: &[bool]) -> Vec<f64> {
    let points: Vec<usize> = (0..marked.len()).filter(|&i| marked[i]).collect();
    let step =
        |[a, b]: &[Vec<f32>; 2]| mean(&points.iter().map(|&i| f64::from((a[i] - b[i]).abs())).collect::<Vec<_>>());
    frames.array_windows().map(step).collect()
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

    #[test]
    fn standing_still_is_as_wrong_as_crawling() {
        let still = vec![vec![0.0, 1.0]; 3];
        let moving = vec![vec![0.0, 1.0], vec![0.0, 0.5], vec![0.5, 0.5]];
        let all = [true; 2];
        assert_eq!(change_error(&moving, &moving, &all), 0.0);
        assert_eq!(change_error(&still, &moving, &all), 0.25);
        assert_eq!(change_error(&moving, &still, &all), 0.25);
        // A jump doesn't make up for a rest: frame by frame both are wrong, though they change as much in all.
        let jumping = vec![vec![0.0, 1.0], vec![0.0, 1.0], vec![0.5, 0.5]];
        assert_eq!(change(&jumping, &all), change(&moving, &all));
        assert_eq!(change_error(&jumping, &moving, &all), 0.25);
        assert_eq!(change_error(&still, &moving, &[true, false]), 0.25);
        assert_eq!(change_error(&still, &moving, &[false; 2]), 0.0);
    }
}
