//! The search for a setting within bounds. From top to bottom:
//!
//! * [`planner`]: samples the scene, searches, and writes the plan.
//! * [`strategy`]: the order in which candidates are evaluated.
//! * [`bias_search`]: the best bias of one candidate.
//! * [`trials`]: settings evaluated on the samples of all cameras, each once, kept in
//!   [`by_preset`]. [`hold`]: the cameras for which a figure must hold.
//! * [`clock`]: finalists run in turn and timed.
//!
//! Candidates come from [`families`], with amounts of [`bias`] and the map side that matches the
//! screen resolution ([`resolution`]).
//! [`left_out`] finds work that can be omitted.
//! [`lights`] plans all lights of a scene under one budget. [`look`] renders images of settings.
//! [`outcome`] and [`reasons`] form the result. [`regret`] checks it against a sweep of all
//! candidates.

mod bias;
mod bias_search;
mod bounds;
mod by_preset;
mod clock;
mod families;
mod hold;
mod left_out;
mod lights;
mod look;
mod options;
mod outcome;
mod planner;
mod reasons;
mod regret;
mod resolution;
mod setting;
mod strategy;
mod trials;

pub use bias::BiasKind;
pub use bounds::{Bounds, MAX_GRAIN};
pub use hold::Hold;
pub use lights::{LightPlan, LightsBudget, LightsPlan, plan_lights};
pub use look::{Look, look};
pub use options::PlanOptions;
pub use outcome::{CurvePoint, LeftOut, Miss, Omission, Plan, Sampled};
pub use planner::Planner;
pub use regret::{ClockRegret, MAX_REGRET, MIN_KEPT, Regret, regret};
pub use setting::{CameraFigures, Setting};

use crate::{error::MeasureError, progress::OnStep};
use umbrage_core::{Backend, Geometry, Scene};

/// Plans one light of a scene for the cameras of the options, or the scene's first camera.
///
/// # Errors
/// Errors if the scene has no camera or light, the scene is not valid, or bounds are missing or not
/// valid. It is not an error if no candidate is within the bounds: see [`Plan::preset`].
pub fn plan(
    scene: &Scene,
    bounds: &Bounds,
    options: &PlanOptions,
    on_step: &OnStep<'_>,
) -> Result<Plan, MeasureError> {
    plan_by_clock(scene, bounds, options, None, on_step)
}

/// Plans like [`plan`]. With a backend, it also times candidates whose counted costs are too close:
/// [`Planner::plan_by_clock`].
///
/// # Errors
/// Errors in the same cases as [`plan`], and if the backend fails.
pub fn plan_by_clock(
    scene: &Scene,
    bounds: &Bounds,
    options: &PlanOptions,
    clock: Option<&mut dyn Backend>,
    on_step: &OnStep<'_>,
) -> Result<Plan, MeasureError> {
    bounds.validate()?;
    let light = options.light_of(scene)?;
    let cameras = options.cameras_of(scene)?;
    let geometry = Geometry::bake(scene)?;
    let mut planner = Planner::of_cameras(&cameras, light, &geometry, options, on_step)?;
    let plan = planner.plan_by_clock(bounds, clock)?;
    let left_out = left_out::find(scene, &cameras, &mut planner, &plan)?;
    Ok(Plan {
        scene: scene.name.clone(),
        light_number: options.light + 1,
        left_out,
        ..plan
    })
}

#[cfg(test)]
mod demands_tests;
#[cfg(test)]
mod tests;
