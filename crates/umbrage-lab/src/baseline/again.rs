//! Times rows again that look slower, before they count as slower.

use super::{
    changes::Changes,
    times::{RatioSample, Suspect},
};
use crate::{
    compare::{Again, Backends, CompareOptions, Ranks, Runs, SceneInput, time_rows_again},
    error::LabError,
};
use std::collections::BTreeMap;

/// Number of rounds in which suspects are timed again. Between two timings of a row all others are
/// timed, so that noise that lasts for seconds affects different rows.
pub const ROUNDS: usize = 3;

/// Maximum number of rounds until rows have enough undisturbed runs.
const MAX_ROUNDS: usize = 10;

/// Runs of a row in one round.
const RUNS: Runs = Runs {
    min: 9,
    max: 15,
    budget_ms: 200,
    once_from_ms: u32::MAX,
};

/// Results of timing again, by the scene's index and the row's stem.
type Fresh = BTreeMap<(usize, String), Again>;

/// Times suspects again, and moves those that are still slower to [`Changes::worse`]. `inputs` are
/// the scenes of the new results, in their order.
///
/// # Errors
/// Errors if a scene can't be run again.
pub fn time_again(
    changes: &mut Changes,
    inputs: &[SceneInput],
    options: &CompareOptions,
    backends: &mut Backends,
) -> Result<(), LabError> {
    // Time all suspects in rounds, until they are cleared.
    let suspects = std::mem::take(&mut changes.suspects);
    let mut fresh = Fresh::new();
    let mut open: Vec<&Suspect> = suspects.iter().collect();
    for round in 0..MAX_ROUNDS {
        let mut wanted = open.clone();
        if round >= ROUNDS {
            wanted.retain(|suspect| suspect.lacks_calm_runs(&known_ratios(suspect, &fresh)));
        }
        for (scene, (stems, device_units)) in stems_by_scene(&wanted) {
            let Some(input) = inputs.get(scene) else {
                continue;
            };
            let found = time_rows_again(input, &stems, device_units, options, &RUNS, backends)?;
            for (stem, more) in stems.into_iter().zip(found) {
                if let Some(more) = more {
                    fresh.entry((scene, stem)).or_default().add(more);
                }
            }
        }
        open.retain(|suspect| !suspect.is_cleared(&known_ratios(suspect, &fresh)));
    }
    // Judge the remaining suspects.
    let undecided = open
        .iter()
        .filter(|suspect| suspect.lacks_calm_runs(&known_ratios(suspect, &fresh)))
        .count();
    let worse: Vec<String> = open
        .iter()
        .filter_map(|s| s.verdict(&known_ratios(s, &fresh)))
        .collect();
    if !suspects.is_empty() {
        let all = suspects.len();
        let left = worse.len();
        changes.notes.push(format!(
            "{all} rows or techniques looked slower and were timed again: {left} are slower."
        ));
    }
    if undecided > 0 {
        changes.notes.push(format!(
            "{undecided} of them are undecided, as the machine was too busy: run again when it is idle."
        ));
    }
    changes.worse.extend(worse);
    Ok(())
}

/// Returns the stems of the suspects' rows by the index of their scene, without duplicates, and the
/// units of that scene's yardstick on a device.
fn stems_by_scene(suspects: &[&Suspect]) -> BTreeMap<usize, (Vec<String>, Option<f64>)> {
    let mut out: BTreeMap<usize, (Vec<String>, Option<f64>)> = BTreeMap::new();
    for row in suspects.iter().flat_map(|suspect| &suspect.rows) {
        let (stems, device_units) = out.entry(row.scene).or_default();
        *device_units = device_units.or(row.then.device_units);
        if !stems.contains(&row.stem) {
            stems.push(row.stem.clone());
        }
    }
    out
}

/// Returns the new timings of a suspect's rows. `None` for rows that were not timed.
fn known_ratios(suspect: &Suspect, fresh: &Fresh) -> Vec<Option<RatioSample>> {
    suspect
        .rows
        .iter()
        .map(|row| {
            let again = fresh.get(&(row.scene, row.stem.clone()))?;
            Some(sample(again))
        })
        .collect()
}

fn sample(again: &Again) -> RatioSample {
    // Use quantiles of 0 runs if there are no calm runs yet.
    let ratio = Ranks::from_figures(again.calm_ratios()).unwrap_or_default();
    RatioSample {
        ratio,
        least_ms: again.least_ms,
        yardstick: again.yardstick,
        device_units: again.device_units,
    }
}

#[cfg(test)]
#[path = "again_tests.rs"]
mod tests;
