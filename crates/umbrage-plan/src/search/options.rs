//! Options of the planner.

use super::hold::Hold;
use crate::{
    cancel::Cancel, catalogue::Catalogue, cost::CostModel, estimate::weighting::Weighting,
    motion::FrameMotion, truth::TruthOptions,
};
use glam::UVec2;
use umbrage_core::{Camera, Invalid, Light, Scene};

/// Options of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanOptions {
    /// Techniques to evaluate.
    pub catalogue: Catalogue,
    /// Number of receivers sampled under lights with an extent. Ideal lights sample four times as
    /// many, since their truth takes one ray each. Several cameras share the samples; each gets at
    /// least a quarter of them.
    pub samples: u32,
    /// Seed of the sample; the same seed returns the same plan.
    pub seed: u32,
    /// Options for tracing truth.
    pub truth: TruthOptions,
    /// Prices of work.
    pub cost: CostModel,
    /// Index of the scene's light.
    pub light: usize,
    /// The cameras that a plan is made for, such as those along a path; if empty, the scene's
    /// first.
    pub cameras: Vec<Camera>,
    /// Image size that replaces the cameras' own, pixels.
    pub size: Option<UVec2>,
    /// Motion from frame to frame. It decides which work each frame does, and so a setting's cost.
    pub motion: FrameMotion,
    /// Cameras for which the bounds hold.
    pub hold: Hold,
    /// Weight of each pixel's error.
    pub weighting: Weighting,
    /// Cancellation flag.
    pub cancel: Cancel,
}

impl Default for PlanOptions {
    fn default() -> Self {
        // A quarter of the rays of a comparison. Their noise of about .005 is far below the error
        // differences that matter.
        let truth = TruthOptions {
            samples: 256,
            ..TruthOptions::default()
        };
        Self {
            catalogue: Catalogue::built_in(),
            samples: 4096,
            seed: 1,
            truth,
            cost: CostModel::CPU,
            light: 0,
            cameras: Vec::new(),
            size: None,
            motion: FrameMotion::default(),
            hold: Hold::default(),
            weighting: Weighting::default(),
            cancel: Cancel::default(),
        }
    }
}

impl PlanOptions {
    /// Returns the light of the options.
    pub(crate) fn light_of<'a>(&self, scene: &'a Scene) -> Result<&'a Light, Invalid> {
        let count = scene.lights.len();
        scene.lights.get(self.light).ok_or_else(|| match count {
            0 => no_such(scene, "light"),
            _ => Invalid::new(
                format!("scene `{}`", scene.name),
                format!("has no light {}", self.light + 1),
                format!("use 1 to {count}"),
            ),
        })
    }

    /// Returns the cameras of the options, or the scene's first if they have none.
    pub(crate) fn cameras_of(&self, scene: &Scene) -> Result<Vec<Camera>, Invalid> {
        let own = match &self.cameras[..] {
            [] => &scene.cameras[..scene.cameras.len().min(1)],
            own => own,
        };
        if own.is_empty() {
            return Err(no_such(scene, "camera"));
        }
        let resized = |camera: &Camera| self.size.map_or(*camera, |size| camera.with_size(size));
        Ok(own.iter().map(resized).collect())
    }
}

/// Returns the error of a scene without a light or a camera.
pub(super) fn no_such(scene: &Scene, what: &str) -> Invalid {
    Invalid::new(
        format!("scene `{}`", scene.name),
        format!("has no {what}"),
        "add one",
    )
}
