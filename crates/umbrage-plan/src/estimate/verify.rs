//! Second estimate of a setting that may be chosen, to find errors that the first sample missed.
//!
//! All settings share the first sample. It can miss errors of a few settings at points where the
//! pilot shows nothing. The second sample is drawn for one setting, mostly where the whole image's
//! mask differs from the pilot.
//!
//! Under ideal lights the pilot is truth, so errors occur only where the mask differs from it.
//! Under other lights its few rays are noisy. If a mask's error is 0 on the whole sample, the few
//! rays may have missed what many would find. If `count` of all n rays found an error, at most
//! `poisson_upper_limit(count) / n` of the light is wrong on average, except in one of twenty
//! cases.

use super::{
    density::{Pilot, normalize_interest},
    error::{CountedPixels, Estimate, Part, estimate, estimate_of_part, upper_limit_of_sum},
    sample::PixelSample,
    sampled_truth::{Coverage, SampledTruth, Sampling},
    scene::PlanScene,
};
use crate::{
    error::MeasureError,
    progress::{OnStep, Step},
};
use umbrage_core::Recipe;

/// Sizes of second samples, as multiples of the first sample's. They are drawn in sequence until a
/// bound is decided: each halves the uncertainty.
const SIZES: [usize; 3] = [1, 4, 16];

/// Sampler for second samples.
#[derive(Clone, Debug)]
pub(crate) struct Verifier {
    /// `None` if the scene can't be traced.
    pub(crate) pilot: Option<Pilot>,
    /// [`PlanScene::lit_pixels`] of each pixel.
    pub(crate) lit: Vec<bool>,
    pub(crate) sampling: Sampling,
}

/// Setting that may be chosen.
pub(crate) struct Contender<'a> {
    pub(crate) recipe: &'a Recipe,
    /// The estimate from the first sample.
    pub(crate) first: Estimate,
    /// Greatest allowed error, if any.
    pub(crate) bound: Option<f64>,
}

impl Verifier {
    /// Estimates the error of a contender from its own samples: from the first of [`SIZES`], and
    /// from the others until the bound is decided.
    pub(crate) fn estimate(
        &self,
        scene: &mut PlanScene<'_>,
        first_sample: &SampledTruth,
        contender: &Contender<'_>,
        on_step: &OnStep<'_>,
    ) -> Result<Estimate, MeasureError> {
        let Some(pilot) = &self.pilot else {
            return Ok(without_pilot(first_sample, contender.first));
        };
        // Find the pixels at which the mask differs from the pilot.
        let mask = scene.mask(contender.recipe)?;
        let differences = differences(&mask, &pilot.mask, &self.lit);
        // True if errors are possible only where mask and pilot differ.
        let nowhere_else = pilot.is_exact || contender.first.error == 0.0;
        let density = if nowhere_else {
            differences
                .iter()
                .map(|d| f64::from(u8::from(*d > 0.0)))
                .collect()
        } else {
            let interest = differences.iter().map(|d| f64::from(*d)).collect();
            normalize_interest(interest, &self.lit)
        };
        let mut found = contender.first;
        // Draw samples of increasing size.
        for (k, times) in (0..).zip(SIZES) {
            let sample = PixelSample::draw(
                scene.camera.size,
                &density,
                times * self.sampling.count,
                self.sampling.seed.wrapping_add(k),
            )
            .with_weights(&scene.weights);
            let is_whole = sample.chances.iter().all(|chance| *chance == 1.0);
            let greatest_share = if is_whole {
                0.0
            } else {
                greatest_share(&sample, &density, &scene.weights)
            };
            let second = self.truth_of(scene, sample, on_step)?;
            let mask_there: Vec<f32> = second
                .sample
                .pixels
                .iter()
                .map(|&i| mask[i as usize])
                .collect();
            found = if nowhere_else {
                let all = first_sample.counted;
                let unseen = unseen_error(pilot, &second, &mask_there, first_sample.coverage)
                    * self.greatest_weight_over_mean(scene, all);
                let part = Part {
                    all,
                    greatest_share,
                    unseen,
                };
                estimate_of_part(&second.sample, &second.truth, &mask_there, part)
            } else {
                estimate(&second.sample, &second.truth, &mask_there)
            };
            let is_decided = contender
                .bound
                .is_none_or(|bound| found.is_surely_within(bound) || found.is_surely_above(bound));
            if is_whole || is_decided {
                break;
            }
        }
        Ok(found)
    }

    /// Returns the ratio of the greatest weight to the mean weight of the pixels that count, or 1
    /// with equal weights. An unseen error may be at the pixel with the greatest weight.
    fn greatest_weight_over_mean(&self, scene: &PlanScene<'_>, counted: CountedPixels) -> f64 {
        let greatest = scene.weights.iter().copied().fold(0.0, f64::max);
        let lit = self.lit.iter().filter(|lit| **lit).count();
        let mean = counted.count / lit.max(1) as f64;
        if mean > 0.0 && scene.is_weighted() {
            greatest / mean
        } else {
            1.0
        }
    }

    /// Traces the truth of a sample.
    fn truth_of(
        &self,
        scene: &mut PlanScene<'_>,
        sample: PixelSample,
        on_step: &OnStep<'_>,
    ) -> Result<SampledTruth, MeasureError> {
        let truth = scene.truth_at(&sample.pixels, &self.sampling.truth, &|done, total| {
            on_step(Step::Truth(done, total))
        })?;
        Ok(SampledTruth::new(sample, truth))
    }
}

/// Returns |mask - pilot| at each pixel, and 0 outside the lit receivers, which don't count. There,
/// techniques may differ from the pilot everywhere, and would use up the sample.
fn differences(mask: &[f32], pilot: &[f32], lit: &[bool]) -> Vec<f32> {
    (0..mask.len())
        .map(|i| {
            if lit[i] {
                (mask[i] - pilot[i]).abs()
            } else {
                0.0
            }
        })
        .collect()
}

/// Returns the greatest weight over chance of the pixels that can be drawn with these densities.
fn greatest_share(sample: &PixelSample, density: &[f64], weights: &[f64]) -> f64 {
    let least_chance = sample.chances.iter().copied().fold(1.0, f64::min);
    let of_drawable = density.iter().zip(weights).filter(|(d, _)| **d > 0.0);
    let greatest_weight = of_drawable.map(|(_, weight)| *weight).fold(0.0, f64::max);
    greatest_weight / least_chance
}

/// Returns the greatest mean square error that the pilot's rays may have missed where they agree
/// with the mask, or 0 if they are exact.
fn unseen_error(
    pilot: &Pilot,
    second: &SampledTruth,
    mask_there: &[f32],
    coverage: Coverage,
) -> f64 {
    let pixels = coverage.certain + coverage.certain_margin;
    let rays = f64::from(pilot.rays) * pixels as f64;
    if pilot.is_exact || rays == 0.0 {
        return 0.0;
    }
    let faults: f64 = (0..mask_there.len())
        .filter(|&k| second.truth[k].visibility != mask_there[k])
        .map(|k| 1.0 / second.sample.chances[k])
        .sum();
    // Differences are at most 1, so their squares are no greater.
    poisson_upper_limit(faults) / rays
}

/// Returns the first sample's estimate if there is no pilot. If its error is 0, the upper limit
/// assumes that all wrong pixels have the least chance to be drawn.
fn without_pilot(known: &SampledTruth, first: Estimate) -> Estimate {
    let min_chance = known.sample.chances.iter().copied().fold(1.0, f64::min);
    let all = known.coverage.certain as f64;
    if first.error > 0.0 || min_chance == 1.0 || all == 0.0 {
        return first;
    }
    Estimate {
        high: (poisson_upper_limit(0.0) / (min_chance * all)).sqrt(),
        ..first
    }
}

/// Returns the upper limit, with 95 % confidence, of the mean of a Poisson distribution after
/// `count` events: 3 for 0 ("rule of three"). It is accurate to 1 % (Byar's approximation: Breslow
/// and Day 1987, "Statistical methods in cancer research", volume 2).
fn poisson_upper_limit(count: f64) -> f64 {
    upper_limit_of_sum(count, count, 1.0)
}

#[cfg(test)]
mod tests {
    use super::poisson_upper_limit;

    /// Tables of the Poisson distribution: 95 % one-sided.
    #[test]
    fn upper_limits_are_those_of_tables() {
        for (count, limit) in [(0.0, 2.996), (1.0, 4.744), (5.0, 10.513), (20.0, 29.062)] {
            assert!(
                (poisson_upper_limit(count) / limit - 1.0).abs() < 0.01,
                "{count}: {}",
                poisson_upper_limit(count)
            );
        }
    }
}
