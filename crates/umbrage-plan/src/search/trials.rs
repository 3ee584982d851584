//! Evaluation of settings on the sample, each once.

use super::{
    bounds::Bounds,
    by_preset::{ByPreset, without_bias},
    hold::Hold,
    setting::{CameraFigures, Setting},
};
use crate::{
    catalogue::Catalogue,
    cost::CostModel,
    error::MeasureError,
    estimate::{
        error::Estimate,
        grain::GrainProbe,
        sampled_truth::{Coverage, SampledTruth},
        scene::{PlanScene, Price},
        shimmer::shimmer,
        verify::{Contender, Verifier},
    },
    motion::FrameMotion,
    progress::OnStep,
    truth::TruthOptions,
};
use umbrage_core::{BackendError, Fit, Layout, Recipe, RecipeError, ShadowTechnique as _};
use umbrage_techniques::{ShadowMap, TechniquePreset, Unshadowed};

/// View of one camera with its sample.
pub(super) struct SampledView<'a> {
    pub(super) scene: PlanScene<'a>,
    pub(super) sampled: SampledTruth,
    pub(super) verifier: Verifier,
    /// Factor on errors, so that one bound serves all cameras: 1, unless cameras have their own
    /// bounds.
    pub(super) scale: f64,
    /// Points at which grain is measured; `None` until it is first requested.
    grain: Option<GrainProbe>,
}

impl<'a> SampledView<'a> {
    pub(super) fn new(scene: PlanScene<'a>, sampled: SampledTruth, verifier: Verifier) -> Self {
        Self {
            scene,
            sampled,
            verifier,
            scale: 1.0,
            grain: None,
        }
    }

    /// Returns the grain of a recipe for this view.
    fn grain(
        &mut self,
        recipe: &Recipe,
        options: &TruthOptions,
    ) -> Result<Option<f64>, MeasureError> {
        let probe = match self.grain.take() {
            Some(probe) => probe,
            None => GrainProbe::new(&self.scene, &self.sampled, options)?,
        };
        let found = probe.grain(&mut self.scene, recipe)?;
        self.grain = Some(probe);
        Ok(found)
    }
}

/// Rules for counting costs and errors.
#[derive(Clone, Debug)]
pub(super) struct Counting {
    /// Costs of kernels.
    pub(super) catalogue: Catalogue,
    pub(super) cost: CostModel,
    pub(super) motion: FrameMotion,
    pub(super) hold: Hold,
    pub(super) truth: TruthOptions,
}

/// Cost of a setting at each camera.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Prices {
    /// Predicted time of a frame at each camera, milliseconds.
    pub(super) frames: Vec<f64>,
    /// Time of the worst camera that the plan holds for, milliseconds.
    pub(super) milliseconds: f64,
    draw_ms: f64,
    pub(super) bytes: u64,
    kept_as_camera_moves: Option<bool>,
}

/// Key of images that may follow the camera: the technique's name, and the fit and layout of its
/// map.
type DrawnPlace = (&'static str, Option<(Fit, Layout)>);

/// All evaluated settings.
pub(super) struct Trials<'a> {
    /// One per camera, at least one.
    pub(super) views: Vec<SampledView<'a>>,
    pub(super) counting: Counting,
    /// `None` if the setting is not supported.
    tried: ByPreset<Option<Setting>>,
    /// Estimates from the first sample for settings verified since, one per camera.
    first_estimates: ByPreset<Vec<Estimate>>,
    /// Prices by the preset without its bias.
    prices: ByPreset<Option<Prices>>,
    /// Flags for images that are kept as the camera moves.
    kept: Vec<(DrawnPlace, bool)>,
}

impl<'a> Trials<'a> {
    pub(super) fn new(views: Vec<SampledView<'a>>, counting: Counting) -> Self {
        Self {
            views,
            counting,
            tried: ByPreset::default(),
            first_estimates: ByPreset::default(),
            prices: ByPreset::default(),
            kept: Vec::new(),
        }
    }

    /// Prepares for bounds: sets the data that recipes are built from, and each camera's error
    /// bound.
    ///
    /// Returns the bound that serves all cameras, or `None` without one. Removes settings evaluated
    /// under other conditions.
    pub(super) fn prepare(&mut self, bounds: &Bounds) -> Result<Option<f64>, MeasureError> {
        let mut is_new = false;
        for view in &mut self.views {
            is_new |= view.scene.make_recipes_from(bounds.renderer);
        }
        let scales = self.views.iter().map(|view| view.scale).collect::<Vec<_>>();
        let limits = self.limits(bounds)?;
        // Scale errors to the strictest camera's bound.
        let strictest = limits.iter().copied().flatten().reduce(f64::min);
        for (view, limit) in self.views.iter_mut().zip(&limits) {
            view.scale = match (strictest, limit) {
                (Some(strictest), Some(limit)) if *limit > 0.0 => strictest / limit,
                _ => 1.0,
            };
        }
        is_new |= scales != self.views.iter().map(|view| view.scale).collect::<Vec<_>>();
        if is_new {
            self.forget();
        }
        Ok(strictest)
    }

    /// Returns the error bound of each camera, all `Some` or all `None`. A relative bound is 0 if
    /// no shadow at all has no error.
    fn limits(&mut self, bounds: &Bounds) -> Result<Vec<Option<f64>>, MeasureError> {
        let mut limits = Vec::new();
        for view in &mut self.views {
            let mut limit = bounds.max_error;
            if let Some(relative) = bounds.max_relative_error {
                // Use the lower limit, so that the bound holds in 19 of 20 cases.
                let least = relative * error_of_no_shadow(view)?.low;
                limit = Some(limit.map_or(least, |error| error.min(least)));
            }
            limits.push(limit);
        }
        Ok(limits)
    }

    /// Returns the sums over all cameras.
    pub(super) fn coverage(&self) -> Coverage {
        let all = self.views.iter().map(|view| view.sampled.coverage);
        let mut out = all.fold(Coverage::default(), Coverage::plus);
        out.traced = self.traced_points() as u64;
        out
    }

    /// Returns the number of pixels of all cameras whose truth was traced.
    pub(super) fn traced_points(&self) -> usize {
        self.views
            .iter()
            .map(|view| view.scene.traced_points())
            .sum()
    }

    /// Removes all evaluated settings, as if truth had changed.
    pub(super) fn forget(&mut self) {
        self.tried.clear();
        self.first_estimates.clear();
        self.prices.clear();
        self.kept.clear();
    }

    /// Returns the number of settings evaluated.
    pub(super) fn count(&self) -> usize {
        self.tried.len()
    }

    /// Returns all evaluated settings that are supported, by rising cost.
    pub(super) fn all(&self) -> Vec<&Setting> {
        let mut all: Vec<&Setting> = self.tried.values().flatten().collect();
        all.sort_by(|a, b| {
            (a.milliseconds.total_cmp(&b.milliseconds)).then_with(|| a.settings.cmp(&b.settings))
        });
        all
    }

    /// Returns the evaluated settings that differ from a setting only in their bias, by rising
    /// error.
    pub(super) fn with_other_bias(&self, setting: &Setting) -> Vec<Setting> {
        let Some(map) = setting.preset.map() else {
            return Vec::new();
        };
        let differs_in_bias_alone = |other: &&Setting| {
            let rebiased = other.preset.map().map(|own| ShadowMap {
                bias: map.bias,
                ..*own
            });
            other.preset != setting.preset
                && rebiased.is_some_and(|map| other.preset.with_map(map) == setting.preset)
        };
        let mut others: Vec<Setting> = self
            .tried
            .values()
            .flatten()
            .filter(differs_in_bias_alone)
            .cloned()
            .collect();
        others.sort_by(|a, b| {
            a.estimate
                .error
                .total_cmp(&b.estimate.error)
                .then_with(|| a.settings.cmp(&b.settings))
        });
        others
    }

    /// Returns the cost of a preset, or `None` if it is not supported at one of the cameras. A bias
    /// changes the cost only through rounding in the map's fit, so settings that differ only in
    /// bias share a price.
    pub(super) fn price(
        &mut self,
        preset: &TechniquePreset,
    ) -> Result<Option<Prices>, MeasureError> {
        let key = without_bias(preset);
        if let Some(prices) = self.prices.get(&key) {
            return Ok(prices.clone());
        }
        let recipes = self.recipes(preset)?;
        let prices = recipes.map(|recipes| self.price_of(preset, &recipes));
        self.prices.insert(key, prices.clone());
        Ok(prices)
    }

    /// Returns the recipe at each camera, or `None` if the preset is not supported at one of them.
    pub(super) fn recipes(
        &self,
        preset: &TechniquePreset,
    ) -> Result<Option<Vec<Recipe>>, MeasureError> {
        let mut recipes = Vec::new();
        for view in &self.views {
            match view.scene.recipe(preset) {
                Ok(recipe) => recipes.push(recipe),
                Err(RecipeError::Unsupported(_)) => return Ok(None),
                Err(e) => return Err(e.into()),
            }
        }
        Ok(Some(recipes))
    }

    fn price_of(&mut self, preset: &TechniquePreset, recipes: &[Recipe]) -> Prices {
        let Counting {
            ref catalogue,
            ref cost,
            motion,
            hold,
            ..
        } = self.counting;
        let prices: Vec<Price> = self
            .views
            .iter()
            .zip(recipes)
            .map(|(view, recipe)| view.scene.price(recipe, cost, catalogue))
            .collect();
        let kept_as_camera_moves =
            (motion == FrameMotion::CameraMoves).then(|| self.is_kept(preset, &recipes[0]));
        let is_kept = motion.keeps(kept_as_camera_moves);
        let frames: Vec<f64> = prices
            .iter()
            .map(|price| price.lookup_ms + if is_kept { 0.0 } else { price.draw_ms })
            .collect();
        Prices {
            milliseconds: hold.required_figure(frames.clone()),
            frames,
            draw_ms: hold.required_figure(prices.iter().map(|price| price.draw_ms).collect()),
            bytes: prices
                .iter()
                .map(|p| p.work.bytes)
                .max()
                .unwrap_or_default(),
            kept_as_camera_moves,
        }
    }

    /// Returns whether the images of a preset are kept as the camera moves. This depends only on
    /// its technique, fit and layout.
    fn is_kept(&mut self, preset: &TechniquePreset, recipe: &Recipe) -> bool {
        let fit_and_layout = preset.map().map(|map| (map.fit, map.layout));
        let place = (preset.name(), fit_and_layout);
        if let Some((_, is_kept)) = self.kept.iter().find(|(known, _)| *known == place) {
            return *is_kept;
        }
        let is_kept = !self.views[0].scene.follows_camera(preset, recipe);
        self.kept.push((place, is_kept));
        is_kept
    }

    /// Evaluates a preset on the sample. Returns `None` if it is not supported.
    pub(super) fn try_out(
        &mut self,
        preset: &TechniquePreset,
    ) -> Result<Option<Setting>, MeasureError> {
        if let Some(setting) = self.tried.get(preset) {
            return Ok(setting.clone());
        }
        let setting = self.try_new(preset)?;
        self.tried.insert(preset.clone(), setting.clone());
        Ok(setting)
    }

    fn try_new(&mut self, preset: &TechniquePreset) -> Result<Option<Setting>, MeasureError> {
        let Some(recipes) = self.recipes(preset)? else {
            return Ok(None);
        };
        let Some(prices) = self.price(preset)? else {
            return Ok(None);
        };
        let mut estimates = Vec::new();
        for (view, recipe) in self.views.iter_mut().zip(&recipes) {
            match view.sampled.estimate(&mut view.scene, recipe) {
                Ok(estimate) => estimates.push(estimate.times(view.scale)),
                // The recipe exceeds the backend's limits.
                Err(BackendError::Invalid(_)) => return Ok(None),
                Err(e) => return Err(e.into()),
            }
        }
        Ok(Some(self.setting(preset, &estimates, &prices)))
    }

    /// Returns a setting with the estimates and prices of each camera.
    fn setting(
        &self,
        preset: &TechniquePreset,
        estimates: &[Estimate],
        prices: &Prices,
    ) -> Setting {
        let mut setting = Setting {
            preset: preset.clone(),
            technique: preset.name().to_owned(),
            settings: preset.settings(),
            estimate: Estimate::default(),
            milliseconds: prices.milliseconds,
            draw_ms: prices.draw_ms,
            kept_as_camera_moves: prices.kept_as_camera_moves,
            bytes: prices.bytes,
            grain: None,
            shimmer: None,
            measured_ms: None,
            cameras: Vec::new(),
        };
        self.set_estimates(&mut setting, estimates, &prices.frames);
        setting
    }

    fn set_estimates(&self, setting: &mut Setting, estimates: &[Estimate], frames: &[f64]) {
        setting.estimate = worst_required(self.counting.hold, estimates);
        if estimates.len() > 1 {
            setting.cameras = estimates
                .iter()
                .zip(frames)
                .map(|(&estimate, &milliseconds)| CameraFigures {
                    estimate,
                    milliseconds,
                })
                .collect();
        }
    }

    /// Estimates the error of an evaluated setting from second samples, until an error bound (if
    /// given) is decided. Stores the new estimate.
    pub(super) fn verify(
        &mut self,
        setting: &Setting,
        bound: Option<f64>,
        on_step: &OnStep<'_>,
    ) -> Result<Setting, MeasureError> {
        let of_setting: Vec<Estimate> = match &setting.cameras[..] {
            [] => vec![setting.estimate],
            cameras => cameras.iter().map(|camera| camera.estimate).collect(),
        };
        let firsts = match self.first_estimates.get(&setting.preset) {
            Some(known) => known.clone(),
            None => {
                let preset = setting.preset.clone();
                self.first_estimates.insert(preset, of_setting.clone());
                of_setting
            }
        };
        let mut estimates = Vec::new();
        for (view, first) in self.views.iter_mut().zip(firsts) {
            let recipe = view.scene.recipe(&setting.preset)?;
            let contender = Contender {
                recipe: &recipe,
                first: first.times(1.0 / view.scale),
                bound: bound.map(|bound| bound / view.scale),
            };
            let estimate =
                view.verifier
                    .estimate(&mut view.scene, &view.sampled, &contender, on_step)?;
            estimates.push(estimate.times(view.scale));
        }
        let mut verified = setting.clone();
        let frames: Vec<f64> = setting.cameras.iter().map(|c| c.milliseconds).collect();
        self.set_estimates(&mut verified, &estimates, &frames);
        self.tried
            .insert(setting.preset.clone(), Some(verified.clone()));
        Ok(verified)
    }

    /// Measures the grain and the shimmer of a setting if they have bounds; with several cameras,
    /// the greatest.
    pub(super) fn with_grain_and_shimmer(
        &mut self,
        mut setting: Setting,
        bounds: &Bounds,
    ) -> Result<Setting, MeasureError> {
        let truth = self.counting.truth;
        for view in &mut self.views {
            if bounds.max_grain.is_some() {
                let recipe = view.scene.recipe(&setting.preset)?;
                let grain = view.grain(&recipe, &truth)?;
                setting.grain = greater(setting.grain, grain);
            }
            if bounds.max_shimmer.is_some() {
                let found = shimmer(&mut view.scene, &view.sampled, &setting.preset)?;
                setting.shimmer = greater(setting.shimmer, found);
            }
        }
        self.tried
            .insert(setting.preset.clone(), Some(setting.clone()));
        Ok(setting)
    }

    /// Evaluates a preset on other scenes with the same cameras and samples, such as scenes with
    /// fewer casters. Returns its error, and the costs of drawing and lookup, milliseconds. Returns
    /// `None` if it is not supported there.
    pub(super) fn evaluate_on_scenes(
        &self,
        scenes: &mut [PlanScene<'_>],
        preset: &TechniquePreset,
    ) -> Result<Option<(Estimate, f64, f64)>, MeasureError> {
        let Counting {
            ref catalogue,
            ref cost,
            hold,
            ..
        } = self.counting;
        let mut estimates = Vec::new();
        let mut prices = Vec::new();
        for (view, scene) in self.views.iter().zip(scenes) {
            let Ok(recipe) = scene.recipe(preset) else {
                return Ok(None);
            };
            prices.push(scene.price(&recipe, cost, catalogue));
            let estimate = view.sampled.estimate(scene, &recipe)?;
            estimates.push(estimate.times(view.scale));
        }
        let draw_ms = hold.required_figure(prices.iter().map(|price| price.draw_ms).collect());
        let lookup_ms = hold.required_figure(prices.iter().map(|price| price.lookup_ms).collect());
        Ok(Some((worst_required(hold, &estimates), draw_ms, lookup_ms)))
    }

    /// Returns the first sample's estimate of a setting, verified since or not.
    pub(super) fn first_estimate(&self, setting: &Setting) -> Estimate {
        match self.first_estimates.get(&setting.preset) {
            Some(firsts) => worst_required(self.counting.hold, firsts),
            None => setting.estimate,
        }
    }

    /// Returns the error of no shadow at all at the worst camera that the plan holds for.
    pub(super) fn error_of_no_shadow(&mut self) -> Result<Estimate, MeasureError> {
        let mut estimates = Vec::new();
        for view in &mut self.views {
            estimates.push(error_of_no_shadow(view)?);
        }
        Ok(worst_required(self.counting.hold, &estimates))
    }
}

fn greater(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a.max(b)),
        (a, b) => a.or(b),
    }
}

fn error_of_no_shadow(view: &mut SampledView<'_>) -> Result<Estimate, MeasureError> {
    let none = TechniquePreset::from(Unshadowed::default());
    let recipe = view.scene.recipe(&none)?;
    Ok(view.sampled.estimate(&mut view.scene, &recipe)?)
}

/// Returns each figure of the worst camera that the plan holds for.
fn worst_required(hold: Hold, estimates: &[Estimate]) -> Estimate {
    if let [one] = estimates {
        return *one;
    }
    let of =
        |figure: fn(&Estimate) -> f64| hold.required_figure(estimates.iter().map(figure).collect());
    Estimate {
        error: of(|e| e.error),
        low: of(|e| e.low),
        high: of(|e| e.high),
        too_dark: of(|e| e.too_dark),
        too_light: of(|e| e.too_light),
    }
}
