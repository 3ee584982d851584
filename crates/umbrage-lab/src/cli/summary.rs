//! Summary of a comparison: the last lines of its output.

use crate::{
    compare::{
        Comparison, CostBasis, Relative, SceneResult, Section, SettingGroup, percent,
        setting_groups, times,
    },
    report::StabilitySource,
};
use umbrage_plan::statistics::Sorted;

/// Number of lines about settings in all groups together.
const LINES: usize = 8;

/// Returns a heading, about [`LINES`] lines and the rank correlation of predicted cost and time.
///
/// The lines are the most important settings for each kind of light and backend, at least one each.
/// Returns nothing if there is nothing to report.
pub(crate) fn lines(comparison: &Comparison, stability: Option<&StabilitySource>) -> Vec<String> {
    let groups = setting_groups(comparison);
    let Some(first) = groups.first() else {
        return Vec::new();
    };
    let unit = match first.clock() {
        CostBasis::Wall => "time",
        CostBasis::Cost => "cost",
    };
    let heading =
        format!("recommended settings: error relative to no shadow, {unit} relative to a hard map");
    let mut out = vec![heading];
    let count = (LINES / groups.len()).max(1);
    for group in &groups {
        for place in group.shortlist(count) {
            out.push(line(group, &group.settings[place], stability));
        }
        out.extend(without_good_setting(comparison, group));
    }
    out.extend(cost_ranks(comparison));
    let scenes = comparison.scenes.iter();
    let unknown: usize = scenes.map(SceneResult::rows_at_unknown_clock).sum();
    if unknown > 0 {
        out.push(format!(
            "{unknown} rows have times at a reduced or unknown device clock: \
             no run of theirs had a steady reference workload before and after it"
        ));
    }
    out.extend(rows_sensitive_to_rounding(comparison));
    out
}

/// Returns a line about a group without a good setting: what helps, or why nothing is needed. `None`
/// for other groups.
fn without_good_setting(comparison: &Comparison, group: &SettingGroup) -> Option<String> {
    let what = if group.has_no_shadow() {
        "no pixel that counts is in shadow, so `none` is exact"
    } else if group.has_good_setting() {
        return None;
    } else {
        let is_sun = |&scene: &usize| comparison.scenes[scene].light == "directional";
        match (group.light, group.scenes.iter().any(is_sun)) {
            ("hard", true) => "no setting here is good: use cascades or `exact`",
            ("hard", false) => "no setting here is good: use `exact`",
            (_, true) => "no setting here is good: use cascades or `soft`",
            (_, false) => "no setting here is good: use `soft`",
        }
    };
    Some(format!(
        "{} shadows, {:<5} {what}",
        group.light, group.backend
    ))
}

/// Returns a line about rows in which rounding alone changes many pixels. `None` if there are none.
fn rows_sensitive_to_rounding(comparison: &Comparison) -> Option<String> {
    let rows = comparison.rows_sensitive_to_rounding();
    let (first, rest) = rows.split_first()?;
    let others = match rest.len() {
        0 => String::new(),
        count => format!("; and {count} more rows"),
    };
    Some(format!(
        "rounding alone changes many pixels, which is expected here: {first}{others}"
    ))
}

/// Returns a line about the rank correlation of predicted cost and measured time, per scene and
/// backend. `None` without times.
fn cost_ranks(comparison: &Comparison) -> Option<String> {
    let mut worst: Option<(f64, String)> = None;
    let mut all = Vec::new();
    // Skip small checks if there are full-size scenes.
    let is_content = |scene: &&SceneResult| scene.section == Section::Content;
    let has_content = comparison.scenes.iter().any(|scene| is_content(&scene));
    let scenes = comparison.scenes.iter();
    for scene in scenes.filter(|scene| !has_content || is_content(scene)) {
        for backend in scene.backends() {
            let Some(correlation) = scene.cost_ranks(backend) else {
                continue;
            };
            all.push(correlation);
            if worst.as_ref().is_none_or(|(least, _)| correlation < *least) {
                worst = Some((correlation, format!("{} on {backend}", scene.name)));
            }
        }
    }
    let median = Sorted::new(all).quantile(0.5)?;
    let (least, place) = worst?;
    Some(format!(
        "rank correlation of predicted cost and measured time: median {median:.2}, minimum {least:.2} ({place})"
    ))
}

fn line(group: &SettingGroup, setting: &Relative, stability: Option<&StabilitySource>) -> String {
    let error = if setting.is_exact() {
        "exact".to_owned()
    } else {
        percent(setting.error)
    };
    let time = times(setting.take(group.clock()).unwrap_or_default());
    let (light, backend, name) = (group.light, &group.backend, setting.name());
    let verdicts = stability.and_then(|s| s.verdicts_of(&setting.technique, &setting.settings));
    let fails = verdicts.map_or_else(String::new, |v| format!("; {}", v.words(0)));
    format!("{light} shadows, {backend:<5} {error:>6} {time:>10}  {name}{fails}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::{CompareRow, Measured, RowOutcome, RowTimes, SceneResult, TimingStats};

    fn row(technique: &str, backend: &str, rmse: f64, ms: f64) -> CompareRow {
        let total = TimingStats {
            median: ms,
            ..TimingStats::default()
        };
        let times = RowTimes {
            total,
            full_clock_factor: Some(1.0),
            ..RowTimes::default()
        };
        let errors = umbrage_core::metrics::Errors {
            rmse,
            ..Default::default()
        };
        let measured = Measured {
            errors: Some(errors),
            times: Some(times),
            cost_ms: ms,
            executed_cost_ms: None,
            ..Measured::default()
        };
        CompareRow {
            technique: technique.into(),
            settings: String::new(),
            slug: technique.into(),
            backend: backend.into(),
            same_as: None,
            outcome: RowOutcome::Measured(Box::new(measured)),
        }
    }

    fn comparison(backends: &[&str]) -> Comparison {
        let scene = |is_ideal| {
            let mut rows = Vec::new();
            for backend in backends {
                rows.push(row("hard", backend, 0.1, 1.0));
                rows.push(row("pcf", backend, 0.05, 1.5));
                rows.push(row("pcss", backend, 0.04, 3.0));
                rows.push(row("volumes", backend, 0.0, 12.0));
                rows.push(row("slow", backend, 0.4, 20.0));
                rows.push(row("slower", backend, 0.4, 30.0));
            }
            SceneResult {
                is_ideal,
                rmse_of_none: [0.5, 0.9],
                rows,
                ..SceneResult::default()
            }
        };
        Comparison {
            scenes: vec![scene(true), scene(false)],
            ..Comparison::default()
        }
    }

    #[test]
    fn ten_lines_tell_what_to_use() {
        let all = lines(&comparison(&["cpu", "wgpu"]), None);
        assert_eq!(all.len(), 2 + LINES, "{all:?}");
        let ranks = "median 1.00, minimum 1.00 ( on cpu)";
        assert!(all[1 + LINES].ends_with(ranks), "{}", all[1 + LINES]);
        assert_eq!(all[1], "hard shadows, cpu     10 %  1.5 times  pcf");
        assert_eq!(all[8], "soft shadows, wgpu   exact   12 times  volumes");
        assert_eq!(lines(&comparison(&["cpu"]), None).len(), 2 + LINES);
        assert_eq!(
            lines(&comparison(&["a", "b", "c", "d", "e"]), None).len(),
            12
        );
    }

    #[test]
    fn groups_without_a_good_setting_report_what_helps() {
        let with = |rmse: f64, lit: f64, light: &str, is_ideal: bool| {
            let scene = SceneResult {
                is_ideal,
                light: light.into(),
                rmse_of_none: [lit, 0.9],
                rows: vec![row("none", "cpu", lit, 0.1), row("hard", "cpu", rmse, 1.0)],
                ..SceneResult::default()
            };
            let all = Comparison {
                scenes: vec![scene],
                ..Comparison::default()
            };
            lines(&all, None)[1..].join("\n")
        };
        let poor = "hard shadows, cpu   no setting here is good: use cascades or `exact`";
        assert!(with(0.5, 0.5, "directional", true).starts_with(poor));
        let poor = "hard shadows, cpu     80 %  1.0 times  hard\n\
                    hard shadows, cpu   no setting here is good: use `exact`";
        assert!(with(0.4, 0.5, "point", true).starts_with(poor));
        let poor = "soft shadows, cpu   no setting here is good: use cascades or `soft`";
        assert!(with(0.6, 0.5, "directional", false).starts_with(poor));
        let none = "hard shadows, cpu   no pixel that counts is in shadow, so `none` is exact";
        assert!(with(0.05, 0.0, "directional", true).starts_with(none));
        let good = with(0.1, 0.5, "directional", true);
        assert!(!good.contains("good") && !good.contains("exact"), "{good}");
    }

    #[test]
    fn rows_at_an_unknown_clock_are_counted_once() {
        let mut all = comparison(&["wgpu"]);
        all.scenes.truncate(1);
        let rows = &mut all.scenes[0].rows;
        for row in rows.iter_mut() {
            let RowOutcome::Measured(m) = &mut row.outcome else {
                panic!("measured")
            };
            m.times.as_mut().expect("timed").full_clock_factor = None;
        }
        let count = |all: &Comparison| {
            let line = lines(all, None)
                .into_iter()
                .find(|line| line.contains("unknown device clock"));
            line.map(|line| line[..1].to_owned())
        };
        assert_eq!(count(&all), None, "timed once, without a yardstick");
        let rows = &mut all.scenes[0].rows;
        for row in &mut rows[..3] {
            let RowOutcome::Measured(m) = &mut row.outcome else {
                panic!("measured")
            };
            m.times.as_mut().expect("timed").yardstick = Some(TimingStats::default());
        }
        rows[1].same_as = Some("hard ()".into());
        assert_eq!(count(&all).as_deref(), Some("2"));
    }

    #[test]
    fn where_nothing_was_compared_nothing_is_said() {
        assert_eq!(lines(&Comparison::default(), None), [""; 0]);
    }
}
