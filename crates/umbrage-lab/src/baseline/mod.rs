//! Compares a comparison with an earlier one, the baseline: what got slower, dearer, larger or less
//! accurate. A check for a renderer's continuous integration.
//!
//! Rows of the same scene, technique, settings and backend are compared, if the scene itself, its
//! image and its truth are the same:
//!
//! * **Errors** (RMSE, false shadow, false light, acne) are deterministic: any growth beyond
//!   [`ROUNDING`] counts. Between different graphics adapters, whose rounding differs, as much as
//!   the [undecided pixels allowed](umbrage_core::metrics::MAX_UNDECIDED_SHARE) can make counts as
//!   noise.
//! * **Cost** (counted work, at today's prices) and **bytes** are deterministic, too: any growth
//!   beyond rounding counts.
//! * **Time** counts only on the same processor, threads, system and adapter. Rows are compared as
//!   multiples of the yardstick that was timed in turn with them; [`mod@times`] says when one is
//!   slower, and how seldom that is said in vain. What looks slower is [timed again](time_again)
//!   before it counts. Times of results before schema 7 are not compared: their yardsticks had
//!   other lengths, or they had none.
//!
//! A row that was measured and is now refused counts as less accurate. What the baseline has and
//! the new results lack, and scenes that can't be compared since they changed, count as faults,
//! too, unless they are [excepted](Except) by name: a guard that compares less than it did guards
//! less. New rows are told, no more.

mod again;
mod changes;
mod except;
mod figures;
mod read;
pub mod times;

pub use again::{ROUNDS, time_again};
pub use changes::{Changes, ROUNDING};
pub use except::Except;
pub use read::{apart, read};

use crate::compare::{CompareRow, Comparison, Environment, RowOutcome, RowTimes, SceneResult};
use std::collections::HashMap;

/// The first schema whose times are compared: yardsticks had other lengths before it.
const FIRST_TIMED: u32 = 7;

/// Compares `new` with the baseline `old`. What `except` names may be missing.
pub fn changes(old: &Comparison, new: &Comparison, except: &Except) -> Changes {
    let mut out = Changes::default();
    let SameMachine {
        timed,
        same_adapter,
    } = machines(old, new, &mut out.notes);
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
    let mut timings = Vec::new();
    for pair in &pairs {
        pair.compare(&mut out, &mut lost, &mut timings);
    }
    let (timings, other): (Vec<_>, Vec<_>) = timings
        .into_iter()
        .partition(|t| t.then.device_units == t.now.device_units);
    if let Some(timing) = other.first() {
        out.notes.push(format!(
            "The times of {} rows are not compared, since their yardstick on the device is not as \
             long as the baseline's (the first: {}: {}): run it again, or make a new baseline.",
            other.len(),
            timing.scene.1,
            timing.row.label()
        ));
    }
    out.timed = timings.len();
    let judged = times::judge(&timings);
    out.better.extend(judged.quicker);
    out.suspects = judged.suspects;
    if judged.rough > 0 {
        let rough = judged.rough;
        let few = times::MIN_RUNS;
        out.notes.push(format!(
            "{rough} rows have fewer than {few} calm runs in the baseline (--runs, or a busy machine): their times count with \
             their techniques' alone."
        ));
    }
    lost.report(&mut out);
    out
}

/// Returns the scene of `others` that has the name of the scene at `place`. Where several share a
/// name, the first belongs to the first, the second to the second, and so on.
fn counterpart<'a>(
    scenes: &[SceneResult],
    place: usize,
    others: &'a [SceneResult],
) -> Option<&'a SceneResult> {
    let name = &scenes[place].name;
    let before = scenes[..place].iter().filter(|s| s.name == *name).count();
    others.iter().filter(|s| s.name == *name).nth(before)
}

/// What two comparisons' machines allow to compare.
struct SameMachine {
    /// Whether times can be compared.
    timed: bool,
    /// Whether graphics rounding is the same.
    same_adapter: bool,
}

/// Compares machines, and notes why times can't be compared.
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

/// Returns the times of all rows that have some.
fn times(comparison: &Comparison) -> impl Iterator<Item = RowTimes> + '_ {
    comparison
        .scenes
        .iter()
        .flat_map(|scene| &scene.rows)
        .filter_map(|row| row.measured()?.times)
}

/// Returns why a scene can't be compared with what it was; none if it can.
fn incomparable(old: &SceneResult, new: &SceneResult) -> Option<&'static str> {
    if old.fingerprint != new.fingerprint || old.light != new.light {
        Some("its triangles differ")
    } else if old.size != new.size {
        Some("its image has another size")
    } else if old.truth.samples != new.truth.samples {
        Some("its truth has other samples")
    } else if old.truth.counted != new.truth.counted {
        Some("other pixels count")
    } else if moved(old.rmse_of_none, new.rmse_of_none) {
        Some("its light or camera moved")
    } else {
        None
    }
}

/// Whether the light or the camera moved: the RMSE of no shadows at all depends on truth alone, not
/// on techniques.
fn moved(old: [f64; 2], new: [f64; 2]) -> bool {
    old.iter()
        .zip(new)
        .any(|(old, new)| (old - new).abs() > ROUNDING * old.abs().max(new.abs()))
}

/// One scene, then and now.
struct Pair<'a> {
    /// The scene's place among the new results.
    place: usize,
    then: &'a SceneResult,
    now: &'a SceneResult,
    /// Whether times are compared.
    timed: bool,
    /// Whether graphics rounding is the same.
    same_adapter: bool,
}

impl<'a> Pair<'a> {
    /// Compares all rows, and notes rows that are new or missing.
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

    /// Returns a line about a row: its scene, its label, and `what`, which may be empty.
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
        for figure in figures::of(&new.backend, then, now, exact) {
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

/// What tells a row from others of its scene: technique, settings and backend.
fn setting(row: &CompareRow) -> [&str; 3] {
    [&row.technique, &row.settings, &row.backend]
}

fn by_setting(rows: &[CompareRow]) -> HashMap<[&str; 3], &CompareRow> {
    rows.iter().map(|row| (setting(row), row)).collect()
}

/// Returns what of a row's times is compared; none without times beside a yardstick.
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
