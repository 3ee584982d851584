//! Compares plans with an exhaustive sweep of the same candidates over the whole image.

use super::{
    Bounds, PlanOptions, Planner, Setting,
    bias::bias_amounts,
    families::{FamilyNeeds, families_for},
    seen,
};
use crate::{
    MeasureError,
    progress::{OnStep, Step},
};
use serde::{Deserialize, Serialize};
use umbrage_core::{
    Geometry, Scene,
    metrics::{Errors, Pixel},
};
use umbrage_techniques::TechniquePreset;

/// One scene, light and bound.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Regret {
    /// The scene's name.
    pub scene: String,
    /// The light's kind.
    pub light: String,
    /// Which of the scene's lights it is, from 1.
    pub light_number: usize,
    /// The bound of the error.
    pub bound: f64,
    /// What was planned; none if nothing was found.
    pub chosen: Option<Setting>,
    /// Its error over the whole image; NaN without a choice.
    pub error: f64,
    /// The cheapest that meets the bound on the whole image, of all candidates with all biases; none if none does.
    pub cheapest: Option<String>,
    /// What that costs, milliseconds.
    #[serde(rename = "least_milliseconds")]
    pub min_milliseconds: f64,
    /// Seconds that the plan took, with its sample.
    pub seconds: f64,
}

/// Plans may cost at most this many times the least.
pub const MAX_REGRET: f64 = 1.25;
/// The share of cases in which the bound must be kept on the whole image.
pub const MIN_KEPT: f64 = 0.95;

impl Regret {
    /// Whether the choice keeps the bound on the whole image, or rightly nothing was chosen.
    pub fn keeps(&self) -> bool {
        match &self.chosen {
            Some(_) => self.error <= self.bound,
            None => self.cheapest.is_none(),
        }
    }

    /// Returns the plan's cost over the least; none where either is missing.
    pub fn ratio(&self) -> Option<f64> {
        let chosen = self.chosen.as_ref()?;
        self.cheapest.as_ref()?;
        Some(if self.min_milliseconds > 0.0 {
            chosen.milliseconds / self.min_milliseconds
        } else {
            1.0
        })
    }

    /// Whether the plan is wrong: it breaks the bound, or costs more than [`MAX_REGRET`] times the least.
    pub fn misses(&self) -> bool {
        !self.keeps() || self.ratio().is_some_and(|ratio| ratio > MAX_REGRET)
    }
}

/// Plans for each error bound, each as if it were the first, and sweeps all candidates by rising cost until the least bound
/// is met.
///
/// # Errors
/// Errors if the scene has no camera or light, or is not valid.
pub fn regret(
    scene: &Scene,
    bounds: &[f64],
    options: &PlanOptions,
    on_step: &OnStep<'_>,
) -> Result<Vec<Regret>, MeasureError> {
    let (cameras, light) = seen(scene, options)?;
    let camera = &cameras[0];
    let geometry = Geometry::bake(scene)?;
    let whole_image = Planner::new(camera, light, &geometry, options, on_step)?;
    let mut sweep = Sweep::new(whole_image, options)?;
    let mut out = Vec::new();
    for &bound in bounds {
        let mut planner = Planner::new(camera, light, &geometry, options, on_step)?;
        let sampling_seconds = planner.sampling_seconds;
        let plan = planner.plan(&Bounds::error(bound))?;
        let error = match &plan.chosen {
            Some(chosen) => sweep.error(&chosen.preset)?,
            None => f64::NAN,
        };
        out.push(Regret {
            scene: scene.name.clone(),
            light: plan.light,
            light_number: options.light + 1,
            bound,
            chosen: plan.chosen,
            error,
            cheapest: None,
            min_milliseconds: f64::NAN,
            seconds: sampling_seconds + plan.sampled.trying,
        });
    }
    sweep.run(&mut out)?;
    Ok(out)
}

/// How many times the error of one in twenty estimates is out of the question: nearly five standard errors, not once in a million.
const FAR: f64 = 3.0;

/// The candidates' errors over the whole image.
struct Sweep<'a> {
    planner: Planner<'a>,
    truth: Vec<f32>,
    pixels: Vec<Pixel>,
}

impl<'a> Sweep<'a> {
    fn new(mut planner: Planner<'a>, options: &PlanOptions) -> Result<Self, MeasureError> {
        let scene = &mut planner.search.trials.views[0].scene;
        let all: Vec<u32> = (0..scene.receivers.len() as u32).collect();
        let on_step = planner.search.on_step;
        let truth = scene.truth_at(&all, &options.truth, &|done, total| {
            on_step(Step::Truth(done, total))
        })?;
        let (truth, pixels) = truth.iter().map(|t| (t.visibility, t.pixel)).unzip();
        Ok(Self {
            planner,
            truth,
            pixels,
        })
    }

    fn error(&mut self, preset: &TechniquePreset) -> Result<f64, MeasureError> {
        let scene = &mut self.planner.search.trials.views[0].scene;
        let mask = scene.preset_mask(preset)?;
        let errors = Errors::measure(scene.camera.size, &mask, &self.truth, &self.pixels)?;
        Ok(errors.rmse)
    }

    /// Returns every candidate with every size and bias, by rising cost. A bias changes the cost only by a rounding of the map's
    /// fit, so the first one is priced.
    fn candidates(&mut self) -> Result<Vec<TechniquePreset>, MeasureError> {
        let mut priced: Vec<(f64, Vec<TechniquePreset>)> = Vec::new();
        let scene = &self.planner.search.trials.views[0].scene;
        for family in families_for(&self.planner.techniques, scene, FamilyNeeds::default()) {
            for size in 0..family.candidates.len() {
                let mut presets: Vec<TechniquePreset> = Vec::new();
                for biases in bias_amounts(family.preset()) {
                    for texels in biases.amounts {
                        presets.push(family.at(size, biases.kind, texels));
                    }
                }
                let Some(price) = self.planner.search.trials.price(&presets[0])? else {
                    continue;
                };
                priced.push((price.milliseconds, presets));
            }
        }
        priced.sort_by(|a, b| a.0.total_cmp(&b.0));
        Ok(priced
            .into_iter()
            .flat_map(|(_, presets)| presets)
            .collect())
    }

    /// Tries candidates by rising cost, until the cheapest within each bound is found.
    fn run(&mut self, regrets: &mut [Regret]) -> Result<(), MeasureError> {
        for preset in self.candidates()? {
            if regrets.iter().all(|r| r.cheapest.is_some()) {
                break;
            }
            let Some(setting) = self.planner.search.trials.try_out(&preset)? else {
                continue;
            };
            if is_hopeless(&setting, regrets) {
                continue;
            }
            let milliseconds = setting.milliseconds;
            let technique = preset.technique();
            let tried = self.planner.search.trials.count();
            (self.planner.search.on_step)(Step::Trying(technique.name(), tried));
            let error = match self.error(&preset) {
                Ok(error) => error,
                // Its images are larger than the backend can hold.
                Err(MeasureError::Backend(umbrage_core::BackendError::Invalid(_))) => continue,
                Err(e) => return Err(e),
            };
            for regret in regrets.iter_mut() {
                if regret.cheapest.is_none() && error <= regret.bound {
                    let label = format!("{} ({})", technique.name(), technique.settings());
                    regret.cheapest = Some(label);
                    regret.min_milliseconds = milliseconds;
                }
            }
        }
        Ok(())
    }
}

/// Whether the sample alone shows that a setting meets none of the bounds that are still open: its mean square error is above
/// them by more than [`FAR`] times the uncertainty. This avoids most renderings of the whole image.
fn is_hopeless(setting: &Setting, regrets: &[Regret]) -> bool {
    let error = setting.estimate.error;
    let high = setting.estimate.high;
    let uncertainty = high.powi(2) - error.powi(2);
    let lower_square = error.powi(2) - FAR * uncertainty;
    let max_open_bound = regrets
        .iter()
        .filter(|r| r.cheapest.is_none())
        .map(|r| r.bound)
        .fold(0.0, f64::max);
    lower_square > max_open_bound.powi(2)
}
