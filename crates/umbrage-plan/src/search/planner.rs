//! The planner, once it has sampled a scene: bounds can be asked about one after the other.

use super::{
    Bounds, CurvePoint, Plan, PlanOptions, Sampled, Setting,
    bias_search::{Biased, all_biases},
    families::families_for,
    reasons::Facts,
    strategy::{Found, Place, Search},
    trials::Trials,
};
use crate::{
    MeasureError,
    estimate::{
        density::{Pilot, density},
        sampled_truth::{SampledTruth, Sampling},
        scene::PlanScene,
        verify::Verifier,
    },
    pareto::front,
    progress::{OnStep, Step},
    truth::TruthOptions,
};
use std::time::Instant;
use umbrage_core::{Camera, Geometry, Light};
use umbrage_techniques::{Bias, ShadowMap, TechniquePreset, Techniques};

/// A camera's view of a scene with its sample, and what was tried on it.
pub struct Planner<'a> {
    pub(super) search: Search<'a>,
    pub(super) techniques: Techniques,
    truth: TruthOptions,
    /// Seconds that receivers, sample and truth took.
    pub(super) sampling_seconds: f64,
}

/// Ideal lights take one ray a receiver where others take hundreds: so many times more are sampled.
const IDEAL_LIGHT_FACTOR: usize = 4;
/// Runners-up in a plan, at most.
const RUNNERS_UP: usize = 8;

impl std::fmt::Debug for Planner<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Planner")
            .field("settings tried", &self.search.trials.count())
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
        let start = Instant::now();
        camera.validate()?;
        light.validate()?;
        on_step(Step::Looking);
        let mut scene = PlanScene::new(camera, light, geometry)?;
        let pilot = Pilot::new(&mut scene)?;
        let density = density(&mut scene, pilot.as_ref())?;
        let factor = if light.is_ideal() {
            IDEAL_LIGHT_FACTOR
        } else {
            1
        };
        let sampling = Sampling {
            count: factor * options.samples as usize,
            seed: options.seed,
            truth: options.truth,
        };
        let sampled = SampledTruth::draw(&mut scene, &density, &sampling, on_step)?;
        let verifier = Verifier {
            pilot,
            sampling: sampling.second(),
        };
        Ok(Self {
            search: Search {
                trials: Trials::new(scene, sampled, verifier, options.cost),
                families: Vec::new(),
                on_step,
            },
            techniques: options.registry.clone(),
            truth: options.truth,
            sampling_seconds: start.elapsed().as_secs_f64(),
        })
    }

    /// Finds the cheapest setting within the bounds; without a bound of the error, the most accurate.
    ///
    /// # Errors
    /// Errors if bounds are missing or bad.
    pub fn plan(&mut self, bounds: &Bounds) -> Result<Plan, MeasureError> {
        bounds.validate()?;
        let start = Instant::now();
        let search = &mut self.search;
        search.families = families_for(
            &self.techniques,
            &search.trials.scene,
            bounds.max_bytes.is_some(),
        );
        let found = match bounds.max_error {
            Some(max_error) => search.cheapest(bounds, max_error)?,
            None => search.most_accurate(bounds)?,
        };
        (search.on_step)(Step::Explaining);
        let (chosen, curve, miss) = match found {
            Found::Chosen(place, setting) => {
                let (setting, curve) = self.with_best_bias(place, setting, bounds)?;
                (Some(setting), curve, None)
            }
            Found::Missed(miss) => (None, Vec::new(), Some(miss)),
        };
        let trials = &self.search.trials;
        let facts = Facts::find(trials, &self.truth)?;
        let reasons = facts.reasons(trials, bounds, chosen.as_ref(), &curve)?;
        let scene = &trials.scene;
        Ok(Plan {
            scene: String::new(),
            light: scene.light.kind().to_owned(),
            light_number: 1,
            size: scene.camera.size.to_array(),
            bounds: *bounds,
            runners_up: self.runners_up(chosen.as_ref()),
            chosen,
            miss,
            reasons,
            curve,
            sampled: Sampled {
                receivers: trials.sampled.truth.len(),
                traced: scene.traced(),
                settings: trials.count(),
                looking: self.sampling_seconds,
                trying: start.elapsed().as_secs_f64(),
            },
        })
    }

    /// Returns the chosen setting with the best of all biases, and what all of them do.
    fn with_best_bias(
        &mut self,
        place: Place,
        chosen: Setting,
        bounds: &Bounds,
    ) -> Result<(Setting, Vec<CurvePoint>), MeasureError> {
        let Search {
            trials,
            families,
            on_step,
        } = &mut self.search;
        let family = &families[place.family];
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
            // What was chosen was verified: another bias must hold as well.
            let other = trials.verify(other, bounds.max_error, *on_step)?;
            let is_within = bounds
                .max_error
                .is_none_or(|error| other.estimate.is_surely_within(error));
            if is_within && other.estimate.error < best_setting.estimate.error {
                best_setting = other;
            }
        }
        // One point is no curve: there was nothing to find.
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

    /// Of each technique and map the best bias; of these the front of cost and error, nearest to the chosen one.
    fn runners_up(&self, chosen: Option<&Setting>) -> Vec<Setting> {
        let mut best: Vec<(TechniquePreset, &Setting)> = Vec::new();
        for setting in self
            .search
            .trials
            .all()
            .into_iter()
            .filter(|s| chosen.is_none_or(|c| c.preset != s.preset))
        {
            let unbiased = setting.preset.map().map(|&map| ShadowMap {
                bias: Bias::NONE,
                ..map
            });
            let key = match unbiased {
                Some(map) => setting.preset.with_map(map),
                None => setting.preset.clone(),
            };
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

/// By how many times one setting costs more or less than another: the logarithm of the ratio, 0 for the same cost.
fn cost_distance(setting: &Setting, chosen: &Setting) -> f64 {
    let ratio = setting.milliseconds / chosen.milliseconds.max(1e-9);
    ratio.ln().abs()
}

/// A point of the curve; the one of the chosen setting has its second estimate.
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
