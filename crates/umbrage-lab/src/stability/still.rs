//! Runs still cases: one setting against a case's truth, on every backend.

use super::{
    all_backends,
    case_truth::CaseTruth,
    cell::{Cell, CellOutcome},
    criterion::Criterion,
    guard::{self, NoMask},
    measure::{Measure, SCREEN, rmse},
    measures::cascade_seams,
    pictures,
    threads::SharedBackends,
    verdict::{Judgement, Verdict},
};
use crate::error::LabError;
use umbrage_core::{Light, Receivers, Recipe, ShadowTechnique, View};
use umbrage_plan::{catalogue::Catalogue, cost::Work, motion::draws_the_picture};
use umbrage_techniques::TechniquePreset;

/// A still case, ready to run.
#[derive(Debug)]
pub(super) struct Still<'a> {
    pub(super) case_truth: &'a CaseTruth,
    /// Truth of the same scene at scale 1, for [`Measure::ScaleDrift`].
    pub(super) reference: Option<&'a CaseTruth>,
    pub(super) criteria: &'a [Criterion],
    /// Catalogue with the costs and layers of kernels.
    pub(super) catalogue: &'a Catalogue,
}

/// A mask, and further results of its rendering.
struct RenderedOnAll {
    mask: Vec<f32>,
    /// Fragments that casts draw, millions, for an image of [`SCREEN`].
    fill: f64,
    /// Whether anything is drawn.
    casts: bool,
    /// Cascade of each pixel; `None` if the technique has no cascades.
    cascades: Option<Vec<u32>>,
    disagreeing: Option<u64>,
}

/// Reason why fill is not measured if nothing is drawn.
const CASTS_NOTHING: &str = "it draws nothing; `compare` reports the cost of its rays";
/// Reason why seams between cascades are not measured without any.
const NO_SEAM: &str = "no two cascades meet in the image";

impl Still<'_> {
    /// Runs one setting and returns its cell.
    pub(super) fn cell(
        &self,
        technique: &TechniquePreset,
        backends: &SharedBackends<'_>,
    ) -> Result<Cell, LabError> {
        let executed = match self.render_all_lights(self.case_truth, technique, backends) {
            Ok(executed) => executed,
            Err(why) => return Ok(no_mask(technique, why)),
        };
        let mut judgements = Vec::new();
        for criterion in self.criteria {
            if criterion.measure == Measure::Fill && !executed.casts {
                judgements.push(Judgement::not_measured(CASTS_NOTHING));
                continue;
            }
            if criterion.measure == Measure::CascadeSeams {
                let seams = self.cascade_seams(&executed);
                judgements.push(seams.map_or(Judgement::not_measured(NO_SEAM), |figure| {
                    criterion.limits.judgement(figure)
                }));
                continue;
            }
            match self.figure(criterion.measure, &executed, technique, backends) {
                Ok(figure) => judgements.push(criterion.limits.judgement(figure)),
                Err(why) => return Ok(no_mask(technique, why)),
            }
        }
        let mut out = cell(technique, CellOutcome::from_judgements(judgements));
        out.disagreeing = executed.disagreeing;
        if out.verdict() > Some(Verdict::NotMeasured) {
            out.picture = Some(pictures::side_by_side(self.case_truth, &executed.mask)?);
        }
        Ok(out)
    }

    /// Returns the figure of [`Measure::CascadeSeams`]; `None` if no two cascades meet.
    fn cascade_seams(&self, executed: &RenderedOnAll) -> Option<f64> {
        let truth = &self.case_truth.truth;
        cascade_seams::excess(
            truth.size,
            &executed.mask,
            &truth.visibility,
            executed.cascades.as_ref()?,
            |i| self.case_truth.counts(i),
        )
    }

    /// Returns a measure's figure of a rendering. For a comparison with scale 1, runs the technique
    /// there, too.
    fn figure(
        &self,
        measure: Measure,
        executed: &RenderedOnAll,
        technique: &dyn ShadowTechnique,
        backends: &SharedBackends<'_>,
    ) -> Result<f64, NoMask> {
        match (measure, self.reference) {
            (Measure::Fill, _) => Ok(executed.fill),
            (Measure::ScaleDrift(_), Some(reference)) => {
                let at_one = self.render_all_lights(reference, technique, backends)?;
                let rmse_at_one = rmse(reference, &at_one.mask);
                Ok((rmse(self.case_truth, &executed.mask) - rmse_at_one).abs())
            }
            (measure, _) => Ok(measure.figure(self.case_truth, &executed.mask)),
        }
    }

    /// Returns the mean mask over the case's lights on the first backend, and the number of pixels
    /// on which the others differ from it.
    fn render_all_lights(
        &self,
        case_truth: &CaseTruth,
        technique: &dyn ShadowTechnique,
        backends: &SharedBackends<'_>,
    ) -> Result<RenderedOnAll, NoMask> {
        let mut all: Option<RenderedOnAll> = None;
        for light in &case_truth.lights {
            let one = self.render_under_light(light, case_truth, technique, backends)?;
            all = Some(match all {
                None => one,
                Some(sum) => sum.plus(one),
            });
        }
        let mut all = all.ok_or_else(|| NoMask::Unsupported("there is no light".to_owned()))?;
        let light_count = case_truth.lights.len() as f32;
        for visibility in &mut all.mask {
            *visibility /= light_count;
        }
        Ok(all)
    }

    /// Renders a technique under one light.
    fn render_under_light(
        &self,
        light: &Light,
        case_truth: &CaseTruth,
        technique: &dyn ShadowTechnique,
        backends: &SharedBackends<'_>,
    ) -> Result<RenderedOnAll, NoMask> {
        let view = case_truth.view(light);
        let recipe = guard::plan(technique, &view.with_receivers(&case_truth.truth.receivers))?;
        let rendered = all_backends::render(&mut backends.lock().backends, &view, &recipe)?;
        Ok(RenderedOnAll {
            mask: rendered.mask,
            fill: self.fill(&recipe, &view),
            casts: !recipe.casts.is_empty(),
            cascades: self.cascades(light, &recipe, &case_truth.truth.receivers),
            disagreeing: rendered.disagreeing,
        })
    }

    /// Returns each pixel's cascade; `None` if the recipe has no cascades. Only a directional
    /// light's map has several layers that aren't a cube's.
    fn cascades(&self, light: &Light, recipe: &Recipe, receivers: &Receivers) -> Option<Vec<u32>> {
        if light.position().is_some() {
            return None;
        }
        let kernel = self.catalogue.kernel(recipe);
        let pixels = 0..receivers.len();
        pixels
            .map(|i| kernel.layer(receivers.position(i)))
            .collect()
    }

    /// Returns the number of fragments that casts draw for an image of [`SCREEN`] pixels, millions.
    /// Casts into images of the camera's size grow with its pixels.
    fn fill(&self, recipe: &Recipe, view: &View<'_>) -> f64 {
        let covered = Work::of_recipe(view, recipe, self.catalogue).covered as f64 * 1e-6;
        let pixels = f64::from(view.camera.size.x) * f64::from(view.camera.size.y) * 1e-6;
        if draws_the_picture(recipe, view.camera) {
            covered * SCREEN / pixels
        } else {
            covered
        }
    }
}

/// Returns a cell without an image.
pub(super) fn cell(technique: &TechniquePreset, outcome: CellOutcome) -> Cell {
    Cell {
        technique: technique.name().to_owned(),
        settings: technique.settings(),
        outcome,
        disagreeing: None,
        picture: None,
    }
}

/// Returns the cell of a setting without a mask.
pub(super) fn no_mask(technique: &TechniquePreset, why: NoMask) -> Cell {
    let outcome = match why {
        NoMask::Unsupported(reason) => CellOutcome::Unsupported { reason },
        NoMask::Fault(what) => CellOutcome::Fault { what },
    };
    cell(technique, outcome)
}

impl RenderedOnAll {
    /// Adds two renderings; the mask is a sum, too.
    fn plus(mut self, other: Self) -> Self {
        for (sum, visibility) in self.mask.iter_mut().zip(&other.mask) {
            *sum += visibility;
        }
        self.fill += other.fill;
        self.casts |= other.casts;
        self.disagreeing = all_backends::sum(self.disagreeing, other.disagreeing);
        self
    }
}
