//! The results of a run, as plain data.

use super::{
    bias_window::BiasWindow,
    verdict::{Judgement, Verdict, VerdictLimits},
};
use serde::{Deserialize, Serialize};

/// Results of all cases.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Stability {
    /// Kinds of the backends. Figures are the first one's.
    pub backends: Vec<String>,
    /// Side of the maps, texels.
    pub map_size: u32,
    /// Image size, pixels.
    pub size: [u32; 2],
    /// Frames of moving cases.
    pub frames: u32,
    /// Cases of all rows, in the list's order.
    pub cases: Vec<CaseResult>,
    /// Tuning that each technique needs, the least first; empty if single rows were selected.
    pub windows: Vec<BiasWindow>,
    /// Messages about events that must never happen: NaN, panics, validation errors, backends that
    /// disagree, a backend whose images differ after the run.
    pub faults: Vec<String>,
}

/// Results of all settings on one case.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct CaseResult {
    /// The row's number.
    pub row: u8,
    /// The row's title.
    pub title: String,
    /// Description of the failure.
    pub weakness: String,
    /// Techniques that the row concerns and that don't exist yet.
    pub not_yet: Option<String>,
    /// The case's name.
    pub case: String,
    /// The scene's name.
    pub scene: String,
    /// Description of the movement.
    pub motion: String,
    /// Map fit as settings name it; empty for the tight fit.
    pub fit: String,
    /// Whether nothing shadows the visible geometry. Then a fully lit mask is right, and the case
    /// doesn't separate techniques.
    pub is_sanity: bool,
    /// Criteria of the cells: the case's own measure first, then the measure that a fix may worsen.
    pub criteria: Vec<CriterionResult>,
    /// Cells of all settings.
    pub cells: Vec<Cell>,
}

/// A measure and its limits on one case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CriterionResult {
    /// Name of the measure.
    pub measure: String,
    /// Unit of the measure; may be empty.
    pub unit: String,
    /// Limits to pass and to fail.
    pub limits: VerdictLimits,
    /// Reason for the limits.
    pub reason: String,
    /// Figure of a perfect map of the same size.
    pub ideal: f64,
}

/// One setting of a technique on one case.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Cell {
    /// The technique's name.
    pub technique: String,
    /// Settings of the technique.
    pub settings: String,
    /// The result.
    pub outcome: CellOutcome,
    /// Number of pixels on which backends differ, among those that rounding doesn't decide; `None`
    /// with a single backend.
    pub disagreeing: Option<u64>,
    /// Truth, mask and error side by side, or a strip of frames: a PNG, for cells that don't pass.
    #[serde(skip)]
    pub picture: Option<Vec<u8>>,
}

/// The result of a cell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CellOutcome {
    /// The technique returned a mask.
    Measured {
        /// One judgement per criterion of the case, in order.
        judgements: Vec<Judgement>,
        /// The worst of their verdicts.
        verdict: Verdict,
    },
    /// The technique doesn't support this scene.
    Unsupported {
        /// Reason.
        reason: String,
    },
    /// An event that must never happen.
    Fault {
        /// Description of the event: NaN, a panic, an error of the graphics API.
        what: String,
    },
}

impl CellOutcome {
    /// Returns the outcome of a mask with at least one judgement. The worst verdict counts.
    pub fn from_judgements(judgements: Vec<Judgement>) -> Self {
        let worst = judgements.iter().map(|judgement| judgement.verdict).max();
        Self::Measured {
            judgements,
            verdict: worst.unwrap_or(Verdict::Fails),
        }
    }
}

impl Cell {
    /// Returns the verdict; `None` without a mask.
    pub fn verdict(&self) -> Option<Verdict> {
        match self.outcome {
            CellOutcome::Measured { verdict, .. } => Some(verdict),
            _ => None,
        }
    }

    /// Returns a sign that reads without color: ✓ passes, ~ degraded, ✗ fails, · not measured, –
    /// unsupported, ! a fault.
    pub fn sign(&self) -> char {
        match &self.outcome {
            CellOutcome::Measured { verdict, .. } => verdict.sign(),
            CellOutcome::Unsupported { .. } => '–',
            CellOutcome::Fault { .. } => '!',
        }
    }

    /// Returns the figure of the case's own measure; `None` if it isn't measured.
    pub fn figure(&self) -> Option<f64> {
        self.judgements().first()?.figure
    }

    /// Returns the judgement of each of the case's criteria; empty without a mask.
    pub fn judgements(&self) -> &[Judgement] {
        match &self.outcome {
            CellOutcome::Measured { judgements, .. } => judgements,
            _ => &[],
        }
    }

    /// Returns the index of the decisive criterion: the first with the worst verdict. `None`
    /// without a mask.
    pub fn decisive(&self) -> Option<usize> {
        let verdict = self.verdict()?;
        self.judgements()
            .iter()
            .position(|judgement| judgement.verdict == verdict)
    }
}

impl Stability {
    /// Returns the number of cells with a verdict, over the cases that separate techniques.
    pub fn count(&self, verdict: Verdict) -> usize {
        let cells = self.separating_cases().flat_map(|case| &case.cells);
        cells.filter(|cell| cell.verdict() == Some(verdict)).count()
    }

    /// Returns the cases that separate techniques.
    pub fn separating_cases(&self) -> impl Iterator<Item = &CaseResult> {
        self.cases.iter().filter(|case| !case.is_sanity)
    }

    /// Returns one line about the sanity cases, in which nothing shadows the visible geometry;
    /// `None` if there are none.
    pub fn sanity_line(&self) -> Option<String> {
        let cases: Vec<&CaseResult> = self.cases.iter().filter(|case| case.is_sanity).collect();
        let mut failing = Vec::new();
        for case in &cases {
            let not_passing = case.cells.iter().filter(|cell| {
                let is_measured = cell.verdict().is_some();
                let is_fault = matches!(cell.outcome, CellOutcome::Fault { .. });
                is_fault || is_measured && cell.verdict() != Some(Verdict::Pass)
            });
            failing.extend(
                not_passing
                    .map(|cell| format!("{}: {} ({})", case.case, cell.technique, cell.settings)),
            );
        }
        let count = cases.len();
        let noun = if count == 1 { "case" } else { "cases" };
        match (count, failing.is_empty()) {
            (0, _) => None,
            (_, true) => Some(format!("{count} sanity {noun}: all pass")),
            (_, false) => Some(format!(
                "{count} sanity {noun}; these do not pass: {}",
                failing.join("; ")
            )),
        }
    }

    /// Returns the names of all techniques, in the order of their first cell.
    pub fn techniques(&self) -> Vec<&str> {
        let mut names: Vec<&str> = Vec::new();
        for cell in self.cases.iter().flat_map(|c| &c.cells) {
            if !names.contains(&cell.technique.as_str()) {
                names.push(&cell.technique);
            }
        }
        names
    }
}
