//! Measures shadow techniques against ray-traced truth: error, time, agreement between backends,
//! reports.
//!
//! * [`compare`]: every technique setting on every backend, against truth and against each other.
//! * [`report`]: a page, charts, tables, data and pictures of it.
//! * [`baseline`]: what got slower or less accurate than it was.
//! * [`textbook`]: the textbooks' effects, measured and pictured. [`mod@bench`]: paired timings.
//! * [`mod@bias`]: the default bias against all that could be tuned by hand.
//! * [`causes`]: an example of each cause of error ([`umbrage_core::metrics::Causes`]).
//! * [`stability`]: where methods fail, scene by scene.
//! * [`which`]: which technique to use, as a page made from the results of the two.
//! * [`plan_files`]: plans on disk. [`assembled_wgsl`]: the shader text of a technique.
//! * [`cli`]: the commands, for programs of one's own, too.
//! * [`output`]: what all of these write with: folders, pictures, charts, pages and tables.
//!
//! Truth, costs, footprints and the planner are [`umbrage_plan`]'s; [`umbrage_core::metrics`] says
//! how far a mask is from truth.
//!
//! How it measures:
//!
//! * **A row's time is a frame's** (`compare/row.rs`). What is made once a scene, once a change and
//!   every frame is timed apart; what moves picks the sum.
//! * **Times are multiples of a yardstick**, fixed work timed in turn with every row; baselines
//!   compare these.
//! * **Every technique has a negative control** (`compare/control.rs`): rendered without casters,
//!   it must return the full light.
//! * **Limits of stability come from truth**, never from results. A case has a criterion for its
//!   failure and one for what a cure takes away; what could not have failed is not measured, which
//!   is no pass.
//! * **A report is assembled from scenes' folders.** One run, a resumed run and merged shards share
//!   one path. Figures have a checksum; what was changed or cut off is measured again, or refused.
//! * **The page carries figures, not pictures**: pictures are the scenes' files beside it; its
//!   scripts draw charts and tables.

mod assembled;
pub mod baseline;
pub mod bench;
pub mod bias;
pub mod card;
pub mod causes;
mod color;
pub mod compare;
mod error;
#[cfg(test)]
mod faulty_backend;
pub mod output;
pub mod plan_files;
pub mod report;
pub mod stability;
pub mod textbook;
pub mod which;

// Its macros are for the modules after it.
#[macro_use]
mod print;
pub mod cli;

pub use assembled::assembled_wgsl;
pub use error::LabError;
