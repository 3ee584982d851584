//! Catalogue entry of `soft`.

use super::{
    Candidate, CataloguedTechnique, ClosedFormDemand, RandomParameter,
    kernel::{self, CataloguedKernel, KernelCost},
};
use umbrage_core::{Fit, Light, ReceiveKernel, Recipe};
use umbrage_techniques::{SOFT_ERRORS, ShadowMap, Soft, SoftKernel};

/// Errors that are compared.
const COMPARED: [f32; 3] = [0.04, 0.015, 0.006];

/// Errors that a planner evaluates. Each takes 1.6 to 2.5 times the points of the one before.
const PLANNED: [f32; 9] = [0.1, 0.07, 0.05, 0.035, 0.025, 0.015, 0.01, 0.006, 0.003];

/// Greatest factor by which one step divides the error: at most 2 nominally, plus a margin for
/// chance.
const GAIN_OF_POINTS: f64 = 2.5;

impl CataloguedTechnique for Soft {
    fn kernel(kernel: &dyn ReceiveKernel) -> Option<&dyn CataloguedKernel> {
        kernel::downcast::<SoftKernel>(kernel)
    }

    fn compared_settings(_: &[u32], _: Fit) -> Vec<Self> {
        COMPARED.map(|error| Self { error }).to_vec()
    }

    fn headline(_: &[u32], _: Fit) -> Vec<Self> {
        vec![Self { error: COMPARED[1] }]
    }

    fn exhaustive(_: u32) -> Vec<Self> {
        [0.05, 0.015, 0.002].map(|error| Self { error }).to_vec()
    }

    fn candidates(_: ShadowMap, light: &Light) -> Vec<Candidate<Self>> {
        // Ideal lights have one point: one ray is equally exact, and cheaper.
        if light.is_ideal() {
            return Vec::new();
        }
        vec![Candidate::Series {
            settings: PLANNED.map(|error| Self { error }).to_vec(),
            max_gain: GAIN_OF_POINTS,
        }]
    }

    fn why_chosen(&self, _: f64, _: &Recipe) -> Option<String> {
        Some("it samples hundreds of points of the light at the cost of a few rays".to_owned())
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
        // Approximate the inverse of the number of rows for discs in
        // `shaders/techniques/soft/lattice.rs`.
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

    /// Counts a walk as several rays, and rows of points as tests of some casters.
    fn cost_per_receiver(&self) -> KernelCost {
        let rows = self.uniforms.rows;
        KernelCost::rays(WALK_IN_RAYS + rows / ROWS_A_RAY)
    }
}

/// Cost of a walk through a shaft, in rays. Together with [`ROWS_A_RAY`], it is within a factor of
/// 4 in `nave-soft`, `dancer-soft` and `valley-soft` on the CPU and on wgpu. The finer the casters,
/// the more of them are in a shaft.
const WALK_IN_RAYS: u32 = 4;

/// Number of rows of points that cost about as much as a ray.
const ROWS_A_RAY: u32 = 3;
