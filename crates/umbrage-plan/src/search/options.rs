//! Options of the planner.

use crate::{cost::CostModel, truth::TruthOptions};
use glam::UVec2;
use umbrage_techniques::Techniques;

/// Options of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanOptions {
    /// The techniques that are tried.
    pub registry: Techniques,
    /// Receivers sampled under lights with an extent; four times as many under ideal ones, whose truth takes one ray each.
    pub samples: u32,
    /// Which sample: the same seed gives the same plan.
    pub seed: u32,
    /// How truth is traced.
    pub truth: TruthOptions,
    /// What work costs.
    pub cost: CostModel,
    /// Which of the scene's lights, from 0.
    pub light: usize,
    /// Image size in place of the camera's own, pixels.
    pub size: Option<UVec2>,
}

impl Default for PlanOptions {
    fn default() -> Self {
        // A quarter of a comparison's rays: their noise of about .005 is far below the errors that are told apart.
        let truth = TruthOptions {
            samples: 256,
            ..TruthOptions::default()
        };
        Self {
            registry: Techniques::built_in(),
            samples: 4096,
            seed: 1,
            truth,
            cost: CostModel::CPU,
            light: 0,
            size: None,
        }
    }
}
