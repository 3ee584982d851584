//! Decides when a row counts as slower, with a low rate of false alarms.
//!
//! Times are multiples of the [yardstick](umbrage_yardstick::Yardstick) that runs before and after
//! each run of a row. The rest is noise of single runs. On a shared machine with 2 cores and 8 to
//! 18 busy programs, the median of 5 to 9 such ratios is off by a factor of 2 in one row of twenty.
//! A comparison has thousands of rows, so single medians prove nothing. Two tests replace them:
//!
//! * **A row** is suspected if the upper quartile of its ratios exceeds a bound: [`APART`] times
//!   the baseline's upper quartile (its maximum, if it has fewer than [`MANY`] runs). It is then
//!   timed again, in [`ROUNDS`](super::ROUNDS) rounds that alternate with the other suspects. It is
//!   slower if 90 % of the new ratios exceed the bound, and if the fastest new run took [`APART`]
//!   times as long as the baseline's fastest. If nothing changed, a run of the baseline is below
//!   the new 10 % quantile with probability 1/10, for any distribution of the noise. The quartile
//!   of 9 runs is below if at least 7 of them are (at most 36 / 10^7), the maximum of 5 if all are
//!   (1 / 10^5). In addition, there must be a factor of [`APART`] between them: noise narrower than
//!   this never raises an alarm.
//!
//!   These probabilities assume independent runs. Runs are not independent while other programs
//!   occupy one of two cores: a yardstick may then be slow next to all runs of a row, while the row
//!   fits between two turns of the scheduler. So a run only counts if neither adjacent yardstick
//!   took more than [`CALM`] times the fastest one of that row. Rows are not judged if their
//!   fastest yardstick took more than [`CALM`] times its known minimum, or if they have fewer than
//!   [`MIN_RUNS`] such runs. Under the load above, the bound was below the row's time in 3 % of all
//!   rows; of rows with a calm median yardstick, in 1 of 2,393.
//!
//!   On devices the clock changes, too, and ratios don't depend on it. There a run counts if
//!   neither adjacent yardstick took more than [`CALM`] times the other, and only ratios decide.
//! * **A technique** on a backend is judged by the median of its rows over all scenes and settings.
//!   It is suspected if the median is slower by more than [`TECHNIQUE`] and by more than [`SIGMAS`]
//!   standard errors. A median's standard error is 1.253 sigma / sqrt n, with sigma from the median
//!   absolute deviation (Rousseeuw and Croux 1993, "Alternatives to the median absolute
//!   deviation"). For normal noise this has a probability of 3 / 10^5: with 26 techniques on
//!   backends, one comparison in 1,000. The technique is slower if timing its rows again leads to
//!   the same result. Techniques with fewer than [`MIN_ROWS`] rows are only judged row by row.
//!
//! Not detected are a single row that is slower by less than [`APART`] (more if the baseline is
//! noisy or the machine got faster), and a technique that is slower by less than [`TECHNIQUE`].
//! Predicted cost detects every additional operation.

use crate::compare::{CALM, CompareRow, Ranks};
use std::collections::BTreeMap;

/// Minimum factor between the slower of the usual old runs and the faster of the usual new runs.
/// Smaller changes may be due to another placement of code and data in memory.
pub const APART: f64 = 1.4;

/// Minimum number of runs for which the upper quartile bounds the baseline's noise. With fewer
/// runs, the maximum does.
pub const MANY: u32 = 9;

/// Minimum number of runs of a judged row.
pub const MIN_RUNS: u32 = crate::compare::MIN_JUDGED_RUNS;

/// Minimum factor of a technique's median over its rows, beyond its error.
///
/// Rows of a technique depend on the same part of the machine. A yardstick that depends on another
/// part doesn't cancel all of that: medians of unchanged code changed by up to 1.2.
pub const TECHNIQUE: f64 = 1.3;

/// Minimum change of a technique's median, in standard errors.
pub const SIGMAS: f64 = 4.0;

/// Rows of a technique count as unchanged if their fastest run takes less than this times the
/// baseline's fastest run, whatever their yardsticks measure.
pub const AS_QUICK: f64 = 1.1;

/// Minimum number of rows of a technique that is judged as a whole.
pub const MIN_ROWS: usize = 8;

/// A row timed in turn with a yardstick, then and now.
#[derive(Clone, Copy, Debug)]
pub(super) struct Timing<'a> {
    /// The scene's index in the new results, and its name.
    pub(super) scene: (usize, &'a str),
    pub(super) row: &'a CompareRow,
    pub(super) then: RatioSample,
    pub(super) now: RatioSample,
}

/// Times of a row and of its yardstick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RatioSample {
    /// Ratios of calm runs to the yardstick.
    pub ratio: Ranks,
    /// Fastest run, milliseconds.
    pub least_ms: f64,
    /// Fastest yardstick, milliseconds per unit.
    pub yardstick: f64,
    /// Units of the yardstick on a device with its own clock. `None` on the CPU.
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

/// A row or technique that looks slower.
#[derive(Clone, Debug, PartialEq)]
pub struct Suspect {
    /// Label for readers: a row with its scene, or a technique with its backend.
    pub label: String,
    /// Rows to time again.
    pub rows: Vec<RowToRetime>,
    /// Whether it is a technique as a whole.
    pub whole: bool,
}

/// A row to time again.
#[derive(Clone, Debug, PartialEq)]
pub struct RowToRetime {
    /// Index of its scene in the new results.
    pub scene: usize,
    /// [`CompareRow::stem`].
    pub stem: String,
    /// Times in the baseline.
    pub then: RatioSample,
}

/// The verdict on all times.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Judged {
    pub(super) suspects: Vec<Suspect>,
    pub(super) quicker: Vec<String>,
    /// Number of rows with too few calm runs to be judged one by one.
    pub(super) rough: usize,
}

/// Finds rows and techniques that look slower, and techniques that got faster.
pub(super) fn judge(timings: &[Timing<'_>]) -> Judged {
    // Judge each row.
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
                    rows: vec![timing.row_to_retime()],
                    whole: false,
                });
            }
            Some(_) => {}
        }
    }
    // Judge each technique.
    for ([technique, backend], rows) in techniques {
        let changes: Vec<f64> = rows
            .iter()
            .filter_map(|t| change(&t.then.ratio, &t.now.ratio))
            .collect();
        let label = format!("{technique} on {backend}");
        match median_factor(&changes) {
            Some(factor) if factor > 1.0 => {
                let rows = spread_out(&rows, MAX_ROWS)
                    .map(|t| t.row_to_retime())
                    .collect();
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

/// Maximum number of rows of a technique that are timed again.
const MAX_ROWS: usize = 16;

/// Returns at most `most` items, evenly spread.
fn spread_out<T>(all: &[T], most: usize) -> impl Iterator<Item = &T> {
    let count = all.len().min(most);
    (0..count).map(move |i| &all[i * all.len() / count])
}

impl Timing<'_> {
    fn row_to_retime(&self) -> RowToRetime {
        RowToRetime {
            scene: self.scene.0,
            stem: self.row.stem(),
            then: self.then,
        }
    }
}

/// Returns the ratio beyond which a row is slower. `None` if the baseline has too few runs.
fn bound(then: &Ranks) -> Option<f64> {
    let usual = if then.runs < MANY {
        then.max
    } else {
        then.high
    };
    (then.runs >= MIN_RUNS).then_some(APART * usual)
}

/// Reports whether the baseline's yardstick was as fast as the known minimum. On a device it need
/// not be, as ratios don't depend on the clock.
fn is_calm(then: &RatioSample, now: &RatioSample) -> bool {
    then.device_units.is_some() || then.yardstick <= CALM * now.yardstick
}

/// Returns the change of a row: the logarithm of the ratio of its medians. `None` if that is not
/// finite.
fn change(then: &Ranks, now: &Ranks) -> Option<f64> {
    Some((now.median / then.median).ln()).filter(|change| change.is_finite())
}

/// Returns the factor by which rows as a whole got slower (above 1) or faster (below 1), from the
/// logarithms of their changes. `None` if they didn't, or there are too few.
fn median_factor(changes: &[f64]) -> Option<f64> {
    if changes.len() < MIN_ROWS {
        return None;
    }
    let median = Ranks::from_figures(changes.to_vec())?.median;
    let deviation =
        Ranks::from_figures(changes.iter().map(|c| (c - median).abs()).collect())?.median;
    // For normal noise, the standard deviation is 1.4826 median absolute deviations, and the
    // standard error of a median is sqrt(pi / 2) = 1.253 times that of the mean.
    let error = 1.253 * 1.4826 * deviation / (changes.len() as f64).sqrt();
    let counts = median.abs() > TECHNIQUE.ln() && median.abs() > SIGMAS * error;
    counts.then_some(median.exp())
}

impl Suspect {
    /// Returns a line about the suspect after timing it again. `None` if it is not slower. `fresh`
    /// has the new times of each of its rows.
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
            || is_as_fast(&then, &now, APART)
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

    /// Reports whether there are too few undisturbed new runs for a quartile.
    pub(super) fn lacks_calm_runs(&self, fresh: &[Option<RatioSample>]) -> bool {
        if self.whole {
            return false;
        }
        match fresh.first() {
            Some(Some(now)) => now.ratio.runs < MANY,
            _ => false,
        }
    }

    /// Reports whether new runs already clear the suspect, so that it need not be timed again.
    ///
    /// One of three conditions suffices. Half of the ratios are within the bound (with few runs,
    /// 90 % may not be yet). One run is nearly as fast as the baseline's fastest. The yardstick is
    /// faster than in the baseline.
    pub(super) fn is_cleared(&self, fresh: &[Option<RatioSample>]) -> bool {
        if self.whole {
            return Ranks::from_figures(self.changes(fresh))
                .is_none_or(|changes| changes.median <= TECHNIQUE.ln());
        }
        let (Some(row), Some(Some(now))) = (self.rows.first(), fresh.first()) else {
            return true;
        };
        let then = row.then;
        let usual = now.ratio.runs >= MIN_RUNS
            && bound(&then.ratio).is_none_or(|bound| now.ratio.median <= bound);
        usual || is_as_fast(&then, now, APART) || !is_calm(&then, now)
    }

    /// Returns the logarithms of its rows' changes. Rows with a run as fast as the baseline's
    /// fastest count as unchanged.
    fn changes(&self, fresh: &[Option<RatioSample>]) -> Vec<f64> {
        let mut out = Vec::new();
        for (row, now) in self.rows.iter().zip(fresh) {
            let Some(now) = now else {
                continue;
            };
            if is_as_fast(&row.then, now, AS_QUICK) {
                out.push(0.0);
            } else {
                out.extend(change(&row.then.ratio, &now.ratio));
            }
        }
        out
    }
}

/// Reports whether a run is as fast as the baseline's fastest, up to a factor. Never on a device,
/// whose clock changes milliseconds.
fn is_as_fast(then: &RatioSample, now: &RatioSample, factor: f64) -> bool {
    then.device_units.is_none() && now.least_ms < factor * then.least_ms
}

#[cfg(test)]
#[path = "times_tests.rs"]
mod tests;
