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
    /// The techniques that are tried.
    pub catalogue: Catalogue,
    /// Receivers sampled under lights with an extent; four times as many under ideal ones, whose
    /// truth takes one ray each. Several cameras share them, down to a quarter of them each.
    pub samples: u32,
    /// Which sample: the same seed gives the same plan.
    pub seed: u32,
    /// How truth is traced.
    pub truth: TruthOptions,
    /// What work costs.
    pub cost: CostModel,
    /// Which of the scene's lights, from 0.
    pub light: usize,
    /// The cameras that a plan is made for, such as those along a path; none: the scene's first.
    pub cameras: Vec<Camera>,
    /// Image size in place of the cameras' own, pixels.
    pub size: Option<UVec2>,
    /// What moves from frame to frame: which work each frame does, and so what a setting costs.
    pub motion: FrameMotion,
    /// For how many of several cameras the bounds hold.
    pub hold: Hold,
    /// How much each pixel's error counts.
    pub weighting: Weighting,
    /// Who calls the plan off.
    pub cancel: Cancel,
}

impl Default for PlanOptions {
    fn default() -> Self {
        // A quarter of a comparison's rays: their noise of about .005 is far below the errors that
        // are told apart.
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
    /// Returns the light that the options are about.
    pub(crate) fn light_of<'a>(&self, scene: &'a Scene) -> Result<&'a Light, Invalid> {
        let count = scene.lights.len();
        scene.lights.get(self.light).ok_or_else(|| match count {
            0 => no_such(scene, "light"),
            _ => Invalid::new(
                format!("scene `{}`", scene.name),
                format!("has no light {}", self.light + 1),
                format!("ask for one from 1 to {count}"),
            ),
        })
    }

    /// Returns the cameras that the options are about: their own, or else the scene's first.
    pub(crate) fn cameras_of(&self, scene: &Scene) -> Result<Vec<Camera>, Invalid> {
        let own = match &self.cameras[..] {
            [] => &scene.cameras[..scene.cameras.len().min(1)],
            own => own,
        };
        if own.is_empty() {
            return Err(no_such(scene, "camera"));
        }
        let resized = |camera: &Camera| self.size.map_or(*camera, |size| camera.resized(size));
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
