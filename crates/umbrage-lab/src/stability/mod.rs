//! Failure cases of shadow methods: every row of the failure catalogue as a scene, still or moving.
//! Every technique runs on each, and the row's own measure judges it.
//!
//! * [`rows`]: the list of rows. [`Measure`]: measure of a row. [`VerdictLimits`]: its limits to
//!   pass and to fail.
//! * [`run`]: runs all cases. [`Stability`]: the results.
//! * [`Criterion`]: a measure with its limits. Most cases have two: one for the failure, and one
//!   for what its fix may worsen, such as lost shadow for a larger bias. The worse verdict counts.
//! * [`measures`]: the measures as plain functions. [`CaseTruth`]: truth, and the mask of a
//!   *perfect map* of the same size, from which limits are derived.
//! * [`SettingVerdicts`]: the rows that a setting fails, over all cases.
//! * [`windows`]: the range of biases in which each technique passes, texels: its need of tuning.
//! * [`sweeps`]: one parameter from too little to too much. [`report`]: a page, an image, a table,
//!   data.
//!
//! Limits are never tuned to results. They are derived from the error of edge aliasing on a map of
//! that size, from what is visible (steps of 1/255, one pixel in a thousand), or from the noise of
//! a stated number of rays.

mod all_backends;
mod bias_window;
mod case_truth;
mod cell;
mod criterion;
mod guard;
mod measure;
pub mod measures;
mod motion;
mod passing;
mod pictures;
pub mod report;
mod row;
mod rows;
mod run;
mod setting_verdicts;
mod settings;
mod still;
pub mod sweeps;
pub mod texels;
mod threads;
mod verdict;
mod window;

pub use bias_window::{Base, BiasWindow};
pub use case_truth::{CaseTruth, OPEN_TEXELS, without_extent};
pub use cell::{CaseResult, Cell, CellOutcome, CriterionResult, Stability};
pub use criterion::Criterion;
pub use guard::is_as_new;
pub use measure::Measure;
pub use motion::{MotionFrame, Moving};
pub use passing::Demand;
pub use row::{StabilityCase, StabilityRow};
pub use rows::{PLATE, cases, rows};
pub use run::{StabilityEvent, StabilityOptions, case_truth, check_state, run};
pub use setting_verdicts::{FailedRow, SettingVerdicts, nearest};
pub use settings::settings;
pub use umbrage_scenes::motion::Motion;
pub use verdict::{FAILS_AT, Judgement, Verdict, VerdictLimits};
pub use window::windows;

#[cfg(test)]
mod tests;
