//! Comparison of plans with an exhaustive sweep of the same candidates over the whole image, by
//! counted costs and by the clock.

use super::{
    bias_search::best_bias,
    bounds::Bounds,
    clock::{self, Race},
    families::{FamilyNeeds, families_for},
    options::PlanOptions,
    planner::Planner,
    setting::Setting,
};
use crate::{
    error::MeasureError,
    progress::{OnStep, Step},
    truth::{TruthOptions, stratified_pixels},
};
use glam::UVec2;
use serde::{Deserialize, Serialize};
use umbrage_core::{
    Backend, Geometry, Scene, ShadowTechnique as _,
    metrics::{Errors, Pixel},
};
use umbrage_techniques::TechniquePreset;

/// Comparison of a plan with the sweep, for one scene, light and bound.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Regret {
    /// The scene's name.
    pub scene: String,
    /// The light's kind.
    pub light: String,
    /// Number of the light in the scene, from 1.
    pub light_number: usize,
    /// The bound of the error.
    pub bound: f64,
    /// The planned setting; `None` if nothing was found.
    pub chosen: Option<Setting>,
    /// Error of the planned setting over the whole image; NaN without one.
    pub error: f64,
    /// The cheapest setting that meets the bound on the whole image, of all candidates with all
    /// biases; `None` if none does.
    pub cheapest: Option<String>,
    /// Cost of the cheapest setting, milliseconds.
    #[serde(rename = "least_milliseconds")]
    pub min_milliseconds: f64,
    /// Comparison by the clock; `None` if nothing was timed or planned.
    pub clock: Option<ClockRegret>,
    /// Seconds for the plan, including its sample.
    pub seconds: f64,
}

/// Comparison of a plan with all candidates that meet its bounds, by times measured in turn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClockRegret {
    /// Time of the planned setting, milliseconds.
    pub chosen_ms: f64,
    /// Least time of a candidate, milliseconds.
    pub least_ms: f64,
    /// Label of the fastest candidate.
    pub quickest: String,
    /// Number of candidates timed.
    pub candidates: usize,
}

impl ClockRegret {
    /// Returns the ratio of the plan's time to the least time.
    pub fn ratio(&self) -> f64 {
        if self.least_ms > 0.0 {
            self.chosen_ms / self.least_ms
        } else {
            1.0
        }
    }
}

/// Greatest ratio of a plan's cost to the least cost.
pub const MAX_REGRET: f64 = 1.25;
/// Least share of cases in which the bound must hold on the whole image.
pub const MIN_KEPT: f64 = 0.95;

impl Regret {
    /// Returns whether the choice meets the bound on the whole image, or rightly nothing was
    /// chosen.
    pub fn keeps(&self) -> bool {
        match &self.chosen {
            Some(_) => self.error <= self.bound,
            None => self.cheapest.is_none(),
        }
    }

    /// Returns the ratio of the plan's cost to the least cost; `None` if either is missing.
    pub fn ratio(&self) -> Option<f64> {
        let chosen = self.chosen.as_ref()?;
        self.cheapest.as_ref()?;
        Some(if self.min_milliseconds > 0.0 {
            chosen.milliseconds / self.min_milliseconds
        } else {
            1.0
        })
    }

    /// Returns whether the plan is wrong: it breaks the bound, or costs more than [`MAX_REGRET`]
    /// times the least.
    pub fn misses(&self) -> bool {
        !self.keeps() || self.ratio().is_some_and(|ratio| ratio > MAX_REGRET)
    }
}

/// Plans for each error bound independently, and sweeps all candidates by rising cost until the
/// least bound is met.
///
/// With a backend, plans are made by the clock, and all candidates that meet a bound run in turn
/// and are timed.
///
/// Under ideal lights, whose truth takes one ray a pixel, errors cover the whole image. Hard
/// shadows are wrong at few pixels, and a plan may be within a thousandth of its bound, which no
/// sample can resolve. Under lights with an extent, errors cover one pixel of each block
/// ([`TruthOptions::block_side`](crate::truth::TruthOptions::block_side)). If blocks are larger
/// than a pixel, each candidate is swept with its best bias only.
///
/// # Errors
/// Errors if the scene has no camera or light, or is not valid, or if a backend fails.
pub fn regret(
    scene: &Scene,
    bounds: &[f64],
    options: &PlanOptions,
    mut clock: Option<&mut dyn Backend>,
    on_step: &OnStep<'_>,
) -> Result<Vec<Regret>, MeasureError> {
    let light = options.light_of(scene)?;
    let cameras = options.cameras_of(scene)?;
    let camera = &cameras[0];
    let geometry = Geometry::bake(scene)?;
    let planner = Planner::new(camera, light, &geometry, options, on_step)?;
    let sampling_seconds = planner.sampling_seconds;
    let mut sweep = Sweep::new(planner, options)?;
    // Plan for each bound.
    let mut out = Vec::new();
    for &bound in bounds {
        let planner = &mut sweep.planner;
        // Samples and their truth do not depend on the bound. Settings evaluated for another bound
        // would help, so remove them.
        planner.trials.forget();
        let plan = match &mut clock {
            Some(backend) => planner.plan_by_clock(&Bounds::error(bound), Some(&mut **backend))?,
            None => planner.plan(&Bounds::error(bound))?,
        };
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
            clock: None,
            seconds: sampling_seconds + plan.sampled.trying,
        });
    }
    // Sweep the candidates.
    if sweep.is_thorough && clock.is_none() {
        sweep.run(&mut out)?;
    } else {
        sweep.run_with_best_biases(&mut out, clock)?;
    }
    Ok(out)
}

/// Factor on the error that one in twenty estimates exceeds. Three times it is nearly five standard
/// errors, exceeded less than once in a million.
const FAR: f64 = 3.0;

/// Greatest number of rays a pixel if errors cover one pixel of each block, under lights with an
/// extent. They are off by .5 % in a penumbra with one straight edge, negligible compared with
/// errors of some percent.
const JUDGED_SAMPLES: u32 = 256;

/// Errors of the candidates over the whole image.
struct Sweep<'a> {
    planner: Planner<'a>,
    /// The evaluated pixels.
    judged: Vec<u32>,
    truth: Vec<f32>,
    pixels: Vec<Pixel>,
    /// True if candidates are swept with all biases.
    is_thorough: bool,
}

impl<'a> Sweep<'a> {
    fn new(mut planner: Planner<'a>, options: &PlanOptions) -> Result<Self, MeasureError> {
        let scene = &mut planner.trials.views[0].scene;
        let is_thorough = options.truth.block_side <= 1;
        let block_side = if scene.light.is_ideal() {
            1
        } else {
            options.truth.block_side
        };
        let judged = stratified_pixels(scene.receivers.size, block_side);
        let truth = if block_side <= 1 {
            options.truth
        } else {
            TruthOptions {
                samples: options.truth.samples.min(JUDGED_SAMPLES),
                penumbra_factor: 1,
                ..options.truth
            }
        };
        let on_step = planner.on_step;
        let truth = scene.trace_at(&judged, &truth, &|done, total| {
            on_step(Step::Truth(done, total))
        })?;
        let (truth, pixels) = truth.iter().map(|t| (t.visibility, t.pixel)).unzip();
        Ok(Self {
            planner,
            judged,
            truth,
            pixels,
            is_thorough,
        })
    }

    fn error(&mut self, preset: &TechniquePreset) -> Result<f64, MeasureError> {
        let scene = &mut self.planner.trials.views[0].scene;
        let recipe = scene.recipe(preset)?;
        let mask = scene.mask_at(&recipe, &self.judged)?;
        // Use a single row: only errors of neighbours depend on the image's shape, and they are not
        // used.
        let size = UVec2::new(self.judged.len() as u32, 1);
        let errors = Errors::measure(size, &mask, &self.truth, &self.pixels)?;
        Ok(errors.rmse)
    }

    /// Returns a candidate's error over the evaluated pixels. Returns `None` if its images exceed
    /// the backend's limits, or if it has more grain than error bounds allow.
    fn error_of_candidate(&mut self, setting: &Setting) -> Result<Option<f64>, MeasureError> {
        let error = match self.error(&setting.preset) {
            Ok(error) => error,
            Err(MeasureError::Backend(umbrage_core::BackendError::Invalid(_))) => return Ok(None),
            Err(e) => return Err(e),
        };
        let bounds = Bounds::error(1.0);
        let measured = self
            .planner
            .trials
            .with_grain_and_shimmer(setting.clone(), &bounds)?;
        let is_fine = bounds.allows_noise(measured.grain, measured.shimmer);
        Ok(is_fine.then_some(error))
    }

    /// Evaluates every candidate with its best bias. With a backend, those that meet a bound are
    /// timed.
    fn run_with_best_biases(
        &mut self,
        regrets: &mut [Regret],
        clock: Option<&mut dyn Backend>,
    ) -> Result<(), MeasureError> {
        let strictest = regrets.iter().map(|r| r.bound).fold(1.0, f64::min);
        let scene = &self.planner.trials.views[0].scene;
        let families = families_for(
            &self.planner.trials.counting.catalogue,
            scene,
            FamilyNeeds::default(),
        );
        // Collect the candidates that meet the loosest bound, with their errors.
        let mut keeping: Vec<(Setting, f64)> = Vec::new();
        for family in &families {
            for candidate in 0..family.candidates.len() {
                let trials = &mut self.planner.trials;
                let name = family.preset().technique().name();
                (self.planner.on_step)(Step::Trying(name, trials.count()));
                let Some(setting) = best_bias(trials, family, candidate, Some(strictest))? else {
                    continue;
                };
                if is_hopeless(&setting, regrets) {
                    continue;
                }
                if let Some(error) = self.error_of_candidate(&setting)?
                    && regrets.iter().any(|r| error <= r.bound)
                {
                    keeping.push((setting, error));
                }
            }
        }
        // Add the planned settings with their own bias.
        for regret in regrets.iter() {
            if let Some(chosen) = &regret.chosen
                && keeping.iter().all(|(s, _)| s.preset != chosen.preset)
            {
                keeping.push((chosen.clone(), regret.error));
            }
        }
        // Time the candidates in races, one per bound.
        let times = match clock {
            Some(backend) => {
                let races: Vec<Race> = regrets.iter().map(|r| race(r, &keeping)).collect();
                self.times(&keeping, &races, backend)?
            }
            None => Vec::new(),
        };
        // Find the cheapest and the fastest candidate for each bound.
        for regret in regrets {
            let keeps = |i: &usize| keeping[*i].1 <= regret.bound;
            let cheapest = (0..keeping.len()).filter(keeps).min_by(|&a, &b| {
                keeping[a]
                    .0
                    .milliseconds
                    .total_cmp(&keeping[b].0.milliseconds)
            });
            if let Some(i) = cheapest {
                regret.cheapest = Some(keeping[i].0.label());
                regret.min_milliseconds = keeping[i].0.milliseconds;
            }
            if times.is_empty() {
                continue;
            }
            let timed: Vec<usize> = (0..keeping.len())
                .filter(keeps)
                .filter(|&i| times[i].is_some())
                .collect();
            let quickest = timed.iter().copied().min_by(|&a, &b| {
                let ms = |i: usize| times[i].unwrap_or(f64::INFINITY);
                ms(a).total_cmp(&ms(b))
            });
            let chosen = regret.chosen.as_ref();
            let place = chosen.and_then(|c| keeping.iter().position(|(s, _)| s.preset == c.preset));
            if let (Some(quickest), Some(place)) = (quickest, place)
                && let (Some(least_ms), Some(chosen_ms)) = (times[quickest], times[place])
            {
                regret.clock = Some(ClockRegret {
                    chosen_ms,
                    least_ms,
                    quickest: keeping[quickest].0.label(),
                    candidates: timed.len(),
                });
            }
        }
        Ok(())
    }

    /// Times settings in turn.
    fn times(
        &self,
        settings: &[(Setting, f64)],
        races: &[Race],
        backend: &mut dyn Backend,
    ) -> Result<Vec<Option<f64>>, MeasureError> {
        (self.planner.on_step)(Step::Timing(settings.len()));
        let motion = self.planner.trials.counting.motion;
        let presets: Vec<(TechniquePreset, bool)> = settings
            .iter()
            .map(|(setting, _)| {
                (
                    setting.preset.clone(),
                    motion.keeps(setting.kept_as_camera_moves),
                )
            })
            .collect();
        let scene = &self.planner.trials.views[0].scene;
        clock::times(backend, scene, motion, &presets, races)
    }

    /// Returns every candidate with every size and bias, by rising cost. A bias changes the cost
    /// only through rounding in the map's fit, so only the first one is priced.
    fn candidates(&mut self) -> Result<Vec<TechniquePreset>, MeasureError> {
        let mut priced: Vec<(f64, Vec<TechniquePreset>)> = Vec::new();
        let scene = &self.planner.trials.views[0].scene;
        for family in families_for(
            &self.planner.trials.counting.catalogue,
            scene,
            FamilyNeeds::default(),
        ) {
            for size in 0..family.candidates.len() {
                let mut presets: Vec<TechniquePreset> = Vec::new();
                for biases in family.bias_amounts() {
                    for texels in biases.amounts {
                        presets.push(family.preset_at(size, biases.kind, texels));
                    }
                }
                let Some(price) = self.planner.trials.price(&presets[0])? else {
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

    /// Evaluates candidates by rising cost, until the cheapest within each bound is found.
    fn run(&mut self, regrets: &mut [Regret]) -> Result<(), MeasureError> {
        for preset in self.candidates()? {
            if regrets.iter().all(|r| r.cheapest.is_some()) {
                break;
            }
            let Some(setting) = self.planner.trials.try_out(&preset)? else {
                continue;
            };
            if is_hopeless(&setting, regrets) {
                continue;
            }
            let milliseconds = setting.milliseconds;
            let tried = self.planner.trials.count();
            (self.planner.on_step)(Step::Trying(preset.name(), tried));
            let Some(error) = self.error_of_candidate(&setting)? else {
                continue;
            };
            for regret in regrets.iter_mut() {
                if regret.cheapest.is_none() && error <= regret.bound {
                    let label = format!("{} ({})", preset.name(), preset.settings());
                    regret.cheapest = Some(label);
                    regret.min_milliseconds = milliseconds;
                }
            }
        }
        Ok(())
    }
}

/// Returns the race of all settings that meet a bound, and watches the planned one. `settings` come
/// with their errors.
fn race(regret: &Regret, settings: &[(Setting, f64)]) -> Race {
    let keeping = (0..settings.len()).filter(|&i| settings[i].1 <= regret.bound);
    let is_chosen = |(setting, _): &(Setting, f64)| {
        (regret.chosen.as_ref()).is_some_and(|chosen| chosen.preset == setting.preset)
    };
    Race {
        settings: keeping.collect(),
        watched: settings.iter().position(is_chosen),
    }
}

/// Returns whether the sample alone shows that a setting meets none of the open bounds: its mean
/// square error exceeds them by more than [`FAR`] times the uncertainty. This avoids most
/// renderings of the whole image.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::search::tests::{scene, small};
    use umbrage_techniques::{Hard, MapTechnique};

    /// Under ideal lights, errors cover whole images for any block size.
    #[test]
    fn under_ideal_lights_whole_images_are_judged() {
        let scene = scene("cubes");
        let camera = scene.cameras[0].with_size(UVec2::new(160, 120));
        let geometry = Geometry::bake(&scene).expect("built in");
        let judged = |block_side| {
            let mut options = small();
            options.truth.block_side = block_side;
            let light = &scene.lights[0];
            let planner =
                Planner::new(&camera, light, &geometry, &options, &|_| {}).expect("can be planned");
            let mut sweep = Sweep::new(planner, &options).expect("can be traced");
            let error = sweep
                .error(&MapTechnique::<Hard>::default().into())
                .expect("valid");
            (sweep.judged.len(), error)
        };
        assert!(scene.lights[0].is_ideal());
        assert_eq!(judged(4), judged(1));
    }
}
