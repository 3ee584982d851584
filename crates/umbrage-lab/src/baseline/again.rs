//! What looks slower is timed again, before it is called so.

use super::{
    Changes,
    times::{RatioSample, RowToRetime, Suspect},
};
use crate::{
    LabError,
    compare::{Again, Backends, CompareOptions, Ranks, Runs, SceneInput, again, calm},
};
use std::collections::BTreeMap;

/// How often what looks slower is timed again, each time after all else: noise that lasts for seconds meets other rows ...
pub const ROUNDS: usize = 3;

/// ... and how often at most, until there are enough runs that nothing held up.
const MAX_ROUNDS: usize = 10;

/// Runs of a row in a round.
const RUNS: Runs = Runs {
    min: 9,
    max: 15,
    budget_ms: 200,
};

/// What was found, by the scene's place and the row's stem.
type Fresh = BTreeMap<(usize, String), Again>;

/// Times again what looks slower, and moves what still does to [`Changes::worse`]. `inputs` are the scenes of the new
/// results, in their order.
///
/// # Errors
/// Errors if a scene can't be played again.
pub fn time_again(
    changes: &mut Changes,
    inputs: &[SceneInput],
    options: &CompareOptions,
    backends: &mut Backends,
) -> Result<(), LabError> {
    let suspects = std::mem::take(&mut changes.suspects);
    let mut fresh = Fresh::new();
    let mut open: Vec<&Suspect> = suspects.iter().collect();
    for round in 0..MAX_ROUNDS {
        let wanted = |suspect: &&&Suspect| {
            round < ROUNDS || suspect.lacks_calm_runs(&known(suspect, &fresh))
        };
        let asked = asked(open.iter().filter(wanted).copied());
        for (scene, stems) in asked {
            let Some(input) = inputs.get(scene) else {
                continue;
            };
            let found = again(input, &stems, options, &RUNS, backends)?;
            for (stem, more) in stems
                .into_iter()
                .zip(found)
                .filter_map(|(stem, found)| Some((stem, found?)))
            {
                fresh.entry((scene, stem)).or_default().add(more);
            }
        }
        open.retain(|suspect| !suspect.is_cleared(&known(suspect, &fresh)));
    }
    let undecided = open
        .iter()
        .filter(|suspect| suspect.lacks_calm_runs(&known(suspect, &fresh)))
        .count();
    let worse: Vec<String> = open
        .iter()
        .filter_map(|s| s.verdict(&known(s, &fresh)))
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
            "The machine was too busy to tell of {undecided} of them: try again when it is calm."
        ));
    }
    changes.worse.extend(worse);
    Ok(())
}

/// The rows of some suspects by their scenes, each once.
fn asked<'a>(suspects: impl Iterator<Item = &'a Suspect>) -> BTreeMap<usize, Vec<String>> {
    let mut out: BTreeMap<usize, Vec<String>> = BTreeMap::new();
    for row in suspects.flat_map(|suspect| &suspect.rows) {
        let stems = out.entry(row.scene).or_default();
        if !stems.contains(&row.stem) {
            stems.push(row.stem.clone());
        }
    }
    out
}

/// What was found of a suspect's rows.
fn known(suspect: &Suspect, fresh: &Fresh) -> Vec<Option<RatioSample>> {
    let of = |row: &RowToRetime| {
        let Again {
            runs,
            least_ms,
            yardstick,
        } = fresh.get(&(row.scene, row.stem.clone()))?;
        // None were calm yet: then there are no ranks, of no runs.
        let ratio = Ranks::of(calm(runs, *yardstick)).unwrap_or_default();
        Some(RatioSample {
            ratio,
            least_ms: *least_ms,
            yardstick: *yardstick,
        })
    };
    suspect.rows.iter().map(of).collect()
}

#[cfg(test)]
#[path = "again_tests.rs"]
mod tests;
