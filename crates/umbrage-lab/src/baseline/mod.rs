//! Did anything get slower or less accurate than it was? The guard that a renderer's continuous integration asks.
//!
//! Rows of the same scene, technique, settings and backend are compared, if the scene itself, its image and its truth are
//! the same:
//!
//! * **Errors** (RMSE, false shadow, false light, acne) are deterministic: any growth beyond [`ROUNDING`] counts. Between
//!   different graphics adapters, whose rounding differs, as much as the [undecided pixels
//!   allowed](umbrage_core::metrics::MOST_UNDECIDED) can make counts as noise.
//! * **Cost** (counted work, at today's prices) and **bytes** are deterministic, too: any growth beyond rounding counts.
//! * **Time** counts only on the same processor, threads, system and adapter, and only when each run's median lies outside
//!   the other's spread and differs by more than [`TIME_NOISE`].
//!
//! A row that was measured and is now refused counts as less accurate. New and missing rows are told, no more.

mod read;

pub use read::{apart, read};

use crate::{
    compare::{Comparison, Environment, Measured, Outcome, Row, SceneResult, Spread},
    cost::CostModel,
};
use std::collections::HashMap;
use umbrage_core::metrics::MOST_UNDECIDED;

/// Sums over pixels may come out of another order of additions: relative growth up to this is none.
pub const ROUNDING: f64 = 1e-9;

/// Medians that differ by less are noise: software drivers scatter by 10 to 30 percent even on an idle machine.
pub const TIME_NOISE: f64 = 0.3;

/// What has changed, one line each.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Changes {
    /// Rows that both have and that could be compared: a guard that compared nothing guards nothing.
    pub compared: usize,
    /// Slower, dearer, larger or less accurate: what a guard refuses.
    pub worse: Vec<String>,
    /// The opposite.
    pub better: Vec<String>,
    /// Rows that the baseline lacks.
    pub new: Vec<String>,
    /// Rows that only the baseline has.
    pub missing: Vec<String>,
    /// What could not be compared, and why.
    pub notes: Vec<String>,
}

/// What has changed since `old`.
pub fn changes(old: &Comparison, new: &Comparison) -> Changes {
    let mut out = Changes::default();
    let [timed, same_adapter] = machines(&old.environment, &new.environment, &mut out.notes);
    let before: HashMap<&str, &SceneResult> = old.scenes.iter().map(|s| (s.name.as_str(), s)).collect();
    for scene in &new.scenes {
        let Some(then) = before.get(scene.name.as_str()) else {
            out.new.push(format!("{}: the whole scene", scene.name));
            continue;
        };
        if let Some(why) = incomparable(then, scene) {
            out.notes.push(format!("{}: not compared, as {why}", scene.name));
            continue;
        }
        Pair { then, now: scene, timed, same_adapter }.compare(&mut out);
    }
    let now: Vec<&str> = new.scenes.iter().map(|s| s.name.as_str()).collect();
    let gone = old.scenes.iter().filter(|s| !now.contains(&s.name.as_str()));
    out.missing.extend(gone.map(|s| format!("{}: the whole scene", s.name)));
    out
}

/// Whether times can be compared, and whether graphics rounding is the same.
fn machines(old: &Environment, new: &Environment, notes: &mut Vec<String>) -> [bool; 2] {
    let same_adapter = old.adapter == new.adapter;
    let machine = |e: &Environment| format!("{}, {} threads, {}", e.cpu, e.threads, e.system);
    let same = machine(old) == machine(new) && same_adapter;
    if !same {
        let describe = |e: &Environment| format!("{}; {}", machine(e), e.adapter.as_deref().unwrap_or("no adapter"));
        notes.push(format!(
            "Times are not compared, only counted costs: the baseline was made on another machine ({}; here: {}).",
            describe(old),
            describe(new)
        ));
    }
    [same, same_adapter]
}

fn incomparable(old: &SceneResult, new: &SceneResult) -> Option<String> {
    let facts = [
        ("its triangles differ", old.fingerprint != new.fingerprint || old.light != new.light),
        ("its image has another size", old.size != new.size),
        ("its truth has other samples", old.truth.samples != new.truth.samples),
        ("other pixels count", old.truth.counted != new.truth.counted),
        ("its light or camera moved", moved(old.rmse_of_none, new.rmse_of_none)),
    ];
    facts.iter().find(|(_, differs)| *differs).map(|(why, _)| (*why).to_owned())
}

/// How much is in shadow depends on truth alone: it changes with light and camera, not with techniques.
fn moved(old: [f64; 2], new: [f64; 2]) -> bool {
    old.iter().zip(new).any(|(old, new)| (old - new).abs() > ROUNDING * old.abs().max(new.abs()))
}

/// One scene, then and now.
struct Pair<'a> {
    then: &'a SceneResult,
    now: &'a SceneResult,
    timed: bool,
    same_adapter: bool,
}

impl Pair<'_> {
    fn compare(&self, out: &mut Changes) {
        let key = |r: &Row| [r.technique.clone(), r.settings.clone(), r.backend.clone()];
        let then: HashMap<_, &Row> = self.then.rows.iter().map(|r| (key(r), r)).collect();
        for row in &self.now.rows {
            match then.get(&key(row)) {
                Some(old) => self.row(old, row, out),
                None => out.new.push(self.say(row, "")),
            }
        }
        let now: Vec<_> = self.now.rows.iter().map(key).collect();
        out.missing.extend(self.then.rows.iter().filter(|r| !now.contains(&key(r))).map(|r| self.say(r, "")));
    }

    fn say(&self, row: &Row, what: &str) -> String {
        let colon = if what.is_empty() { "" } else { ": " };
        format!("{}: {}{colon}{what}", self.now.name, row.label())
    }

    fn row(&self, old: &Row, new: &Row, out: &mut Changes) {
        out.compared += 1;
        let (then, now) = match (&old.outcome, &new.outcome) {
            (Outcome::Measured(then), Outcome::Measured(now)) => (then, now),
            (Outcome::Measured(_), Outcome::Unsupported { reason }) => {
                return out.worse.push(self.say(new, &format!("refused now: {reason}")));
            }
            (Outcome::Unsupported { .. }, Outcome::Measured(_)) => {
                return out.better.push(self.say(new, "measured now"));
            }
            _ => return,
        };
        let exact = new.backend == "cpu" || self.same_adapter;
        for figure in figures(&new.backend, then, now, exact) {
            match figure.change() {
                Some((true, what)) => out.worse.push(self.say(new, &what)),
                Some((false, what)) => out.better.push(self.say(new, &what)),
                None => {}
            }
        }
        if let (true, Some(then), Some(now)) = (self.timed, then.times, now.times) {
            match slower(&then.total, &now.total) {
                Some(true) => out.worse.push(self.say(new, &times("slower", &then.total, &now.total))),
                Some(false) => out.better.push(self.say(new, &times("quicker", &then.total, &now.total))),
                None => {}
            }
        }
    }
}

/// A figure that should not grow.
struct Figure {
    name: &'static str,
    then: f64,
    now: f64,
    noise: f64,
}

impl Figure {
    /// Whether it grew, and what to say, if it changed beyond the noise.
    fn change(&self) -> Option<(bool, String)> {
        let difference = self.now - self.then;
        let noise = self.noise + ROUNDING * self.then.abs().max(self.now.abs());
        let what = || format!("{} {} -> {}", self.name, short(self.then), short(self.now));
        (difference.abs() > noise).then(|| (difference > 0.0, what()))
    }
}

fn figures(backend: &str, then: &Measured, now: &Measured, exact: bool) -> [Figure; 6] {
    let (a, b) = (&then.errors, &now.errors);
    // Undecided pixels may all flip: in a share of the image, that share; in a mean square, that much.
    let share = if exact { 0.0 } else { 100.0 * MOST_UNDECIDED };
    let rmse = if exact { 0.0 } else { (a.rmse.powi(2) + MOST_UNDECIDED).sqrt() - a.rmse };
    let prices = CostModel::of(backend);
    let [cost_then, cost_now] = [then, now].map(|m| prices.milliseconds(&m.work));
    let figure = |name, then, now, noise| Figure { name, then, now, noise };
    [
        figure("RMSE", a.rmse, b.rmse, rmse),
        figure("false shadow %", a.false_shadow, b.false_shadow, share),
        figure("false light %", a.false_light, b.false_light, share),
        figure("acne %", a.acne, b.acne, share),
        figure("cost ms", cost_then, cost_now, 0.0),
        figure("bytes", then.bytes as f64, now.bytes as f64, 0.0),
    ]
}

/// Whether runs got slower (or quicker), if beyond the noise.
fn slower(then: &Spread, now: &Spread) -> Option<bool> {
    let beyond = |quick: &Spread, slow: &Spread| {
        let outside = slow.median > quick.greatest && quick.median < slow.least;
        outside && slow.median > (1.0 + TIME_NOISE) * quick.median
    };
    match (beyond(then, now), beyond(now, then)) {
        (true, _) => Some(true),
        (_, true) => Some(false),
        _ => None,
    }
}

fn times(word: &str, then: &Spread, now: &Spread) -> String {
    let ms = |s: &Spread| format!("{} ({} to {}) ms", short(s.median), short(s.least), short(s.greatest));
    format!("{word}: {} -> {}", ms(then), ms(now))
}

/// Four digits that count.
fn short(v: f64) -> String {
    if v == 0.0 || (0.01..1e6).contains(&v.abs()) { format!("{:.4}", v) } else { format!("{v:.3e}") }
}

#[cfg(test)]
mod tests;
