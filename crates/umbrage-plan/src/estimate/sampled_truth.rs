//! A sample of the image and the truth there.

use super::{
    error::{CountedPixels, Estimate, estimate},
    sample::PixelSample,
    scene::PlanScene,
};
use crate::{
    MeasureError,
    progress::{OnStep, Step},
    truth::{PixelTruth, TruthOptions},
};
use umbrage_core::{BackendError, Recipe, metrics::Pixel};

/// How samples are drawn and their truth is traced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sampling {
    /// About how many pixels are drawn.
    pub(crate) count: usize,
    pub(crate) seed: u32,
    pub(crate) truth: TruthOptions,
}

impl Sampling {
    /// Returns the sampling of second samples: with another seed, so that what was chosen by the first is judged without favour.
    pub(crate) fn second(&self) -> Self {
        Self {
            seed: self.seed.wrapping_add(0x9e37_79b9),
            ..*self
        }
    }
}

/// The sampled pixels that count, and truth there.
#[derive(Clone, Debug)]
pub(crate) struct SampledTruth {
    pub(crate) sample: PixelSample,
    /// In the order of the sample's pixels.
    pub(crate) truth: Vec<PixelTruth>,
    /// How many pixels of the whole image count; 0 if the sample is of a part of the image alone.
    pub(crate) counted: CountedPixels,
}

impl SampledTruth {
    /// Keeps the pixels of a sample that count.
    pub(crate) fn new(sample: PixelSample, truth: Vec<PixelTruth>) -> Self {
        let kept: Vec<usize> = (0..truth.len())
            .filter(|&k| truth[k].pixel == Pixel::Counted)
            .collect();
        let sample = PixelSample {
            pixels: kept.iter().map(|&k| sample.pixels[k]).collect(),
            chances: kept.iter().map(|&k| sample.chances[k]).collect(),
        };
        Self {
            sample,
            truth: kept.into_iter().map(|k| truth[k]).collect(),
            counted: CountedPixels::default(),
        }
    }

    /// Draws a sample of all receivers in proportion to `density` (one a pixel), and traces its truth.
    pub(crate) fn draw(
        scene: &mut PlanScene<'_>,
        density: &[f64],
        sampling: &Sampling,
        on_step: &OnStep<'_>,
    ) -> Result<Self, MeasureError> {
        let sample = PixelSample::draw(scene.camera.size, density, sampling.count, sampling.seed);
        let truth = scene.truth_at(&sample.pixels, &sampling.truth, &|done, total| {
            on_step(Step::Truth(done, total))
        })?;
        let receives = &scene.receivers.receives;
        let receivers = receives.iter().filter(|receives| **receives).count();
        let drawn = sample
            .chances
            .iter()
            .zip(&truth)
            .map(|(chance, truth)| (*chance, truth.pixel == Pixel::Counted));
        let counted = CountedPixels::estimate(receivers, drawn);
        Ok(Self {
            counted,
            ..Self::new(sample, truth)
        })
    }

    /// Estimates the error of a recipe from the sampled pixels alone.
    pub(crate) fn estimate(
        &self,
        scene: &mut PlanScene<'_>,
        recipe: &Recipe,
    ) -> Result<Estimate, BackendError> {
        let mask = scene.mask_at(recipe, &self.sample.pixels)?;
        Ok(estimate(&self.sample, &self.truth, &mask))
    }
}
