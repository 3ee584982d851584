//! Did anything get slower or less accurate than it was? The guard that a renderer's continuous integration asks.
//!
//! Rows of the same scene, technique, settings and backend are compared, if the scene itself, its image and its truth are
//! the same:
//!
//! * **Errors** (RMSE, false shadow, false light, acne) are deterministic: any growth beyond [`ROUNDING`] counts. Between
//!   different graphics adapters, whose rounding differs, as much as the [undecided pixels
//!   allowed](umbrage_core::metrics::MAX_UNDECIDED_SHARE) can make counts as noise.
//! * **Cost** (counted work, at today's prices) and **bytes** are deterministic, too: any growth beyond rounding counts.
//! * **Time** counts only on the same processor, threads, system and adapter. Rows are compared as multiples of the
//!   yardstick that was timed in turn with them; [`mod@times`] says when one is slower, and how seldom that is said in
//!   vain. What looks slower is [timed again](time_again) before it counts. Results of schema 4 and before have no
//!   yardstick: their times are not compared.
//!
//! A row that was measured and is now refused counts as less accurate. What the baseline has and the new results lack, and
//! scenes that can't be compared since they changed, count as faults, too, unless they are [excepted](Except) by name: a
//! guard that compares less than it did guards less. New rows are told, no more.

mod again;
mod except;
mod figures;
mod read;
pub mod times;

pub use again::{ROUNDS, time_again};
pub use except::Except;
pub use read::{apart, read};

use crate::compare::{CompareRow, Comparison, Environment, RowOutcome, RowTimes, SceneResult};
use std::collections::HashMap;
use times::Suspect;

/// Sums over pixels may come out of another order of additions: relative growth up to this is none.
pub const ROUNDING: f64 = 1e-9;

/// What has changed, one line each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Changes {
    /// Rows that both have and that could be compared: a guard that compared nothing guards nothing.
    pub compared: usize,
    /// Of these, rows whose times could be compared.
    pub timed: usize,
    /// Slower, dearer, larger or less accurate: what a guard refuses.
    pub worse: Vec<String>,
    /// The opposite.
    pub better: Vec<String>,
    /// Rows that the baseline lacks.
    pub new: Vec<String>,
    /// What only the baseline has, and what can't be compared with it: what a guard refuses, too.
    pub lost: Vec<String>,
    /// The names that would except all that is lost.
    pub except: Vec<String>,
    /// What was excepted, and what the reader must know.
    pub notes: Vec<String>,
    /// What looks slower, and is to be [timed again](time_again) before it is called so.
    pub suspects: Vec<Suspect>,
}

/// What has changed since `old`; nothing that `except` names is missed.
pub fn changes(old: &Comparison, new: &Comparison, except: &Except) -> Changes {
    let mut out = Changes::default();
    let [timed, same_adapter] = machines(old, new, &mut out.notes);
    let before: HashMap<_, &SceneResult> = numbered(&old.scenes).collect();
    let mut lost = except::Lost::new(except);
    let mut pairs = Vec::new();
    for (place, (key, scene)) in numbered(&new.scenes).enumerate() {
        let Some(then) = before.get(&key) else {
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
    let now: HashMap<_, &SceneResult> = numbered(&new.scenes).collect();
    for (key, scene) in numbered(&old.scenes).filter(|(key, _)| !now.contains_key(key)) {
        lost.scene(
            key.0,
            &format!("is missing with its {} rows", scene.rows.len()),
        );
    }
    let mut timings = Vec::new();
    for pair in &pairs {
        pair.compare(&mut out, &mut lost, &mut timings);
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

/// Scenes by name, and by number where several share one.
fn numbered(scenes: &[SceneResult]) -> impl Iterator<Item = ((&str, usize), &SceneResult)> {
    let number = |i: usize| {
        scenes[..i]
            .iter()
            .filter(|s| s.name == scenes[i].name)
            .count()
    };
    scenes
        .iter()
        .enumerate()
        .map(move |(i, s)| ((s.name.as_str(), number(i)), s))
}

/// Whether times can be compared, and whether graphics rounding is the same.
fn machines(old: &Comparison, new: &Comparison, notes: &mut Vec<String>) -> [bool; 2] {
    let then = &old.environment;
    let now = &new.environment;
    let same_adapter = then.adapter == now.adapter;
    let machine = |e: &Environment| format!("{}, {} threads, {}", e.cpu, e.threads, e.system);
    let describe = |e: &Environment| {
        format!(
            "{}; {}",
            machine(e),
            e.adapter.as_deref().unwrap_or("no adapter")
        )
    };
    let any = |c: &Comparison, has: fn(&RowTimes) -> bool| {
        let mut times = c
            .scenes
            .iter()
            .flat_map(|s| &s.rows)
            .filter_map(|r| r.measured()?.times);
        times.any(|t| has(&t))
    };
    let times: fn(&RowTimes) -> bool = |_| true;
    let ratios: fn(&RowTimes) -> bool = |t| t.yardstick.is_some();
    let why = if machine(then) != machine(now) || !same_adapter {
        let [then, now] = [then, now].map(describe);
        Some(format!(
            "the baseline was made on another machine ({then}; here: {now})"
        ))
    } else if !any(old, times) {
        Some("the baseline has none".to_owned())
    } else if !any(new, times) {
        Some("this run has none".to_owned())
    } else if !any(old, ratios) {
        let schema = old.schema;
        Some(format!(
            "the baseline (schema {schema}) has no yardsticks beside them; make it anew to compare times"
        ))
    } else {
        None
    };
    notes.extend(why.iter().map(|why| {
        format!("Times are not compared, only accuracy, counted cost and bytes: {why}.")
    }));
    [why.is_none(), same_adapter]
}

fn incomparable(old: &SceneResult, new: &SceneResult) -> Option<String> {
    let facts = [
        (
            "its triangles differ",
            old.fingerprint != new.fingerprint || old.light != new.light,
        ),
        ("its image has another size", old.size != new.size),
        (
            "its truth has other samples",
            old.truth.samples != new.truth.samples,
        ),
        ("other pixels count", old.truth.counted != new.truth.counted),
        (
            "its light or camera moved",
            moved(old.rmse_of_none, new.rmse_of_none),
        ),
    ];
    facts
        .iter()
        .find(|(_, differs)| *differs)
        .map(|(why, _)| (*why).to_owned())
}

/// How much is in shadow depends on truth alone: it changes with light and camera, not with techniques.
fn moved(old: [f64; 2], new: [f64; 2]) -> bool {
    old.iter()
        .zip(new)
        .any(|(old, new)| (old - new).abs() > ROUNDING * old.abs().max(new.abs()))
}

/// One scene, then and now.
struct Pair<'a> {
    /// Among the new results.
    place: usize,
    then: &'a SceneResult,
    now: &'a SceneResult,
    timed: bool,
    same_adapter: bool,
}

impl<'a> Pair<'a> {
    fn compare(
        &self,
        out: &mut Changes,
        lost: &mut except::Lost<'_>,
        timings: &mut Vec<times::Timing<'a>>,
    ) {
        let key = |r: &CompareRow| [r.technique.clone(), r.settings.clone(), r.backend.clone()];
        let then: HashMap<_, &CompareRow> = self.then.rows.iter().map(|r| (key(r), r)).collect();
        let now: HashMap<_, &CompareRow> = self.now.rows.iter().map(|r| (key(r), r)).collect();
        for row in &self.now.rows {
            match then.get(&key(row)) {
                Some(old) => self.row(old, row, out, timings),
                None => out.new.push(self.say(row, "")),
            }
        }
        for row in &self.then.rows {
            lost.row(&self.now.name, row, !now.contains_key(&key(row)));
        }
    }

    fn say(&self, row: &CompareRow, what: &str) -> String {
        let colon = if what.is_empty() { "" } else { ": " };
        format!("{}: {}{colon}{what}", self.now.name, row.label())
    }

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
                return out
                    .worse
                    .push(self.say(new, &format!("refused now: {reason}")));
            }
            (RowOutcome::Unsupported { .. }, RowOutcome::Measured(_)) => {
                return out.better.push(self.say(new, "measured now"));
            }
            _ => return,
        };
        let exact = new.backend == "cpu" || self.same_adapter;
        for figure in figures::of(&new.backend, then, now, exact) {
            match figure.change() {
                Some((true, what)) => out.worse.push(self.say(new, &what)),
                Some((false, what)) => out.better.push(self.say(new, &what)),
                None => {}
            }
        }
        let sample = |times: Option<RowTimes>| {
            let times = times?;
            Some(times::RatioSample {
                ratio: times.ratio?,
                least_ms: times.total.min,
                yardstick: times.yardstick?.min,
            })
        };
        if let (true, Some(then), Some(now)) = (self.timed, sample(then.times), sample(now.times)) {
            timings.push(times::Timing {
                scene: (self.place, &self.now.name),
                row: new,
                then,
                now,
            });
        }
    }
}

#[cfg(test)]
mod tests;
