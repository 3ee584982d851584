//! Compares results with those of an earlier run, the baseline. A regression check for continuous
//! integration.
//!
//! Rows with the same scene, technique, settings and backend are compared, if the scene, its image
//! and its truth are unchanged:
//!
//! * **Errors** (RMSE, false shadow, false light, acne) are deterministic: any growth beyond
//!   [`ROUNDING`] counts. Different graphics adapters round differently. Between them, the possible
//!   effect of the allowed [undecided pixels](umbrage_core::metrics::MAX_UNDECIDED_SHARE) counts as
//!   noise.
//! * **Cost** (counted work at today's prices) and **bytes** are deterministic, too: any growth
//!   beyond rounding counts.
//! * **Time** counts only on the same processor, threads, system and adapter. Times are multiples
//!   of the yardstick that ran in turn with the row. [`mod@times`] defines when a row is slower,
//!   and the rate of false alarms. Rows that look slower are [timed again](time_again) before they
//!   count. Times of results before schema 7 are not compared: they have yardsticks of other
//!   lengths, or none.
//!
//! A measured row that is now refused counts as less accurate. Missing parts of the baseline and
//! changed scenes count as failures, too, unless they are [excepted](Except) by name. New rows are
//! listed but don't fail the check.

mod again;
mod changes;
mod except;
mod figures;
mod read;
pub mod times;

pub use again::{ROUNDS, time_again};
pub use changes::{Changes, ROUNDING};
pub use except::Except;
pub use read::{check_not_overwritten, read};

use crate::compare::{CompareRow, Comparison, Environment, RowOutcome, RowTimes, SceneResult};
use std::collections::HashMap;

/// The first schema whose times are compared. Earlier yardsticks have other lengths.
const FIRST_TIMED: u32 = 7;

/// Compares `new` with the baseline `old`. Parts named in `except` may be missing.
pub fn changes(old: &Comparison, new: &Comparison, except: &Except) -> Changes {
    let mut out = Changes::default();
    let SameMachine {
        timed,
        same_adapter,
    } = machines(old, new, &mut out.notes);
    // Pair the scenes.
    let mut lost = except::Lost::new(except);
    let mut pairs = Vec::new();
    for (place, scene) in new.scenes.iter().enumerate() {
        let Some(then) = counterpart(&new.scenes, place, &old.scenes) else {
            out.new.push(format!("{}: the whole scene", scene.name));
            continue;
        };
        match incomparable(then, scene) {
            Some(why) => lost.scene(&scene.name, &format!("cannot be compared: {why}")),
            None => pairs.push(Pair {
                place,
                then,
                now: scene,
                timed,
                same_adapter,
            }),
        }
    }
    for (place, scene) in old.scenes.iter().enumerate() {
        if counterpart(&old.scenes, place, &new.scenes).is_none() {
            let what = format!("is missing with its {} rows", scene.rows.len());
            lost.scene(&scene.name, &what);
        }
    }
    // Compare the rows.
    let mut timings = Vec::new();
    for pair in &pairs {
        pair.compare(&mut out, &mut lost, &mut timings);
    }
    let (timings, other): (Vec<_>, Vec<_>) = timings
        .into_iter()
        .partition(|t| t.then.device_units == t.now.device_units);
    if let Some(timing) = other.first() {
        out.notes.push(format!(
            "The times of {} rows are not compared, since their yardstick on the device has not the \
             length of the baseline's (the first: {}: {}); run again, or make a new baseline.",
            other.len(),
            timing.scene.1,
            timing.row.label()
        ));
    }
    // Judge the times.
    out.timed = timings.len();
    let judged = times::judge(&timings);
    out.better.extend(judged.quicker);
    out.suspects = judged.suspects;
    if judged.rough > 0 {
        let rough = judged.rough;
        let few = times::MIN_RUNS;
        out.notes.push(format!(
            "{rough} rows have fewer than {few} calm runs in the baseline (--runs, or a busy machine): their times count for \
             their techniques only."
        ));
    }
    lost.report(&mut out);
    out
}

/// Returns the scene of `others` with the name of the scene at `place`. Scenes with equal names are
/// paired in their order.
fn counterpart<'a>(
    scenes: &[SceneResult],
    place: usize,
    others: &'a [SceneResult],
) -> Option<&'a SceneResult> {
    let name = &scenes[place].name;
    let before = scenes[..place].iter().filter(|s| s.name == *name).count();
    others.iter().filter(|s| s.name == *name).nth(before)
}

/// Comparable quantities of two comparisons.
struct SameMachine {
    /// Whether times are comparable.
    timed: bool,
    /// Whether graphics rounding is the same.
    same_adapter: bool,
}

/// Compares the machines. Adds a note if times can't be compared.
fn machines(old: &Comparison, new: &Comparison, notes: &mut Vec<String>) -> SameMachine {
    let then = &old.environment;
    let now = &new.environment;
    let same_adapter = then.adapter == now.adapter;
    let why = if machine(then) != machine(now) || !same_adapter {
        Some(format!(
            "the baseline was made on another machine ({}; here: {})",
            machine_and_adapter(then),
            machine_and_adapter(now)
        ))
    } else if times(old).next().is_none() {
        Some("the baseline has none".to_owned())
    } else if times(new).next().is_none() {
        Some("this run has none".to_owned())
    } else if old.schema < FIRST_TIMED || !times(old).any(|times| times.yardstick.is_some()) {
        let schema = old.schema;
        Some(format!(
            "the baseline (schema {schema}) was timed with other yardsticks than this version's; \
             make a new one to compare times"
        ))
    } else {
        None
    };
    if let Some(why) = &why {
        notes.push(format!(
            "Times are not compared, only accuracy, counted cost and bytes: {why}."
        ));
    }
    SameMachine {
        timed: why.is_none(),
        same_adapter,
    }
}

fn machine(e: &Environment) -> String {
    format!("{}, {} threads, {}", e.cpu, e.threads, e.system)
}

fn machine_and_adapter(e: &Environment) -> String {
    let adapter = e.adapter.as_deref().unwrap_or("no adapter");
    format!("{}; {adapter}", machine(e))
}

/// Returns the times of all rows with times.
fn times(comparison: &Comparison) -> impl Iterator<Item = RowTimes> + '_ {
    comparison
        .scenes
        .iter()
        .flat_map(|scene| &scene.rows)
        .filter_map(|row| row.measured_figures()?.times)
}

/// Returns why a scene can't be compared with the baseline's. `None` if it can.
fn incomparable(old: &SceneResult, new: &SceneResult) -> Option<&'static str> {
    if old.fingerprint != new.fingerprint || old.light != new.light {
        Some("its triangles differ")
    } else if old.size != new.size {
        Some("its image has another size")
    } else if old.truth.samples != new.truth.samples {
        Some("its truth has other samples")
    } else if old.truth.counted != new.truth.counted {
        Some("other pixels count")
    } else if has_moved(old.rmse_of_none, new.rmse_of_none) {
        Some("its light or camera moved")
    } else {
        None
    }
}

/// Reports whether the light or the camera moved: the RMSE without shadows depends on truth only.
fn has_moved(old: [f64; 2], new: [f64; 2]) -> bool {
    old.iter()
        .zip(new)
        .any(|(old, new)| (old - new).abs() > ROUNDING * old.abs().max(new.abs()))
}

/// A scene of both comparisons.
struct Pair<'a> {
    /// The scene's index in the new results.
    place: usize,
    then: &'a SceneResult,
    now: &'a SceneResult,
    /// Whether times are compared.
    timed: bool,
    /// Whether graphics rounding is the same.
    same_adapter: bool,
}

impl<'a> Pair<'a> {
    /// Compares all rows. Records new and missing ones.
    fn compare(
        &self,
        out: &mut Changes,
        lost: &mut except::Lost<'_>,
        timings: &mut Vec<times::Timing<'a>>,
    ) {
        let then = by_setting(&self.then.rows);
        let now = by_setting(&self.now.rows);
        for row in &self.now.rows {
            match then.get(&setting(row)) {
                Some(old) => self.row(old, row, out, timings),
                None => out.new.push(self.say(row, "")),
            }
        }
        for row in &self.then.rows {
            lost.row(&self.now.name, row, !now.contains_key(&setting(row)));
        }
    }

    /// Formats a line about a row: scene, label, and `what`, which may be empty.
    fn say(&self, row: &CompareRow, what: &str) -> String {
        let colon = if what.is_empty() { "" } else { ": " };
        format!("{}: {}{colon}{what}", self.now.name, row.label())
    }

    /// Compares one row.
    fn row(
        &self,
        old: &CompareRow,
        new: &'a CompareRow,
        out: &mut Changes,
        timings: &mut Vec<times::Timing<'a>>,
    ) {
        out.compared += 1;
        let (then, now) = match (&old.outcome, &new.outcome) {
            (RowOutcome::Measured(then), RowOutcome::Measured(now)) => (then, now),
            (RowOutcome::Measured(_), RowOutcome::Unsupported { reason }) => {
                let what = format!("refused now: {reason}");
                out.worse.push(self.say(new, &what));
                return;
            }
            (RowOutcome::Unsupported { .. }, RowOutcome::Measured(_)) => {
                out.better.push(self.say(new, "measured now"));
                return;
            }
            _ => return,
        };
        let exact = new.backend == "cpu" || self.same_adapter;
        for figure in figures::figures_of_row(&new.backend, then, now, exact) {
            match figure.change() {
                Some(figures::Change::Grew(what)) => out.worse.push(self.say(new, &what)),
                Some(figures::Change::Shrank(what)) => out.better.push(self.say(new, &what)),
                None => {}
            }
        }
        if !self.timed {
            return;
        }
        if let (Some(then), Some(now)) = (sample(then.times), sample(now.times)) {
            timings.push(times::Timing {
                scene: (self.place, &self.now.name),
                row: new,
                then,
                now,
            });
        }
    }
}

/// Returns the key of a row in its scene: technique, settings and backend.
fn setting(row: &CompareRow) -> [&str; 3] {
    [&row.technique, &row.settings, &row.backend]
}

fn by_setting(rows: &[CompareRow]) -> HashMap<[&str; 3], &CompareRow> {
    rows.iter().map(|row| (setting(row), row)).collect()
}

/// Returns the compared times of a row. `None` without a yardstick.
fn sample(times: Option<RowTimes>) -> Option<times::RatioSample> {
    let times = times?;
    Some(times::RatioSample {
        ratio: times.ratio?,
        least_ms: times.total.min,
        yardstick: times.yardstick?.min,
        device_units: times.device_units,
    })
}

#[cfg(test)]
mod tests;
