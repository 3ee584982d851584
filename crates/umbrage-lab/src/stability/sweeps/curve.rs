//! The curves of a sweep, and the rendering of their points.

use crate::{
    error::LabError,
    output::csv,
    stability::{
        all_backends::{self, RenderedOnAll},
        case_truth::CaseTruth,
        guard::{self, NoMask},
        threads::SharedBackends,
    },
};
use serde::{Deserialize, Serialize};
use umbrage_core::ShadowTechnique;

/// A chart's data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sweep {
    /// For file names.
    pub name: String,
    /// For people.
    pub title: String,
    /// What is varied, with its unit.
    pub x: String,
    /// What is measured, with its unit.
    pub y: String,
    /// The curves.
    pub curves: Vec<Curve>,
    /// The best value of x, where there is one.
    pub best: Option<f64>,
    /// The value of y up to which a result passes, where there is one.
    pub limit: Option<f64>,
    /// On how many pixels backends differ, of those whose visibility doesn't depend on rounding;
    /// none with a single backend.
    pub disagreeing: Option<u64>,
}

/// One curve.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    /// Its name.
    pub label: String,
    /// Points as [x, y], x growing.
    pub points: Vec<[f64; 2]>,
}

impl Sweep {
    /// Returns a message if backends disagree.
    pub fn fault(&self) -> Option<String> {
        let n = self.disagreeing.filter(|n| *n > 0)?;
        Some(format!(
            "sweep {}: backends differ on {n} decided pixels",
            self.name
        ))
    }

    /// Returns the curves' points as CSV, a line for each: `curve,x,y`.
    ///
    /// # Errors
    /// Errors if the table can't be written.
    pub fn csv(&self) -> Result<Vec<u8>, LabError> {
        let mut lines = Vec::new();
        for curve in &self.curves {
            for [x, y] in &curve.points {
                lines.push([curve.label.clone(), x.to_string(), y.to_string()]);
            }
        }
        csv::of_lines(&self.name, &["curve", &self.x, &self.y], lines)
    }
}

/// Plays a technique under the case's first light, at point `i` of `count` of a curve.
pub(crate) fn play(
    case_truth: &CaseTruth,
    technique: &dyn ShadowTechnique,
    backends: &SharedBackends<'_>,
    i: usize,
    count: usize,
) -> Result<RenderedOnAll, NoMask> {
    let view = case_truth
        .view(&case_truth.lights[0])
        .with_receivers(&case_truth.truth.receivers);
    let recipe = guard::plan(technique, &view)?;
    // Other backends play the curve's ends and its middle.
    let is_checked = i == 0 || i == count / 2 || i == count - 1;
    let mut backends = backends.lock();
    let playing = all_backends::select(&mut backends.playing, is_checked);
    all_backends::render(playing, &view, &recipe)
}

/// Returns the error of a sweep with a setting that could not be played.
pub(crate) fn not_played(
    case_truth: &CaseTruth,
    technique: &dyn ShadowTechnique,
    why: &str,
) -> LabError {
    LabError::NotComparable {
        scene: case_truth.scene.name.clone(),
        what: format!("{}: {why}", technique.name()),
    }
}
