//! Rank correlation of two orders of rows.

/// Returns Spearman's rank correlation of two lists of the same length (Spearman 1904, "The proof
/// and measurement of association between two things").
///
/// It is 1 if both rise together, and -1 if one falls as the other rises. Equal numbers share the
/// mean of their ranks. Returns `None` for fewer than three pairs, or if all numbers of a list are
/// equal.
pub fn rank_correlation(pairs: &[[f64; 2]]) -> Option<f64> {
    if pairs.len() < 3 {
        return None;
    }
    let ranks = [0, 1].map(|side| ranks(&pairs.iter().map(|pair| pair[side]).collect::<Vec<_>>()));
    let mean = 0.5 * (pairs.len() as f64 + 1.0);
    let mut products = 0.0;
    let mut squares = [0.0; 2];
    for (a, b) in ranks[0].iter().zip(&ranks[1]) {
        products += (a - mean) * (b - mean);
        squares[0] += (a - mean).powi(2);
        squares[1] += (b - mean).powi(2);
    }
    let scale = (squares[0] * squares[1]).sqrt();
    (scale > 0.0).then(|| products / scale)
}

/// Returns each number's rank, from 1. Equal numbers share the mean of their ranks.
fn ranks(numbers: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..numbers.len()).collect();
    order.sort_by(|&a, &b| numbers[a].total_cmp(&numbers[b]));
    let mut out = vec![0.0; numbers.len()];
    let mut start = 0;
    while start < order.len() {
        let value = numbers[order[start]];
        let equal = order[start..]
            .iter()
            .take_while(|&&i| numbers[i] == value)
            .count()
            .max(1);
        // Mean of the ranks start + 1 .. start + equal.
        let rank = start as f64 + 0.5 * (equal as f64 + 1.0);
        for &i in &order[start..start + equal] {
            out[i] = rank;
        }
        start += equal;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn correlations_are_those_of_the_formula() {
        let rising = [[1.0, 10.0], [2.0, 1e3], [3.0, 1e9]];
        assert_eq!(rank_correlation(&rising), Some(1.0));
        let falling = [[1.0, 3.0], [2.0, 2.0], [9.0, 1.0]];
        assert_eq!(rank_correlation(&falling), Some(-1.0));
        // Ranks 1 2 3 4 5 against 2 1 4 3 5: 1 - 6 * 4 / (5 * 24).
        let some = [[1.0, 2.0], [2.0, 1.0], [3.0, 4.0], [4.0, 3.0], [5.0, 5.0]];
        let found = rank_correlation(&some).expect("enough");
        assert!((found - 0.8).abs() < 1e-12, "{found}");
    }

    #[test]
    fn equal_numbers_share_their_rank() {
        assert_eq!(ranks(&[5.0, 1.0, 5.0, 7.0]), [2.5, 1.0, 2.5, 4.0]);
        assert_eq!(
            rank_correlation(&[[1.0, 1.0], [1.0, 2.0], [1.0, 3.0]]),
            None
        );
        assert_eq!(rank_correlation(&[[1.0, 1.0], [2.0, 2.0]]), None);
    }
}
