//! Least squares whose unknowns are not negative.

/// The x >= 0 with the least sum of squares of `rows` x - 1, one unknown after the other (coordinate descent), until nothing
/// changes any more. Unknowns that no row mentions are 0.
pub(super) fn solve<const N: usize>(rows: &[[f64; N]]) -> [f64; N] {
    let mut x = [0.0; N];
    let mut residuals = vec![-1.0; rows.len()];
    let squares: [f64; N] = std::array::from_fn(|k| rows.iter().map(|row| row[k] * row[k]).sum());
    for _ in 0..MAX_ROUNDS {
        let mut moved = 0.0_f64;
        for k in (0..N).filter(|&k| squares[k] > 0.0) {
            let slope: f64 = rows.iter().zip(&residuals).map(|(row, r)| row[k] * r).sum();
            let to = (x[k] - slope / squares[k]).max(0.0);
            let step = to - x[k];
            x[k] = to;
            rows.iter()
                .zip(&mut residuals)
                .for_each(|(row, r)| *r += row[k] * step);
            // How much the step matters, whatever the unit: its share of what the rows are to sum up to.
            moved = moved.max(step.abs() * squares[k].sqrt());
        }
        if moved < ENOUGH {
            break;
        }
    }
    x
}

/// Rounds over all unknowns: correlated ones approach each other slowly, but thousands of rounds take milliseconds.
const MAX_ROUNDS: usize = 100_000;
/// A round that changes sums by less than this ends it: far below what times are worth.
const ENOUGH: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::solve;

    #[test]
    fn exact_answers_are_found() {
        // 3 a + b = 1, a + 2 b = 1: a = .2, b = .4.
        let [a, b] = solve(&[[3.0, 1.0], [1.0, 2.0]]);
        assert!((a - 0.2).abs() < 1e-6 && (b - 0.4).abs() < 1e-6, "{a} {b}");
    }

    #[test]
    fn what_would_be_negative_is_zero() {
        // a + b = 1, a + 3 b = 1, a + 9 b = .1 would want b < 0: then a is the mean's best fit.
        let [a, b] = solve(&[[1.0, 1.0], [1.0, 3.0], [10.0, 90.0]]);
        assert!(b == 0.0 && a > 0.0, "{a} {b}");
        assert_eq!(solve::<2>(&[[0.0, 1.0]]), [0.0, 1.0]);
        assert_eq!(solve::<3>(&[]), [0.0; 3]);
    }
}
