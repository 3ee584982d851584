//! Errors of a whole image, estimated from a sample of it.

use super::sample::PixelSample;
use crate::truth::PixelTruth;
use serde::{Deserialize, Serialize};
use umbrage_core::metrics::Pixel;

/// Number of standard errors of a normal distribution that one in twenty exceeds. One in twenty
/// errors is above [`Estimate::high`], and one in twenty below [`Estimate::low`].
pub(crate) const ONE_IN_TWENTY: f64 = 1.645;

/// Errors of a setting, estimated from the sample.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Root mean square of mask - truth over the pixels that count, 0..=1:
    /// [`Errors::rmse`](umbrage_core::metrics::Errors::rmse), or [weighted](crate::Weighting).
    pub error: f64,
    /// Lower limit: the whole image's error is below this with a chance of one in twenty.
    pub low: f64,
    /// Upper limit: the whole image's error is above this with a chance of one in twenty.
    pub high: f64,
    /// Part of `error` where the mask is darker than truth (acne, blur). The squares of both parts
    /// add up to the square of `error`.
    pub too_dark: f64,
    /// Part of `error` where the mask is lighter than truth (detached shadows, leaks, blur).
    pub too_light: f64,
}

/// Compares a mask at the sampled pixels with truth.
///
/// The mean over the pixels that count is a ratio of two sums. Its variance is that of Hájek 1964,
/// "Asymptotic theory of rejective sampling with varying probabilities from a finite population":
/// pixels that were certain to be drawn add none. For a mask without errors the uncertainty is 0:
/// see [`Verifier`](super::verify::Verifier).
pub(crate) fn estimate(sample: &PixelSample, truth: &[PixelTruth], mask: &[f32]) -> Estimate {
    let compared = Compared {
        sample,
        truth,
        mask,
    };
    let all = compared.sum(|k| compared.weight(k));
    if all <= 0.0 {
        return Estimate::default();
    }
    let squares = compared.squares().divided_by(all);
    let margin = compared.margin(squares.sum()) / all;
    Estimate::new(squares, margin, 0.0)
}

/// Part of an image in which a mask can be wrong.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Part {
    /// Number of pixels of the whole image that count.
    pub(crate) all: CountedPixels,
    /// Greatest weight over chance of the part's pixels that were not certain to be drawn: the
    /// greatest contribution of one missed pixel to a sum. 0 if all were certain to be drawn.
    pub(crate) greatest_share: f64,
    /// Greatest contribution of errors outside the part to the mean square.
    pub(crate) unseen: f64,
}

/// Estimates errors like [`estimate`], from a sample of only those pixels that can be wrong.
///
/// Many of them may be ambiguous, so that few or none of the drawn pixels are wrong. The margin is
/// then not that of a normal distribution: see [`upper_limit_of_sum`].
pub(crate) fn estimate_of_part(
    sample: &PixelSample,
    truth: &[PixelTruth],
    mask: &[f32],
    part: Part,
) -> Estimate {
    let all = part.all;
    let compared = Compared {
        sample,
        truth,
        mask,
    };
    if all.count <= 0.0 {
        return Estimate::default();
    }
    let squares = compared.squares().divided_by(all.count);
    // Combine two independent uncertainties: the number of pixels that count, and the sum over
    // them.
    let margin_of_count = all.margin / all.count * squares.sum();
    let margin_of_sum = compared.margin_of_few(part.greatest_share) / all.count;
    Estimate::new(squares, margin_of_count.hypot(margin_of_sum), part.unseen)
}

/// Weighted number of an image's pixels that count, estimated from a sample of its receivers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct CountedPixels {
    pub(crate) count: f64,
    /// One in twenty counts exceeds `count` by more than this.
    pub(crate) margin: f64,
}

impl CountedPixels {
    /// Estimates the number from the receivers drawn out of those with the total weight
    /// `receivers`. `drawn` has the chance, the weight and the counted flag of each. The share that
    /// counts is a ratio of two sums, as in [`estimate`].
    pub(crate) fn estimate(
        receivers: f64,
        drawn: impl Iterator<Item = (f64, f64, bool)> + Clone,
    ) -> Self {
        let all: f64 = drawn
            .clone()
            .map(|(chance, weight, _)| weight / chance)
            .sum();
        if all <= 0.0 {
            return Self::default();
        }
        let share = drawn
            .clone()
            .filter(|(_, _, counts)| *counts)
            .map(|(chance, weight, _)| weight / chance)
            .sum::<f64>()
            / all;
        let variance: f64 = drawn
            .map(|(chance, weight, counts)| {
                let deviation = weight * (f64::from(u8::from(counts)) - share);
                (1.0 - chance) / chance.powi(2) * deviation.powi(2)
            })
            .sum();
        let share_margin = ONE_IN_TWENTY * variance.sqrt() / all;
        Self {
            count: share * receivers,
            margin: share_margin * receivers,
        }
    }
}

/// Returns the upper limit, with 95 % confidence, of the mean of a weighted sum of
/// Poisson-distributed numbers.
///
/// The arguments are the sum itself, its variance (each number times the square of its weight) and
/// the greatest weight. The limit is the quantile of a gamma distribution (Fay and Feuer 1997,
/// "Confidence intervals for directly standardized rates: a method based on the gamma
/// distribution"). The distribution has the mean and the variance of the sum with one more
/// observation of the greatest weight. The limit is 3 weights if the sum is 0 ("rule of three"),
/// and nearly [`ONE_IN_TWENTY`] standard errors above a large sum. With equal weights it is the
/// exact limit of the Poisson distribution. The quantile is accurate to 1 % (Wilson and Hilferty
/// 1931, "The distribution of chi-square").
pub(crate) fn upper_limit_of_sum(sum: f64, variance: f64, greatest: f64) -> f64 {
    let mean = sum + greatest;
    let variance = variance + greatest.powi(2);
    if mean <= 0.0 || variance <= 0.0 {
        return sum;
    }
    let shape = mean.powi(2) / variance;
    mean * (1.0 - 1.0 / (9.0 * shape) + ONE_IN_TWENTY / (3.0 * shape.sqrt())).powi(3)
}

/// Number of standard errors that one in sixty exceeds. Up to three successive samples decide a
/// bound. Each may be wrong in one of sixty cases, so that all are wrong in at most one of twenty
/// (Bonferroni).
const ONE_IN_SIXTY: f64 = 2.128;

impl Estimate {
    /// Computes the estimate from mean squares, the margin of their sum in both directions, and the
    /// contribution that may have been missed.
    fn new(squares: Squares, margin: f64, unseen: f64) -> Self {
        let square = squares.sum();
        Self {
            error: square.sqrt(),
            low: (square - margin).max(0.0).sqrt(),
            high: (square + margin + unseen).sqrt(),
            too_dark: squares.too_dark.sqrt(),
            too_light: squares.too_light.sqrt(),
        }
    }

    /// Returns the estimate with all errors multiplied by a factor.
    pub(crate) fn times(self, factor: f64) -> Self {
        Self {
            error: self.error * factor,
            low: self.low * factor,
            high: self.high * factor,
            too_dark: self.too_dark * factor,
            too_light: self.too_light * factor,
        }
    }

    /// Returns whether the whole image's error is within `bound`, for any number of samples.
    /// Margins are widened as for a normal distribution. If a sample contains no error, one case in
    /// 46 is wrong instead of one in 60.
    pub(crate) fn is_surely_within(&self, bound: f64) -> bool {
        let square = self.error.powi(2);
        square + ONE_IN_SIXTY / ONE_IN_TWENTY * (self.high.powi(2) - square) <= bound.powi(2)
    }

    /// Returns whether the whole image's error is above `bound`, except in about one of a thousand
    /// cases: twice the margin of [`Estimate::low`], in squares.
    pub(crate) fn is_surely_above(&self, bound: f64) -> bool {
        let square = self.error.powi(2);
        square - 2.0 * (self.high.powi(2) - square) > bound.powi(2)
    }
}

/// Squared differences of mask and truth: a sum or a mean.
#[derive(Clone, Copy, Debug)]
struct Squares {
    too_dark: f64,
    too_light: f64,
}

impl Squares {
    fn divided_by(self, count: f64) -> Self {
        Self {
            too_dark: self.too_dark / count,
            too_light: self.too_light / count,
        }
    }

    fn sum(self) -> f64 {
        self.too_dark + self.too_light
    }
}

/// Mask and truth at the sampled pixels.
struct Compared<'a> {
    sample: &'a PixelSample,
    truth: &'a [PixelTruth],
    mask: &'a [f32],
}

impl Compared<'_> {
    fn difference(&self, k: usize) -> f64 {
        f64::from(self.mask[k]) - f64::from(self.truth[k].visibility)
    }

    /// Estimates the sum over the image's pixels that count.
    fn sum(&self, of: impl Fn(usize) -> f64) -> f64 {
        let counted = (0..self.mask.len()).filter(|&k| self.truth[k].pixel == Pixel::Counted);
        // Start from 0, since an empty sum of floats is -0.
        counted
            .map(|k| of(k) / self.sample.chances[k])
            .fold(0.0, |sum, v| sum + v)
    }

    fn weight(&self, k: usize) -> f64 {
        self.sample.weights[k]
    }

    /// Returns the sums of squared differences.
    fn squares(&self) -> Squares {
        Squares {
            too_dark: self.sum(|k| self.weight(k) * self.difference(k).min(0.0).powi(2)),
            too_light: self.sum(|k| self.weight(k) * self.difference(k).max(0.0).powi(2)),
        }
    }

    /// Returns the margin that one in twenty sums of squares exceeds, given the mean square.
    fn margin(&self, mean: f64) -> f64 {
        ONE_IN_TWENTY * self.variance(mean).sqrt()
    }

    /// Returns the margin for a mean square of 0, also valid if few or none of the sample are
    /// wrong. Draws without replacement vary less than Poisson numbers, so the limit is
    /// conservative.
    fn margin_of_few(&self, greatest_share: f64) -> f64 {
        let sum = self.squares().sum();
        // Differences are at most 1, and so are their squares.
        upper_limit_of_sum(sum, self.variance(0.0), greatest_share) - sum
    }

    /// Returns the variance of the sum of squares, given the mean square.
    fn variance(&self, mean: f64) -> f64 {
        self.sum(|k| {
            let chance = self.sample.chances[k];
            let deviation = self.weight(k) * (self.difference(k).powi(2) - mean);
            (1.0 - chance) / chance * deviation.powi(2)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::UVec2;
    use umbrage_core::light_sample::hash;

    const SIZE: UVec2 = UVec2::new(64, 64);

    /// Returns an image of which a tenth is wrong, more of it on one side, and nine tenths count.
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

    fn of_sample(sample: &PixelSample, truth: &[PixelTruth], mask: &[f32]) -> Estimate {
        let truth: Vec<_> = sample.pixels.iter().map(|&i| truth[i as usize]).collect();
        let mask: Vec<_> = sample.pixels.iter().map(|&i| mask[i as usize]).collect();
        estimate(sample, &truth, &mask)
    }

    /// Samples that prefer one side of the image estimate the same mean square, and their bounds
    /// hold as often as stated.
    #[test]
    fn estimates_are_unbiased_and_know_their_error() {
        let (truth, mask) = image();
        let whole = of_sample(
            &PixelSample::draw(SIZE, &[1.0; 4096], 4096, 0),
            &truth,
            &mask,
        );
        assert_eq!((whole.low, whole.high), (whole.error, whole.error));
        assert!((whole.too_dark.hypot(whole.too_light) - whole.error).abs() < 1e-12);
        let density: Vec<f64> = (0..4096).map(|i| 1.0 + f64::from(i % 64) / 8.0).collect();
        let estimates: Vec<_> = (0..500)
            .map(|s| of_sample(&PixelSample::draw(SIZE, &density, 400, s), &truth, &mask))
            .collect();
        let squares = estimates.iter().map(|e| e.error * e.error).sum::<f64>() / 500.0;
        // The standard error of one sample is about a tenth of the mean square. That of 500 samples
        // is a twentieth of it.
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
        let sample = PixelSample::draw(SIZE, &[1.0; 4096], 500, 1);
        let spoilt: Vec<f32> = mask.iter().map(|v| 1.0 - v).collect();
        let good = of_sample(&sample, &truth, &mask);
        let bad = of_sample(&sample, &truth, &spoilt);
        assert!(bad.too_dark > good.too_dark);
    }

    /// Few of 4,096 pixels are wrong, and most samples contain one of them or none. Limits hold as
    /// often as stated, and none states that the error is certainly 0.
    #[test]
    fn samples_that_meet_no_error_know_that_there_may_be_some() {
        let truth = vec![
            PixelTruth {
                visibility: 1.0,
                error: 0.0,
                pixel: Pixel::Counted,
            };
            4096
        ];
        let of_part = |count: usize, seed: u32, mask: &[f32]| {
            let sample = PixelSample::draw(SIZE, &[1.0; 4096], count, seed);
            let truth = &truth[..sample.pixels.len()];
            let mask: Vec<_> = sample.pixels.iter().map(|&i| mask[i as usize]).collect();
            let missed_at_most = 4096.0 / count as f64;
            let part = Part {
                all: CountedPixels {
                    count: 4096.0,
                    margin: 0.0,
                },
                greatest_share: if count < 4096 { missed_at_most } else { 0.0 },
                unseen: 0.0,
            };
            estimate_of_part(&sample, truth, &mask, part)
        };
        for wrong in [3, 10, 40] {
            let mut mask = vec![1.0; 4096];
            for n in 0..wrong {
                mask[hash(n) as usize % 4096] = 0.0;
            }
            let whole = of_part(4096, 0, &mask);
            assert!(whole.error > 0.0 && whole.high == whole.error);
            let estimates: Vec<_> = (0..1000).map(|seed| of_part(256, seed, &mask)).collect();
            assert!(estimates.iter().all(|e| e.high > 0.0));
            let above = estimates.iter().filter(|e| e.high < whole.error).count();
            // One in twenty is 50; five standard deviations of the count are 34.
            assert!(above < 84, "{wrong}: {above}");
        }
    }

    #[test]
    fn nothing_that_counts_is_no_error() {
        let sample = PixelSample {
            pixels: vec![0],
            chances: vec![0.5],
            weights: vec![1.0],
        };
        let truth = [PixelTruth {
            visibility: 0.0,
            error: 0.0,
            pixel: Pixel::Unlit,
        }];
        assert_eq!(estimate(&sample, &truth, &[1.0]), Estimate::default());
    }
}
