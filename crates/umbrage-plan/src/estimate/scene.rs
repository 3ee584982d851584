//! What is seen, and how techniques are tried on it.

use super::{
    error::{Counted, Estimate, estimate},
    sample::Sample,
};
use crate::{
    MeasureError,
    cost::CostModel,
    truth::{PixelTruth, TruthOptions, trace_pixels},
};
use std::collections::HashMap;
use umbrage_core::{
    Backend as _, BackendError, Camera, FitMemory, Geometry, Light, PlanError, Receivers, Recipe,
    View, Work, metrics::Pixel,
};
use umbrage_cpu::Cpu;
use umbrage_techniques::Preset;

/// A camera's view of a scene, ready to have techniques tried on it.
pub(crate) struct Look<'a> {
    pub(crate) camera: &'a Camera,
    pub(crate) light: &'a Light,
    pub(crate) geometry: &'a Geometry,
    pub(crate) receivers: Receivers,
    pub(crate) cpu: Cpu,
    /// Many settings' maps lie alike.
    fits: FitMemory,
    /// By pixel, as far as it was traced.
    pub(crate) truth: HashMap<u32, PixelTruth>,
}

/// What a setting costs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Price {
    pub(crate) milliseconds: f64,
    pub(crate) work: Work,
}

impl<'a> Look<'a> {
    pub(crate) fn new(
        camera: &'a Camera,
        light: &'a Light,
        geometry: &'a Geometry,
    ) -> Result<Self, MeasureError> {
        let mut cpu = Cpu::new();
        let receivers = cpu.receivers(camera, geometry)?;
        Ok(Self {
            camera,
            light,
            geometry,
            receivers,
            cpu,
            fits: FitMemory::default(),
            truth: HashMap::new(),
        })
    }

    /// What a technique may look at: all receivers, so that its map lies as it will.
    pub(crate) fn view(&self) -> View<'_> {
        View::new(self.camera, self.light, self.geometry)
            .with_receivers(&self.receivers)
            .with_fits(&self.fits)
    }

    pub(crate) fn recipe(&self, preset: &Preset) -> Result<Recipe, PlanError> {
        preset.technique().plan(&self.view())
    }

    pub(crate) fn price(&self, recipe: &Recipe, cost: &CostModel) -> Price {
        let work = Work::of(&self.view(), recipe);
        Price {
            milliseconds: cost.milliseconds(&work),
            work,
        }
    }

    /// The whole image's mask.
    pub(crate) fn mask(&mut self, preset: &Preset) -> Result<Vec<f32>, MeasureError> {
        let recipe = self.recipe(preset)?;
        Ok(self.render(&recipe)?)
    }

    /// As [`Look::mask`], by recipe.
    pub(crate) fn render(&mut self, recipe: &Recipe) -> Result<Vec<f32>, BackendError> {
        let view =
            View::new(self.camera, self.light, self.geometry).with_receivers(&self.receivers);
        Ok(self.cpu.render(&view, recipe)?.mask)
    }

    /// The mask at some pixels.
    pub(crate) fn ask(
        &mut self,
        recipe: &Recipe,
        pixels: &[u32],
    ) -> Result<Vec<f32>, BackendError> {
        let view =
            View::new(self.camera, self.light, self.geometry).with_receivers(&self.receivers);
        self.cpu.ask(&view, recipe, pixels)
    }

    /// Truth at some pixels; what was traced before is remembered. `options` are always the same.
    pub(crate) fn truth(
        &mut self,
        pixels: &[u32],
        options: &TruthOptions,
        progress: &crate::truth::Progress<'_>,
    ) -> Result<Vec<PixelTruth>, MeasureError> {
        let Self {
            camera,
            light,
            geometry,
            receivers,
            cpu,
            truth,
            ..
        } = self;
        let new: Vec<u32> = pixels
            .iter()
            .copied()
            .filter(|i| !truth.contains_key(i))
            .collect();
        let find = &mut |camera: &Camera, geometry: &Geometry| cpu.receivers(camera, geometry);
        let traced = trace_pixels(
            (camera, light, geometry, receivers),
            &new,
            options,
            find,
            progress,
        )?;
        truth.extend(new.into_iter().zip(traced));
        Ok(pixels.iter().map(|i| truth[i]).collect())
    }
}

/// A sample of an image and the truth there.
#[derive(Clone, Debug)]
pub(crate) struct Known {
    pub(crate) sample: Sample,
    pub(crate) truth: Vec<PixelTruth>,
    /// Of all receivers; none if the sample isn't of all.
    pub(crate) counted: Counted,
}

impl Known {
    /// Only the pixels that count.
    pub(crate) fn new(sample: Sample, truth: Vec<PixelTruth>) -> Self {
        let counts = |k: &usize| truth[*k].pixel == Pixel::Counted;
        let kept: Vec<usize> = (0..truth.len()).filter(counts).collect();
        let pixels = kept.iter().map(|&k| sample.pixels[k]).collect();
        let chances = kept.iter().map(|&k| sample.chances[k]).collect();
        let sample = Sample { pixels, chances };
        Self {
            sample,
            truth: kept.into_iter().map(|k| truth[k]).collect(),
            counted: Counted::default(),
        }
    }

    /// As [`Known::new`], of a sample of all of so many receivers: how many count is then known, too.
    pub(crate) fn of_all(receivers: usize, sample: Sample, truth: Vec<PixelTruth>) -> Self {
        let drawn = sample
            .chances
            .iter()
            .zip(&truth)
            .map(|(chance, t)| (*chance, t.pixel == Pixel::Counted));
        let counted = Counted::of(receivers, drawn);
        Self {
            counted,
            ..Self::new(sample, truth)
        }
    }

    /// A recipe's errors.
    pub(crate) fn ask(
        &self,
        look: &mut Look<'_>,
        recipe: &Recipe,
    ) -> Result<Estimate, BackendError> {
        let mask = look.ask(recipe, &self.sample.pixels)?;
        Ok(estimate(&self.sample, &self.truth, &mask))
    }
}
