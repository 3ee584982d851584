//! The walk from the cheapest candidate up.

use super::{Bounds, Miss, Planner, Setting, bias::scales, families::Family, trial::Goal};
use crate::{MeasureError, progress::Step};

/// Where a candidate stands in the list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Place {
    pub(super) family: usize,
    pub(super) size: usize,
}

/// How a walk ends.
pub(super) enum Found {
    Chosen(Place, Setting),
    Missed(Miss),
}

/// A family's next step.
#[derive(Clone, Copy, Debug)]
struct Rung {
    milliseconds: f64,
    place: Place,
    /// The errors on the last two maps, the finer one first.
    last: [f64; 2],
}

/// How many biases of one kernel and map are verified at most.
const BIASES: usize = 3;
/// A kernel on maps whose error has fallen by less than this over two doublings is limited by its width, not by the map.
const SATURATED: f64 = 0.95;

impl Planner<'_> {
    /// The cheapest candidate whose error is surely within its bound.
    pub(super) fn cheapest(&mut self, bounds: &Bounds, error: f64) -> Result<Found, MeasureError> {
        let mut rungs = Vec::new();
        for family in 0..self.families.len() {
            rungs.extend(self.rung(Place { family, size: 0 }, [f64::INFINITY; 2])?);
        }
        // Within the error's bound, but not within the others'.
        let mut too_dear: Option<Setting> = None;
        while let Some(rung) = take_cheapest(&mut rungs) {
            if too_dear.is_some() && bounds.max_ms.is_some_and(|max| rung.milliseconds > max) {
                break;
            }
            let Some(setting) = self.settle(rung.place, Some(Goal { error }))? else {
                rungs.extend(self.finer(&rung, f64::INFINITY, error)?);
                continue;
            };
            let setting = self.look_again(setting, error)?;
            if !setting.estimate.is_surely_within(error) {
                rungs.extend(self.finer(&rung, setting.estimate.error, error)?);
            } else if bounds.affords(setting.milliseconds, setting.bytes) {
                return Ok(Found::Chosen(rung.place, setting));
            } else if too_dear
                .as_ref()
                .is_none_or(|other| setting.milliseconds < other.milliseconds)
            {
                too_dear = Some(setting);
            }
        }
        Ok(Found::Missed(self.miss(bounds, too_dear)))
    }

    /// A setting verified; if it does not keep the bound, the first of those that differ in bias alone that does. Of some
    /// that err alike, a shared sample may well prefer the wrong one.
    fn look_again(&mut self, setting: Setting, error: f64) -> Result<Setting, MeasureError> {
        let mut others = self
            .trial
            .alike(&setting)
            .into_iter()
            .filter(|s| !s.estimate.is_surely_above(error));
        if setting.estimate.is_surely_above(error) {
            return Ok(setting);
        }
        let first = self.trial.verify(&setting, Some(error), self.on_step)?;
        let mut verified = first.clone();
        for _ in 1..BIASES {
            if verified.estimate.is_surely_within(error) {
                return Ok(verified);
            }
            let Some(other) = others.next() else { break };
            verified = self.trial.verify(&other, Some(error), self.on_step)?;
        }
        Ok(if verified.estimate.is_surely_within(error) {
            verified
        } else {
            first
        })
    }

    /// The most accurate candidate within the bounds of time and memory: of each family the finest two maps that are.
    pub(super) fn most_accurate(&mut self, bounds: &Bounds) -> Result<Found, MeasureError> {
        let mut left = Vec::new();
        for family in 0..self.families.len() {
            let mut tried = 0;
            for size in (0..self.families[family].rungs.len()).rev() {
                let place = Place { family, size };
                let Some(rung) = self.exactly(place, [f64::INFINITY; 2])? else {
                    continue;
                };
                if !bounds.affords(rung.milliseconds, 0) {
                    continue;
                }
                let Some(setting) = self.settle(place, None)? else {
                    continue;
                };
                if !bounds.affords(setting.milliseconds, setting.bytes) {
                    continue;
                }
                left.push((place, setting));
                tried += 1;
                if tried == 2 {
                    break;
                }
            }
        }
        if let Some((place, setting)) = self.best_of(left)? {
            return Ok(Found::Chosen(place, setting));
        }
        // The least of all is priced, so that the answer can say what is missing.
        self.settle(Place { family: 0, size: 0 }, None)?;
        Ok(Found::Missed(self.miss(bounds, None)))
    }

    /// The candidate with the least error, looked at again: the next ones, too, as long as one may be better.
    fn best_of(
        &mut self,
        mut left: Vec<(Place, Setting)>,
    ) -> Result<Option<(Place, Setting)>, MeasureError> {
        let key = |s: &Setting| (s.estimate.error, s.milliseconds);
        let order = |a: &Setting, b: &Setting| {
            let (a, b) = (key(a), key(b));
            a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
        };
        left.sort_by(|a, b| order(&b.1, &a.1));
        let mut best: Option<(Place, Setting)> = None;
        while let Some((place, first)) = left.pop() {
            if best
                .as_ref()
                .is_some_and(|(_, best)| order(best, &first).is_le())
            {
                break;
            }
            let setting = self.trial.verify(&first, None, self.on_step)?;
            if best
                .as_ref()
                .is_none_or(|(_, best)| order(&setting, best).is_lt())
            {
                best = Some((place, setting));
            }
        }
        Ok(best)
    }

    fn settle(
        &mut self,
        place: Place,
        goal: Option<Goal>,
    ) -> Result<Option<Setting>, MeasureError> {
        let family = self.families[place.family].clone();
        (self.on_step)(Step::Trying(
            family.preset().technique().name(),
            self.trial.played(),
        ));
        self.trial.settle(&family, place.size, goal)
    }

    /// The first of a family's sizes from `place` on that is supported.
    fn rung(&mut self, place: Place, last: [f64; 2]) -> Result<Option<Rung>, MeasureError> {
        for size in place.size..self.families[place.family].rungs.len() {
            let rung = self.exactly(Place { size, ..place }, last)?;
            if rung.is_some() {
                return Ok(rung);
            }
        }
        Ok(None)
    }

    fn exactly(&mut self, place: Place, last: [f64; 2]) -> Result<Option<Rung>, MeasureError> {
        let family = &self.families[place.family];
        let scale = &scales(&family.preset())[0];
        let price =
            self.trial
                .price(&family.at(place.size, scale.kind, scale.texels[scale.first]))?;
        Ok(price.map(|price| Rung {
            milliseconds: price.milliseconds,
            place,
            last,
        }))
    }

    /// The next size that may be within the bound, if any.
    fn finer(&mut self, rung: &Rung, error: f64, bound: f64) -> Result<Option<Rung>, MeasureError> {
        let Place { family, size } = rung.place;
        let of_place = &self.families[family];
        let Family { rungs, most_gain } = of_place;
        let [coarser, coarsest] = rung.last;
        let stalls = coarsest.is_finite() && error > SATURATED * coarsest.min(coarser);
        if stalls && of_place.saturates(size) && error > 1.3 * bound {
            return Ok(None);
        }
        let (mut next, mut reachable) = (size + 1, error / most_gain);
        while error.is_finite() && reachable > bound && next + 1 < rungs.len() {
            (next, reachable) = (next + 1, reachable / most_gain);
        }
        // Sizes in between would have been no worse.
        let last = if next == size + 1 {
            [error, coarser]
        } else {
            [error, f64::INFINITY]
        };
        self.rung(Place { family, size: next }, last)
    }

    fn miss(&self, bounds: &Bounds, too_dear: Option<Setting>) -> Miss {
        let affordable = self
            .trial
            .all()
            .into_iter()
            .filter(|s| bounds.affords(s.milliseconds, s.bytes));
        let best = affordable
            .min_by(|a, b| a.estimate.error.total_cmp(&b.estimate.error))
            .cloned();
        let reason = match (&best, &too_dear, bounds.max_error) {
            (_, Some(dear), Some(error)) => {
                let (label, ms, bytes) = (dear.label(), dear.milliseconds, dear.bytes);
                format!(
                    "an error of {error} takes {label} at {ms:.3} ms and {bytes} bytes: allow for that, or for a greater error"
                )
            }
            (Some(best), _, Some(error)) => format!(
                "no technique keeps the error at {error}: the best, {}, errs by {:.4} (up to {:.4}); allow for that",
                best.label(),
                best.estimate.error,
                best.estimate.high
            ),
            _ => match self.trial.all().first() {
                Some(least) => format!(
                    "not even {} is within {bounds}: it takes {:.3} ms and {} bytes",
                    least.label(),
                    least.milliseconds,
                    least.bytes
                ),
                None => format!("nothing is within {bounds}: allow for more"),
            },
        };
        Miss { reason, best }
    }
}

fn take_cheapest(rungs: &mut Vec<Rung>) -> Option<Rung> {
    let order = |r: &Rung| (r.milliseconds, r.place.family, r.place.size);
    let cheapest = (0..rungs.len()).min_by(|&a, &b| {
        let (a, b) = (order(&rungs[a]), order(&rungs[b]));
        a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2)))
    })?;
    Some(rungs.swap_remove(cheapest))
}
