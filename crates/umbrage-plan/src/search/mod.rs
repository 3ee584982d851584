//! The search for a setting within bounds. From top to bottom:
//!
//! * [`planner`]: samples the scene, searches, and writes down the plan.
//! * [`strategy`]: the order in which candidates are tried.
//! * [`bias_search`]: the best bias of one candidate.
//! * [`trials`]: settings tried on the sample, each once.
//!
//! Candidates come from [`families`], with amounts of [`bias`] and the map's side that the screen asks for ([`resolution`]).
//! [`outcome`] and [`reasons`] are the answer; [`regret`] checks it against a sweep of all candidates.

mod bias;
mod bias_search;
mod bounds;
mod families;
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
pub use bounds::Bounds;
pub use options::PlanOptions;
pub use outcome::{CurvePoint, Miss, Plan, Sampled};
pub use planner::Planner;
pub use regret::{MAX_REGRET, MIN_KEPT, Regret, regret};
pub use setting::Setting;

use crate::{MeasureError, progress::OnStep};
use umbrage_core::{Camera, Geometry, Invalid, Light, Scene};

/// The plan for a scene's first camera and one light.
///
/// # Errors
/// Errors if the scene has no camera or light or is not valid, or if bounds are missing or not valid. That no candidate is within the bounds is
/// no error: see [`Plan::preset`].
pub fn plan(
    scene: &Scene,
    bounds: &Bounds,
    options: &PlanOptions,
    on_step: &OnStep<'_>,
) -> Result<Plan, MeasureError> {
    bounds.validate()?;
    let (camera, light) = seen(scene, options)?;
    let geometry = Geometry::bake(scene)?;
    let plan = Planner::new(&camera, light, &geometry, options, on_step)?.plan(bounds)?;
    Ok(Plan {
        scene: scene.name.clone(),
        light_number: options.light + 1,
        ..plan
    })
}

/// The camera and the light that options are about.
fn seen<'a>(scene: &'a Scene, options: &PlanOptions) -> Result<(Camera, &'a Light), Invalid> {
    let invalid = |why, help| Invalid::new(format!("scene `{}`", scene.name), why, help);
    let none = |what| invalid(format!("has no {what}"), "add one".to_owned());
    let camera = scene.cameras.first().ok_or_else(|| none("camera"))?;
    let camera = options.size.map_or(*camera, |size| camera.resized(size));
    let count = scene.lights.len();
    let light = scene.lights.get(options.light).ok_or_else(|| match count {
        0 => none("light"),
        _ => invalid(
            format!("has no light {}", options.light + 1),
            format!("ask for one from 1 to {count}"),
        ),
    })?;
    Ok((camera, light))
}

#[cfg(test)]
mod tests;
