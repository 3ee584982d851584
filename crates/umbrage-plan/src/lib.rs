//! The least that a scene needs: the cheapest technique and setting within bounds, found by measurement.
//!
//! No rule says what is chosen. Some thousand seen receivers are sampled, more where visibility varies, and their truth is
//! traced; candidates are then tried on these receivers alone, bit by bit as they would shade the image, from the cheapest
//! up. What is about to be chosen is looked at again, where its own mask is suspect. What candidates cost comes from
//! [`cost`](crate::cost), so that the same scene has the same plan on every run. Of each candidate the bias is searched that
//! leaves the least acne plus gap.
//!
//! ```
//! use umbrage_plan::{Bounds, Options, plan};
//! let scene = umbrage_scenes::by_argument("no-casters")?;
//! let plan = plan(&scene, &Bounds::error(0.02), &Options::default(), &|_| {})?;
//! assert_eq!(plan.preset()?.technique().name(), "none");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod cost;
mod error;
mod estimate;
pub mod footprint;
pub mod pareto;
mod progress;
mod search;
pub mod statistics;
pub mod truth;

pub use error::MeasureError;
pub use estimate::error::Estimate;
pub use progress::{OnStep, Step};
pub use search::{
    BiasKind, Bounds, CurvePoint, MAX_REGRET, MIN_KEPT, Miss, Options, Plan, Planner, Regret,
    Sampled, Setting, plan, regret,
};
