//! Quantiles.

/// Numbers in rising order.
#[derive(Clone, Debug, PartialEq)]
pub struct Sorted(Vec<f64>);

impl Sorted {
    /// Sorts numbers. NaN comes last.
    pub fn new(mut numbers: Vec<f64>) -> Self {
        numbers.sort_by(f64::total_cmp);
        Self(numbers)
    }

    /// Returns the number that a share in 0..=1 of all numbers does not exceed.
    ///
    /// Interpolates linearly between neighbours (type 7 of Hyndman and Fan 1996, "Sample quantiles
    /// in statistical packages"). Share 0 returns the least, 0.5 the median, 1 the greatest.
    /// Returns `None` if there are no numbers.
    pub fn quantile(&self, share: f64) -> Option<f64> {
        let last = self.0.len().checked_sub(1)?;
        let place = share.clamp(0.0, 1.0) * last as f64;
        let before = self.0[place.floor() as usize];
        let after = self.0[place.ceil() as usize];
        Some(before + (after - before) * place.fract())
    }

    /// Returns the nearest of the numbers themselves, without the interpolation of
    /// [`Sorted::quantile`].
    pub fn nearest(&self, share: f64) -> Option<f64> {
        let last = self.0.len().checked_sub(1)?;
        let place = share.clamp(0.0, 1.0) * last as f64;
        self.0.get(place.round() as usize).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::Sorted;

    #[test]
    fn quantiles_lie_between_neighbours() {
        let sorted = Sorted::new(vec![4.0, 1.0, 2.0, 8.0]);
        let at = [0.0, 0.5, 0.75, 1.0].map(|share| sorted.quantile(share));
        assert_eq!(at, [1.0, 3.0, 5.0, 8.0].map(Some));
        let nearest = [0.0, 0.1, 0.5, 0.9].map(|share| sorted.nearest(share));
        assert_eq!(nearest, [1.0, 1.0, 4.0, 8.0].map(Some));
    }

    #[test]
    fn few_numbers_have_quantiles_and_none_have_none() {
        assert_eq!(Sorted::new(vec![7.0]).quantile(0.3), Some(7.0));
        assert_eq!(Sorted::new(Vec::new()).quantile(0.5), None);
        assert_eq!(Sorted::new(Vec::new()).nearest(0.5), None);
    }
}
