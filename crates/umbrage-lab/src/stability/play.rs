//! Still cases: every setting against one case's truth, on every backend.

use super::{
    Cell, CellOutcome, Verdict, VerdictLimits, all_backends,
    case_truth::CaseTruth,
    guard::{self, NoMask},
    measure::{Measure, SCREEN, rmse},
    pictures,
    row::StabilityCase,
};
use crate::{LabError, compare::Backends};
use umbrage_core::{Camera, Light, Recipe, ShadowTechnique, View, Work};

/// A still case, ready to be played.
#[derive(Debug)]
pub(super) struct Still<'a> {
    pub(super) case: &'a StabilityCase,
    pub(super) case_truth: &'a CaseTruth,
    /// The same scene at scale 1, for [`Measure::ScaleDrift`].
    pub(super) reference: Option<&'a CaseTruth>,
    pub(super) limits: VerdictLimits,
}

/// A mask with what else is asked of its rendering.
struct RenderedOnAll {
    mask: Vec<f32>,
    /// Fragments that casts draw, millions, for a picture of [`SCREEN`].
    fill: f64,
    disagreeing: Option<u64>,
}

impl Still<'_> {
    /// One setting's cell.
    pub(super) fn cell(
        &self,
        technique: &dyn ShadowTechnique,
        backends: &mut Backends,
    ) -> Result<Cell, LabError> {
        let played = match play(self.case_truth, technique, backends) {
            Ok(played) => played,
            Err(why) => return Ok(no_mask(technique, why)),
        };
        let figure = match (self.case.measure, self.reference) {
            (Measure::Fill, _) => played.fill,
            (Measure::ScaleDrift(_), Some(reference)) => match play(reference, technique, backends)
            {
                Ok(at_one) => {
                    (rmse(self.case_truth, &played.mask) - rmse(reference, &at_one.mask)).abs()
                }
                Err(why) => return Ok(no_mask(technique, why)),
            },
            (measure, _) => measure.figure(self.case_truth, &played.mask),
        };
        let verdict = self.limits.judge(figure);
        let worse = verdict != Verdict::Pass;
        let picture = worse
            .then(|| pictures::beside(self.case_truth, &played.mask))
            .transpose()?;
        Ok(Cell {
            picture,
            disagreeing: played.disagreeing,
            ..cell(technique, CellOutcome::Measured { figure, verdict })
        })
    }
}

pub(super) fn cell(technique: &dyn ShadowTechnique, outcome: CellOutcome) -> Cell {
    let (technique, settings) = (technique.name().to_owned(), technique.settings());
    Cell {
        technique,
        settings,
        outcome,
        disagreeing: None,
        picture: None,
    }
}

pub(super) fn no_mask(technique: &dyn ShadowTechnique, why: NoMask) -> Cell {
    let outcome = match why {
        NoMask::Unsupported(reason) => CellOutcome::Unsupported { reason },
        NoMask::Fault(what) => CellOutcome::Fault { what },
    };
    cell(technique, outcome)
}

/// The mean mask over the case's lights on the first backend; the others must agree with it.
fn play(
    case_truth: &CaseTruth,
    technique: &dyn ShadowTechnique,
    backends: &mut Backends,
) -> Result<RenderedOnAll, NoMask> {
    let mut all: Option<RenderedOnAll> = None;
    for light in &case_truth.lights {
        let one = under(light, case_truth, technique, backends)?;
        all = Some(match all {
            None => one,
            Some(sum) => sum.plus(one),
        });
    }
    let n = case_truth.lights.len() as f32;
    let mut all = all.ok_or_else(|| NoMask::Unsupported("there is no light".to_owned()))?;
    all.mask.iter_mut().for_each(|v| *v /= n);
    Ok(all)
}

impl RenderedOnAll {
    fn plus(mut self, other: Self) -> Self {
        self.mask
            .iter_mut()
            .zip(&other.mask)
            .for_each(|(a, b)| *a += b);
        self.fill += other.fill;
        self.disagreeing = all_backends::sum(self.disagreeing, other.disagreeing);
        self
    }
}

fn under(
    light: &Light,
    case_truth: &CaseTruth,
    technique: &dyn ShadowTechnique,
    backends: &mut Backends,
) -> Result<RenderedOnAll, NoMask> {
    let view = case_truth.view(light);
    let recipe = guard::plan(technique, &view.with_receivers(&case_truth.truth.receivers))?;
    let all_backends::RenderedOnAll { mask, disagreeing } =
        all_backends::render(&mut backends.playing, &view, &recipe)?;
    Ok(RenderedOnAll {
        fill: fill(&recipe, &view),
        mask,
        disagreeing,
    })
}

/// Fragments that casts draw, millions, for a picture of [`SCREEN`]: casts into images of the camera's size grow with its
/// pixels.
fn fill(recipe: &Recipe, view: &View<'_>) -> f64 {
    let covered = Work::of(view, recipe).covered as f64 * 1e-6;
    let pixels = f64::from(view.camera.size.x) * f64::from(view.camera.size.y) * 1e-6;
    if draws_the_picture(recipe, view.camera) {
        covered * SCREEN / pixels
    } else {
        covered
    }
}

/// Whether a recipe casts into the camera's own picture.
pub(super) fn draws_the_picture(recipe: &Recipe, camera: &Camera) -> bool {
    recipe
        .casts
        .iter()
        .any(|cast| recipe.images[cast.image].size == camera.size)
}
