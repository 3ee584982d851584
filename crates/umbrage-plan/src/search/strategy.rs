//! Order in which candidates are evaluated: from the cheapest up until one meets the error bound,
//! or the finest ones that are affordable.

use super::{
    bias_search::best_bias, bounds::Bounds, outcome::Miss, planner::Planner, setting::Setting,
};
use crate::{error::MeasureError, progress::Step};

/// Index of a candidate in the list of families.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct LadderPlace {
    pub(super) family: usize,
    /// Index within the family, from the coarsest map or the fewest rays up.
    pub(super) candidate: usize,
}

/// Result of a search.
pub(super) enum Found {
    /// The candidates within the bounds, the best by counted costs first; at least one.
    Chosen(Vec<(LadderPlace, Setting)>),
    Missed(Box<Miss>),
}

/// Greatest number of settings with verified errors that are compared by the clock, if the most
/// accurate one is wanted.
const MOST_ACCURATE: usize = 4;

/// Next candidate of a family.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    place: LadderPlace,
    milliseconds: f64,
    bytes: u64,
    /// Error of the previous candidate; infinite without one.
    last_error: f64,
    /// Error of the candidate before the previous one; infinite without one.
    error_before: f64,
}

/// Greatest number of verified biases of one kernel and map.
const MAX_BIASES: usize = 3;
/// Ratio of errors over two doublings of the map above which the kernel's width limits the error,
/// not the map.
const SATURATED: f64 = 0.95;
/// Number of finest candidates of each family evaluated for accuracy.
const FINEST: usize = 2;

impl Planner<'_> {
    /// Finds the cheapest candidate whose error is surely within its bound and that meets the other
    /// bounds. Also returns candidates of other families that cost up to `spread` times as much.
    /// `spread` is 1 or more: the factor by which prices may be wrong.
    pub(super) fn cheapest(
        &mut self,
        bounds: &Bounds,
        max_error: f64,
        spread: f64,
    ) -> Result<Found, MeasureError> {
        let mut candidates = Vec::new();
        for family in 0..self.families.len() {
            let coarsest = LadderPlace {
                family,
                candidate: 0,
            };
            candidates.extend(self.supported_from(coarsest, [f64::INFINITY; 2])?);
        }
        // Settings within the error bound that break another bound.
        let mut too_dear: Option<Setting> = None;
        let mut refused: Option<Setting> = None;
        let mut found: Vec<(LadderPlace, Setting)> = Vec::new();
        // Evaluate candidates from the cheapest up.
        while let Some(candidate) = take_cheapest(&mut candidates) {
            if let Some((_, least)) = found.first()
                && (spread <= 1.0 || candidate.milliseconds > spread * least.milliseconds)
            {
                break;
            }
            let is_over_time = bounds
                .max_ms
                .is_some_and(|max| candidate.milliseconds > max);
            if too_dear.is_some() && is_over_time {
                break;
            }
            // A family's finer candidates have no fewer bytes.
            let is_over_bytes = bounds.max_bytes.is_some_and(|max| candidate.bytes > max);
            if too_dear.is_some() && is_over_bytes {
                continue;
            }
            let Some(setting) = self.try_out(candidate.place, Some(max_error))? else {
                candidates.extend(self.finer(&candidate, f64::INFINITY, max_error)?);
                continue;
            };
            let setting = self.verify_setting(setting, max_error)?;
            if !setting.estimate.is_surely_within(max_error) {
                candidates.extend(self.finer(&candidate, setting.estimate.error, max_error)?);
                continue;
            }
            if !bounds.affords(setting.milliseconds, setting.bytes) {
                if too_dear
                    .as_ref()
                    .is_none_or(|other| setting.milliseconds < other.milliseconds)
                {
                    too_dear = Some(setting);
                }
                continue;
            }
            let setting = self.trials.with_grain_and_shimmer(setting, bounds)?;
            if bounds.allows_noise(setting.grain, setting.shimmer) {
                found.push((candidate.place, setting));
            } else {
                candidates.extend(self.finer(&candidate, setting.estimate.error, max_error)?);
                refused.get_or_insert(setting);
            }
        }
        if found.is_empty() {
            return Ok(Found::Missed(Box::new(
                self.miss(bounds, max_error, too_dear, refused),
            )));
        }
        Ok(Found::Chosen(found))
    }

    /// Verifies a setting. If it breaks the bound, returns the first setting with another bias that
    /// meets it. Among biases of similar error, a shared sample can prefer the wrong one.
    fn verify_setting(
        &mut self,
        setting: Setting,
        max_error: f64,
    ) -> Result<Setting, MeasureError> {
        let mut others = self
            .trials
            .with_other_bias(&setting)
            .into_iter()
            .filter(|s| !s.estimate.is_surely_above(max_error));
        if setting.estimate.is_surely_above(max_error) {
            return Ok(setting);
        }
        let first = self
            .trials
            .verify(&setting, Some(max_error), self.on_step)?;
        let mut verified = first.clone();
        for _ in 1..MAX_BIASES {
            if verified.estimate.is_surely_within(max_error) {
                return Ok(verified);
            }
            let Some(other) = others.next() else { break };
            verified = self.trials.verify(&other, Some(max_error), self.on_step)?;
        }
        Ok(if verified.estimate.is_surely_within(max_error) {
            verified
        } else {
            first
        })
    }

    /// Finds the most accurate candidate within the bounds of time and memory, from the two finest
    /// affordable ones of each family.
    pub(super) fn most_accurate(&mut self, bounds: &Bounds) -> Result<Found, MeasureError> {
        let mut affordable = Vec::new();
        for family in 0..self.families.len() {
            let mut tried = 0;
            for candidate in (0..self.families[family].candidates.len()).rev() {
                let place = LadderPlace { family, candidate };
                let Some(candidate) = self.priced_candidate(place, [f64::INFINITY; 2])? else {
                    continue;
                };
                if !bounds.affords(candidate.milliseconds, 0) {
                    continue;
                }
                let Some(setting) = self.try_out(place, None)? else {
                    continue;
                };
                if !bounds.affords(setting.milliseconds, setting.bytes) {
                    continue;
                }
                affordable.push((place, setting));
                tried += 1;
                if tried == FINEST {
                    break;
                }
            }
        }
        let best = self.best_of(affordable, bounds)?;
        if !best.is_empty() {
            return Ok(Found::Chosen(best));
        }
        // Price the cheapest candidate, so that the message can state the shortfall.
        let least = LadderPlace {
            family: 0,
            candidate: 0,
        };
        self.try_out(least, None)?;
        Ok(Found::Missed(Box::new(self.miss(bounds, 0.0, None, None))))
    }

    /// Returns the candidates with the least errors after verification, the best first.
    ///
    /// Verifies all candidates that may be better than the best, and at least [`MOST_ACCURATE`] if
    /// the clock decides. Removes those outside the bounds of grain and shimmer.
    fn best_of(
        &mut self,
        mut left: Vec<(LadderPlace, Setting)>,
        bounds: &Bounds,
    ) -> Result<Vec<(LadderPlace, Setting)>, MeasureError> {
        // Sort the best one last, since `pop` takes the last.
        left.sort_by(|(_, a), (_, b)| by_error_then_cost(b, a));
        let mut best: Vec<(LadderPlace, Setting)> = Vec::new();
        while let Some((place, first)) = left.pop() {
            let is_no_better = best
                .first()
                .is_some_and(|(_, best)| by_error_then_cost(best, &first).is_le());
            if is_no_better && best.len() >= self.most_accurate_wanted() {
                break;
            }
            let setting = self.trials.verify(&first, None, self.on_step)?;
            let setting = self.trials.with_grain_and_shimmer(setting, bounds)?;
            if bounds.allows_noise(setting.grain, setting.shimmer) {
                best.push((place, setting));
                best.sort_by(|(_, a), (_, b)| by_error_then_cost(a, b));
            }
        }
        Ok(best)
    }

    /// Returns the number of most accurate candidates needed: one, unless the clock decides between
    /// them.
    fn most_accurate_wanted(&self) -> usize {
        if self.is_timed { MOST_ACCURATE } else { 1 }
    }

    /// Evaluates a candidate with its best bias. Returns `None` if it is not supported.
    /// `error_limit` is that of [`best_bias`].
    fn try_out(
        &mut self,
        place: LadderPlace,
        error_limit: Option<f64>,
    ) -> Result<Option<Setting>, MeasureError> {
        let family = &self.families[place.family];
        let technique = family.preset().technique();
        self.cancel.check()?;
        (self.on_step)(Step::Trying(technique.name(), self.trials.count()));
        best_bias(&mut self.trials, family, place.candidate, error_limit)
    }

    /// Returns the first supported candidate of a family from `place` on. `last_errors` are those
    /// of the two candidates before, the finer one first.
    fn supported_from(
        &mut self,
        place: LadderPlace,
        last_errors: [f64; 2],
    ) -> Result<Option<Candidate>, MeasureError> {
        for candidate in place.candidate..self.families[place.family].candidates.len() {
            let found = self.priced_candidate(LadderPlace { candidate, ..place }, last_errors)?;
            if found.is_some() {
                return Ok(found);
            }
        }
        Ok(None)
    }

    /// Returns the candidate at `place` with its price, or `None` if it is not supported.
    fn priced_candidate(
        &mut self,
        place: LadderPlace,
        last_errors: [f64; 2],
    ) -> Result<Option<Candidate>, MeasureError> {
        let family = &self.families[place.family];
        let biases = &family.bias_amounts()[0];
        let preset = family.preset_at(place.candidate, biases.kind, biases.first());
        let price = self.trials.price(&preset)?;
        Ok(price.map(|price| Candidate {
            place,
            milliseconds: price.milliseconds,
            bytes: price.bytes,
            last_error: last_errors[0],
            error_before: last_errors[1],
        }))
    }

    /// Returns the next candidate of a family that may be within the bound after one with this
    /// `error`, if any.
    fn finer(
        &mut self,
        candidate: &Candidate,
        error: f64,
        max_error: f64,
    ) -> Result<Option<Candidate>, MeasureError> {
        let LadderPlace {
            family: of,
            candidate: at,
        } = candidate.place;
        let family = &self.families[of];
        let before = candidate.error_before;
        let stalls = before.is_finite() && error > SATURATED * before.min(candidate.last_error);
        if stalls && family.saturates(at) && error > 1.3 * max_error {
            return Ok(None);
        }
        // Skip candidates whose least possible error exceeds the bound.
        let mut next = at + 1;
        let mut reachable = error / family.max_gain;
        while error.is_finite() && reachable > max_error && next + 1 < family.candidates.len() {
            next += 1;
            reachable /= family.max_gain;
        }
        // After a skip, two doublings can't be compared.
        let last_errors = if next == at + 1 {
            [error, candidate.last_error]
        } else {
            [error, f64::INFINITY]
        };
        let place = LadderPlace {
            family: of,
            candidate: next,
        };
        self.supported_from(place, last_errors)
    }

    /// Returns the bound that fails, and by how much. `max_error` is the error bound of the
    /// strictest camera. `refused` meets all bounds except those of grain and shimmer.
    fn miss(
        &self,
        bounds: &Bounds,
        max_error: f64,
        too_dear: Option<Setting>,
        refused: Option<Setting>,
    ) -> Miss {
        if let (Some(refused), None) = (&refused, &too_dear) {
            return Miss {
                reason: refusal(refused, bounds),
                best: Some(refused.clone()),
            };
        }
        let affordable = self
            .trials
            .all()
            .into_iter()
            .filter(|s| bounds.affords(s.milliseconds, s.bytes));
        let best = affordable
            .min_by(|a, b| a.estimate.error.total_cmp(&b.estimate.error))
            .cloned();
        let error_bound = bounds.has_error().then_some(max_error);
        let reason = match (&best, &too_dear, error_bound) {
            (_, Some(dear), Some(error)) => {
                let (label, ms, bytes) = (dear.label(), dear.milliseconds, dear.bytes);
                format!(
                    "an error of {error} needs {label} with {ms:.3} ms and {bytes} bytes; allow these, or a greater error"
                )
            }
            (Some(best), _, Some(error)) => format!(
                "no technique meets an error of {error}; closest: {} at {:.4} (up to {:.4}); allow a greater error",
                best.label(),
                best.estimate.error,
                best.estimate.high
            ),
            _ => match self.trials.all().first() {
                Some(least) => format!(
                    "no setting is within {bounds}; cheapest: {} with {:.3} ms and {} bytes; allow more",
                    least.label(),
                    least.milliseconds,
                    least.bytes
                ),
                None => format!("no setting is within {bounds}; allow more"),
            },
        };
        Miss { reason, best }
    }
}

/// Returns a message with the bounds of grain and shimmer that a setting breaks.
fn refusal(setting: &Setting, bounds: &Bounds) -> String {
    let mut why = Vec::new();
    let figures = [
        ("grain", setting.grain, bounds.max_grain),
        ("shimmer", setting.shimmer, bounds.max_shimmer),
    ];
    for (name, figure, max) in figures {
        if let (Some(figure), Some(max)) = (figure, max)
            && figure > max
        {
            why.push(format!("its {name} of {figure:.4} is above {max}"));
        }
    }
    format!(
        "{} meets the error bound, but {}; allow more",
        setting.label(),
        why.join(" and ")
    )
}

/// Removes and returns the cheapest candidate; the first one of equal cost.
fn take_cheapest(candidates: &mut Vec<Candidate>) -> Option<Candidate> {
    let cheapest = (0..candidates.len()).min_by(|&a, &b| {
        let a = &candidates[a];
        let b = &candidates[b];
        let a_place = (a.place.family, a.place.candidate);
        let b_place = (b.place.family, b.place.candidate);
        a.milliseconds
            .total_cmp(&b.milliseconds)
            .then(a_place.cmp(&b_place))
    })?;
    Some(candidates.swap_remove(cheapest))
}

fn by_error_then_cost(a: &Setting, b: &Setting) -> std::cmp::Ordering {
    a.estimate
        .error
        .total_cmp(&b.estimate.error)
        .then(a.milliseconds.total_cmp(&b.milliseconds))
}
