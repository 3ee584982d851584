//! The results of a run, as plain data.

use super::{Verdict, VerdictLimits};
use serde::{Deserialize, Serialize};

/// The whole matrix.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Stability {
    /// Kinds of the backends: figures are the first's.
    pub backends: Vec<String>,
    /// Side of the maps, texels.
    pub map_size: u32,
    /// Image size, pixels.
    pub size: [u32; 2],
    /// Frames of moving cases.
    pub frames: u32,
    /// Rows' cases, in the list's order.
    pub cases: Vec<CaseResult>,
    /// Messages about what must never happen: NaN, panics, validation errors, backends that disagree, a backend whose pictures
    /// differ after the run.
    pub faults: Vec<String>,
}

/// One case against all settings.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct CaseResult {
    /// The row's number.
    pub row: u8,
    /// The row's title.
    pub title: String,
    /// What fails there.
    pub weakness: String,
    /// Techniques that the row is about and that don't exist yet.
    pub not_yet: Option<String>,
    /// The case's name.
    pub case: String,
    /// The scene's name.
    pub scene: String,
    /// What moves.
    pub motion: String,
    /// What is measured.
    pub measure: String,
    /// Its unit, may be empty.
    pub unit: String,
    /// Where it passes and fails.
    pub limits: VerdictLimits,
    /// Why there.
    pub reason: String,
    /// The figure of a perfect map of the same size.
    pub ideal: f64,
    /// All settings.
    pub cells: Vec<Cell>,
}

/// One setting of a technique on one case.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Cell {
    /// The technique's name.
    pub technique: String,
    /// Its settings.
    pub settings: String,
    /// The result.
    pub outcome: CellOutcome,
    /// On how many pixels backends differ, of those whose visibility doesn't depend on rounding; none with a single backend.
    pub disagreeing: Option<u64>,
    /// Truth, mask and error side by side, or a strip of frames: a PNG, for cells that don't pass.
    #[serde(skip)]
    pub picture: Option<Vec<u8>>,
}

/// The result of a cell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CellOutcome {
    /// A figure in the measure's unit.
    Measured {
        /// Smaller is better.
        figure: f64,
        /// Against the limits.
        verdict: Verdict,
    },
    /// The technique isn't made for this scene.
    Unsupported {
        /// Why.
        reason: String,
    },
    /// What must never happen.
    Fault {
        /// What did: NaN, a panic, an error of the graphics API.
        what: String,
    },
}

impl Cell {
    /// Returns the verdict; none if the cell isn't measured.
    pub fn verdict(&self) -> Option<Verdict> {
        match self.outcome {
            CellOutcome::Measured { verdict, .. } => Some(verdict),
            _ => None,
        }
    }

    /// Returns a sign that reads without color: ✓ passes, ~ degraded, ✗ fails, – not served, ! a fault.
    pub fn sign(&self) -> char {
        match &self.outcome {
            CellOutcome::Measured { verdict, .. } => verdict.sign(),
            CellOutcome::Unsupported { .. } => '–',
            CellOutcome::Fault { .. } => '!',
        }
    }

    /// Returns the figure; none if the cell isn't measured.
    pub fn figure(&self) -> Option<f64> {
        match self.outcome {
            CellOutcome::Measured { figure, .. } => Some(figure),
            _ => None,
        }
    }
}

impl Stability {
    /// Returns the numbers of cells that pass, are degraded, and fail.
    pub fn counts(&self) -> [usize; 3] {
        let mut counts = [0; 3];
        for cell in self.cases.iter().flat_map(|case| &case.cells) {
            match cell.verdict() {
                Some(Verdict::Pass) => counts[0] += 1,
                Some(Verdict::Degraded) => counts[1] += 1,
                Some(Verdict::Fails) => counts[2] += 1,
                None => {}
            }
        }
        counts
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
