//! The matrix as a page, a picture, a table and data.

mod page;
mod svg;

use super::{Outcome, Stability, sweeps::Sweep};
use crate::{LabError, output::Folder};
use std::path::{Path, PathBuf};

/// Writes `index.html` (opens alone), `matrix.svg`, `matrix.csv`, `results.json`, and for each sweep an SVG and a CSV.
/// Returns the page's path. The figures' files hold nothing that changes from run to run: no dates, no times.
///
/// # Errors
/// When the folder can't be written.
pub fn write(folder: &Path, stability: &Stability, sweeps: &[Sweep]) -> Result<PathBuf, LabError> {
    let out = Folder::create(folder)?;
    out.write("matrix.csv", &csv(stability)?)?;
    out.write("matrix.svg", svg::matrix(stability).as_bytes())?;
    out.write("results.json", &json(&(stability, sweeps))?)?;
    if !sweeps.is_empty() {
        let inner = out.inner("sweeps")?;
        for sweep in sweeps {
            inner.write(&format!("{}.svg", sweep.name), sweep.svg().as_bytes())?;
            inner.write(&format!("{}.csv", sweep.name), &sweep.csv()?)?;
        }
    }
    out.write("index.html", page::html(stability, sweeps)?.as_bytes())?;
    Ok(folder.join("index.html"))
}

/// Pretty, so that changes show line by line.
fn json(data: &impl serde::Serialize) -> Result<Vec<u8>, LabError> {
    serde_json::to_vec_pretty(data).map_err(|e| LabError::Write {
        path: "results.json".into(),
        source: e.into(),
    })
}

const HEADER: [&str; 14] = [
    "row",
    "case",
    "scene",
    "motion",
    "measure",
    "unit",
    "pass",
    "fails",
    "ideal",
    "technique",
    "settings",
    "figure",
    "verdict",
    "reason",
];

/// One line a cell.
fn csv(stability: &Stability) -> Result<Vec<u8>, LabError> {
    let failed = |source| LabError::Write {
        path: "matrix.csv".into(),
        source,
    };
    let mut out = csv::Writer::from_writer(Vec::new());
    out.write_record(HEADER).map_err(|e| failed(e.into()))?;
    for case in &stability.cases {
        for cell in &case.cells {
            let (verdict, reason) = match &cell.outcome {
                Outcome::Measured { verdict, .. } => (verdict.word(), ""),
                Outcome::Unsupported { reason } => ("unsupported", reason.as_str()),
                Outcome::Fault { what } => ("fault", what.as_str()),
            };
            let figure = cell.figure().map_or_else(String::new, |f| f.to_string());
            let limits = [case.limits.pass, case.limits.fails, case.ideal].map(|v| v.to_string());
            let [row, pass, fails, ideal] =
                [&case.row.to_string(), &limits[0], &limits[1], &limits[2]];
            let record = [
                row,
                &case.case,
                &case.scene,
                &case.motion,
                &case.measure,
                &case.unit,
                pass,
                fails,
                ideal,
                &cell.technique,
                &cell.settings,
                &figure,
                verdict,
                reason,
            ];
            out.write_record(record).map_err(|e| failed(e.into()))?;
        }
    }
    out.into_inner().map_err(|e| failed(e.into_error()))
}

#[cfg(test)]
mod tests;
