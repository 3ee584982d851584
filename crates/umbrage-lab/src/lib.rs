//! Measures shadow techniques against ray-traced truth: error, time, agreement between backends, reports.
//!
//! * [`compare`]: every technique setting on every backend, against truth and against each other.
//! * [`report`]: a page, charts, tables, data and pictures of it. [`pareto`]: the front of time against error.
//! * [`baseline`]: what got slower or less accurate than it was. [`figure`]: still charts.
//! * [`footprint`]: how much of their maps techniques use, and how fine these are on screen.
//! * [`textbook`]: the textbooks' effects, measured and pictured. [`mod@bench`]: paired timings.
//! * [`mod@bias`]: the default bias against all that could be tuned by hand.
//! * [`causes`]: an example of each cause of error ([`umbrage_core::metrics::Causes`]).
//! * [`cost`]: milliseconds by counting, the same on every run.
//! * [`stability`]: where methods fail, scene by scene.
//! * [`mod@plan`]: the least that a scene needs.
//! * [`truth`]: what every shadow should have been, with its own error bars.
//! * [`umbrage_core::metrics`]: how far a mask is from it.
//!
//! The feature `report`, on by default, brings comparisons, reports and benchmarks; without it the lab is truth, costs and
//! the planner.

#[cfg(feature = "report")]
pub mod baseline;
#[cfg(feature = "report")]
pub mod bench;
#[cfg(feature = "report")]
pub mod bias;
pub mod causes;
#[cfg(all(test, feature = "report"))]
mod cheat;
#[cfg(feature = "report")]
mod color;
#[cfg(feature = "report")]
pub mod compare;
pub mod cost;
mod error;
#[cfg(feature = "report")]
pub mod figure;
pub mod footprint;
#[cfg(feature = "report")]
mod page;
pub mod pareto;
pub mod plan;
#[cfg(feature = "report")]
pub mod report;
#[cfg(feature = "report")]
pub mod stability;
#[cfg(feature = "report")]
pub mod textbook;
pub mod truth;

pub use error::LabError;
