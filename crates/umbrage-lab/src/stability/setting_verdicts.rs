//! Verdicts of all rows on one setting of a technique: the number of failed rows, and their names.
//!
//! A row counts once, with the worst verdict of its cases. Cases with another fit than the tight
//! one are separate: if a row fails only under the tight fit, the fit that fixes it is named.

use super::{
    cell::{CaseResult, Cell, Stability},
    verdict::Verdict,
};
use serde::Serialize;

/// A row that a setting does not pass.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct FailedRow {
    /// The row's number.
    pub row: u8,
    /// The row's title.
    pub title: String,
    /// Cases of the row with this verdict.
    pub cases: Vec<String>,
    /// Label of the fit under which all of the row's cases pass or are only degraded; `None`
    /// without such a fit.
    pub cured_by: Option<String>,
}

/// The rows' verdicts on one setting of a technique.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct SettingVerdicts {
    /// The technique's name.
    pub technique: String,
    /// Settings of the technique, without a fit.
    pub settings: String,
    /// Number of rows with a verdict: passed, degraded or failed.
    pub measured: usize,
    /// Number of passed rows.
    pub passed: usize,
    /// Rows in which the setting is degraded.
    pub degraded: Vec<FailedRow>,
    /// Rows that the setting fails.
    pub failed: Vec<FailedRow>,
    /// Number of rows that the setting could not have failed.
    pub not_measured: usize,
    /// Number of rows that the setting does not support.
    pub not_served: usize,
}

/// Least number in a setting's label that is read as the side of a shadow map, texels: kernels and
/// ray counts are smaller.
const LEAST_MAP_SIDE: u32 = 16;

impl Stability {
    /// Returns the verdicts on every setting that ran in all rows with the tight fit, in the order
    /// of the cells.
    pub fn setting_verdicts(&self) -> Vec<SettingVerdicts> {
        let tight: Vec<&CaseResult> = self
            .separating_cases()
            .filter(|c| c.fit.is_empty())
            .collect();
        // Some cases add settings; those that all cases share are the techniques' own.
        let Some(least) = tight.iter().min_by_key(|case| case.cells.len()) else {
            return Vec::new();
        };
        let settings = least.cells.iter();
        settings.map(|cell| self.verdicts_on(cell)).collect()
    }

    fn verdicts_on(&self, setting: &Cell) -> SettingVerdicts {
        let mut out = SettingVerdicts {
            technique: setting.technique.clone(),
            settings: setting.settings.clone(),
            measured: 0,
            passed: 0,
            degraded: Vec::new(),
            failed: Vec::new(),
            not_measured: 0,
            not_served: 0,
        };
        let mut rows: Vec<u8> = self.separating_cases().map(|case| case.row).collect();
        rows.dedup();
        for row in rows {
            let of_row: Vec<&CaseResult> =
                self.separating_cases().filter(|c| c.row == row).collect();
            match worst(&of_row, "", setting) {
                None => out.not_served += 1,
                Some(Verdict::NotMeasured) => out.not_measured += 1,
                Some(Verdict::Pass) => out.passed += 1,
                Some(Verdict::Degraded) => {
                    let failed = failed_row(&of_row, setting, Verdict::Degraded);
                    out.degraded.extend(failed);
                }
                Some(Verdict::Fails) => {
                    out.failed
                        .extend(failed_row(&of_row, setting, Verdict::Fails));
                }
            }
        }
        out.measured = out.passed + out.degraded.len() + out.failed.len();
        out
    }
}

/// Returns a row with its cases that have this verdict on a setting; `None` without cases.
fn failed_row(of_row: &[&CaseResult], setting: &Cell, verdict: Verdict) -> Option<FailedRow> {
    let first = of_row.first()?;
    let tight = of_row.iter().filter(|case| case.fit.is_empty());
    let has_it = |case: &&&CaseResult| verdict_of(case, setting) == Some(verdict);
    let cases = tight.filter(has_it).map(|case| case.case.clone()).collect();
    let other = of_row.iter().find(|case| !case.fit.is_empty());
    let is_cured = |fit: &str| {
        worst(of_row, fit, setting).is_some_and(|w| w != Verdict::NotMeasured && w < verdict)
    };
    Some(FailedRow {
        row: first.row,
        title: first.title.clone(),
        cases,
        cured_by: other
            .map(|case| case.fit.clone())
            .filter(|fit| is_cured(fit)),
    })
}

/// Returns the worst verdict on a setting over a row's cases with this fit; `None` if it supports
/// none of them. A case that could not fail counts only if there is no other.
fn worst(of_row: &[&CaseResult], fit: &str, setting: &Cell) -> Option<Verdict> {
    let cases = of_row.iter().filter(|case| case.fit == fit);
    let verdicts: Vec<Verdict> = cases.filter_map(|case| verdict_of(case, setting)).collect();
    let of_measured = verdicts.iter().filter(|v| **v != Verdict::NotMeasured);
    of_measured.max().or(verdicts.first()).copied()
}

/// Returns a case's verdict on a setting; `None` if it doesn't support the case or didn't run
/// there.
fn verdict_of(case: &CaseResult, setting: &Cell) -> Option<Verdict> {
    let is_setting = |cell: &&Cell| {
        cell.technique == setting.technique && case.settings_without_fit(cell) == setting.settings
    };
    case.cells.iter().find(is_setting)?.verdict()
}

impl CaseResult {
    /// Returns a cell's settings without the case's fit.
    pub fn settings_without_fit(&self, cell: &Cell) -> String {
        if self.fit.is_empty() {
            cell.settings.clone()
        } else {
            cell.settings.replace(&format!(", {}", self.fit), "")
        }
    }
}

impl SettingVerdicts {
    /// Returns the technique with its settings.
    pub fn name(&self) -> String {
        format!("{} ({})", self.technique, self.settings)
    }

    /// Reports whether another setting differs from this one only in the side of its map.
    pub fn is_of(&self, technique: &str, settings: &str) -> bool {
        self.technique == technique && without_side(&self.settings) == without_side(settings)
    }

    /// Returns the verdicts in a few words: `fails 4 of 33 rows: low sun, fine casters, ..`. It
    /// lists at most `most` titles.
    pub fn words(&self, most: usize) -> String {
        if self.measured == 0 {
            return "no row measures it".to_owned();
        }
        let count = self.count_words();
        if self.failed.is_empty() || most == 0 {
            return count;
        }
        let mut titles: Vec<&str> = Vec::new();
        for failed in self.failed.iter().take(most) {
            titles.push(&failed.title);
        }
        if self.failed.len() > most {
            titles.push("..");
        }
        format!("{count}: {}", titles.join(", "))
    }

    /// Returns the number of failed rows in words: `fails 4 of 33 rows`.
    fn count_words(&self) -> String {
        let measured = self.measured;
        match self.failed.len() {
            0 => format!("fails none of {measured} rows"),
            failed => format!("fails {failed} of {measured} rows"),
        }
    }

    /// Returns the failed share of the rows with a verdict, 0 to 1.
    pub fn share(&self) -> f64 {
        self.failed.len() as f64 / self.measured.max(1) as f64
    }
}

/// Returns a setting's label without the side of its map.
fn without_side(settings: &str) -> String {
    let is_side = |word: &&str| word.parse().is_ok_and(|n: u32| n >= LEAST_MAP_SIDE);
    let words: Vec<&str> = settings.split(", ").filter(|word| !is_side(word)).collect();
    words.join(", ")
}

/// Returns the verdicts that apply to a setting: those of the same setting on another map, else
/// those of the technique with the same bias, smallest kernel first. `None` if neither ran: another
/// bias fails other rows.
pub fn nearest<'a>(
    all: &'a [SettingVerdicts],
    technique: &str,
    settings: &str,
) -> Option<&'a SettingVerdicts> {
    let of_technique = || all.iter().filter(|v| v.technique == technique);
    let same = of_technique().find(|v| v.is_of(technique, settings));
    let bias = |words: &str| words.rsplit_once("bias: ").map(|(_, bias)| bias.to_owned());
    let with_bias = || {
        let wanted = bias(settings)?;
        of_technique().find(|v| bias(&v.settings).as_ref() == Some(&wanted))
    };
    same.or_else(with_bias)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stability::{cell::CellOutcome, verdict::Judgement};

    fn cell(settings: &str, outcome: CellOutcome) -> Cell {
        Cell {
            technique: "pcf".to_owned(),
            settings: settings.to_owned(),
            outcome,
            disagreeing: None,
            picture: None,
        }
    }

    fn judged_cell(verdict: Verdict) -> CellOutcome {
        CellOutcome::from_judgements(vec![Judgement {
            figure: Some(1.0),
            verdict,
            reason: None,
        }])
    }

    fn case(row: u8, name: &str, fit: &str, outcomes: [CellOutcome; 2]) -> CaseResult {
        let fitted = |settings: &str| match fit {
            "" => settings.to_owned(),
            fit => settings.replace(", bias", &format!(", {fit}, bias")),
        };
        let [a, b] = outcomes;
        CaseResult {
            row,
            title: format!("title {row}"),
            weakness: String::new(),
            not_yet: None,
            case: name.to_owned(),
            scene: name.to_owned(),
            motion: "still".to_owned(),
            fit: fit.to_owned(),
            is_sanity: false,
            criteria: Vec::new(),
            cells: vec![
                cell(&fitted("3x3, 1024, bias: slope"), a),
                cell(&fitted("3x3, 1024, bias: adaptive"), b),
            ],
        }
    }

    /// Returns a sample: row 1 fails in one of two cases, but not with the stable fit; row 2 is
    /// degraded; row 3 is not measured, row 4 not supported.
    fn sample() -> Stability {
        use Verdict::{Degraded, Fails, NotMeasured, Pass};
        let both = |verdict| [judged_cell(verdict), judged_cell(Pass)];
        let unsupported = || CellOutcome::Unsupported {
            reason: String::new(),
        };
        Stability {
            cases: vec![
                case(1, "a", "", both(Pass)),
                case(1, "b", "", both(Fails)),
                case(1, "b-stable", "stable fit", both(Degraded)),
                case(2, "c", "", both(Degraded)),
                case(2, "c-moving", "", both(NotMeasured)),
                case(3, "d", "", both(NotMeasured)),
                case(4, "e", "", [unsupported(), unsupported()]),
            ],
            ..Stability::default()
        }
    }

    #[test]
    fn a_row_counts_once_by_its_worst_case() {
        let all = sample().setting_verdicts();
        assert_eq!(all.len(), 2);
        let slope = &all[0];
        assert_eq!((slope.measured, slope.passed), (2, 0));
        assert_eq!((slope.not_measured, slope.not_served), (1, 1));
        let [failed] = &slope.failed[..] else {
            panic!("{slope:?}");
        };
        assert_eq!((failed.row, &failed.cases[..]), (1, &["b".to_owned()][..]));
        assert_eq!(failed.cured_by.as_deref(), Some("stable fit"));
        assert_eq!(slope.degraded[0].cases, ["c"]);
        assert_eq!(slope.words(4), "fails 1 of 2 rows: title 1");
        assert_eq!(slope.words(0), "fails 1 of 2 rows");
        assert_eq!(slope.share(), 0.5);
        // The other setting passes row 3, as its case is measured.
        assert_eq!((all[1].measured, all[1].passed), (3, 3));
        assert_eq!(all[1].words(4), "fails none of 3 rows");
    }

    #[test]
    fn sanity_cases_do_not_count() {
        let mut stability = sample();
        for case in &mut stability.cases {
            case.is_sanity = case.row == 1;
        }
        assert_eq!(
            stability.setting_verdicts()[0].words(4),
            "fails none of 1 rows"
        );
        assert_eq!(Stability::default().setting_verdicts(), []);
    }

    #[test]
    fn another_map_is_the_same_setting_another_kernel_the_nearest_and_another_bias_is_neither() {
        let all = sample().setting_verdicts();
        let found =
            |technique, settings| nearest(&all, technique, settings).map(|v| &v.settings[..]);
        let slope = Some("3x3, 1024, bias: slope");
        assert_eq!(found("pcf", "3x3, 2048, bias: slope"), slope);
        assert_eq!(found("pcf", "7x7, 2048, bias: slope"), slope);
        assert_eq!(found("pcf", "3x3, 1024, bias: none"), None);
        assert_eq!(found("hard", "2048, bias: slope"), None);
        // Settings without a bias are all distinct.
        assert_eq!(found("pcf", "5x5"), None);
        assert!(all[0].is_of("pcf", "3x3, 4096, bias: slope"));
        assert!(!all[0].is_of("pcf", "5x5, 1024, bias: slope"));
        assert_eq!(without_side("radius 3, 8 taps, 4"), "radius 3, 8 taps, 4");
    }
}
