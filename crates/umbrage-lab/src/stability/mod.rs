//! Where shadow methods fail: every row of the catalogue of failures as a scene, still or moving,
//! against every technique, each judged by the row's own measure.
//!
//! * [`rows`]: the one list of rows. [`Measure`] says what each is judged by, [`VerdictLimits`]
//!   where it passes and fails.
//! * [`run`]: plays them. [`Stability`]: what comes out.
//! * [`Criterion`]: a measure with its limits. Most cases have two, one for the failure and one for
//!   what its cure takes away, so that no bias is free; the worse verdict counts.
//! * [`measures`]: the measures as plain functions. [`CaseTruth`]: truth, and what a *perfect map*
//!   of the same size would show, which limits are taken from.
//! * [`SettingVerdicts`]: which rows a setting fails, all cases taken together.
//! * [`windows`]: by how much each technique's bias may be off, in texels: how much tuning it
//!   needs.
//! * [`sweeps`]: one number turned from too little to too much. [`report`]: a page, a picture, a
//!   table, data.
//!
//! Limits are never tuned to results. They come from what edge aliasing alone must cause on a map
//! of that size, from what is visible (steps of 1/255, one pixel in a thousand), or from the noise
//! of a stated number of rays.

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
mod play;
pub mod report;
mod row;
mod rows;
mod run;
mod setting_verdicts;
mod settings;
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
