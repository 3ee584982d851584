//! Finds the cheapest shadow technique and setting that a scene needs, by measurement on the CPU.
//!
//! * [`catalogue`]: one entry per technique: how it is compared, planned and tested.
//! * [`truth`]: the ray-traced reference for each shadow, with its own error bars.
//! * [`cost`]: milliseconds from counted work, the same on every run.
//! * [`footprint`]: the share of their maps that techniques use, and its resolution on screen.
//! * [`plan()`], [`Planner`]: the planner. [`regret()`]: its check against a sweep of all
//!   candidates.
//! * [`motion`]: what moves from frame to frame, and what must be redrawn as a result.
//! * [`pareto`]: the front of cost and error. [`statistics`]: quantiles.
//!
//! No fixed rule decides the choice. The planner samples a few thousand visible receivers, more
//! where visibility varies, and traces their truth. It then evaluates candidates on these receivers
//! alone, from the cheapest up, with the bits of the full image. A second sample, drawn where the
//! candidate's own mask is suspect, verifies a candidate before it is chosen. Costs are counted and
//! priced, so the same scene has the same plan on every run. For each candidate, the planner
//! searches the bias with the least estimated error.
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
//! * **Single receivers are evaluated at their own position in the image**, so results have the
//!   bits of the whole mask. Estimates are unbiased. Receivers that face away from the light are in
//!   no sample and count in no error.
//! * **Plans are made for the program that uses them** ([`RendererData`]): recipes are built from
//!   the data that it has. Techniques that it can't execute are not candidates.
//! * **Several cameras are evaluated together**: a setting's figure is that of the worst camera.
//!   **All lights under one budget** are a knapsack over their fronts, solved exactly.

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
