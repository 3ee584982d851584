//! The search for a setting within bounds. From top to bottom:
//!
//! * [`planner`]: samples the scene, searches, and writes down the plan.
//! * [`strategy`]: the order in which candidates are tried.
//! * [`bias_search`]: the best bias of one candidate.
//! * [`trials`]: settings tried on the samples of all cameras, each once, kept in [`by_preset`].
//!   [`hold`]: for how many cameras a figure must hold.
//! * [`clock`]: finalists played in turn and timed.
//!
//! Candidates come from [`families`], with amounts of [`bias`] and the map's side that the screen
//! asks for ([`resolution`]).
//! [`left_out`]: what more may be left out.
//! [`lights`]: all lights of a scene under one budget. [`look`]: pictures of settings.
//! [`outcome`] and [`reasons`] are the answer; [`regret`] checks it against a sweep of all
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

/// The plan for one light of a scene, seen by the cameras of the options, or else by the scene's
/// first.
///
/// # Errors
/// Errors if the scene has no camera or light or is not valid, or if bounds are missing or not
/// valid. That no candidate is within the bounds is no error: see [`Plan::preset`].
pub fn plan(
    scene: &Scene,
    bounds: &Bounds,
    options: &PlanOptions,
    on_step: &OnStep<'_>,
) -> Result<Plan, MeasureError> {
    plan_by_clock(scene, bounds, options, None, on_step)
}

/// As [`plan`]; with a backend, what counted costs can't tell apart is timed on it:
/// [`Planner::plan_by_clock`].
///
/// # Errors
/// As those of [`plan`], and if the backend fails.
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
