//! The Pareto front of cost and error.

/// Returns the indices of the Pareto-optimal points (cost, error), by rising cost.
///
/// A point is optimal if no other point is less in one figure and at most equal in the other. Equal
/// points are all kept. Points with NaN are never kept.
pub fn front(points: &[[f64; 2]]) -> Vec<usize> {
    let mut front: Vec<usize> = (0..points.len())
        .filter(|&i| {
            let point = points[i];
            let is_number = !point[0].is_nan() && !point[1].is_nan();
            is_number && !points.iter().any(|other| dominates(*other, point))
        })
        .collect();
    front.sort_by(|&a, &b| points[a][0].total_cmp(&points[b][0]));
    front
}

/// Returns whether `p` is better than `q` in one figure and at least as good in the other.
fn dominates(p: [f64; 2], q: [f64; 2]) -> bool {
    let is_no_worse = p[0] <= q[0] && p[1] <= q[1];
    let is_better = p[0] < q[0] || p[1] < q[1];
    is_no_worse && is_better
}

#[cfg(test)]
mod tests {
    use super::front;

    #[test]
    fn beaten_points_are_left_out() {
        let points = [
            [3.0, 1.0],
            [1.0, 3.0],
            [2.0, 2.0],
            [2.5, 2.5],
            [4.0, 1.0],
            [1.0, 3.0],
        ];
        assert_eq!(front(&points), [1, 5, 2, 0]);
    }

    #[test]
    fn a_spoilt_point_is_on_no_front() {
        assert_eq!(front(&[[f64::NAN, 0.0], [1.0, 1.0]]), [1]);
        assert_eq!(front(&[]), [0; 0]);
    }

    #[test]
    fn one_point_is_its_own_front() {
        assert_eq!(front(&[[1.0, f64::INFINITY]]), [0]);
    }
}
