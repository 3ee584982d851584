//! Which rows get pictures: thousands of them would take longer to write and to open than anyone looks at them.

use crate::compare::{CompareRow, CostBasis, Measured, SceneResult};
use std::collections::{BTreeMap, BTreeSet};
use umbrage_plan::pareto;

/// Rows on a backend's Pareto front of either clock, each technique's row of least error, and rows whose mask differs from
/// the CPU's.
pub(super) fn rows(result: &SceneResult) -> BTreeSet<usize> {
    let mut best: BTreeMap<&str, (f64, usize)> = BTreeMap::new();
    let mut chosen = BTreeSet::new();
    for (i, row, m) in measured(result) {
        let least = best.entry(&row.technique).or_insert((f64::INFINITY, i));
        let rmse = m.rmse().unwrap_or_default();
        if rmse < least.0 {
            *least = (rmse, i);
        }
        if m.agreement.is_some_and(|a| a.differing > 0) {
            chosen.insert(i);
        }
    }
    chosen.extend(best.values().map(|(_, i)| *i));
    chosen.extend(
        [CostBasis::Wall, CostBasis::Cost]
            .map(|clock| fronts(result, clock))
            .concat(),
    );
    chosen
}

/// Rows on their backend's Pareto front of time against error, backend by backend.
pub(super) fn fronts(result: &SceneResult, clock: CostBasis) -> Vec<usize> {
    let mut backends: BTreeMap<&str, Vec<(usize, [f64; 2])>> = BTreeMap::new();
    for (i, row, m) in measured(result) {
        if let Some(ms) = m.milliseconds(clock) {
            backends
                .entry(&row.backend)
                .or_default()
                .push((i, [ms, m.rmse().unwrap_or_default()]));
        }
    }
    let front = |points: &Vec<(usize, [f64; 2])>| {
        pareto::front(&points.iter().map(|(_, p)| *p).collect::<Vec<_>>())
            .into_iter()
            .map(|k| points[k].0)
            .collect()
    };
    backends
        .values()
        .flat_map(|points| -> Vec<usize> { front(points) })
        .collect()
}

fn measured(result: &SceneResult) -> impl Iterator<Item = (usize, &CompareRow, &Measured)> {
    result
        .rows
        .iter()
        .enumerate()
        .filter_map(|(i, r)| Some((i, r, r.measured()?)))
}
