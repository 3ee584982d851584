//! The planner, once it has looked at a scene: bounds can be asked about one after the other.

use super::{
    Bounds, CurvePoint, OnStep, Options, Plan, Sampled, Setting, Step,
    density::density,
    families::{Family, families},
    look::{Known, Look},
    reasons::Facts,
    sample::Sample,
    trial::Trial,
    walk::{Found, Place},
};
use crate::{LabError, pareto::front};
use std::time::Instant;
use umbrage_core::{Camera, Geometry, Light};

/// What is known of a camera's view of a scene, and what was tried on it.
pub struct Planner<'a> {
    pub(super) trial: Trial<'a>,
    pub(super) families: Vec<Family>,
    pub(super) on_step: &'a OnStep<'a>,
    options: Options,
    looking: f64,
}

impl std::fmt::Debug for Planner<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Planner").field("settings tried", &self.trial.played()).finish_non_exhaustive()
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
    ) -> Result<Self, LabError> {
        let start = Instant::now();
        camera.validate()?;
        light.validate()?;
        on_step(Step::Looking);
        let mut look = Look::new(camera, light, geometry)?;
        let density = density(&mut look)?;
        let count = options.samples as usize * if light.is_ideal() { 4 } else { 1 };
        let sample = Sample::draw(camera.size, &density, count, options.seed);
        let truth = look.truth(&sample.pixels, &options.truth, &|done, total| on_step(Step::Truth(done, total)))?;
        let trial = Trial::new(look, Known::new(sample, truth), options.cost);
        let looking = start.elapsed().as_secs_f64();
        Ok(Self { trial, families: Vec::new(), on_step, options: options.clone(), looking })
    }

    /// Seconds that receivers, sample and truth took.
    pub(super) fn looking(&self) -> f64 {
        self.looking
    }

    /// The least within the bounds.
    ///
    /// # Errors
    /// When bounds are missing or bad.
    pub fn plan(&mut self, bounds: &Bounds) -> Result<Plan, LabError> {
        bounds.validate()?;
        let start = Instant::now();
        self.families = families(self.trial.look.light, bounds.max_bytes.is_some());
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
        let facts = Facts::find(&self.trial, &self.options.truth)?;
        let reasons = facts.reasons(&self.trial, bounds, chosen.as_ref(), &curve)?;
        let look = &self.trial.look;
        Ok(Plan {
            scene: String::new(),
            light: look.light.kind().to_owned(),
            size: look.camera.size.to_array(),
            bounds: *bounds,
            runners_up: self.runners_up(chosen.as_ref()),
            chosen,
            miss,
            reasons,
            curve,
            sampled: Sampled {
                receivers: self.trial.known.truth.len(),
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
    ) -> Result<(Setting, Vec<CurvePoint>), LabError> {
        let Place { family, size } = place;
        let family = self.families[family];
        let points = if family.preset.map().is_some() { self.trial.curve(&family, size)? } else { Vec::new() };
        let affordable = points.iter().map(|(.., s)| s).filter(|s| bounds.affords(s.milliseconds, s.bytes));
        let best = affordable.min_by(|a, b| a.estimate.error.total_cmp(&b.estimate.error));
        let best = best.filter(|b| b.estimate.error < chosen.estimate.error).cloned().unwrap_or(chosen);
        let point = |(kind, texels, setting): &(_, _, Setting)| CurvePoint {
            kind: *kind,
            texels: *texels,
            estimate: setting.estimate,
            chosen: setting.preset == best.preset,
        };
        // One point is no curve: there was nothing to find.
        let curve = if points.len() > 1 { points.iter().map(point).collect() } else { Vec::new() };
        Ok((best, curve))
    }

    fn runners_up(&self, chosen: Option<&Setting>) -> Vec<Setting> {
        let others = self.trial.all().into_iter().filter(|s| chosen.is_none_or(|c| c.preset != s.preset));
        let others: Vec<&Setting> = others.collect();
        let points: Vec<[f64; 2]> = others.iter().map(|s| [s.milliseconds, s.estimate.error]).collect();
        front(&points).into_iter().map(|i| others[i].clone()).collect()
    }
}
