//! Catalogue entry of `midpoint`.

use super::{Candidate, CataloguedTechnique, PlannedBiases, RandomParameter, sweeps};
use umbrage_core::{Fit, Light};
use umbrage_techniques::{Bias, MapFilter as _, MapTechnique, Midpoint, ShadowMap};

impl CataloguedTechnique for MapTechnique<Midpoint> {
    fn kernel_reach(&self) -> Option<f32> {
        Some(self.filter.radius as f32)
    }

    fn compared_settings(map_sizes: &[u32], fit: Fit) -> Vec<Self> {
        let biases = [Bias::NONE, Bias::ADAPTIVE];
        sweeps::sweep(map_sizes, fit, &biases, |map| {
            Midpoint { radius: 0 }.on(map)
        })
    }

    fn exhaustive(map_size: u32) -> Vec<Self> {
        sweeps::every_bias(map_size, |map| Midpoint { radius: 1 }.on(map))
    }

    fn candidates(map: ShadowMap, _: &Light) -> Vec<Candidate<Self>> {
        [0, 1]
            .map(|radius| Candidate::from_setting(Midpoint { radius }.on(map)))
            .to_vec()
    }

    // Peeling does not support a polygon offset.
    const PLANNED_BIASES: PlannedBiases = PlannedBiases::WithoutPolygonOffset;

    fn random_parameters() -> Vec<RandomParameter> {
        vec![RandomParameter::Count(0..4)]
    }

    fn random(map: ShadowMap, numbers: &[f32]) -> MapTechnique<Midpoint> {
        Midpoint {
            radius: numbers[0] as u32,
        }
        .on(map)
    }
}
