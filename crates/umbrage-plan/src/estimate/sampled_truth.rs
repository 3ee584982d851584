//! Sample of the image and its truth.

use super::{
    error::{CountedPixels, Estimate, estimate},
    sample::PixelSample,
    scene::PlanScene,
};
use crate::{
    error::MeasureError,
    progress::{OnStep, Step},
    truth::{PixelTruth, TruthOptions},
};
use serde::{Deserialize, Serialize};
use umbrage_core::{BackendError, Receivers, Recipe, metrics::Pixel};

/// Options for drawing samples and tracing their truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sampling {
    /// Approximate number of pixels drawn.
    pub(crate) count: usize,
    pub(crate) seed: u32,
    pub(crate) truth: TruthOptions,
}

impl Sampling {
    /// Returns the sampling of second samples. It has another seed, so that the choice by the first
    /// sample does not bias the second.
    pub(crate) fn second(&self) -> Self {
        Self {
            seed: self.seed.wrapping_add(0x9e37_79b9),
            ..*self
        }
    }
}

/// Sampled pixels that count, with their truth.
#[derive(Clone, Debug)]
pub(crate) struct SampledTruth {
    pub(crate) sample: PixelSample,
    /// Truth in the order of the sample's pixels.
    pub(crate) truth: Vec<PixelTruth>,
    /// Weighted number of pixels of the whole image that count; 0 if the sample covers only a part
    /// of the image.
    pub(crate) counted: CountedPixels,
    /// Number of the image's pixels in each class.
    pub(crate) coverage: Coverage,
}

/// Number of an image's pixels for which a plan holds, estimated from its sample.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Coverage {
    /// All pixels of the images of all cameras.
    pub pixels: u64,
    /// Pixels that show receivers.
    pub receivers: u64,
    /// Receivers whose truth is certain. The plan's error covers these.
    pub certain: u64,
    /// One in twenty counts of `certain` differs by more than this.
    pub certain_margin: u64,
    /// Receivers whose truth depends on rounding ([`Pixel::Ambiguous`]). The plan makes no
    /// statement about them.
    pub ambiguous: u64,
    /// Receivers that face away from the light or are outside its cone. They are not evaluated.
    pub unlit: u64,
    /// Receivers whose truth was traced. The sample estimates the other lit ones.
    pub traced: u64,
}

impl Coverage {
    /// Returns the field-wise sum.
    pub(crate) fn plus(self, other: Self) -> Self {
        Self {
            pixels: self.pixels + other.pixels,
            receivers: self.receivers + other.receivers,
            certain: self.certain + other.certain,
            certain_margin: self.certain_margin + other.certain_margin,
            ambiguous: self.ambiguous + other.ambiguous,
            unlit: self.unlit + other.unlit,
            traced: self.traced + other.traced,
        }
    }

    /// Returns the number of receivers that are lit and whose truth was not traced.
    pub fn unsampled_pixels(&self) -> u64 {
        self.receivers.saturating_sub(self.unlit + self.traced)
    }
}

impl SampledTruth {
    /// Creates the sampled truth from the pixels of a sample that count.
    pub(crate) fn new(sample: PixelSample, truth: Vec<PixelTruth>) -> Self {
        let kept: Vec<usize> = (0..truth.len())
            .filter(|&k| truth[k].pixel == Pixel::Counted)
            .collect();
        let sample = sample.keep_places(&kept);
        Self {
            sample,
            truth: kept.into_iter().map(|k| truth[k]).collect(),
            counted: CountedPixels::default(),
            coverage: Coverage::default(),
        }
    }

    /// Draws a sample of all [lit](PlanScene::lit_pixels) receivers in proportion to `density`, and
    /// traces its truth. `density` has one number a pixel: above 0 at lit receivers, and 0
    /// elsewhere.
    pub(crate) fn draw(
        scene: &mut PlanScene<'_>,
        density: &[f64],
        sampling: &Sampling,
        on_step: &OnStep<'_>,
    ) -> Result<Self, MeasureError> {
        let sample = PixelSample::draw(scene.camera.size, density, sampling.count, sampling.seed)
            .with_weights(&scene.weights);
        let truth = scene.truth_at(&sample.pixels, &sampling.truth, &|done, total| {
            on_step(Step::Truth(done, total))
        })?;
        let lit: Vec<usize> = (0..density.len()).filter(|&i| density[i] > 0.0).collect();
        let lit_weight = lit.iter().map(|&i| scene.weights[i]).sum();
        let drawn = (0..truth.len()).map(|k| {
            let counts = truth[k].pixel == Pixel::Counted;
            (sample.chances[k], sample.weights[k], counts)
        });
        let counted = CountedPixels::estimate(lit_weight, drawn);
        let coverage = coverage(&scene.receivers, lit.len(), &sample, &truth);
        Ok(Self {
            counted,
            coverage,
            ..Self::new(sample, truth)
        })
    }

    /// Estimates the error of a recipe from the sampled pixels only.
    pub(crate) fn estimate(
        &self,
        scene: &mut PlanScene<'_>,
        recipe: &Recipe,
    ) -> Result<Estimate, BackendError> {
        let mask = scene.mask_at(recipe, &self.sample.pixels)?;
        Ok(estimate(&self.sample, &self.truth, &mask))
    }
}

/// Returns the number of an image's pixels in each class, estimated from a sample of its `lit`
/// receivers with their truth.
fn coverage(
    receivers: &Receivers,
    lit: usize,
    sample: &PixelSample,
    truth: &[PixelTruth],
) -> Coverage {
    let receiving = receivers.receives.iter().filter(|r| **r).count();
    let of_class = |class: Pixel| {
        let drawn = (0..truth.len()).map(|k| (sample.chances[k], 1.0, truth[k].pixel == class));
        CountedPixels::estimate(lit as f64, drawn)
    };
    let certain = of_class(Pixel::Counted);
    let rounded = |count: f64| count.round() as u64;
    Coverage {
        pixels: receivers.len() as u64,
        receivers: receiving as u64,
        certain: rounded(certain.count),
        certain_margin: rounded(certain.margin),
        ambiguous: rounded(of_class(Pixel::Ambiguous).count),
        unlit: (receiving - lit) as u64,
        traced: truth.len() as u64,
    }
}
