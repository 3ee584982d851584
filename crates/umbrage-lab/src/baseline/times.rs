//! Decides when a row counts as slower, and how rare false alarms are.
//!
//! A row's time is compared as a multiple of the [yardstick](umbrage_yardstick::Yardstick) that was
//! played before and after each of its runs. What is left is noise of single runs: on a shared
//! machine with 2 cores and 8 to 18 busy programs, a row's median of 5 to 9 such ratios is off by a
//! factor of 2 in one row of twenty. A comparison has thousands of rows, so single medians prove
//! nothing. Two tests take their place:
//!
//! * **A row** is suspected if its ratios' upper quartile lies beyond its bound: [`APART`] times
//!   the baseline's upper quartile (its greatest, of fewer than [`MANY`] runs). It is then timed
//!   again, in [`ROUNDS`](super::ROUNDS) rounds between which all other suspects are. It is slower
//!   if nine in ten of these fresh ratios lie beyond the bound, and if the quickest of these runs
//!   took [`APART`] times as many milliseconds as the baseline's quickest, too. If nothing has
//!   changed, a run of the baseline lies below the fresh tenth with a chance of 1/10, whatever the
//!   noise's distribution; the quartile of 9 lies there if at least 7 of them do (36 / 10^7 at
//!   most), the greatest of 5 if all do (1 / 10^5). Besides, a factor of [`APART`] must lie
//!   between: where noise is narrower than that, no chance is left at all.
//!
//!   These chances take for granted that runs are independent. They are not while others hold one
//!   of two cores: then a yardstick may be slow next to all of a row's runs, while the row fits
//!   between two turns of the scheduler. So only runs count next to which no yardstick took more
//!   than [`CALM`] times the quickest of that row, and rows of which even that one took more than
//!   [`CALM`] times what it can are not judged, as are those of fewer than [`MIN_RUNS`] such runs.
//!   Under the load above, of all rows the bound lay below what the row takes in 3 %; of those
//!   whose yardstick's median was calm, in 1 of 2,393.
//!
//!   On devices the clock changes, too, and ratios are the same at each clock. So there a run
//!   counts if neither yardstick next to it took more than [`CALM`] times the other, and ratios
//!   alone decide.
//! * **A technique** on a backend, over all scenes and settings, is suspected if its rows' median
//!   is slower by more than [`TECHNIQUE`], and by more than [`SIGMAS`] standard errors of a median
//!   (1.253 sigma / sqrt n, sigma from the median absolute deviation: Rousseeuw and Croux 1993,
//!   "Alternatives to the median absolute deviation"). For normal noise that has a chance of 3 /
//!   10^5: with 26 techniques on backends, one comparison in 1,000. It is slower if the same is
//!   found when rows of it are timed again. Fewer than [`MIN_ROWS`] rows are judged one by one
//!   alone.
//!
//! What this can't see: a single row that got slower by less than [`APART`] (more where the
//! baseline itself is noisy, or where the machine got faster meanwhile), and a technique that did
//! by less than [`TECHNIQUE`]. Counted cost sees every operation more, however small.

use crate::compare::{CALM, CompareRow, Ranks};
use std::collections::BTreeMap;

/// The least factor between the slower of the usual runs then and the quicker of the usual runs
/// now. Smaller changes may come from another placement of code and data in memory.
pub const APART: f64 = 1.4;

/// From this many runs on, the upper quartile bounds the baseline's noise; with fewer runs, the
/// greatest does.
pub const MANY: u32 = 9;

/// Rows with fewer runs are not judged.
pub const MIN_RUNS: u32 = crate::compare::MIN_JUDGED_RUNS;

/// The least factor by which a technique's median over its rows must change, beyond its error. Rows
/// of one technique wait for the same part of the machine, and a yardstick that waits for another
/// does not cancel all of that: medians of unchanged code moved by up to 1.2.
pub const TECHNIQUE: f64 = 1.3;

/// How many standard errors of a technique's median its change must be.
pub const SIGMAS: f64 = 4.0;

/// Rows of a technique whose quickest run takes less than this times what the baseline's quickest
/// run took count as unchanged, whatever their yardsticks say.
pub const AS_QUICK: f64 = 1.1;

/// Techniques with fewer rows are not judged as a whole.
pub const MIN_ROWS: usize = 8;

/// A row that was timed beside a yardstick, then and now.
#[derive(Clone, Copy, Debug)]
pub(super) struct Timing<'a> {
    /// The scene's place in the new results, and its name.
    pub(super) scene: (usize, &'a str),
    pub(super) row: &'a CompareRow,
    pub(super) then: RatioSample,
    pub(super) now: RatioSample,
}

/// How long a row took, and its yardstick beside it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RatioSample {
    /// Times over the yardstick's, of calm runs.
    pub ratio: Ranks,
    /// The quickest run, milliseconds.
    pub least_ms: f64,
    /// The quickest yardstick, milliseconds a unit.
    pub yardstick: f64,
    /// The yardstick's units on a device with a clock of its own. `None` on the CPU.
    pub device_units: Option<f64>,
}

impl RatioSample {
    fn words(&self) -> String {
        let ratio = &self.ratio;
        format!(
            "{:.3} yardsticks ({:.3} to {:.3}; at least {:.3} ms)",
            ratio.median, ratio.tenth, ratio.max, self.least_ms
        )
    }
}

/// What looks slower.
#[derive(Clone, Debug, PartialEq)]
pub struct Suspect {
    /// For people: a row with its scene, or a technique with its backend.
    pub label: String,
    /// Rows to be timed again.
    pub rows: Vec<RowToRetime>,
    /// Whether it is a technique as a whole.
    pub whole: bool,
}

/// A row that is to be timed again.
#[derive(Clone, Debug, PartialEq)]
pub struct RowToRetime {
    /// Its scene's place in the new results.
    pub scene: usize,
    /// [`CompareRow::stem`].
    pub stem: String,
    /// What the baseline says of it.
    pub then: RatioSample,
}

/// The verdict on all times.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Judged {
    pub(super) suspects: Vec<Suspect>,
    pub(super) quicker: Vec<String>,
    /// Rows of too few calm runs to be judged one by one.
    pub(super) rough: usize,
}

/// Finds rows and techniques that look slower, and techniques that got quicker.
pub(super) fn judge(timings: &[Timing<'_>]) -> Judged {
    let mut out = Judged::default();
    let mut techniques: BTreeMap<[&str; 2], Vec<&Timing<'_>>> = BTreeMap::new();
    for timing in timings {
        techniques
            .entry([&timing.row.technique, &timing.row.backend])
            .or_default()
            .push(timing);
        match bound(&timing.then.ratio) {
            None => out.rough += 1,
            Some(_) if !is_calm(&timing.then, &timing.now) => out.rough += 1,
            Some(bound) if timing.now.ratio.high > bound => {
                let label = format!("{}: {}", timing.scene.1, timing.row.label());
                out.suspects.push(Suspect {
                    label,
                    rows: vec![timing.asked()],
                    whole: false,
                });
            }
            Some(_) => {}
        }
    }
    for ([technique, backend], rows) in techniques {
        let changes: Vec<f64> = rows
            .iter()
            .filter_map(|t| change(&t.then.ratio, &t.now.ratio))
            .collect();
        let label = format!("{technique} on {backend}");
        match median_factor(&changes) {
            Some(factor) if factor > 1.0 => {
                let rows = spread_out(&rows, MAX_ROWS).map(|t| t.asked()).collect();
                out.suspects.push(Suspect {
                    label,
                    rows,
                    whole: true,
                });
            }
            Some(factor) => out.quicker.push(format!(
                "{label}: quicker by a factor of {:.2}",
                1.0 / factor
            )),
            None => {}
        }
    }
    out
}

/// The most rows of a technique that are timed again.
const MAX_ROWS: usize = 16;

/// Returns at most `most` items, spread evenly over all.
fn spread_out<T>(all: &[T], most: usize) -> impl Iterator<Item = &T> {
    let count = all.len().min(most);
    (0..count).map(move |i| &all[i * all.len() / count])
}

impl Timing<'_> {
    fn asked(&self) -> RowToRetime {
        RowToRetime {
            scene: self.scene.0,
            stem: self.row.stem(),
            then: self.then,
        }
    }
}

/// Returns the ratio beyond which a row is slower; none if the baseline has too few runs.
fn bound(then: &Ranks) -> Option<f64> {
    let usual = if then.runs < MANY {
        then.max
    } else {
        then.high
    };
    (then.runs >= MIN_RUNS).then_some(APART * usual)
}

/// Whether the baseline's yardstick was as quick as it can be, as far as is known. On a device it
/// need not be: ratios are the same at each clock.
fn is_calm(then: &RatioSample, now: &RatioSample) -> bool {
    then.device_units.is_some() || then.yardstick <= CALM * now.yardstick
}

/// Returns by how much a row changed: the logarithm of its medians' ratio; none if that is not
/// finite.
fn change(then: &Ranks, now: &Ranks) -> Option<f64> {
    Some((now.median / then.median).ln()).filter(|change| change.is_finite())
}

/// Returns the factor by which rows as a whole got slower (above 1) or quicker (below 1), from the
/// logarithms of their changes; none if they didn't, or there are too few.
fn median_factor(changes: &[f64]) -> Option<f64> {
    if changes.len() < MIN_ROWS {
        return None;
    }
    let median = Ranks::of(changes.to_vec())?.median;
    let deviation = Ranks::of(changes.iter().map(|c| (c - median).abs()).collect())?.median;
    // Of normal noise the standard deviation is 1.4826 median absolute deviations, and a median's
    // standard error is sqrt(pi / 2) = 1.253 times the mean's.
    let error = 1.253 * 1.4826 * deviation / (changes.len() as f64).sqrt();
    let counts = median.abs() > TECHNIQUE.ln() && median.abs() > SIGMAS * error;
    counts.then_some(median.exp())
}

impl Suspect {
    /// Returns a line about it now that its rows were timed again; none if it is no slower. `fresh`
    /// is what was found of each of its rows.
    pub(super) fn verdict(&self, fresh: &[Option<RatioSample>]) -> Option<String> {
        if self.whole {
            let changes = self.changes(fresh);
            let factor = median_factor(&changes).filter(|factor| *factor > 1.0)?;
            let label = &self.label;
            let rows = changes.len();
            return Some(format!(
                "{label}: slower by a factor of {factor:.2} in the median of {rows} rows"
            ));
        }
        let then = self.rows.first()?.then;
        let now = (*fresh.first()?)?;
        if self.lacks_calm_runs(fresh)
            || now.ratio.tenth <= bound(&then.ratio)?
            || as_quick(&then, &now, APART)
            || !is_calm(&then, &now)
        {
            return None;
        }
        Some(format!(
            "{}: slower by a factor of {:.2}: {} -> {}",
            self.label,
            now.ratio.median / then.ratio.median,
            then.words(),
            now.words()
        ))
    }

    /// Whether there are too few fresh runs that nothing held up: as many as make a quartile.
    pub(super) fn lacks_calm_runs(&self, fresh: &[Option<RatioSample>]) -> bool {
        if self.whole {
            return false;
        }
        match fresh.first() {
            Some(Some(now)) => now.ratio.runs < MANY,
            _ => false,
        }
    }

    /// Whether fresh runs clear it already, so that it need not be timed once more: half of the
    /// ratios lie within the bound (nine in ten may not yet, of few runs), one run is nearly as
    /// quick as ever, or the yardstick can be quicker than it was beside the baseline.
    pub(super) fn is_cleared(&self, fresh: &[Option<RatioSample>]) -> bool {
        if self.whole {
            return Ranks::of(self.changes(fresh))
                .is_none_or(|changes| changes.median <= TECHNIQUE.ln());
        }
        let (Some(row), Some(Some(now))) = (self.rows.first(), fresh.first()) else {
            return true;
        };
        let then = row.then;
        let usual = now.ratio.runs >= MIN_RUNS
            && bound(&then.ratio).is_none_or(|bound| now.ratio.median <= bound);
        usual || as_quick(&then, now, APART) || !is_calm(&then, now)
    }

    /// Returns the logarithms by which its rows changed; those with a run as quick as ever did not.
    fn changes(&self, fresh: &[Option<RatioSample>]) -> Vec<f64> {
        let mut out = Vec::new();
        for (row, now) in self.rows.iter().zip(fresh) {
            let Some(now) = now else {
                continue;
            };
            if as_quick(&row.then, now, AS_QUICK) {
                out.push(0.0);
            } else {
                out.extend(change(&row.then.ratio, &now.ratio));
            }
        }
        out
    }
}

/// Whether a run is as quick as the baseline's quickest, or slower by less than a factor. Never so
/// on a device, where milliseconds depend on its clock.
fn as_quick(then: &RatioSample, now: &RatioSample, factor: f64) -> bool {
    then.device_units.is_none() && now.least_ms < factor * then.least_ms
}

#[cfg(test)]
#[path = "times_tests.rs"]
mod tests;
