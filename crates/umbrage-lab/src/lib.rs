//! Measures shadow techniques against ray-traced truth: error, time, agreement between backends,
//! reports.
//!
//! * [`compare`]: all technique settings on all backends, compared with truth and with each other.
//! * [`report`]: its page, charts, tables, data and images.
//! * [`baseline`]: regressions of speed and accuracy.
//! * [`textbook`]: textbook effects, measured, with images. [`mod@bench`]: paired timings.
//! * [`mod@bias`]: the default bias compared with the best manually tuned one.
//! * [`causes`]: an example of each cause of error ([`umbrage_core::metrics::Causes`]).
//! * [`stability`]: failure tests of methods, scene by scene.
//! * [`which`]: a page that recommends techniques, from results of [`compare`] and [`stability`].
//! * [`plan_files`]: plans on disk. [`assembled_wgsl`]: the shader text of a technique.
//! * [`cli`]: the commands, also for your own programs.
//! * [`output`]: shared output of folders, images, charts, pages and tables.
//!
//! [`umbrage_plan`] has truth, costs, footprints and the planner. [`umbrage_core::metrics`] has the
//! error of a mask against truth.
//!
//! Principles of measurement:
//!
//! * **A row's time is that of a frame** (`compare/row.rs`). Work per scene, per change and per
//!   frame is timed separately. The motion selects the parts of the sum.
//! * **Times are multiples of a yardstick**, fixed work that is timed in turn with every row.
//!   Baselines compare these.
//! * **Every technique has a negative control** (`compare/control.rs`): rendered without casters,
//!   it must return the full light.
//! * **Limits of stability come from truth**, never from results. A case has a criterion for its
//!   failure and one for the side effect of fixing it. A case that could not have failed is
//!   reported as not measured, which is not a pass.
//! * **A report is assembled from folders of scenes.** A single run, a resumed run and merged
//!   shards use the same code path. Figures have a checksum; changed or truncated ones are measured
//!   again, or refused.
//! * **The page contains figures, not images**: images are separate files in the folders of scenes.
//!   Its scripts draw charts and tables.

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

// Its macros are used in the modules after it.
#[macro_use]
mod print;
pub mod cli;

pub use assembled::assembled_wgsl;
pub use error::LabError;
