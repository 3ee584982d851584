//! Writes the rows as files: a CSV table, and a page with a summary.

use super::BiasRow;
use crate::{
    error::LabError,
    output::{csv, folder::Folder},
};
use std::{
    fmt::Write as _,
    path::{Path, PathBuf},
};

/// Maximum ratio of errors at which the default bias counts as equal to manual tuning.
pub(super) const GOOD: f64 = 1.1;
/// Number of worst rows on the page.
const WORST: usize = 12;

/// Summary of some rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    /// Number of rows.
    pub rows: usize,
    /// Number of rows with a ratio of at most 1.1.
    pub good: usize,
    /// Geometric mean of the ratios.
    pub mean: f64,
    /// Maximum ratio.
    pub max: f64,
    /// Geometric mean of the ratio of the textbook slope bias.
    pub textbook: f64,
    /// Geometric mean of the ratio of Isidoro's receiver plane bias.
    pub plane: f64,
}

impl Summary {
    /// Summarises rows.
    pub fn from_rows<'a>(rows: impl Iterator<Item = &'a BiasRow> + Clone) -> Self {
        let ratios = rows.clone().map(BiasRow::ratio);
        let textbook = rows.clone().map(|row| row.ratio_of(row.textbook));
        let plane = rows.clone().map(|row| row.ratio_of(row.plane));
        Self {
            rows: rows.count(),
            good: ratios.clone().filter(|ratio| *ratio <= GOOD).count(),
            mean: geometric_mean(ratios.clone()),
            max: ratios.fold(0.0, f64::max),
            textbook: geometric_mean(textbook),
            plane: geometric_mean(plane),
        }
    }

    /// Returns the summary as a line of the page's table.
    fn line(&self, name: &str) -> String {
        let percent = 100.0 * self.good as f64 / self.rows.max(1) as f64;
        format!(
            "| {name} | {} | {percent:.0} % | {:.3} | {:.2} | {:.2} | {:.2} |\n",
            self.rows, self.mean, self.max, self.textbook, self.plane
        )
    }
}

/// Returns the geometric mean of positive numbers. 1 without numbers.
fn geometric_mean(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let count = values.clone().count();
    let logarithms: f64 = values.map(f64::ln).sum();
    (logarithms / count.max(1) as f64).exp()
}

/// Returns the page: summaries by kernel and map size, then the worst rows.
pub fn markdown(rows: &[BiasRow]) -> String {
    let mut out = String::from(
        "| kernel, map | rows | within 10 % | mean ratio | maximum | slope .05/.005 | receiver plane only |\n\
         |---|--:|--:|--:|--:|--:|--:|\n",
    );
    let mut groups: Vec<(&str, u32)> = Vec::new();
    for row in rows {
        let group = (row.kernel.as_str(), row.side);
        if !groups.contains(&group) {
            groups.push(group);
        }
    }
    for (kernel, side) in groups {
        let of_group = rows
            .iter()
            .filter(|row| row.kernel == kernel && row.side == side);
        out += &Summary::from_rows(of_group).line(&format!("{kernel}, {side}"));
    }
    out += &Summary::from_rows(rows.iter()).line("all");
    out += "\n| scene | light | kernel | map | default | best tuned | ratio | best bias |\n|---|---|---|--:|--:|--:|--:|---|\n";
    let mut worst: Vec<&BiasRow> = rows.iter().filter(|row| row.ratio() > GOOD).collect();
    worst.sort_by(|a, b| b.ratio().total_cmp(&a.ratio()));
    for row in worst.into_iter().take(WORST) {
        let default = row
            .default_errors
            .iter()
            .map(|rendered| rendered.rmse)
            .fold(0.0, f64::max);
        let ratio = row.ratio();
        let _ = writeln!(
            out,
            "| {} | {} | {} | {} | {default:.4} | {:.4} | {ratio:.2} | {} |",
            row.scene, row.light, row.kernel, row.side, row.best, row.best_bias
        );
    }
    out
}

/// Writes `bias.csv` and `bias.md` into a folder, which is created if necessary. Returns the page's
/// path.
///
/// # Errors
/// Errors if they cannot be written.
pub fn write(rows: &[BiasRow], folder: &Path) -> Result<PathBuf, LabError> {
    let out = Folder::create(folder)?;
    out.write("bias.csv", &table(rows)?)?;
    out.write("bias.md", markdown(rows).as_bytes())?;
    Ok(folder.join("bias.md"))
}

const HEADER: [&str; 13] = [
    "scene",
    "light",
    "triangles",
    "kernel",
    "side",
    "counted",
    "backend",
    "rmse",
    "best",
    "best_bias",
    "textbook",
    "plane",
    "ratio",
];

/// Returns the CSV table with a line for each row and backend.
fn table(rows: &[BiasRow]) -> Result<Vec<u8>, LabError> {
    let mut lines = Vec::new();
    for row in rows {
        for rendered in &row.default_errors {
            lines.push([
                row.scene.clone(),
                row.light.clone(),
                row.triangles.to_string(),
                row.kernel.clone(),
                row.side.to_string(),
                row.counted.to_string(),
                rendered.backend.clone(),
                rendered.rmse.to_string(),
                row.best.to_string(),
                row.best_bias.clone(),
                row.textbook.to_string(),
                row.plane.to_string(),
                row.ratio_of(rendered.rmse).to_string(),
            ]);
        }
    }
    csv::of_lines("bias.csv", &HEADER, lines)
}
