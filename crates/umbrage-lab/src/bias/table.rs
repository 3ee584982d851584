//! The rows as files: a CSV of all, and a page that begins with what they come to.

use super::BiasRow;
use crate::{
    LabError,
    output::{Folder, csv},
};
use std::{
    fmt::Write as _,
    path::{Path, PathBuf},
};

/// The default counts as good as tuned by hand up to this ratio of errors.
pub(super) const GOOD: f64 = 1.1;
/// How many of the worst rows the page lists.
const WORST: usize = 12;

/// What some rows come to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    /// Rows.
    pub rows: usize,
    /// Those with a ratio of at most 1.1.
    pub good: usize,
    /// Geometric mean of the ratios.
    pub mean: f64,
    /// The greatest ratio.
    pub max: f64,
    /// Geometric mean of the same ratio for the textbooks' slope bias.
    pub textbook: f64,
    /// Geometric mean of the same ratio for Isidoro's receiver plane.
    pub plane: f64,
}

impl Summary {
    /// Sums rows up.
    pub fn of<'a>(rows: impl Iterator<Item = &'a BiasRow> + Clone) -> Self {
        let count = rows.clone().count();
        let mean = |ratio: &dyn Fn(&BiasRow) -> f64| {
            let logarithms: f64 = rows.clone().map(|row| ratio(row).ln()).sum();
            (logarithms / count.max(1) as f64).exp()
        };
        Self {
            rows: count,
            good: rows.clone().filter(|row| row.ratio() <= GOOD).count(),
            mean: mean(&BiasRow::ratio),
            max: rows.clone().map(BiasRow::ratio).fold(0.0, f64::max),
            textbook: mean(&|row| row.ratio_of(row.textbook)),
            plane: mean(&|row| row.ratio_of(row.plane)),
        }
    }

    fn line(&self, name: &str) -> String {
        let Self {
            rows,
            good,
            mean,
            max,
            textbook,
            plane,
        } = self;
        let share = 100.0 * *good as f64 / (*rows).max(1) as f64;
        format!(
            "| {name} | {rows} | {share:.0} % | {mean:.3} | {max:.2} | {textbook:.2} | {plane:.2} |\n"
        )
    }
}

/// The page: sums by kernel and side, then the worst rows.
pub fn markdown(rows: &[BiasRow]) -> String {
    let mut out = String::from(
        "| kernel, map | rows | within 10 % | mean ratio | greatest | slope .05/.005 | receiver plane alone |\n\
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
        out += &Summary::of(of_group).line(&format!("{kernel}, {side}"));
    }
    out += &Summary::of(rows.iter()).line("all");
    out += "\n| scene | light | kernel | map | default | best by hand | ratio | which |\n|---|---|---|--:|--:|--:|--:|---|\n";
    let mut worst: Vec<&BiasRow> = rows.iter().filter(|row| row.ratio() > GOOD).collect();
    worst.sort_by(|a, b| b.ratio().total_cmp(&a.ratio()));
    for row in worst.into_iter().take(WORST) {
        let own = row
            .played
            .iter()
            .map(|played| played.rmse)
            .fold(0.0, f64::max);
        let BiasRow {
            scene,
            light,
            kernel,
            side,
            best,
            best_bias,
            ..
        } = row;
        let ratio = row.ratio();
        let line = writeln!(
            out,
            "| {scene} | {light} | {kernel} | {side} | {own:.4} | {best:.4} | {ratio:.2} | {best_bias} |"
        );
        line.expect("strings take all that is written");
    }
    out
}

/// Writes `bias.csv` and `bias.md` into a folder, which is made if need be. Returns the page's path.
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

/// One line a row and backend.
fn table(rows: &[BiasRow]) -> Result<Vec<u8>, LabError> {
    let mut lines = Vec::new();
    for row in rows {
        for played in &row.played {
            lines.push([
                row.scene.clone(),
                row.light.clone(),
                row.triangles.to_string(),
                row.kernel.clone(),
                row.side.to_string(),
                row.counted.to_string(),
                played.backend.clone(),
                played.rmse.to_string(),
                row.best.to_string(),
                row.best_bias.clone(),
                row.textbook.to_string(),
                row.plane.to_string(),
                row.ratio_of(played.rmse).to_string(),
            ]);
        }
    }
    csv::of_lines("bias.csv", &HEADER, lines)
}
