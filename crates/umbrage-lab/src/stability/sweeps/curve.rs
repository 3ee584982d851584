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

/// Data of a chart.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sweep {
    /// Name for files.
    pub name: String,
    /// Title for readers.
    pub title: String,
    /// Label of the varied quantity, with its unit.
    pub x: String,
    /// Label of the measure, with its unit.
    pub y: String,
    /// The curves.
    pub curves: Vec<Curve>,
    /// Best value of x, if there is one.
    pub best: Option<f64>,
    /// Greatest passing value of y, if there is one.
    pub limit: Option<f64>,
    /// Number of pixels on which backends differ, among those that rounding doesn't decide; `None`
    /// with a single backend.
    pub disagreeing: Option<u64>,
}

/// A curve of a chart.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    /// Name of the curve.
    pub label: String,
    /// Points as [x, y], by increasing x.
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

    /// Returns the curves' points as CSV, a line each: `curve,x,y`.
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

/// Renders a technique under the case's first light, at point `i` of `count` of a curve.
pub(crate) fn render_point(
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
    // Run the other backends only at the curve's ends and its middle.
    let is_checked = i == 0 || i == count / 2 || i == count - 1;
    let mut backends = backends.lock();
    let own_backends = all_backends::select(&mut backends.backends, is_checked);
    all_backends::render(own_backends, &view, &recipe)
}

/// Returns the error of a sweep with a setting that could not be rendered.
pub(crate) fn sweep_error(
    case_truth: &CaseTruth,
    technique: &dyn ShadowTechnique,
    why: &str,
) -> LabError {
    LabError::NotComparable {
        scene: case_truth.scene.name.clone(),
        what: format!("{}: {why}", technique.name()),
    }
}
