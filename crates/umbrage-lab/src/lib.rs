//! Measures shadow techniques against ray-traced truth: error, time, agreement between backends, reports.
//!
//! * [`compare`]: every technique setting on every backend, against truth and against each other.
//! * [`report`]: a page, charts, tables, data and pictures of it. [`pareto`]: the front of time against error.
//! * [`baseline`]: what got slower or less accurate than it was. [`figure`]: still charts.
//! * [`textbook`]: the textbooks' effects, measured and pictured. [`mod@bench`]: paired timings.
//! * [`cost`]: milliseconds by counting, the same on every run.
//! * [`truth`]: what every shadow should have been, with its own error bars.
//! * [`umbrage_core::metrics`]: how far a mask is from it.

pub mod baseline;
pub mod bench;
mod color;
pub mod compare;
pub mod cost;
mod error;
pub mod figure;
pub mod pareto;
pub mod report;
pub mod textbook;
pub mod truth;

pub use error::LabError;
