//! A sample of the image and the truth there.

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

/// How samples are drawn and their truth is traced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sampling {
    /// About how many pixels are drawn.
    pub(crate) count: usize,
    pub(crate) seed: u32,
    pub(crate) truth: TruthOptions,
}

impl Sampling {
    /// Returns the sampling of second samples: with another seed, so that what was chosen by the
    /// first is judged without favour.
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
    /// How many pixels of the whole image count, by their weights; 0 if the sample is of a part of
    /// the image alone.
    pub(crate) counted: CountedPixels,
    /// How many of the image's pixels are of which class.
    pub(crate) coverage: Coverage,
}

/// For how many of an image's pixels a plan holds, estimated from its sample.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Coverage {
    /// All pixels of the image, of all cameras together.
    pub pixels: u64,
    /// Those that show what receives shadows.
    pub receivers: u64,
    /// Those of them whose truth is certain: what the plan's error is about.
    pub certain: u64,
    /// One in twenty counts of `certain` differs by more than this.
    pub certain_margin: u64,
    /// Those whose truth depends on how a program rounds ([`Pixel::Ambiguous`]): the plan promises
    /// nothing there.
    pub ambiguous: u64,
    /// Those that face away from the light or lie outside its cone, where no technique is asked.
    pub unlit: u64,
    /// Those whose truth was traced; of the others that are lit the sample tells.
    pub traced: u64,
}

impl Coverage {
    /// Returns the sums of both.
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
    pub fn unsampled(&self) -> u64 {
        self.receivers.saturating_sub(self.unlit + self.traced)
    }
}

impl SampledTruth {
    /// Keeps the pixels of a sample that count.
    pub(crate) fn new(sample: PixelSample, truth: Vec<PixelTruth>) -> Self {
        let kept: Vec<usize> = (0..truth.len())
            .filter(|&k| truth[k].pixel == Pixel::Counted)
            .collect();
        let sample = sample.kept(&kept);
        Self {
            sample,
            truth: kept.into_iter().map(|k| truth[k]).collect(),
            counted: CountedPixels::default(),
            coverage: Coverage::default(),
        }
    }

    /// Draws a sample of all [lit](PlanScene::lit) receivers in proportion to `density` (one a
    /// pixel; above 0 at each of them, and 0 elsewhere), and traces its truth.
    pub(crate) fn draw(
        scene: &mut PlanScene<'_>,
        density: &[f64],
        sampling: &Sampling,
        on_step: &OnStep<'_>,
    ) -> Result<Self, MeasureError> {
        let sample = PixelSample::draw(scene.camera.size, density, sampling.count, sampling.seed)
            .weighted(&scene.weights);
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

/// Returns how many of an image's pixels are of which class, estimated from a sample of its `lit`
/// receivers and the truth there.
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
