//! What is measured and planned of `second_depth`.

use super::{
    Candidate, CataloguedTechnique, ClosedFormDemand, PlannedBiases, RandomParameter, sweeps,
};
use umbrage_core::{Fit, Light};
use umbrage_techniques::{Bias, SecondDepth, ShadowMap};

impl CataloguedTechnique for SecondDepth {
    fn kernel_reach(&self) -> Option<f32> {
        Some(self.radius as f32)
    }

    fn compared(map_sizes: &[u32], fit: Fit) -> Vec<Self> {
        sweeps::sweep(map_sizes, fit, &[Bias::FRONT_CULL], |map| Self {
            map,
            radius: 0,
        })
    }

    fn exhaustive(map_size: u32) -> Vec<Self> {
        sweeps::every_bias(map_size, |map| Self { map, radius: 1 })
    }

    fn candidates(map: ShadowMap, _: &Light) -> Vec<Candidate<Self>> {
        let map = ShadowMap {
            bias: Bias::FRONT_CULL,
            ..map
        };
        [0, 1]
            .map(|radius| Candidate::of(Self { map, radius }))
            .to_vec()
    }

    // Far sides are their own bias.
    const PLANNED_BIASES: PlannedBiases = PlannedBiases::Own;

    fn closed_form(map: ShadowMap) -> Option<ClosedFormDemand<Self>> {
        let map = ShadowMap {
            bias: Bias::FRONT_CULL,
            ..map
        };
        // It shows nothing but the far sides of bodies: sheets, and rooms without an outside, have none.
        Some(ClosedFormDemand {
            closed_bodies: true,
            ..ClosedFormDemand::new(Self { map, radius: 0 }, 0.0)
        })
    }

    fn random_parameters() -> Vec<RandomParameter> {
        vec![RandomParameter::Count(0..4)]
    }

    fn random(map: ShadowMap, numbers: &[f32]) -> Self {
        Self {
            map,
            radius: numbers[0] as u32,
        }
    }
}
