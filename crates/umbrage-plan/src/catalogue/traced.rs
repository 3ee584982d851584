//! Catalogue entry of `traced`.

use super::{
    Candidate, CataloguedTechnique, ClosedFormDemand, RandomParameter,
    kernel::{self, CataloguedKernel, KernelCost},
};
use umbrage_core::{Fit, Light, ReceiveKernel, Recipe};
use umbrage_techniques::{ShadowMap, Traced, TracedKernel};

/// Numbers of rays a receiver that a planner evaluates. Each step is about a fifth (or one ray),
/// and increases the cost accordingly.
const PLANNED_SAMPLES: [u32; 23] = [
    1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 15, 18, 22, 27, 33, 40, 49, 60, 74, 91, 112, 170, 256,
];

/// Greatest factor by which one step divides the error. Twice the rays divide it by at most 2,
/// since samples are stratified. No step exceeds that from one ray to two.
const GAIN_OF_RAYS: f64 = 2.0;

impl CataloguedTechnique for Traced {
    fn kernel(kernel: &dyn ReceiveKernel) -> Option<&dyn CataloguedKernel> {
        kernel::downcast::<TracedKernel>(kernel)
    }

    fn compared_settings(_: &[u32], _: Fit) -> Vec<Self> {
        [1, 4, 32].map(|samples| Self { samples }).to_vec()
    }

    fn headline(_: &[u32], _: Fit) -> Vec<Self> {
        vec![Self { samples: 4 }]
    }

    fn exhaustive(_: u32) -> Vec<Self> {
        vec![Self { samples: 3 }]
    }

    fn candidates(_: ShadowMap, light: &Light) -> Vec<Candidate<Self>> {
        // Ideal lights always use one ray.
        let counts = if light.is_ideal() {
            &PLANNED_SAMPLES[..1]
        } else {
            &PLANNED_SAMPLES[..]
        };
        vec![Candidate::Series {
            settings: counts.iter().map(|&samples| Self { samples }).collect(),
            max_gain: GAIN_OF_RAYS,
        }]
    }

    fn why_chosen(&self, _: f64, _: &Recipe) -> Option<String> {
        Some("rays need neither a map nor a bias".to_owned())
    }

    fn closed_form(_: ShadowMap) -> Option<ClosedFormDemand<Self>> {
        Some(ClosedFormDemand::new(Self { samples: 1 }, 0.0))
    }

    fn random_parameters() -> Vec<RandomParameter> {
        vec![RandomParameter::Count(1..5)]
    }

    fn random(_: ShadowMap, numbers: &[f32]) -> Self {
        Self {
            samples: numbers[0] as u32,
        }
    }
}

impl CataloguedKernel for TracedKernel {
    fn cost_per_receiver(&self) -> KernelCost {
        KernelCost::rays(self.uniforms.samples)
    }
}
