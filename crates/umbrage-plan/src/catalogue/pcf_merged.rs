//! Catalogue entry of `pcf_merged`.

use super::{
    Candidate, CataloguedTechnique, ClosedFormDemand, RandomParameter,
    kernel::{self, CataloguedKernel, KernelCost},
    sweeps,
};
use umbrage_core::{Fit, Light, ReceiveKernel, glam::Vec3};
use umbrage_techniques::{Bias, MapFilter as _, MapTechnique, MergedKernel, PcfMerged, ShadowMap};

impl CataloguedTechnique for MapTechnique<PcfMerged> {
    fn kernel_reach(&self) -> Option<f32> {
        Some(PcfMerged::reach(self.filter.radius))
    }

    fn kernel(kernel: &dyn ReceiveKernel) -> Option<&dyn CataloguedKernel> {
        kernel::downcast::<MergedKernel>(kernel)
    }

    fn compared_settings(map_sizes: &[u32], fit: Fit) -> Vec<Self> {
        let mut out = Vec::new();
        for radius in [1, 2] {
            let biases = sweeps::two_biases(PcfMerged::reach(radius));
            out.extend(sweeps::sweep(map_sizes, fit, &biases, |map| {
                PcfMerged { radius }.on(map)
            }));
        }
        let radius = 3;
        out.extend(sweeps::middle(map_sizes, fit, &[Bias::ADAPTIVE], |map| {
            PcfMerged { radius }.on(map)
        }));
        out
    }

    fn exhaustive(map_size: u32) -> Vec<Self> {
        let mut out = sweeps::every_bias(map_size, |map| PcfMerged { radius: 1 }.on(map));
        for radius in [2, 3] {
            out.extend(sweeps::slope_and_adaptive(map_size, |map| {
                PcfMerged { radius }.on(map)
            }));
        }
        let kinds = sweeps::sampled_maps(map_size).into_iter();
        out.extend(kinds.map(|map| PcfMerged { radius: 2 }.on(map)));
        out
    }

    fn candidates(map: ShadowMap, _: &Light) -> Vec<Candidate<Self>> {
        [1, 2, 3]
            .map(|radius| Candidate::from_setting(PcfMerged { radius }.on(map)))
            .to_vec()
    }

    fn closed_form(map: ShadowMap) -> Option<ClosedFormDemand<Self>> {
        // Use the same bias as `PcfHardware`.
        let map = ShadowMap {
            bias: Bias::RECEIVER_PLANE,
            ..map
        };
        Some(ClosedFormDemand::new(
            PcfMerged { radius: 1 }.on(map),
            PcfMerged::reach(1),
        ))
    }

    const RANDOM_WEIGHT: u32 = 2;

    fn random_parameters() -> Vec<RandomParameter> {
        vec![RandomParameter::Count(1..4)]
    }

    fn random(map: ShadowMap, numbers: &[f32]) -> MapTechnique<PcfMerged> {
        PcfMerged {
            radius: numbers[0] as u32,
        }
        .on(map)
    }
}

impl CataloguedKernel for MergedKernel {
    fn cost_per_receiver(&self) -> KernelCost {
        KernelCost::samples(self.0.samples.unsigned_abs().pow(2))
    }

    fn layer(&self, position: Vec3) -> Option<u32> {
        Some(self.0.lookup.layer_of(position))
    }
}
