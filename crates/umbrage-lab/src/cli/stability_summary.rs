//! Summary of a `stability` run: the last lines of its output.

use crate::stability::{SettingVerdicts, Stability, Verdict};

/// Number of lines about single techniques: those that fail the smallest share of their rows.
const TECHNIQUES: usize = 5;
/// Number of titles of failed rows in a line.
const TITLES: usize = 5;

/// Returns at most nine lines: a heading, the techniques that fail the smallest share of their
/// rows, the other techniques, the bias windows and the sanity rows. The command adds the path of
/// the report as the tenth.
pub(crate) fn lines(stability: &Stability) -> Vec<String> {
    let count = |verdict| stability.count(verdict);
    let cells = format!(
        "{} cells pass, {} are degraded, {} fail, {} are not measured, as they could not have failed",
        count(Verdict::Pass),
        count(Verdict::Degraded),
        count(Verdict::Fails),
        count(Verdict::NotMeasured)
    );
    let all = stability.setting_verdicts();
    let mut out = vec![format!(
        "failures of each technique with its best setting ({cells}):"
    )];
    let best = best_settings(&all);
    for verdicts in best.iter().take(TECHNIQUES) {
        out.push(format!(
            "{:<13} {}",
            verdicts.technique,
            verdicts.words(TITLES)
        ));
    }
    let others = best.get(TECHNIQUES..).unwrap_or_default();
    if !others.is_empty() {
        let mut parts = Vec::new();
        for verdicts in others {
            parts.push(format!("{} {}", verdicts.technique, verdicts.words(0)));
        }
        out.push(parts.join("; "));
    }
    if let Some(windows) = stability.windows_line() {
        out.push(format!("bias: {windows}"));
    }
    out.extend(stability.sanity_line());
    out
}

/// Returns the best setting of each technique, sorted: the smallest share of failed rows, then the
/// fewest degraded ones.
///
/// `none` is skipped, since it has no shadow that could be wrong. So are settings without measured
/// rows.
fn best_settings(all: &[SettingVerdicts]) -> Vec<&SettingVerdicts> {
    let mut sorted: Vec<&SettingVerdicts> = all
        .iter()
        .filter(|v| v.technique != "none" && v.measured > 0)
        .collect();
    sorted.sort_by(|a, b| {
        let by_share = a.share().total_cmp(&b.share());
        by_share.then(a.degraded.len().cmp(&b.degraded.len()))
    });
    let mut out: Vec<&SettingVerdicts> = Vec::new();
    for verdicts in sorted {
        if out
            .iter()
            .all(|other| other.technique != verdicts.technique)
        {
            out.push(verdicts);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stability::{CaseResult, Cell, CellOutcome, Judgement};

    /// Technique `t<n>` fails the first `n` of 12 rows. Its second setting fails all.
    fn sample(techniques: usize) -> Stability {
        let mut cases = Vec::new();
        for row in 0..12 {
            let mut cells = Vec::new();
            for n in 0..techniques {
                for (settings, fails) in [("good", row < n), ("bad", true)] {
                    let verdict = if fails { Verdict::Fails } else { Verdict::Pass };
                    let judgement = Judgement {
                        figure: Some(1.0),
                        verdict,
                        reason: None,
                    };
                    cells.push(Cell {
                        technique: format!("t{n}"),
                        settings: settings.to_owned(),
                        outcome: CellOutcome::from_judgements(vec![judgement]),
                        disagreeing: None,
                        picture: None,
                    });
                }
            }
            cases.push(CaseResult {
                row: row as u8,
                title: format!("row {row}"),
                weakness: String::new(),
                not_yet: None,
                case: format!("case {row}"),
                scene: String::new(),
                motion: "still".to_owned(),
                fit: String::new(),
                is_sanity: row == 11,
                criteria: Vec::new(),
                cells,
            });
        }
        Stability {
            cases,
            ..Stability::default()
        }
    }

    #[test]
    fn ten_lines_at_most_name_the_best_and_what_they_fail() {
        let lines = lines(&sample(9));
        assert_eq!(lines.len(), 8, "{lines:#?}");
        assert_eq!(lines[1], "t0            fails none of 11 rows");
        assert_eq!(
            lines[5],
            "t4            fails 4 of 11 rows: row 0, row 1, row 2, row 3"
        );
        assert_eq!(
            lines[6],
            "t5 fails 5 of 11 rows; t6 fails 6 of 11 rows; t7 fails 7 of 11 rows; t8 fails 8 of 11 rows"
        );
        assert!(lines[7].starts_with("1 sanity case"), "{}", lines[7]);
    }

    #[test]
    fn nothing_rendered_is_one_line() {
        assert_eq!(lines(&Stability::default()).len(), 1);
    }
}
