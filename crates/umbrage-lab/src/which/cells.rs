//! Cells and lines of the page: answers with their errors and times.

use super::document::{Inline, text};
use super::groups::{Answer, BUDGETS, OfBackend, POOR, WhichGroup};
use crate::compare::{CostBasis, FrameMotion, Measured, Relative, percent, times};
use umbrage_techniques::ShadowMap;

/// Returns a cell of a table of all budgets: `as above` if the larger budget changes nothing.
pub(super) fn cell_below(
    group: &WhichGroup,
    of: &OfBackend,
    budget: usize,
    motion: usize,
) -> Vec<Inline> {
    let is_as_above = budget > 0 && of.table[budget][motion] == of.table[budget - 1][motion];
    if is_as_above {
        vec![text("as above")]
    } else {
        cell(group, of, budget, motion)
    }
}

/// Returns a cell of a table of budgets: the answer, its error and its time. If its error is
/// [`POOR`], names the fastest setting whose error is not.
pub(super) fn cell(
    group: &WhichGroup,
    of: &OfBackend,
    budget: usize,
    motion: usize,
) -> Vec<Inline> {
    let Some(place) = of.table[budget][motion] else {
        return vec![text("no setting is better than no shadow")];
    };
    let Some(setting) = of.setting(&group.answers[place], motion) else {
        return Vec::new();
    };
    if setting.error <= POOR {
        return setting_words(of, setting);
    }
    let mut out = vec![Inline::Bold("none is good".to_owned()), text(": ")];
    out.extend(setting_words(of, setting));
    if let Some(good) = of.fastest_good(motion) {
        out.push(text("; take "));
        out.extend(setting_words(of, good));
    }
    out
}

/// Returns a setting with its error and its time.
fn setting_words(of: &OfBackend, setting: &Relative) -> Vec<Inline> {
    let time = setting.take(of.clock).map_or_else(String::new, times);
    vec![
        Inline::Bold(setting.technique.clone()),
        text(format!(
            " {}: {}, {time}",
            words_of(&Answer::from_setting(setting)),
            error_words(setting)
        )),
    ]
}

/// Returns a line with the backend and the time of `hard` on it.
pub(super) fn hard_words(of: &OfBackend) -> Vec<Inline> {
    let mut parts = Vec::new();
    for (motion, (kind, words)) in of.motions.iter().enumerate() {
        let near_one = |s: &&Relative| {
            let time = s.take(of.clock).unwrap_or(f64::NAN);
            s.technique == "hard" && (time - 1.0).abs() < 1e-6
        };
        let Some(hard) = of.settings[motion].iter().find(near_one) else {
            continue;
        };
        if let Some(ms) = of.milliseconds(&Answer::from_setting(hard), *kind) {
            parts.push(format!("{} ms ({words})", short(ms)));
        }
    }
    let clock = match of.clock {
        CostBasis::Wall => "takes",
        CostBasis::Cost => "(by counted cost, not timed) takes",
    };
    vec![
        text("On "),
        Inline::Bold(of.backend.clone()),
        text(", "),
        Inline::Code("hard".to_owned()),
        text(format!(" {clock} {}:", parts.join(", "))),
    ]
}

/// Returns a setting's frame times on a backend: milliseconds, and multiples of `hard`.
pub(super) fn frame_words(of: &OfBackend, answer: &Answer) -> Option<String> {
    let mut ms = Vec::new();
    let mut ratios = Vec::new();
    for (motion, (kind, _)) in of.motions.iter().enumerate() {
        ms.push(short(of.milliseconds(answer, *kind)?));
        ratios.push(digits(of.setting(answer, motion)?.take(of.clock)?));
    }
    let labels: Vec<&str> = of.motions.iter().map(|(_, words)| *words).collect();
    Some(format!(
        "{} ({}): {} ms ({} times hard)",
        of.backend,
        labels.join(", "),
        ms.join(", "),
        ratios.join(", ")
    ))
}

impl OfBackend {
    /// Returns the geometric mean of a setting's frame times over the scenes, milliseconds; `None`
    /// if any scene lacks one.
    fn milliseconds(&self, answer: &Answer, motion: FrameMotion) -> Option<f64> {
        let mut logarithms = 0.0;
        for place in 0..self.scenes.len() {
            let measured = self.measured_figures(place, answer)?;
            logarithms += measured.milliseconds(self.clock, motion)?.ln();
        }
        Some((logarithms / self.scenes.len() as f64).exp())
    }

    /// Returns the measurement of a setting on a scene.
    fn measured_figures(&self, scene: usize, answer: &Answer) -> Option<&Measured> {
        let mut rows = self.scenes[scene].rows.iter();
        let row = rows.find(|row| {
            row.backend == self.backend
                && row.technique == answer.technique
                && row.settings == answer.settings
        })?;
        row.measured_figures()
    }
}

/// Returns an answer's settings without the default bias, which the page states once.
pub(super) fn words_of(answer: &Answer) -> String {
    let default = ShadowMap::default().bias.label();
    let words = answer.settings.split(", ").filter(|word| *word != default);
    words.collect::<Vec<_>>().join(", ")
}

pub(super) fn error_words(setting: &Relative) -> String {
    if setting.is_exact() {
        "exact".to_owned()
    } else {
        percent(setting.error)
    }
}

/// Returns a budget's label, by its index in [`BUDGETS`].
pub(super) fn budget_words(budget: usize) -> String {
    let times = BUDGETS[budget];
    if times.is_infinite() {
        "unlimited".to_owned()
    } else {
        format!("{times} times hard")
    }
}

/// Formats milliseconds with three digits.
fn short(ms: f64) -> String {
    match ms {
        _ if ms >= 100.0 => format!("{ms:.0}"),
        _ if ms >= 10.0 => format!("{ms:.1}"),
        _ => format!("{ms:.2}"),
    }
}

/// Formats a ratio with two digits.
fn digits(ratio: f64) -> String {
    if ratio < 10.0 {
        format!("{ratio:.1}")
    } else {
        format!("{ratio:.0}")
    }
}
