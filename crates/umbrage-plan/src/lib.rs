//! Finds the cheapest shadow technique and setting that a scene needs, by measurement on the CPU.
//!
//! * [`catalogue`]: a row a technique: what is compared, planned and tested of it.
//! * [`truth`]: what every shadow should have been, with its own error bars.
//! * [`cost`]: milliseconds by counting, the same on every run.
//! * [`footprint`]: how much of their maps techniques use, and how fine these are on screen.
//! * [`plan()`], [`Planner`]: the planner. [`regret()`]: its check against a sweep of all
//!   candidates.
//! * [`motion`]: what moves from frame to frame, and what has to be drawn again then.
//! * [`pareto`]: the front of cost and error. [`statistics`]: quantiles.
//!
//! No rule says what is chosen. Some thousand seen receivers are sampled, more where visibility
//! varies, and their truth is traced; candidates are then tried on these receivers alone, bit by
//! bit as they would shade the image, from the cheapest up. What is about to be chosen is verified
//! by a second sample, drawn where its own mask is suspect. Costs are counted and priced, so that
//! the same scene has the same plan on every run. Of each candidate the bias is searched that has
//! the least estimated error.
//!
//! ```
//! use umbrage_plan::{Bounds, PlanOptions, plan};
//! let scene = umbrage_scenes::by_argument("no-casters")?;
//! let plan = plan(&scene, &Bounds::error(0.02), &PlanOptions::default(), &|_| {})?;
//! assert_eq!(plan.preset()?.technique().name(), "none");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! * **Costs are counted** (triangles, covered texels, taps, samples, rays) and priced; prices are
//!   fitted to times by `cargo xtask bench --costs`.
//! * **Single receivers are asked at their own place in the image**, so answers are the whole
//!   mask's bits. Estimates are unbiased. Receivers that face away from the light are in no sample,
//!   and count in no error.
//! * **Plans are made for the program that uses them** ([`RendererData`]): recipes are made from
//!   what it has, and what it can't execute is no candidate.
//! * **Several cameras are one trial**: a setting's figure is that of the worst camera. **All
//!   lights under one budget** are a knapsack over their fronts, solved exactly.

mod cancel;
pub mod catalogue;
pub mod cost;
mod error;
mod estimate;
pub mod footprint;
pub mod motion;
pub mod pareto;
mod progress;
mod search;
pub mod statistics;
pub mod truth;

pub use cancel::Cancel;
pub use error::MeasureError;
pub use estimate::{
    error::Estimate, sampled_truth::Coverage, scene::RendererData, weighting::Weighting,
};
pub use progress::{OnStep, Step};
pub use search::{
    BiasKind, Bounds, CameraFigures, ClockRegret, CurvePoint, Hold, LeftOut, LightPlan,
    LightsBudget, LightsPlan, Look, MAX_GRAIN, MAX_REGRET, MIN_KEPT, Miss, Omission, Plan,
    PlanOptions, Planner, Regret, Sampled, Setting, look, plan, plan_by_clock, plan_lights, regret,
};
