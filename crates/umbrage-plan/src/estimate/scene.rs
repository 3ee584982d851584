//! A camera's view of a scene, on which techniques are tried.

use crate::{
    MeasureError,
    cost::CostModel,
    truth::{PixelTruth, Progress, TruthOptions, TruthRequest, trace_pixels},
};
use std::collections::HashMap;
use umbrage_core::{
    Backend as _, BackendError, Camera, FitMemory, Geometry, Light, Receivers, Recipe, RecipeError,
    View, Work,
};
use umbrage_cpu::Cpu;
use umbrage_techniques::TechniquePreset;

/// A camera's view of a scene, ready to have techniques tried on it.
pub(crate) struct PlanScene<'a> {
    pub(crate) camera: &'a Camera,
    pub(crate) light: &'a Light,
    pub(crate) geometry: &'a Geometry,
    pub(crate) receivers: Receivers,
    cpu: Cpu,
    /// Light spaces found before: the maps of many settings lie alike.
    fits: FitMemory,
    /// Truth by pixel index, as far as it was traced.
    pub(crate) truth: HashMap<u32, PixelTruth>,
}

/// The cost of a setting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Price {
    pub(crate) milliseconds: f64,
    pub(crate) work: Work,
}

impl<'a> PlanScene<'a> {
    /// Finds the receivers that the camera sees.
    ///
    /// # Errors
    /// Errors if the backend can't find receivers.
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

    /// Returns the view that techniques plan for. It has all receivers, not the sampled ones alone, so that maps lie as they
    /// will in the program.
    pub(crate) fn view(&self) -> View<'_> {
        View::new(self.camera, self.light, self.geometry)
            .with_receivers(&self.receivers)
            .with_fits(&self.fits)
    }

    pub(crate) fn recipe(&self, preset: &TechniquePreset) -> Result<Recipe, RecipeError> {
        preset.technique().recipe(&self.view())
    }

    pub(crate) fn price(&self, recipe: &Recipe, cost: &CostModel) -> Price {
        let work = Work::of(&self.view(), recipe);
        Price {
            milliseconds: cost.milliseconds(&work),
            work,
        }
    }

    /// Renders the mask of the whole image.
    pub(crate) fn mask(&mut self, recipe: &Recipe) -> Result<Vec<f32>, BackendError> {
        let view =
            View::new(self.camera, self.light, self.geometry).with_receivers(&self.receivers);
        Ok(self.cpu.render(&view, recipe)?.mask)
    }

    /// Renders the mask of a preset over the whole image.
    pub(crate) fn preset_mask(
        &mut self,
        preset: &TechniquePreset,
    ) -> Result<Vec<f32>, MeasureError> {
        let recipe = self.recipe(preset)?;
        Ok(self.mask(&recipe)?)
    }

    /// Renders the mask at some pixels, bit by bit as in the whole image.
    pub(crate) fn mask_at(
        &mut self,
        recipe: &Recipe,
        pixels: &[u32],
    ) -> Result<Vec<f32>, BackendError> {
        let view =
            View::new(self.camera, self.light, self.geometry).with_receivers(&self.receivers);
        self.cpu.render_pixels(&view, recipe, pixels)
    }

    /// Returns truth at some pixels. Pixels that were traced before are not traced again, so `options` must always be the same.
    pub(crate) fn truth_at(
        &mut self,
        pixels: &[u32],
        options: &TruthOptions,
        progress: &Progress<'_>,
    ) -> Result<Vec<PixelTruth>, MeasureError> {
        let new: Vec<u32> = pixels
            .iter()
            .copied()
            .filter(|i| !self.truth.contains_key(i))
            .collect();
        let request = TruthRequest {
            camera: self.camera,
            geometry: self.geometry,
            receivers: &self.receivers,
            pixels: &new,
        };
        let traced = trace_pixels(
            &request,
            self.light,
            options,
            &mut |camera, geometry| self.cpu.receivers(camera, geometry),
            progress,
        )?;
        self.truth.extend(new.into_iter().zip(traced));
        Ok(pixels.iter().map(|i| self.truth[i]).collect())
    }

    /// Returns the number of pixels whose truth was traced.
    pub(crate) fn traced(&self) -> usize {
        self.truth.len()
    }
}
