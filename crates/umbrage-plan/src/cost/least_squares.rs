//! Non-negative least squares.

/// Returns the x >= 0 with the least sum of squares of `rows` x - `targets`. Solves for one unknown
/// after the other (coordinate descent) until the solution converges. Unknowns that are in no row
/// are 0.
pub(super) fn solve<const N: usize>(rows: &[[f64; N]], targets: &[f64]) -> [f64; N] {
    let mut x = [0.0; N];
    // `rows` x - `targets`, starting with x = 0.
    let mut residuals: Vec<f64> = targets.iter().map(|target| -target).collect();
    let squares: [f64; N] = std::array::from_fn(|k| rows.iter().map(|row| row[k] * row[k]).sum());
    for _ in 0..MAX_ROUNDS {
        let mut max_change = 0.0_f64;
        for k in (0..N).filter(|&k| squares[k] > 0.0) {
            // Along x[k] the sum of squares is a parabola. `slope` is half its slope, `squares[k]`
            // half its curvature.
            let slope: f64 = rows
                .iter()
                .zip(&residuals)
                .map(|(row, residual)| row[k] * residual)
                .sum();
            let best = (x[k] - slope / squares[k]).max(0.0);
            let step = best - x[k];
            x[k] = best;
            for (row, residual) in rows.iter().zip(&mut residuals) {
                *residual += row[k] * step;
            }
            // Measure the change of the rows' sums, independent of the unknown's unit.
            max_change = max_change.max(step.abs() * squares[k].sqrt());
        }
        if max_change < CONVERGED {
            break;
        }
    }
    x
}

/// Greatest number of rounds over all unknowns. Correlated ones converge slowly, but thousands of
/// rounds take milliseconds.
const MAX_ROUNDS: usize = 100_000;
/// Change of the sums below which the solution has converged, far below the precision of times.
const CONVERGED: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::solve;

    #[test]
    fn exact_answers_are_found() {
        // 3 a + b = 1, a + 2 b = 1: a = .2, b = .4.
        let [a, b] = solve(&[[3.0, 1.0], [1.0, 2.0]], &[1.0; 2]);
        assert!((a - 0.2).abs() < 1e-6 && (b - 0.4).abs() < 1e-6, "{a} {b}");
    }

    #[test]
    fn what_would_be_negative_is_zero() {
        // a + b = 1, a + 3 b = 1, a + 9 b = .1 would need b < 0: a is then the best fit to the
        // mean.
        let [a, b] = solve(&[[1.0, 1.0], [1.0, 3.0], [10.0, 90.0]], &[1.0; 3]);
        assert!(b == 0.0 && a > 0.0, "{a} {b}");
        assert_eq!(solve::<2>(&[[0.0, 1.0]], &[2.0]), [0.0, 2.0]);
        assert_eq!(solve::<3>(&[], &[]), [0.0; 3]);
    }
}
