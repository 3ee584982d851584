//! Techniques that pass a stability run, for planners with demands beyond a small error.

use super::{
    cell::{CaseResult, CellOutcome, Stability},
    verdict::Verdict,
};
use umbrage_core::Invalid;

/// Demand on a technique.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Demand {
    /// Pass these rows (by number) or cases (by name).
    Pass(Vec<String>),
    /// Fail no case.
    FailNone,
}

impl Stability {
    /// Reports whether a technique meets a demand, by the best of its settings in each case:
    /// planners choose the bias, so one passing bias suffices.
    ///
    /// Cases that are not measured or not supported count neither as passed nor as failed. A
    /// technique without results passes nothing.
    ///
    /// # Errors
    /// Errors if the demand names a row or case that the run doesn't have.
    pub fn meets(&self, technique: &str, demand: &Demand) -> Result<bool, Invalid> {
        match demand {
            Demand::FailNone => {
                let known = self
                    .cases
                    .iter()
                    .any(|case| best(case, technique).is_some());
                let fails = |case: &CaseResult| best(case, technique) == Some(Verdict::Fails);
                Ok(known && !self.cases.iter().any(fails))
            }
            Demand::Pass(names) => {
                for name in names {
                    let mut requested = self
                        .cases
                        .iter()
                        .filter(|case| is_named(case, name))
                        .peekable();
                    if requested.peek().is_none() {
                        return Err(self.no_such(name));
                    }
                    if !requested.all(|case| best(case, technique) == Some(Verdict::Pass)) {
                        return Ok(false);
                    }
                }
                Ok(true)
            }
        }
    }

    fn no_such(&self, name: &str) -> Invalid {
        let cases: Vec<&str> = self.cases.iter().map(|case| &*case.case).collect();
        Invalid::new(
            "row of the stability matrix",
            format!("there are no results of `{name}`"),
            format!("use a row's number, or some of {}", cases.join(", ")),
        )
    }
}

fn is_named(case: &CaseResult, name: &str) -> bool {
    case.case == name || name.parse() == Ok(case.row)
}

/// Returns the best verdict over a technique's settings in a case; `None` if it was not run or
/// doesn't support the scene.
fn best(case: &CaseResult, technique: &str) -> Option<Verdict> {
    let of_cell = |outcome: &CellOutcome| match outcome {
        CellOutcome::Measured { verdict, .. } => Some(*verdict),
        CellOutcome::Fault { .. } => Some(Verdict::Fails),
        CellOutcome::Unsupported { .. } => None,
    };
    case.cells
        .iter()
        .filter(|cell| cell.technique == technique)
        .filter_map(|cell| of_cell(&cell.outcome))
        .min()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stability::{
        cell::Cell,
        report::{STABILITY_SCHEMA, StabilityResults},
    };

    fn case(row: u8, name: &str, verdicts: &[(&str, Verdict)]) -> CaseResult {
        let cells = verdicts.iter().map(|&(technique, verdict)| Cell {
            technique: technique.to_owned(),
            settings: String::new(),
            outcome: CellOutcome::Measured {
                judgements: Vec::new(),
                verdict,
            },
            disagreeing: None,
            picture: None,
        });
        CaseResult {
            row,
            title: String::new(),
            weakness: String::new(),
            not_yet: None,
            case: name.to_owned(),
            scene: String::new(),
            motion: String::new(),
            fit: String::new(),
            is_sanity: false,
            criteria: Vec::new(),
            cells: cells.collect(),
        }
    }

    fn results() -> Stability {
        Stability {
            cases: vec![
                case(
                    1,
                    "shells",
                    &[
                        ("hard", Verdict::Fails),
                        ("hard", Verdict::Pass),
                        ("second_depth", Verdict::Fails),
                        ("traced", Verdict::Pass),
                    ],
                ),
                case(
                    2,
                    "pan",
                    &[
                        ("hard", Verdict::Degraded),
                        ("traced", Verdict::NotMeasured),
                    ],
                ),
            ],
            ..Stability::default()
        }
    }

    #[test]
    fn the_best_setting_of_a_technique_counts() {
        let meets =
            |technique: &str, demand: &Demand| results().meets(technique, demand).expect("known");
        let rows = |names: &[&str]| Demand::Pass(names.iter().map(ToString::to_string).collect());
        assert!(meets("hard", &Demand::FailNone) && meets("hard", &rows(&["1"])));
        assert!(!meets("hard", &rows(&["shells", "2"])));
        assert!(!meets("second_depth", &Demand::FailNone));
        assert!(meets("traced", &Demand::FailNone) && !meets("traced", &rows(&["pan"])));
        assert!(!meets("mine", &Demand::FailNone), "it has no results");
    }

    #[test]
    fn results_come_back_from_their_file() {
        let dir = tempfile::tempdir().expect("a temporary folder");
        let path = dir.path().join("results.json");
        let written = StabilityResults {
            schema: STABILITY_SCHEMA,
            stability: results(),
            ..StabilityResults::default()
        };
        let text = serde_json::to_string(&written).expect("plain data");
        std::fs::write(&path, text).expect("writable");
        let read = StabilityResults::read(&path).expect("readable").stability;
        assert_eq!(read.cases.len(), 2);
        assert_eq!(read.meets("second_depth", &Demand::FailNone), Ok(false));
    }

    #[test]
    fn rows_that_were_not_rendered_are_refused() {
        let error = results()
            .meets("hard", &Demand::Pass(vec!["9".to_owned()]))
            .expect_err("no such row");
        assert!(error.to_string().contains("shells, pan"), "{error}");
        let dir = tempfile::tempdir().expect("a temporary folder");
        assert!(StabilityResults::read(&dir.path().join("none.json")).is_err());
    }
}
