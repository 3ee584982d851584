//! Errors of a whole image from a sample of it.

use super::sample::Sample;
use crate::truth::PixelTruth;
use serde::{Deserialize, Serialize};
use umbrage_core::metrics::Pixel;

/// One in twenty errors lies above [`Estimate::high`], and one in twenty below [`Estimate::low`]: this many standard
/// errors of a normal distribution.
pub(crate) const ONE_IN_TWENTY: f64 = 1.645;

/// A setting's errors, as the sample tells them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Root mean square of mask - truth over the pixels that count, 0..=1: [`Errors::rmse`](umbrage_core::metrics::Errors::rmse).
    pub error: f64,
    /// The whole image's lies below this with a chance of one in twenty ..
    pub low: f64,
    /// .. and above this likewise.
    pub high: f64,
    /// The part of `error` where the mask is darker than truth (acne, blur): squares of both parts add up to its square.
    pub too_dark: f64,
    /// The part where it is lighter (detached shadows, leaks, blur).
    pub too_light: f64,
}

/// Compares a mask at the sampled pixels with truth there. The mean over the pixels that count is a ratio of two sums;
/// its variance is that of Hájek 1964, "Asymptotic theory of rejective sampling with varying probabilities from a finite
/// population": pixels that were sure to be drawn add none. Of a mask without a fault it knows no uncertainty: see
/// [`Verifier`](super::verify::Verifier).
pub(crate) fn estimate(sample: &Sample, truth: &[PixelTruth], mask: &[f32]) -> Estimate {
    let compared = Compared {
        sample,
        truth,
        mask,
    };
    let all = compared.sum(|_| 1.0);
    if all == 0.0 {
        return Estimate::default();
    }
    let squares = compared.squares().map(|sum| sum / all);
    Estimate::new(squares, compared.reach(squares[0] + squares[1]) / all, 0.0)
}

/// As [`estimate`] where the sample is of those pixels alone at which anything can be wrong, out of all that count; what is
/// wrong elsewhere adds at most `unseen` to the mean square.
pub(crate) fn estimate_of_part(
    sample: &Sample,
    truth: &[PixelTruth],
    mask: &[f32],
    all: Counted,
    unseen: f64,
) -> Estimate {
    let compared = Compared {
        sample,
        truth,
        mask,
    };
    if all.count == 0.0 {
        return Estimate::default();
    }
    let squares = compared.squares().map(|sum| sum / all.count);
    let of_count = all.reach / all.count * (squares[0] + squares[1]);
    Estimate::new(
        squares,
        of_count.hypot(compared.reach(0.0) / all.count),
        unseen,
    )
}

/// How many of an image's receivers count, by a sample of them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Counted {
    pub(crate) count: f64,
    /// What one in twenty counts errs by at most.
    pub(crate) reach: f64,
}

impl Counted {
    /// Of so many receivers: the share of those drawn that count, each by its chance and whether it does (a ratio, as in
    /// [`estimate`]).
    pub(crate) fn of(receivers: usize, drawn: impl Iterator<Item = (f64, bool)> + Clone) -> Self {
        let all: f64 = drawn.clone().map(|(chance, _)| 1.0 / chance).sum();
        if all == 0.0 {
            return Self::default();
        }
        let share = drawn
            .clone()
            .filter(|(_, counts)| *counts)
            .map(|(chance, _)| 1.0 / chance)
            .sum::<f64>()
            / all;
        let off = |(chance, counts): (f64, bool)| {
            (1.0 - chance) / chance.powi(2) * (f64::from(u8::from(counts)) - share).powi(2)
        };
        let reach = ONE_IN_TWENTY * drawn.map(off).sum::<f64>().sqrt() / all;
        Self {
            count: share * receivers as f64,
            reach: reach * receivers as f64,
        }
    }

    /// As many as there may be.
    pub(crate) fn most(&self) -> f64 {
        self.count + self.reach
    }
}

/// A bound is decided by up to three looks, one after the other: each may be wrong in one case of sixty alone, so that all
/// are in one of twenty (Bonferroni). In standard errors.
const ONE_IN_SIXTY: f64 = 2.128;

impl Estimate {
    /// From mean squares, too dark and too light, and by how much their sum may be off: either way, and too low.
    fn new([dark, light]: [f64; 2], reach: f64, unseen: f64) -> Self {
        let square = dark + light;
        Self {
            error: square.sqrt(),
            low: (square - reach).max(0.0).sqrt(),
            high: (square + reach + unseen).sqrt(),
            too_dark: dark.sqrt(),
            too_light: light.sqrt(),
        }
    }

    /// Whether the whole image's error lies within `bound`, however many looks were taken.
    pub(crate) fn is_surely_within(&self, bound: f64) -> bool {
        let square = self.error.powi(2);
        square + ONE_IN_SIXTY / ONE_IN_TWENTY * (self.high.powi(2) - square) <= bound.powi(2)
    }

    /// Whether the whole image's error lies above `bound` but for one case in some thousand: twice as far as
    /// [`Estimate::low`] reaches, in squares.
    pub(crate) fn is_surely_above(&self, bound: f64) -> bool {
        let square = self.error.powi(2);
        square - 2.0 * (self.high.powi(2) - square) > bound.powi(2)
    }
}

/// A mask and truth at the sampled pixels.
struct Compared<'a> {
    sample: &'a Sample,
    truth: &'a [PixelTruth],
    mask: &'a [f32],
}

impl Compared<'_> {
    fn difference(&self, k: usize) -> f64 {
        f64::from(self.mask[k]) - f64::from(self.truth[k].visibility)
    }

    /// An estimate of the sum over the image's pixels that count.
    fn sum(&self, of: impl Fn(usize) -> f64) -> f64 {
        let counted = (0..self.mask.len()).filter(|&k| self.truth[k].pixel == Pixel::Counted);
        // From 0: floats sum up nothing to -0.
        counted
            .map(|k| of(k) / self.sample.chances[k])
            .fold(0.0, |sum, v| sum + v)
    }

    /// Sums of squared differences, too dark and too light.
    fn squares(&self) -> [f64; 2] {
        [
            self.sum(|k| self.difference(k).min(0.0).powi(2)),
            self.sum(|k| self.difference(k).max(0.0).powi(2)),
        ]
    }

    /// What one in twenty sums of squares errs by, about their mean.
    fn reach(&self, mean: f64) -> f64 {
        let unsure = |k: usize| (1.0 - self.sample.chances[k]) / self.sample.chances[k];
        ONE_IN_TWENTY
            * self
                .sum(|k| unsure(k) * (self.difference(k).powi(2) - mean).powi(2))
                .sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::UVec2;
    use umbrage_core::light_sample::hash;

    const SIZE: UVec2 = UVec2::new(64, 64);

    /// An image of which a tenth is wrong, more of it on one side, and nine tenths count.
    fn image() -> (Vec<PixelTruth>, Vec<f32>) {
        let truth = |i: u32| PixelTruth {
            visibility: 0.5,
            error: 0.0,
            pixel: if hash(i).is_multiple_of(10) {
                Pixel::Ambiguous
            } else {
                Pixel::Counted
            },
        };
        let mask = |i: u32| match hash(i + 9999) % 640 {
            n if n < i % 64 => 1.0,
            n if n < 64 => 0.25,
            _ => 0.5,
        };
        (0..4096).map(|i| (truth(i), mask(i))).unzip()
    }

    fn of_sample(sample: &Sample, (truth, mask): &(Vec<PixelTruth>, Vec<f32>)) -> Estimate {
        let truth: Vec<_> = sample.pixels.iter().map(|&i| truth[i as usize]).collect();
        let mask: Vec<_> = sample.pixels.iter().map(|&i| mask[i as usize]).collect();
        estimate(sample, &truth, &mask)
    }

    /// Samples that prefer one side of the image estimate the same mean square, and their bounds hold as often as they say.
    #[test]
    fn estimates_are_unbiased_and_know_their_error() {
        let image = image();
        let whole = of_sample(&Sample::draw(SIZE, &[1.0; 4096], 4096, 0), &image);
        assert_eq!((whole.low, whole.high), (whole.error, whole.error));
        assert!((whole.too_dark.hypot(whole.too_light) - whole.error).abs() < 1e-12);
        let density: Vec<f64> = (0..4096).map(|i| 1.0 + f64::from(i % 64) / 8.0).collect();
        let estimates: Vec<_> = (0..500)
            .map(|s| of_sample(&Sample::draw(SIZE, &density, 400, s), &image))
            .collect();
        let squares = estimates.iter().map(|e| e.error * e.error).sum::<f64>() / 500.0;
        // The standard error of one sample is about a tenth of the mean square; 500 of them have a twentieth of that.
        assert!(
            (squares / whole.error.powi(2) - 1.0).abs() < 0.015,
            "{squares}"
        );
        let above = estimates.iter().filter(|e| e.high < whole.error).count();
        let below = estimates.iter().filter(|e| e.low > whole.error).count();
        // One in twenty is 25; five standard deviations of the count are 24.
        assert!(
            above < 50 && below < 50 && above + below > 5,
            "{above} {below}"
        );
    }

    #[test]
    fn a_spoilt_mask_has_a_greater_error() {
        let (truth, mask) = image();
        let sample = Sample::draw(SIZE, &[1.0; 4096], 500, 1);
        let spoilt: Vec<f32> = mask.iter().map(|v| 1.0 - v).collect();
        let [good, bad] = [mask, spoilt].map(|mask| of_sample(&sample, &(truth.clone(), mask)));
        assert!(bad.too_dark > good.too_dark);
    }

    #[test]
    fn nothing_that_counts_is_no_error() {
        let sample = Sample {
            pixels: vec![0],
            chances: vec![0.5],
        };
        let truth = [PixelTruth {
            visibility: 0.0,
            error: 0.0,
            pixel: Pixel::Unlit,
        }];
        assert_eq!(estimate(&sample, &truth, &[1.0]), Estimate::default());
    }
}
