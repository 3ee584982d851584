//! What is measured and planned of `soft`.

use super::{
    Candidate, CataloguedTechnique, ClosedFormDemand, RandomParameter,
    kernel::{self, CataloguedKernel, KernelCost},
};
use umbrage_core::{Fit, Light, ReceiveKernel, Recipe};
use umbrage_techniques::{SOFT_ERRORS, ShadowMap, Soft, SoftKernel};

/// The errors that are compared.
const COMPARED: [f32; 3] = [0.04, 0.015, 0.006];

/// The errors that a planner tries: each takes 1.6 to 2.5 times the points of the one before.
const PLANNED: [f32; 9] = [0.1, 0.07, 0.05, 0.035, 0.025, 0.015, 0.01, 0.006, 0.003];

/// From one of them to the next the error is divided by at most 2, and by somewhat more by chance.
const GAIN_OF_POINTS: f64 = 2.5;

impl CataloguedTechnique for Soft {
    fn kernel(kernel: &dyn ReceiveKernel) -> Option<&dyn CataloguedKernel> {
        kernel::downcast::<SoftKernel>(kernel)
    }

    fn compared(_: &[u32], _: Fit) -> Vec<Self> {
        COMPARED.map(|error| Self { error }).to_vec()
    }

    fn headline(_: &[u32], _: Fit) -> Vec<Self> {
        vec![Self { error: COMPARED[1] }]
    }

    fn exhaustive(_: u32) -> Vec<Self> {
        [0.05, 0.015, 0.002].map(|error| Self { error }).to_vec()
    }

    fn candidates(_: ShadowMap, light: &Light) -> Vec<Candidate<Self>> {
        // Ideal lights have one point: one ray is as exact, and cheaper.
        if light.is_ideal() {
            return Vec::new();
        }
        vec![Candidate::Series {
            settings: PLANNED.map(|error| Self { error }).to_vec(),
            max_gain: GAIN_OF_POINTS,
        }]
    }

    fn why_chosen(&self, _: f64, _: &Recipe) -> Option<String> {
        Some("hundreds of points of the light for the price of a few rays".to_owned())
    }

    fn closed_form(_: ShadowMap) -> Option<ClosedFormDemand<Self>> {
        Some(ClosedFormDemand::new(Self::default(), 0.0))
    }

    fn random_parameters() -> Vec<RandomParameter> {
        // A lattice has up to 31 rows.
        vec![RandomParameter::Count(1..32)]
    }

    fn random(_: ShadowMap, numbers: &[f32]) -> Self {
        let [least, greatest] = SOFT_ERRORS;
        // As many rows as the number says, about: the inverse of what
        // `shaders/techniques/soft/lattice.rs` has for discs.
        let error = 0.42 * numbers[0].powf(-1.5);
        Self {
            error: error.clamp(least, greatest),
        }
    }
}

impl CataloguedKernel for SoftKernel {
    fn horizon_error(&self) -> Option<f32> {
        Some(self.share_error())
    }

    /// A walk as long as some rays, and rows of points for some casters.
    fn cost_per_receiver(&self) -> KernelCost {
        let rows = self.uniforms.rows;
        KernelCost::rays(WALK_IN_RAYS + rows / ROWS_A_RAY)
    }
}

/// A walk through a shaft costs about as much as so many rays: with [`ROWS_A_RAY`], in `nave-soft`,
/// `dancer-soft` and `valley-soft` within a factor of 4 on the CPU and on wgpu. The finer the
/// casters, the more of them lie in a shaft.
const WALK_IN_RAYS: u32 = 4;

/// So many rows of points cost about as much as a ray.
const ROWS_A_RAY: u32 = 3;
