//! The planner. It samples a scene once and then plans for any number of bounds.

use super::{
    bias_search::{Biased, all_biases},
    bounds::Bounds,
    by_preset::without_bias,
    clock,
    families::{Family, FamilyNeeds, families_for},
    options::PlanOptions,
    outcome::{CurvePoint, Miss, Plan, Sampled},
    reasons::{Facts, by_the_clock},
    setting::Setting,
    strategy::{Found, LadderPlace},
    trials::{Counting, SampledView, Trials},
};
use crate::{
    cancel::Cancel,
    cost::CostModel,
    error::MeasureError,
    estimate::{
        density::{Pilot, density},
        sampled_truth::{SampledTruth, Sampling},
        scene::PlanScene,
        verify::Verifier,
    },
    pareto::front,
    progress::{OnStep, Step},
};
use umbrage_core::{Backend, Camera, Geometry, Invalid, Light};
use umbrage_techniques::TechniquePreset;
use web_time::Instant;

/// Views of a scene with their samples, and the settings evaluated on them.
pub struct Planner<'a> {
    pub(super) trials: Trials<'a>,
    /// The candidates of the last search.
    pub(super) families: Vec<Family>,
    pub(super) on_step: &'a OnStep<'a>,
    pub(super) cancel: Cancel,
    /// True if the found settings will be timed.
    pub(super) is_timed: bool,
    /// Seconds for receivers, sample and truth.
    pub(super) sampling_seconds: f64,
}

/// Factor on the number of samples under ideal lights, which take one ray a receiver instead of
/// hundreds.
const IDEAL_LIGHT_FACTOR: usize = 4;
/// Several cameras share the samples, but each gets at least one n-th of them.
const MIN_SHARE_OF_SAMPLES: usize = 4;
/// Greatest number of runners-up in a plan.
const RUNNERS_UP: usize = 8;

impl std::fmt::Debug for Planner<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Planner")
            .field("settings tried", &self.trials.count())
            .finish_non_exhaustive()
    }
}

impl<'a> Planner<'a> {
    /// Samples the receivers that a camera sees and traces their truth.
    ///
    /// # Errors
    /// Errors if the camera or light is not valid.
    pub fn new(
        camera: &'a Camera,
        light: &'a Light,
        geometry: &'a Geometry,
        options: &PlanOptions,
        on_step: &'a OnStep<'a>,
    ) -> Result<Self, MeasureError> {
        Self::of_cameras(
            std::slice::from_ref(camera),
            light,
            geometry,
            options,
            on_step,
        )
    }

    /// Samples the receivers that each camera sees and traces their truth. Plans hold for the
    /// cameras that [`PlanOptions::hold`] requires.
    ///
    /// # Errors
    /// Errors if there is no camera, or a camera or the light is not valid.
    pub fn of_cameras(
        cameras: &'a [Camera],
        light: &'a Light,
        geometry: &'a Geometry,
        options: &PlanOptions,
        on_step: &'a OnStep<'a>,
    ) -> Result<Self, MeasureError> {
        let start = Instant::now();
        if cameras.is_empty() {
            return Err(Invalid::new("cameras", "are missing", "give at least one").into());
        }
        options.hold.validate()?;
        light.validate()?;
        let shared = (options.samples as usize).div_ceil(cameras.len());
        let samples = shared.max(options.samples as usize / MIN_SHARE_OF_SAMPLES);
        let mut views = Vec::new();
        // Sample each camera's view.
        for camera in cameras {
            camera.validate()?;
            options.cancel.check()?;
            on_step(Step::Looking);
            let scene = PlanScene::new(camera, light, geometry, options.weighting)?;
            views.push(sampled_view(scene, samples, options, on_step)?);
        }
        let counting = Counting {
            catalogue: options.catalogue.clone(),
            cost: options.cost,
            motion: options.motion,
            hold: options.hold,
            truth: options.truth,
        };
        Ok(Self {
            trials: Trials::new(views, counting),
            families: Vec::new(),
            on_step,
            cancel: options.cancel.clone(),
            is_timed: false,
            sampling_seconds: start.elapsed().as_secs_f64(),
        })
    }

    /// Finds the cheapest setting within the bounds, or the most accurate one without a bound of
    /// the error. Costs are counted and priced, so the same scene has the same plan on every run.
    ///
    /// # Errors
    /// Errors if bounds are missing or not valid.
    pub fn plan(&mut self, bounds: &Bounds) -> Result<Plan, MeasureError> {
        self.plan_by_clock(bounds, None)
    }

    /// Plans like [`Planner::plan`]. With a backend, it also times candidates whose counted costs
    /// are too close.
    ///
    /// These run in turn for the first camera, and the one with the least measured time is chosen.
    /// Without a bound of the error, it chooses the most accurate one whose measured time is within
    /// the bounds.
    ///
    /// # Errors
    /// Errors if bounds are missing or not valid, or if the backend fails.
    pub fn plan_by_clock(
        &mut self,
        bounds: &Bounds,
        clock: Option<&mut dyn Backend>,
    ) -> Result<Plan, MeasureError> {
        bounds.validate()?;
        let start = Instant::now();
        self.is_timed = clock.is_some();
        let spread = clock.as_ref().map_or(1.0, |backend| {
            CostModel::factor_of_nine_in_ten(backend.kind())
        });
        // Search by counted costs.
        let (max_error, found) = self.search_within(bounds, spread)?;
        let mut timed = Vec::new();
        // Time the finalists.
        let found = match (found, clock) {
            (Found::Chosen(finalists), Some(backend)) => {
                let (found, others) = self.quickest(finalists, bounds, backend)?;
                timed = others;
                found
            }
            (found, _) => found,
        };
        (self.on_step)(Step::Explaining);
        // Choose the best bias.
        let (chosen, curve, miss) = match found {
            Found::Chosen(mut best) => {
                let (place, setting) = best.swap_remove(0);
                let (setting, curve) = self.with_best_bias(place, setting, bounds, max_error)?;
                (Some(setting), curve, None)
            }
            Found::Missed(miss) => (None, Vec::new(), Some(*miss)),
        };
        // Collect the reasons.
        let none = self.trials.error_of_no_shadow()?;
        let trials = &self.trials;
        let facts = Facts::find(trials, &trials.counting.truth)?;
        let mut reasons = facts.reasons(
            trials,
            &trials.counting.catalogue,
            bounds,
            chosen.as_ref(),
            &curve,
        )?;
        reasons.extend(by_the_clock(chosen.as_ref(), &timed));
        let scene = &trials.views[0].scene;
        Ok(Plan {
            scene: String::new(),
            light: scene.light.kind().to_owned(),
            light_number: 1,
            size: scene.camera.size.to_array(),
            cameras: trials.views.len(),
            motion: trials.counting.motion,
            bounds: *bounds,
            runners_up: self.runners_up(chosen.as_ref()),
            failing: self.missed_settings(chosen.as_ref(), bounds, max_error),
            timed,
            error_of_no_shadow: none,
            chosen,
            miss,
            reasons,
            left_out: Vec::new(),
            curve,
            coverage: trials.coverage(),
            sampled: Sampled {
                receivers: trials
                    .views
                    .iter()
                    .map(|view| view.sampled.truth.len())
                    .sum(),
                traced: trials.traced_points(),
                settings: trials.count(),
                looking: self.sampling_seconds,
                trying: start.elapsed().as_secs_f64(),
            },
        })
    }

    /// Searches the candidates within the bounds. Also returns the error bound of the strictest
    /// camera. `spread` is that of [`Planner::cheapest`].
    fn search_within(
        &mut self,
        bounds: &Bounds,
        spread: f64,
    ) -> Result<(Option<f64>, Found), MeasureError> {
        let max_error = self.trials.prepare(bounds)?;
        let needs = FamilyNeeds {
            small: bounds.max_bytes.is_some(),
            stable: bounds.max_shimmer.is_some(),
        };
        let catalogue = &self.trials.counting.catalogue;
        self.families = families_for(catalogue, &self.trials.views[0].scene, needs);
        let found = match max_error {
            Some(max_error) => self.cheapest(bounds, max_error, spread)?,
            None => self.most_accurate(bounds)?,
        };
        Ok((max_error, found))
    }

    /// Searches the candidates within the bounds by counted costs.
    pub(super) fn search_for(&mut self, bounds: &Bounds) -> Result<Found, MeasureError> {
        self.is_timed = false;
        let (_, found) = self.search_within(bounds, 1.0)?;
        Ok(found)
    }

    /// Returns the settings with their measured times. Settings that the backend can't execute are
    /// removed.
    pub(super) fn measure_times(
        &mut self,
        settings: Vec<Setting>,
        backend: &mut dyn Backend,
    ) -> Result<Vec<Setting>, MeasureError> {
        (self.on_step)(Step::Timing(settings.len()));
        let motion = self.trials.counting.motion;
        let presets: Vec<(TechniquePreset, bool)> = settings
            .iter()
            .map(|setting| {
                (
                    setting.preset.clone(),
                    motion.keeps(setting.kept_as_camera_moves),
                )
            })
            .collect();
        let scene = &self.trials.views[0].scene;
        let times = clock::times(backend, scene, motion, &presets, &[])?;
        let mut timed = Vec::new();
        for (setting, ms) in settings.into_iter().zip(times) {
            if ms.is_some() {
                timed.push(Setting {
                    measured_ms: ms,
                    ..setting
                });
            }
        }
        Ok(timed)
    }

    /// Times finalists in turn. Returns the best one by measured time, and all of them with their
    /// times, the fastest first.
    fn quickest(
        &mut self,
        finalists: Vec<(LadderPlace, Setting)>,
        bounds: &Bounds,
        backend: &mut dyn Backend,
    ) -> Result<(Found, Vec<Setting>), MeasureError> {
        // Run and sort the finalists.
        let (places, settings): (Vec<LadderPlace>, Vec<Setting>) = finalists.into_iter().unzip();
        let all = self.measure_times(settings.clone(), backend)?;
        let place_of = |timed: &Setting| {
            let i = settings.iter().position(|s| s.preset == timed.preset);
            places[i.unwrap_or_default()]
        };
        let mut timed: Vec<(LadderPlace, Setting)> =
            all.into_iter().map(|s| (place_of(&s), s)).collect();
        let quickest = |a: &Setting, b: &Setting| match (a.measured_ms, b.measured_ms) {
            (Some(a), Some(b)) => a.total_cmp(&b),
            _ => std::cmp::Ordering::Equal,
        };
        timed.sort_by(|(_, a), (_, b)| quickest(a, b));
        let all: Vec<Setting> = timed.iter().map(|(_, setting)| setting.clone()).collect();
        // Keep those within the bounds.
        timed.retain(|(_, setting)| {
            let ms = setting.measured_ms.unwrap_or(f64::INFINITY);
            bounds.affords(ms, setting.bytes)
        });
        if !bounds.has_error() {
            timed.sort_by(|(_, a), (_, b)| a.estimate.error.total_cmp(&b.estimate.error));
        }
        if !timed.is_empty() {
            return Ok((Found::Chosen(timed), all));
        }
        // Report the fastest one as a miss.
        let reason = match all.first() {
            Some(least) => format!(
                "when timed, no setting is within {bounds}; fastest: {} in {:.3} ms; allow more time",
                least.label(),
                least.measured_ms.unwrap_or(f64::NAN)
            ),
            None => {
                "the backend supports none of the settings that are within the bounds".to_owned()
            }
        };
        let best = all.first().cloned();
        Ok((Found::Missed(Box::new(Miss { reason, best })), all))
    }

    /// Returns the two cheaper settings that are closest to the bounds and break one, the better
    /// first, of different techniques. Among equal frame costs, the one that is cheaper to draw
    /// counts as cheaper.
    fn missed_settings(
        &self,
        chosen: Option<&Setting>,
        bounds: &Bounds,
        max_error: Option<f64>,
    ) -> Vec<Setting> {
        let Some(chosen) = chosen else {
            return Vec::new();
        };
        let mut best: Vec<&Setting> = Vec::new();
        let mut all = self.trials.all();
        all.sort_by(|a, b| a.estimate.error.total_cmp(&b.estimate.error));
        for setting in all {
            let breaks_error = max_error.is_some_and(|max| !setting.estimate.is_surely_within(max));
            let breaks = breaks_error || !bounds.allows_noise(setting.grain, setting.shimmer);
            let is_new = best
                .iter()
                .all(|other| other.technique != setting.technique);
            let is_cheaper = setting.milliseconds <= chosen.milliseconds
                && setting.milliseconds + setting.draw_ms < chosen.milliseconds + chosen.draw_ms;
            if breaks && is_new && is_cheaper {
                best.push(setting);
            }
        }
        best.into_iter().take(2).cloned().collect()
    }

    /// Returns the chosen setting with the best of all biases, and the error curve over all biases.
    fn with_best_bias(
        &mut self,
        place: LadderPlace,
        chosen: Setting,
        bounds: &Bounds,
        max_error: Option<f64>,
    ) -> Result<(Setting, Vec<CurvePoint>), MeasureError> {
        let Self {
            trials,
            families,
            on_step,
            ..
        } = self;
        let family = &families[place.family];
        // Evaluate all biases.
        let points = if family.preset().map().is_some() {
            all_biases(trials, family, place.candidate)?
        } else {
            Vec::new()
        };
        let best = points
            .iter()
            .map(|point| &point.setting)
            .filter(|s| bounds.affords(s.milliseconds, s.bytes))
            .min_by(|a, b| a.estimate.error.total_cmp(&b.estimate.error));
        let mut best_setting = chosen;
        if let Some(other) = best
            && other.estimate.error < best_setting.estimate.error
        {
            // The chosen setting was verified: another bias must be verified, too.
            let other = trials.verify(other, max_error, *on_step)?;
            let other = trials.with_grain_and_shimmer(other, bounds)?;
            let is_within = max_error.is_none_or(|error| other.estimate.is_surely_within(error))
                && bounds.allows_noise(other.grain, other.shimmer);
            if is_within && other.estimate.error < best_setting.estimate.error {
                // A bias has almost no effect on the time.
                let measured_ms = best_setting.measured_ms;
                best_setting = Setting {
                    measured_ms,
                    ..other
                };
            }
        }
        // A single point is not a curve.
        let curve = if points.len() > 1 {
            points
                .iter()
                .map(|p| curve_point(p, &best_setting))
                .collect()
        } else {
            Vec::new()
        };
        Ok((best_setting, curve))
    }

    /// Returns the runners-up: the best bias of each technique and map, then the front of cost and
    /// error closest to the chosen setting.
    fn runners_up(&self, chosen: Option<&Setting>) -> Vec<Setting> {
        let mut best: Vec<(TechniquePreset, &Setting)> = Vec::new();
        for setting in self
            .trials
            .all()
            .into_iter()
            .filter(|s| chosen.is_none_or(|c| c.preset != s.preset))
        {
            let key = without_bias(&setting.preset);
            match best.iter_mut().find(|(other, _)| *other == key) {
                Some((_, other)) if setting.estimate.error < other.estimate.error => {
                    *other = setting
                }
                Some(_) => {}
                None => best.push((key, setting)),
            }
        }
        let points: Vec<[f64; 2]> = best
            .iter()
            .map(|(_, s)| [s.milliseconds, s.estimate.error])
            .collect();
        let mut front: Vec<&Setting> = front(&points).into_iter().map(|i| best[i].1).collect();
        if let Some(chosen) = chosen {
            front.sort_by(|a, b| cost_distance(a, chosen).total_cmp(&cost_distance(b, chosen)));
        }
        front.truncate(RUNNERS_UP);
        front.sort_by(|a, b| a.milliseconds.total_cmp(&b.milliseconds));
        front.into_iter().cloned().collect()
    }
}

/// Samples the receivers that a camera sees and traces their truth.
fn sampled_view<'a>(
    mut scene: PlanScene<'a>,
    samples: usize,
    options: &PlanOptions,
    on_step: &OnStep<'_>,
) -> Result<SampledView<'a>, MeasureError> {
    let pilot = Pilot::new(&mut scene)?;
    let lit = scene.lit_pixels(&options.truth)?;
    let density = density(&mut scene, pilot.as_ref(), &lit)?;
    let factor = if scene.light.is_ideal() {
        IDEAL_LIGHT_FACTOR
    } else {
        1
    };
    let sampling = Sampling {
        count: factor * samples,
        seed: options.seed,
        truth: options.truth,
    };
    options.cancel.check()?;
    let sampled = SampledTruth::draw(&mut scene, &density, &sampling, on_step)?;
    let verifier = Verifier {
        pilot,
        lit,
        sampling: sampling.second(),
    };
    Ok(SampledView::new(scene, sampled, verifier))
}

/// Returns the distance of two settings in cost: the absolute logarithm of their ratio, 0 for equal
/// costs.
fn cost_distance(setting: &Setting, chosen: &Setting) -> f64 {
    let ratio = setting.milliseconds / chosen.milliseconds.max(1e-9);
    ratio.ln().abs()
}

/// Returns a point of the curve. The chosen setting has its verified estimate.
fn curve_point(point: &Biased, best: &Setting) -> CurvePoint {
    let chosen = point.setting.preset == best.preset;
    let estimate = if chosen {
        best.estimate
    } else {
        point.setting.estimate
    };
    CurvePoint {
        kind: point.kind,
        texels: point.texels,
        estimate,
        chosen,
    }
}
