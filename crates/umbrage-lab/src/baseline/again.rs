//! What looks slower is timed again, before it is called so.

use super::{
    Changes,
    times::{Asked, Sample, Suspect},
};
use crate::{
    LabError,
    compare::{Backends, Options, Ranks, Runs, SceneInput, again},
};
use std::collections::BTreeMap;

/// How often what looks slower is timed again, each time after all else: noise that lasts for seconds meets other rows.
pub const ROUNDS: usize = 3;

/// Runs of a row in a round.
const RUNS: Runs = Runs { least: 9, most: 15, budget_ms: 200 };

/// Fresh ratios, and the quickest run in milliseconds, by the scene's place and the row's stem.
type Fresh = BTreeMap<(usize, String), (Vec<f64>, f64)>;

/// Times again what looks slower, and moves what still does to [`Changes::worse`]. `inputs` are the scenes of the new results,
/// in their order.
///
/// # Errors
/// When a scene can't be played again.
pub fn time_again(
    changes: &mut Changes,
    inputs: &[SceneInput],
    options: &Options,
    backends: &mut Backends,
) -> Result<(), LabError> {
    let suspects = std::mem::take(&mut changes.suspects);
    let (mut fresh, mut open) = (Fresh::new(), suspects.iter().collect::<Vec<&Suspect>>());
    for _ in 0..ROUNDS {
        let mut asked: BTreeMap<usize, Vec<String>> = BTreeMap::new();
        for row in open.iter().flat_map(|suspect| &suspect.rows) {
            let stems = asked.entry(row.scene).or_default();
            if !stems.contains(&row.stem) {
                stems.push(row.stem.clone());
            }
        }
        for (scene, stems) in asked {
            let Some(input) = inputs.get(scene) else { continue };
            let found = again(input, &stems, options, &RUNS, backends)?;
            for (stem, (more, quickest)) in
                stems.into_iter().zip(found).filter_map(|(stem, found)| Some((stem, found?)))
            {
                let (ratios, least) = fresh.entry((scene, stem)).or_insert((Vec::new(), f64::INFINITY));
                ratios.extend(more);
                *least = least.min(quickest);
            }
        }
        open.retain(|suspect| !suspect.is_cleared(&known(suspect, &fresh)));
    }
    let worse: Vec<String> = open.iter().filter_map(|s| s.verdict(&known(s, &fresh))).collect();
    if !suspects.is_empty() {
        let (all, left) = (suspects.len(), worse.len());
        changes.notes.push(format!("{all} rows or techniques looked slower and were timed again: {left} are slower."));
    }
    changes.worse.extend(worse);
    Ok(())
}

/// What was found of a suspect's rows.
fn known(suspect: &Suspect, fresh: &Fresh) -> Vec<Option<Sample>> {
    let of = |row: &Asked| {
        let (ratios, least_ms) = fresh.get(&(row.scene, row.stem.clone()))?;
        Some(Sample { ratio: Ranks::of(ratios.clone())?, least_ms: *least_ms })
    };
    suspect.rows.iter().map(of).collect()
}

#[cfg(test)]
#[path = "again_tests.rs"]
mod tests;
