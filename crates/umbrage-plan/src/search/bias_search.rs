//! The search for the bias of a kernel and map that has the least estimated error.

use super::{
    bias::{BiasAmounts, BiasKind},
    families::Family,
    setting::Setting,
    trials::Trials,
};
use crate::error::MeasureError;

/// Greatest ratio of the error of the best kind's first amount to the target error. Beyond it, no
/// other amount of any kind is evaluated, since none would help.
const MAX_FIRST_ERROR_RATIO: f64 = 1.7;
/// Greatest such ratio for each other kind. Beyond it, no other amount of that kind is evaluated,
/// nor of a kind whose first amount is worse.
const MAX_FIRST_ERROR_RATIO_OF_OTHERS: f64 = 1.3;

/// Returns the setting with the best bias for a candidate, an index into [`Family::candidates`].
///
/// Evaluates the first amount of each kind of bias.
/// Then, from the best kind on, evaluates other amounts of each kind: see [`line_search`].
/// Stops at the first bias whose error is within `error_limit`, uncertainty included.
/// Without a limit, the target error is that of the best first amount.
/// Returns `None` if no kind is supported.
pub(super) fn best_bias(
    trials: &mut Trials<'_>,
    family: &Family,
    candidate: usize,
    error_limit: Option<f64>,
) -> Result<Option<Setting>, MeasureError> {
    let is_within_limit =
        |setting: &Setting| error_limit.is_some_and(|limit| setting.estimate.high <= limit);
    let kinds = family.bias_amounts();
    let mut firsts: Vec<(&BiasAmounts, Setting)> = Vec::new();
    // Evaluate the first amount of each kind.
    for biases in &kinds {
        let preset = family.preset_at(candidate, biases.kind, biases.first());
        let Some(setting) = trials.try_out(&preset)? else {
            continue;
        };
        if is_within_limit(&setting) {
            return Ok(Some(setting));
        }
        firsts.push((biases, setting));
    }
    firsts.sort_by(|(_, a), (_, b)| a.estimate.error.total_cmp(&b.estimate.error));
    let Some((_, mut best)) = firsts.first().cloned() else {
        return Ok(None);
    };
    let error_aimed_at = error_limit.unwrap_or(best.estimate.error);
    // Refine the kinds whose first amount is close enough to the target.
    for (i, (biases, first)) in firsts.into_iter().enumerate() {
        let max_ratio = if i == 0 {
            MAX_FIRST_ERROR_RATIO
        } else {
            MAX_FIRST_ERROR_RATIO_OF_OTHERS
        };
        if first.estimate.error > max_ratio * error_aimed_at {
            break;
        }
        let setting = line_search(trials, family, candidate, biases, first)?;
        if setting.estimate.error < best.estimate.error {
            best = setting;
        }
        if is_within_limit(&best) {
            break;
        }
    }
    Ok(Some(best))
}

/// Returns the best amount of one kind of bias for a candidate, an index into
/// [`Family::candidates`].
///
/// Evaluates ever smaller amounts than the first as long as the error falls.
/// If it never falls, evaluates ever greater amounts in the same way.
fn line_search(
    trials: &mut Trials<'_>,
    family: &Family,
    candidate: usize,
    biases: &BiasAmounts,
    first: Setting,
) -> Result<Setting, MeasureError> {
    let down: Vec<usize> = (0..biases.first_index).rev().collect();
    let up: Vec<usize> = (biases.first_index + 1..biases.amounts.len()).collect();
    let mut best = first;
    for direction in [down, up] {
        let mut is_better = false;
        for index in direction {
            let preset = family.preset_at(candidate, biases.kind, biases.amounts[index]);
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
    /// The amount, texels.
    pub(super) texels: f32,
    pub(super) setting: Setting,
}

/// Evaluates every amount of every kind of bias for a candidate, an index into
/// [`Family::candidates`].
///
/// The planner calls it for the chosen setting, to show that no other bias is better, and for
/// [`Plan::curve`](crate::Plan::curve).
pub(super) fn all_biases(
    trials: &mut Trials<'_>,
    family: &Family,
    candidate: usize,
) -> Result<Vec<Biased>, MeasureError> {
    let mut out = Vec::new();
    for BiasAmounts { kind, amounts, .. } in family.bias_amounts() {
        for texels in amounts {
            let setting = trials.try_out(&family.preset_at(candidate, kind, texels))?;
            out.extend(setting.map(|setting| Biased {
                kind,
                texels,
                setting,
            }));
        }
    }
    Ok(out)
}
