//! Writes the matrix as a page with image files, one image of the matrix, a table and data.

mod page;
mod pictures;
mod results;
mod svg;

pub use results::{STABILITY_SCHEMA, StabilityResults};

use super::{
    bias_window::Base,
    cell::{CellOutcome, Stability},
};
use crate::{
    error::LabError,
    output::{csv, folder::Folder},
};
use std::path::{Path, PathBuf};

/// Writes `index.html`, the cells' images in `pictures/`, `matrix.svg`, `matrix.csv`,
/// `windows.csv`, `results.json`, and for each sweep an SVG and a CSV in `sweeps/`. Returns the
/// page's path.
///
/// The page works from a file, and refers to the other files of the folder. Files with figures have
/// no dates or times, so equal runs write equal files.
///
/// # Errors
/// Errors if the folder can't be written.
pub fn write(folder: &Path, results: &StabilityResults) -> Result<PathBuf, LabError> {
    let out = Folder::create(folder)?;
    let stability = &results.stability;
    out.write("matrix.csv", &matrix(stability)?)?;
    out.write("windows.csv", &windows(stability)?)?;
    out.write("matrix.svg", svg::matrix(stability).as_bytes())?;
    out.write(results::FILE, &json(results)?)?;
    pictures::write(&out, stability, &results.pictures)?;
    // Replace the folder as a whole, so that sweeps of an older run are removed.
    let inner = out.unfinished_folder(SWEEPS)?;
    for sweep in &results.sweeps {
        inner.write(&format!("{}.svg", sweep.name), sweep.svg().as_bytes())?;
        inner.write(&format!("{}.csv", sweep.name), &sweep.csv()?)?;
    }
    out.finish(SWEEPS)?;
    out.write("index.html", page::html(results)?.as_bytes())?;
    Ok(folder.join("index.html"))
}

/// Folder of the sweeps' charts and tables, next to the page.
const SWEEPS: &str = "sweeps";

/// Returns indented JSON, so that differences show line by line.
fn json(data: &impl serde::Serialize) -> Result<Vec<u8>, LabError> {
    serde_json::to_vec_pretty(data).map_err(|e| LabError::write("results.json", e))
}

const HEADER: [&str; 15] = [
    "row",
    "case",
    "scene",
    "motion",
    "technique",
    "settings",
    "cell",
    "measure",
    "unit",
    "pass",
    "fails",
    "ideal",
    "figure",
    "verdict",
    "reason",
];

/// Returns the matrix as CSV: a line per cell and criterion of its case. `cell` is the cell's
/// verdict, the worst of its criteria's.
fn matrix(stability: &Stability) -> Result<Vec<u8>, LabError> {
    let mut lines = Vec::new();
    for case in &stability.cases {
        for cell in &case.cells {
            let (cell_verdict, reason) = match &cell.outcome {
                CellOutcome::Measured { verdict, .. } => (verdict.word(), ""),
                CellOutcome::Unsupported { reason } => ("unsupported", reason.as_str()),
                CellOutcome::Fault { what } => ("fault", what.as_str()),
            };
            for (k, criterion) in case.criteria.iter().enumerate() {
                let judgement = cell.judgements().get(k);
                let figure = judgement.and_then(|j| j.figure);
                let not_measured = judgement.and_then(|j| j.reason.as_deref());
                let verdict = judgement.map_or(cell_verdict, |j| j.verdict.word());
                lines.push([
                    case.row.to_string(),
                    case.case.clone(),
                    case.scene.clone(),
                    case.motion.clone(),
                    cell.technique.clone(),
                    cell.settings.clone(),
                    cell_verdict.to_owned(),
                    criterion.measure.clone(),
                    criterion.unit.clone(),
                    criterion.limits.pass.to_string(),
                    criterion.limits.fails.to_string(),
                    criterion.ideal.to_string(),
                    figure.map_or_else(String::new, |f| f.to_string()),
                    verdict.to_owned(),
                    not_measured.unwrap_or(reason).to_owned(),
                ]);
            }
        }
    }
    csv::of_lines("matrix.csv", &HEADER, lines)
}

/// Returns the bias windows as CSV, a line each: texels, empty if no amount passes.
fn windows(stability: &Stability) -> Result<Vec<u8>, LabError> {
    let mut lines = Vec::new();
    for window in &stability.windows {
        let [from, to] = match window.passes {
            Some(ends) => ends.map(|end| end.to_string()),
            None => [String::new(), String::new()],
        };
        let base = match window.base {
            Base::Own => "own",
            Base::Bare => "bare",
        };
        lines.push([
            window.technique.clone(),
            window.settings.clone(),
            base.to_owned(),
            window.width().to_string(),
            from,
            to,
        ]);
    }
    let header = ["technique", "settings", "base", "width", "from", "to"];
    csv::of_lines("windows.csv", &header, lines)
}

#[cfg(test)]
mod tests;
