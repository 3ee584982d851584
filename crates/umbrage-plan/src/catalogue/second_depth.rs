//! Catalogue entry of `second_depth`.

use super::{
    Candidate, CataloguedTechnique, ClosedFormDemand, PlannedBiases, RandomParameter, sweeps,
};
use umbrage_core::{Fit, Light};
use umbrage_techniques::{Bias, MapFilter as _, MapTechnique, SecondDepth, ShadowMap};

impl CataloguedTechnique for MapTechnique<SecondDepth> {
    fn kernel_reach(&self) -> Option<f32> {
        Some(self.filter.radius as f32)
    }

    fn compared_settings(map_sizes: &[u32], fit: Fit) -> Vec<Self> {
        sweeps::sweep(map_sizes, fit, &[Bias::FRONT_CULL], |map| {
            SecondDepth { radius: 0 }.on(map)
        })
    }

    fn exhaustive(map_size: u32) -> Vec<Self> {
        sweeps::every_bias(map_size, |map| SecondDepth { radius: 1 }.on(map))
    }

    fn candidates(map: ShadowMap, _: &Light) -> Vec<Candidate<Self>> {
        let map = ShadowMap {
            bias: Bias::FRONT_CULL,
            ..map
        };
        [0, 1]
            .map(|radius| Candidate::from_setting(SecondDepth { radius }.on(map)))
            .to_vec()
    }

    // Far sides replace a bias.
    const PLANNED_BIASES: PlannedBiases = PlannedBiases::Own;

    fn closed_form(map: ShadowMap) -> Option<ClosedFormDemand<Self>> {
        let map = ShadowMap {
            bias: Bias::FRONT_CULL,
            ..map
        };
        // The map contains only the far sides of bodies. Sheets, and rooms without an outside, have
        // none.
        Some(ClosedFormDemand {
            closed_bodies: true,
            ..ClosedFormDemand::new(SecondDepth { radius: 0 }.on(map), 0.0)
        })
    }

    fn random_parameters() -> Vec<RandomParameter> {
        vec![RandomParameter::Count(0..4)]
    }

    fn random(map: ShadowMap, numbers: &[f32]) -> MapTechnique<SecondDepth> {
        SecondDepth {
            radius: numbers[0] as u32,
        }
        .on(map)
    }
}
