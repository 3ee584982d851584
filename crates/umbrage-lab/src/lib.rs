//! Measures shadow techniques against ray-traced truth: error, time, agreement between backends, reports.
//!
//! * [`compare`]: every technique setting on every backend, against truth and against each other.
//! * [`report`]: a page, a table, data and pictures of it. [`pareto`]: the front of time against error.
//! * [`footprint`]: how much of their maps techniques use, and how fine these are on screen.
//! * [`textbook`]: the textbooks' effects, measured and pictured. [`mod@bench`]: paired timings.
//! * [`causes`]: an example of each cause of error ([`umbrage_core::metrics::Causes`]).
//! * [`cost`]: milliseconds by counting, the same on every run.
//! * [`stability`]: where methods fail, scene by scene.
//! * [`truth`]: what every shadow should have been, with its own error bars.
//! * [`umbrage_core::metrics`]: how far a mask is from it.

pub mod bench;
pub mod causes;
mod color;
pub mod compare;
pub mod cost;
mod error;
pub mod footprint;
pub mod pareto;
pub mod report;
pub mod stability;
pub mod textbook;
pub mod truth;

pub use error::LabError;
