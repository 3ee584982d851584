//! Selects the rows with images: images of thousands of rows take too long to write and to open.

use crate::compare::{CompareRow, CostBasis, Measured, SceneResult, Section};
use std::collections::{BTreeMap, BTreeSet};
use umbrage_plan::pareto;

/// Returns the rows with images. They are the rows on a backend's Pareto front of either clock,
/// each technique's row of least error, and the rows whose mask differs from the CPU's. On frames
/// of real size they also include all rows of the first backend, for the page's charts.
pub(super) fn rows(result: &SceneResult) -> BTreeSet<usize> {
    let mut best: BTreeMap<&str, (f64, usize)> = BTreeMap::new();
    let mut chosen = BTreeSet::new();
    for (i, row, m) in measured_rows(result) {
        let least = best.entry(&row.technique).or_insert((f64::INFINITY, i));
        let rmse = m.rmse().unwrap_or(f64::INFINITY);
        if rmse < least.0 {
            *least = (rmse, i);
        }
        if m.agreement.is_some_and(|a| a.differing > 0) {
            chosen.insert(i);
        }
    }
    chosen.extend(of_content(result));
    chosen.extend(best.values().map(|(_, i)| *i));
    chosen.extend(fronts(result, CostBasis::Wall));
    chosen.extend(fronts(result, CostBasis::Cost));
    chosen
}

/// Returns the rows of the first backend on a frame of real size, without repetitions; empty on
/// other scenes.
fn of_content(result: &SceneResult) -> Vec<usize> {
    let Some(first) = result.rows.first() else {
        return Vec::new();
    };
    let is_content = result.section == Section::Content;
    let rows = measured_rows(result)
        .filter(|(_, row, _)| is_content && row.backend == first.backend && row.same_as.is_none());
    rows.map(|(i, _, _)| i).collect()
}

/// Returns the rows on their backend's Pareto front of time against error, backend by backend.
pub(super) fn fronts(result: &SceneResult, clock: CostBasis) -> Vec<usize> {
    let mut backends: BTreeMap<&str, BackendPoints> = BTreeMap::new();
    for (i, row, m) in measured_rows(result).filter(|(_, row, _)| row.same_as.is_none()) {
        if let Some(ms) = m.milliseconds(clock, result.motion) {
            let of_backend = backends.entry(&row.backend).or_default();
            of_backend.rows.push(i);
            of_backend.points.push([ms, m.rmse().unwrap_or(f64::NAN)]);
        }
    }
    let mut out = Vec::new();
    for of_backend in backends.values() {
        for k in pareto::front(&of_backend.points) {
            out.push(of_backend.rows[k]);
        }
    }
    out
}

/// Rows of one backend: their indices, and the time and error of each.
#[derive(Default)]
struct BackendPoints {
    rows: Vec<usize>,
    points: Vec<[f64; 2]>,
}

/// Returns the measured rows, each with its index and its figures.
fn measured_rows(result: &SceneResult) -> impl Iterator<Item = (usize, &CompareRow, &Measured)> {
    result
        .rows
        .iter()
        .enumerate()
        .filter_map(|(i, r)| Some((i, r, r.measured_figures()?)))
}
