//! View of a camera on which techniques are evaluated.

use super::weighting::Weighting;
use crate::{
    catalogue::Catalogue,
    cost::{CostModel, Work},
    error::MeasureError,
    motion::follows_camera,
    truth::{PixelTruth, Progress, TruthOptions, TruthRequest, trace_pixels, unlit_pixels},
};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use umbrage_core::{
    Backend as _, BackendError, Camera, FitMemory, Geometry, Light, Receivers, Recipe, RecipeError,
    View,
};
use umbrage_cpu::Cpu;
use umbrage_techniques::TechniquePreset;

/// View of a camera, ready for the evaluation of techniques.
pub(crate) struct PlanScene<'a> {
    pub(crate) camera: &'a Camera,
    pub(crate) light: &'a Light,
    pub(crate) geometry: &'a Geometry,
    pub(crate) receivers: Receivers,
    /// Weight of each pixel's error, 0 or more; 1 on average over the receivers.
    pub(crate) weights: Vec<f64>,
    weighting: Weighting,
    cpu: Cpu,
    renderer: RendererData,
    /// Light spaces found before: many settings share their map's position.
    fits: FitMemory,
    /// Truth by pixel index, for the pixels traced so far.
    pub(crate) truth: HashMap<u32, PixelTruth>,
}

/// Data that the program which executes a plan has when it builds recipes.
///
/// Plans are made for the recipes that this program will build. Fits can't use unknown data, and
/// techniques that need it are not candidates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RendererData {
    /// Triangles on the CPU, and the points visible to the camera. Few programs read these back
    /// from the GPU.
    SeenPoints,
    /// Triangles on the CPU: [`View::new`].
    #[default]
    Triangles,
    /// A box around the casters, with the triangles on the GPU only. This excludes techniques that
    /// build faces or hierarchies from triangles (planar shadows, volumes, rays).
    CasterBox,
    /// A light set that gets no triangles on the CPU. Like [`CasterBox`](Self::CasterBox), with
    /// techniques whose hierarchy the device builds (`exact`).
    LightSet,
}

/// Cost of a setting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Price {
    /// Cost of casts and filters, milliseconds.
    pub(crate) draw_ms: f64,
    /// Cost of the lookup, milliseconds.
    pub(crate) lookup_ms: f64,
    pub(crate) work: Work,
}

impl<'a> PlanScene<'a> {
    /// Finds the receivers visible to the camera.
    ///
    /// # Errors
    /// Errors if the backend can't find receivers.
    pub(crate) fn new(
        camera: &'a Camera,
        light: &'a Light,
        geometry: &'a Geometry,
        weighting: Weighting,
    ) -> Result<Self, MeasureError> {
        let mut cpu = Cpu::new();
        let receivers = cpu.receivers(camera, geometry)?;
        Ok(Self {
            camera,
            light,
            geometry,
            weights: weighting.weights(light, &receivers),
            weighting,
            receivers,
            cpu,
            renderer: RendererData::default(),
            fits: FitMemory::default(),
            truth: HashMap::new(),
        })
    }

    /// Returns whether pixels have different weights.
    pub(crate) fn is_weighted(&self) -> bool {
        self.weighting != Weighting::Even
    }

    /// Sets the data that recipes are built from. Returns whether it changed.
    pub(crate) fn make_recipes_from(&mut self, renderer: RendererData) -> bool {
        if self.renderer == renderer {
            return false;
        }
        self.renderer = renderer;
        self.fits = FitMemory::default();
        true
    }

    /// Returns the view that techniques plan for, with the program's data.
    pub(crate) fn view(&self) -> View<'_> {
        self.view_of(self.camera, &self.receivers)
            .with_fits(&self.fits)
    }

    /// Returns the view of a camera with these receivers, limited to the program's data.
    fn view_of<'b>(&'b self, camera: &'b Camera, receivers: &'b Receivers) -> View<'b> {
        let view = View::new(camera, self.light, self.geometry);
        match self.renderer {
            RendererData::SeenPoints => view.with_receivers(receivers),
            RendererData::Triangles => view,
            RendererData::CasterBox | RendererData::LightSet => View {
                geometry: None,
                ..view
            },
        }
    }

    pub(crate) fn recipe(&self, preset: &TechniquePreset) -> Result<Recipe, RecipeError> {
        self.recipe_from(preset, &self.view())
    }

    /// Returns the recipe for a view with the program's data.
    fn recipe_from(
        &self,
        preset: &TechniquePreset,
        view: &View<'_>,
    ) -> Result<Recipe, RecipeError> {
        let technique = preset.technique();
        let recipe = technique.recipe(view);
        let is_built = || {
            self.renderer == RendererData::LightSet && technique.device_recipe(view, None).is_some()
        };
        if recipe.is_ok() || !is_built() {
            return recipe;
        }
        // The set's device builds the hierarchy of the same casters.
        let view = View {
            geometry: Some(self.geometry),
            ..*view
        };
        let with_triangles = technique.recipe(&view)?;
        match with_triangles.hierarchy {
            Some(_) => Ok(with_triangles),
            None => recipe,
        }
    }

    /// Returns the recipe for another camera, from the program's data.
    pub(crate) fn recipe_for(
        &self,
        preset: &TechniquePreset,
        camera: &Camera,
        receivers: &Receivers,
    ) -> Result<Recipe, RecipeError> {
        self.recipe_from(preset, &self.view_of(camera, receivers))
    }

    /// Finds the receivers visible to another camera, if the program will have them. Otherwise
    /// returns none.
    pub(crate) fn seen_by(&mut self, camera: &Camera) -> Result<Receivers, BackendError> {
        match self.renderer {
            RendererData::SeenPoints => self.cpu.receivers(camera, self.geometry),
            RendererData::Triangles | RendererData::CasterBox | RendererData::LightSet => {
                Ok(Receivers::empty(camera.size))
            }
        }
    }

    /// Returns whether the images of a preset change as the camera moves.
    pub(crate) fn follows_camera(&self, preset: &TechniquePreset, recipe: &Recipe) -> bool {
        follows_camera(&*preset.technique(), recipe, &self.view())
    }

    /// Returns the view that the backend executes, with all data that it needs.
    pub(crate) fn rendered_view(&self) -> View<'_> {
        View::new(self.camera, self.light, self.geometry).with_receivers(&self.receivers)
    }

    pub(crate) fn price(&self, recipe: &Recipe, cost: &CostModel, catalogue: &Catalogue) -> Price {
        let work = Work::of_recipe(&self.rendered_view(), recipe, catalogue);
        let lookup_ms = cost.lookup_milliseconds(&work);
        Price {
            draw_ms: cost.milliseconds(&work) - lookup_ms,
            lookup_ms,
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

    /// Renders the mask at some pixels, with the bits of the whole image.
    pub(crate) fn mask_at(
        &mut self,
        recipe: &Recipe,
        pixels: &[u32],
    ) -> Result<Vec<f32>, BackendError> {
        let view =
            View::new(self.camera, self.light, self.geometry).with_receivers(&self.receivers);
        self.cpu.render_pixels(&view, recipe, pixels)
    }

    /// Renders the mask at some pixels of other receivers of the same image size.
    pub(crate) fn mask_at_receivers(
        &mut self,
        recipe: &Recipe,
        receivers: &Receivers,
        pixels: &[u32],
    ) -> Result<Vec<f32>, BackendError> {
        let view = View::new(self.camera, self.light, self.geometry).with_receivers(receivers);
        self.cpu.render_pixels(&view, recipe, pixels)
    }

    /// Returns for each pixel whether it shows a receiver that the light may reach: truth is not
    /// [`Pixel::Unlit`](umbrage_core::metrics::Pixel::Unlit). Other pixels count in no error.
    pub(crate) fn lit_pixels(&self, options: &TruthOptions) -> Result<Vec<bool>, MeasureError> {
        let receives = &self.receivers.receives;
        let all: Vec<u32> = (0..receives.len() as u32).collect();
        let request = TruthRequest {
            camera: self.camera,
            geometry: self.geometry,
            receivers: &self.receivers,
            pixels: &all,
        };
        let unlit = unlit_pixels(&request, self.light, options)?;
        let lit = receives.iter().zip(unlit);
        Ok(lit.map(|(receives, unlit)| *receives && !unlit).collect())
    }

    /// Returns truth at some pixels. Traced pixels are cached, so `options` must always be the
    /// same.
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
        let traced = self.trace_at(&new, options, progress)?;
        self.truth.extend(new.into_iter().zip(traced));
        Ok(pixels.iter().map(|i| self.truth[i]).collect())
    }

    /// Traces truth at some pixels with any options, without caching it.
    pub(crate) fn trace_at(
        &mut self,
        pixels: &[u32],
        options: &TruthOptions,
        progress: &Progress<'_>,
    ) -> Result<Vec<PixelTruth>, MeasureError> {
        let request = TruthRequest {
            camera: self.camera,
            geometry: self.geometry,
            receivers: &self.receivers,
            pixels,
        };
        let cpu = &mut self.cpu;
        trace_pixels(
            &request,
            self.light,
            options,
            &mut |camera, geometry| cpu.receivers(camera, geometry),
            progress,
        )
    }

    /// Returns the number of pixels whose truth was traced.
    pub(crate) fn traced_points(&self) -> usize {
        self.truth.len()
    }
}
