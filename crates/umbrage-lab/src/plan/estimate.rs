//! Errors of a whole image from a sample of it.

use super::sample::Sample;
use crate::truth::PixelTruth;
use serde::{Deserialize, Serialize};
use umbrage_core::metrics::Pixel;

/// One in twenty errors lies above [`Estimate::high`], and one in twenty below [`Estimate::low`]: this many standard
/// errors of a normal distribution.
const ONE_IN_TWENTY: f64 = 1.645;

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
/// population": pixels that were sure to be drawn add none.
pub(super) fn estimate(sample: &Sample, truth: &[PixelTruth], mask: &[f32]) -> Estimate {
    let counted = || (0..mask.len()).filter(|&k| truth[k].pixel == Pixel::Counted);
    let difference = |k: usize| f64::from(mask[k]) - f64::from(truth[k].visibility);
    let sum = |of: &dyn Fn(usize) -> f64| counted().map(|k| of(k) / sample.chances[k]).sum::<f64>();
    let all = sum(&|_| 1.0);
    if all == 0.0 {
        return Estimate::default();
    }
    let dark = sum(&|k| difference(k).min(0.0).powi(2)) / all;
    let light = sum(&|k| difference(k).max(0.0).powi(2)) / all;
    let square = dark + light;
    let spread = |k: usize| (1.0 - sample.chances[k]) / sample.chances[k] * (difference(k).powi(2) - square).powi(2);
    let reach = ONE_IN_TWENTY * sum(&spread).sqrt() / all;
    Estimate {
        error: square.sqrt(),
        low: (square - reach).max(0.0).sqrt(),
        high: (square + reach).sqrt(),
        too_dark: dark.sqrt(),
        too_light: light.sqrt(),
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
            pixel: if hash(i).is_multiple_of(10) { Pixel::Ambiguous } else { Pixel::Counted },
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
        let estimates: Vec<_> = (0..500).map(|s| of_sample(&Sample::draw(SIZE, &density, 400, s), &image)).collect();
        let squares = estimates.iter().map(|e| e.error * e.error).sum::<f64>() / 500.0;
        // The standard error of one sample is about a tenth of the mean square; 500 of them have a twentieth of that.
        assert!((squares / whole.error.powi(2) - 1.0).abs() < 0.015, "{squares}");
        let above = estimates.iter().filter(|e| e.high < whole.error).count();
        let below = estimates.iter().filter(|e| e.low > whole.error).count();
        // One in twenty is 25; five standard deviations of the count are 24.
        assert!(above < 50 && below < 50 && above + below > 5, "{above} {below}");
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
        let sample = Sample { pixels: vec![0], chances: vec![0.5] };
        let truth = [PixelTruth { visibility: 0.0, error: 0.0, pixel: Pixel::Unlit }];
        assert_eq!(estimate(&sample, &truth, &[1.0]), Estimate::default());
    }
}
