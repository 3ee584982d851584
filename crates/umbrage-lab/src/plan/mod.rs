//! The least that a scene needs: the cheapest technique and setting within bounds, found by measurement.
//!
//! No rule says what is chosen. Some thousand seen receivers are sampled, more where visibility varies, and their truth is
//! traced; candidates are then tried on these receivers alone, bit by bit as they would shade the image, from the cheapest
//! up. What they cost comes from [`cost`](crate::cost), so that the same scene has the same plan on every run. Of each
//! candidate the bias is searched that leaves the least acne plus gap.
//!
//! ```
//! use umbrage_lab::plan::{Bounds, Options, plan};
//! let scene = umbrage_scenes::by_argument("no-casters")?;
//! let plan = plan(&scene, &Bounds::error(0.02), &Options::default(), &|_| {})?;
//! assert_eq!(plan.preset()?.technique().name(), "none");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod bias;
mod bounds;
mod density;
mod estimate;
mod families;
mod look;
mod outcome;
mod penumbra;
#[cfg(feature = "report")]
mod picture;
mod planner;
mod reasons;
mod regret;
mod resolution;
mod sample;
mod setting;
mod trial;
mod walk;

pub use bias::BiasKind;
pub use bounds::Bounds;
pub use estimate::Estimate;
pub use outcome::{CurvePoint, Miss, Plan, Sampled};
#[cfg(feature = "report")]
pub use picture::curve_figure;
pub use planner::Planner;
pub use regret::{LEAST_KEPT, MOST_REGRET, Regret, regret};
pub use setting::Setting;

use crate::{LabError, cost::CostModel, truth::TruthOptions};
use glam::UVec2;
use umbrage_core::{Geometry, Invalid, Scene};

/// How a plan is made.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Receivers sampled under lights with an extent; four times as many under ideal ones, whose truth takes one ray each.
    pub samples: u32,
    /// Which sample: the same seed gives the same plan.
    pub seed: u32,
    /// How truth is traced.
    pub truth: TruthOptions,
    /// What work costs.
    pub cost: CostModel,
    /// Image size in place of the camera's own, pixels.
    pub size: Option<UVec2>,
}

impl Default for Options {
    fn default() -> Self {
        // A quarter of a comparison's rays: their noise of about .005 is far below the errors that are told apart.
        let truth = TruthOptions { samples: 256, ..TruthOptions::default() };
        Self { samples: 4096, seed: 1, truth, cost: CostModel::CPU, size: None }
    }
}

/// What the planner is at, from any thread.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step<'a> {
    /// It looks for where visibility varies.
    Looking,
    /// It traces truth: work done, work in all.
    Truth(usize, usize),
    /// It tries this technique; so many settings were tried before.
    Trying(&'a str, usize),
    /// It writes down the reasons.
    Explaining,
}

/// Called with what the planner is at.
pub type OnStep<'a> = dyn Fn(Step<'_>) + Sync + 'a;

/// The plan for a scene's first camera and first light.
///
/// # Errors
/// When the scene has neither, or is not valid; when bounds are missing or bad. That no candidate is within the bounds is
/// no error: see [`Plan::preset`].
pub fn plan(scene: &Scene, bounds: &Bounds, options: &Options, on_step: &OnStep<'_>) -> Result<Plan, LabError> {
    bounds.validate()?;
    let missing = |what| Invalid::new(format!("scene `{}`", scene.name), format!("has no {what}"), "add one");
    let camera = scene.cameras.first().ok_or_else(|| missing("camera"))?;
    let light = scene.lights.first().ok_or_else(|| missing("light"))?;
    let camera = options.size.map_or(*camera, |size| camera.resized(size));
    let geometry = Geometry::bake(scene)?;
    let plan = Planner::new(&camera, light, &geometry, options, on_step)?.plan(bounds)?;
    Ok(Plan { scene: scene.name.clone(), ..plan })
}

#[cfg(test)]
mod tests;
