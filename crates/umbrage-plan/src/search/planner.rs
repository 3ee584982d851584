//! The planner, once it has looked at a scene: bounds can be asked about one after the other.

use super::{
    Bounds, CurvePoint, Options, Plan, Sampled, Setting,
    families::{Family, families_for},
    reasons::Facts,
    trial::Trial,
    walk::{Found, Place},
};
use crate::{
    MeasureError,
    estimate::{
        density::{Pilot, density},
        sample::Sample,
        scene::{Known, Look},
        verify::Verifier,
    },
    pareto::front,
    progress::{OnStep, Step},
    truth::TruthOptions,
};
use std::time::Instant;
use umbrage_core::{Camera, Geometry, Light};
use umbrage_techniques::{Bias, Preset, ShadowMap};

/// What is known of a camera's view of a scene, and what was tried on it.
pub struct Planner<'a> {
    pub(super) trial: Trial<'a>,
    pub(super) families: Vec<Family>,
    pub(super) on_step: &'a OnStep<'a>,
    drawn: Draw,
    looking: f64,
}

/// How a sample is drawn and its truth traced.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Draw {
    /// Receivers under lights with an extent.
    count: usize,
    seed: u32,
    truth: TruthOptions,
}

/// Ideal lights take one ray a receiver where others take hundreds: so many times more are sampled.
const MORE_OF_IDEAL: usize = 4;

impl Draw {
    fn known(
        &self,
        look: &mut Look<'_>,
        density: &[f64],
        on_step: &OnStep<'_>,
    ) -> Result<Known, MeasureError> {
        let sample = Sample::draw(look.camera.size, density, self.count(look.light), self.seed);
        let truth = look.truth(&sample.pixels, &self.truth, &|done, total| {
            on_step(Step::Truth(done, total))
        })?;
        let receivers = look
            .receivers
            .receives
            .iter()
            .filter(|receives| **receives)
            .count();
        Ok(Known::of_all(receivers, sample, truth))
    }

    fn count(&self, light: &Light) -> usize {
        self.count * if light.is_ideal() { MORE_OF_IDEAL } else { 1 }
    }

    /// Second samples are others, so that what was chosen by the first is judged without favour.
    fn second_seed(&self) -> u32 {
        self.seed.wrapping_add(0x9e37_79b9)
    }
}

impl std::fmt::Debug for Planner<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Planner")
            .field("settings tried", &self.trial.played())
            .finish_non_exhaustive()
    }
}

impl<'a> Planner<'a> {
    /// Samples the receivers that a camera sees and traces their truth.
    ///
    /// # Errors
    /// When the camera or light is not valid.
    pub fn new(
        camera: &'a Camera,
        light: &'a Light,
        geometry: &'a Geometry,
        options: &Options,
        on_step: &'a OnStep<'a>,
    ) -> Result<Self, MeasureError> {
        let start = Instant::now();
        camera.validate()?;
        light.validate()?;
        on_step(Step::Looking);
        let mut look = Look::new(camera, light, geometry)?;
        let pilot = Pilot::new(&mut look)?;
        let density = density(&mut look, pilot.as_ref())?;
        let drawn = Draw {
            count: options.samples as usize,
            seed: options.seed,
            truth: options.truth,
        };
        let known = drawn.known(&mut look, &density, on_step)?;
        let verifier = Verifier {
            pilot,
            truth: options.truth,
            count: drawn.count(light),
            seed: drawn.second_seed(),
        };
        let trial = Trial::new(look, known, verifier, options.cost);
        let looking = start.elapsed().as_secs_f64();
        Ok(Self {
            trial,
            families: Vec::new(),
            on_step,
            drawn,
            looking,
        })
    }

    /// Seconds that receivers, sample and truth took.
    pub(super) fn looking(&self) -> f64 {
        self.looking
    }

    /// The least within the bounds.
    ///
    /// # Errors
    /// When bounds are missing or bad.
    pub fn plan(&mut self, bounds: &Bounds) -> Result<Plan, MeasureError> {
        bounds.validate()?;
        let start = Instant::now();
        self.families = families_for(&self.trial.look, bounds.max_bytes.is_some());
        let found = match bounds.max_error {
            Some(error) => self.cheapest(bounds, error)?,
            None => self.most_accurate(bounds)?,
        };
        (self.on_step)(Step::Explaining);
        let (chosen, curve, miss) = match found {
            Found::Chosen(place, setting) => {
                let (setting, curve) = self.best_bias(place, setting, bounds)?;
                (Some(setting), curve, None)
            }
            Found::Missed(miss) => (None, Vec::new(), Some(miss)),
        };
        let facts = Facts::find(&self.trial, &self.drawn.truth)?;
        let reasons = facts.reasons(&self.trial, bounds, chosen.as_ref(), &curve)?;
        let look = &self.trial.look;
        Ok(Plan {
            scene: String::new(),
            light: look.light.kind().to_owned(),
            light_number: 1,
            size: look.camera.size.to_array(),
            bounds: *bounds,
            runners_up: self.runners_up(chosen.as_ref()),
            chosen,
            miss,
            reasons,
            curve,
            sampled: Sampled {
                receivers: self.trial.known.truth.len(),
                traced: look.truth.len(),
                settings: self.trial.played(),
                looking: self.looking,
                trying: start.elapsed().as_secs_f64(),
            },
        })
    }

    /// The chosen setting with the best of all biases, and what all of them do.
    fn best_bias(
        &mut self,
        place: Place,
        chosen: Setting,
        bounds: &Bounds,
    ) -> Result<(Setting, Vec<CurvePoint>), MeasureError> {
        let Place { family, size } = place;
        let family = self.families[family].clone();
        let points = if family.preset().map().is_some() {
            self.trial.curve(&family, size)?
        } else {
            Vec::new()
        };
        let affordable = points
            .iter()
            .map(|(.., s)| s)
            .filter(|s| bounds.affords(s.milliseconds, s.bytes));
        let best = affordable.min_by(|a, b| a.estimate.error.total_cmp(&b.estimate.error));
        // What was chosen was verified: another bias must hold as well.
        let best = best
            .filter(|b| b.estimate.error < chosen.estimate.error)
            .cloned();
        let best = best
            .map(|b| self.trial.verify(&b, bounds.max_error, self.on_step))
            .transpose()?;
        let surely = |s: &Setting| {
            bounds
                .max_error
                .is_none_or(|error| s.estimate.is_surely_within(error))
        };
        let best = best
            .filter(|b| surely(b) && b.estimate.error < chosen.estimate.error)
            .unwrap_or(chosen);
        let point = |(kind, texels, setting): &(_, _, Setting)| {
            let chosen = setting.preset == best.preset;
            let estimate = if chosen {
                best.estimate
            } else {
                setting.estimate
            };
            CurvePoint {
                kind: *kind,
                texels: *texels,
                estimate,
                chosen,
            }
        };
        // One point is no curve: there was nothing to find.
        let curve = if points.len() > 1 {
            points.iter().map(point).collect()
        } else {
            Vec::new()
        };
        Ok((best, curve))
    }

    /// Of each technique and map the best bias; of these the front of cost and error, nearest to the chosen one.
    fn runners_up(&self, chosen: Option<&Setting>) -> Vec<Setting> {
        let mut best: Vec<(Preset, &Setting)> = Vec::new();
        for setting in self
            .trial
            .all()
            .into_iter()
            .filter(|s| chosen.is_none_or(|c| c.preset != s.preset))
        {
            let unbiased = setting.preset.map().map(|&map| ShadowMap {
                bias: Bias::NONE,
                ..map
            });
            let key = unbiased.map_or(setting.preset, |map| setting.preset.with_map(map));
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
        // By how many times they cost more or less.
        let far = |s: &Setting| {
            chosen.map_or(0.0, |c| {
                (s.milliseconds / c.milliseconds.max(1e-9)).ln().abs()
            })
        };
        front.sort_by(|a, b| far(a).total_cmp(&far(b)));
        front.truncate(RUNNERS_UP);
        front.sort_by(|a, b| a.milliseconds.total_cmp(&b.milliseconds));
        front.into_iter().cloned().collect()
    }
}

/// How many runners-up are told.
const RUNNERS_UP: usize = 8;
