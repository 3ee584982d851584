//! The search for the bias of a kernel and map that leaves the least acne plus gap.

use super::{
    Setting,
    bias::{BiasKind, Scale, scales},
    families::Family,
    trials::Trials,
};
use crate::MeasureError;

/// Nothing is searched where the first amount of the best kind has more than this many times the goal's error: another amount
/// will not help.
const OUT_OF_REACH: f64 = 1.7;
/// Other kinds than the best are not searched where their first amount has more than this many times the goal's error.
const OUT_OF_REACH_OF_OTHERS: f64 = 1.3;

/// Returns the best bias of a family's candidate: tries the first amount of each kind, then, from the best kind on, less or more
/// of it as long as that is better. Stops at what keeps the error within `goal`, uncertainty included. None if nothing is
/// supported.
pub(super) fn best_bias(
    trials: &mut Trials<'_>,
    family: &Family,
    candidate: usize,
    goal: Option<f64>,
) -> Result<Option<Setting>, MeasureError> {
    let meets_goal = |setting: &Setting| goal.is_some_and(|error| setting.estimate.high <= error);
    let scales = scales(family.preset());
    let mut firsts: Vec<(&Scale, Setting)> = Vec::new();
    for scale in &scales {
        let preset = family.at(candidate, scale.kind, scale.texels[scale.first]);
        let Some(setting) = trials.try_out(&preset)? else {
            continue;
        };
        if meets_goal(&setting) {
            return Ok(Some(setting));
        }
        firsts.push((scale, setting));
    }
    firsts.sort_by(|(_, a), (_, b)| a.estimate.error.total_cmp(&b.estimate.error));
    let Some((_, mut best)) = firsts.first().cloned() else {
        return Ok(None);
    };
    let aim = goal.unwrap_or(best.estimate.error);
    for (i, (scale, first)) in firsts.into_iter().enumerate() {
        let out_of_reach = if i == 0 {
            OUT_OF_REACH
        } else {
            OUT_OF_REACH_OF_OTHERS
        };
        if first.estimate.error > out_of_reach * aim {
            break;
        }
        let setting = line_search(trials, family, candidate, scale, first)?;
        if setting.estimate.error < best.estimate.error {
            best = setting;
        }
        if meets_goal(&best) {
            break;
        }
    }
    Ok(Some(best))
}

/// Searches the amounts of one kind of bias: from the first one down as long as that is better; if it never is, up.
fn line_search(
    trials: &mut Trials<'_>,
    family: &Family,
    candidate: usize,
    scale: &Scale,
    first: Setting,
) -> Result<Setting, MeasureError> {
    let down: Vec<usize> = (0..scale.first).rev().collect();
    let up: Vec<usize> = (scale.first + 1..scale.texels.len()).collect();
    let mut best = first;
    for direction in [down, up] {
        let mut is_better = false;
        for amount in direction {
            let preset = family.at(candidate, scale.kind, scale.texels[amount]);
            let Some(setting) = trials.try_out(&preset)? else {
                break;
            };
            if setting.estimate.error >= best.estimate.error {
                break;
            }
            best = setting;
            is_better = true;
        }
        if is_better {
            break;
        }
    }
    Ok(best)
}

/// A setting with one amount of bias.
pub(super) struct Biased {
    pub(super) kind: BiasKind,
    pub(super) texels: f32,
    pub(super) setting: Setting,
}

/// Tries every amount of every kind of bias of a family's candidate.
pub(super) fn all_biases(
    trials: &mut Trials<'_>,
    family: &Family,
    candidate: usize,
) -> Result<Vec<Biased>, MeasureError> {
    let mut out = Vec::new();
    for Scale { kind, texels, .. } in scales(family.preset()) {
        for texels in texels {
            let setting = trials.try_out(&family.at(candidate, kind, texels))?;
            out.extend(setting.map(|setting| Biased {
                kind,
                texels,
                setting,
            }));
        }
    }
    Ok(out)
}
