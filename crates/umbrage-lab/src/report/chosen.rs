//! Which rows get pictures: thousands of them would take longer to write and to open than anyone looks at them.

use crate::{
    compare::{Measured, Row, SceneResult},
    pareto,
};
use std::collections::{BTreeMap, BTreeSet};

/// Rows on a backend's Pareto front, each technique's row of least error, and rows whose mask differs from the CPU's.
pub(super) fn rows(result: &SceneResult) -> BTreeSet<usize> {
    let measured: Vec<(usize, &Row, &Measured)> =
        result.rows.iter().enumerate().filter_map(|(i, r)| Some((i, r, r.measured()?))).collect();
    let differing = |m: &Measured| m.agreement.is_some_and(|a| a.differing > 0);
    let mut chosen: BTreeSet<usize> = measured.iter().filter(|(.., m)| differing(m)).map(|(i, ..)| *i).collect();
    let mut backends: BTreeMap<&str, Vec<(usize, [f64; 2])>> = BTreeMap::new();
    let mut best: BTreeMap<&str, (f64, usize)> = BTreeMap::new();
    for (i, row, m) in measured {
        backends.entry(&row.backend).or_default().push((i, [m.times.total.median, m.errors.rmse]));
        let least = best.entry(&row.technique).or_insert((f64::INFINITY, i));
        if m.errors.rmse < least.0 {
            *least = (m.errors.rmse, i);
        }
    }
    for points in backends.values() {
        let front = pareto::front(&points.iter().map(|(_, p)| *p).collect::<Vec<_>>());
        chosen.extend(front.into_iter().map(|k| points[k].0));
    }
    chosen.extend(best.values().map(|(_, i)| *i));
    chosen
}
