//! Catalogue entry of `pcf_hardware`.

use super::{
    Candidate, CataloguedTechnique, ClosedFormDemand, RandomParameter,
    kernel::{self, CataloguedKernel, KernelCost},
    sweeps,
};
use umbrage_core::{Fit, Light, ReceiveKernel, glam::Vec3};
use umbrage_techniques::{
    Bias, HardwareKernel, MapFilter as _, MapTechnique, PcfHardware, ShadowMap,
};

impl CataloguedTechnique for MapTechnique<PcfHardware> {
    fn kernel_reach(&self) -> Option<f32> {
        Some(PcfHardware::reach(self.filter.samples))
    }

    fn kernel(kernel: &dyn ReceiveKernel) -> Option<&dyn CataloguedKernel> {
        kernel::downcast::<HardwareKernel>(kernel)
    }

    fn compared_settings(map_sizes: &[u32], fit: Fit) -> Vec<Self> {
        let swept = |samples: u32| {
            let biases = sweeps::two_biases(PcfHardware::reach(samples));
            sweeps::sweep(map_sizes, fit, &biases, |map| {
                PcfHardware { samples }.on(map)
            })
        };
        let mut out = swept(1);
        let samples = 2;
        out.extend(sweeps::middle(map_sizes, fit, &[Bias::ADAPTIVE], |map| {
            PcfHardware { samples }.on(map)
        }));
        out.extend(swept(3));
        out
    }

    fn exhaustive(map_size: u32) -> Vec<Self> {
        let mut out = sweeps::every_bias(map_size, |map| PcfHardware { samples: 2 }.on(map));
        for samples in [1, 3] {
            out.extend(sweeps::slope_and_adaptive(map_size, |map| {
                PcfHardware { samples }.on(map)
            }));
        }
        let kinds = sweeps::sampled_maps(map_size).into_iter();
        out.extend(kinds.map(|map| PcfHardware { samples: 2 }.on(map)));
        out
    }

    fn candidates(map: ShadowMap, _: &Light) -> Vec<Candidate<Self>> {
        [1, 2, 3]
            .map(|samples| Candidate::from_setting(PcfHardware { samples }.on(map)))
            .to_vec()
    }

    fn closed_form(map: ShadowMap) -> Option<ClosedFormDemand<Self>> {
        // The default bias makes samples up to 6 % grey on a faceted sphere, where a facet meets a
        // flatter one: see `shaders/shadow_map/bias.rs`.
        let map = ShadowMap {
            bias: Bias::RECEIVER_PLANE,
            ..map
        };
        Some(ClosedFormDemand::new(
            PcfHardware { samples: 2 }.on(map),
            PcfHardware::reach(2),
        ))
    }

    const RANDOM_WEIGHT: u32 = 2;

    fn random_parameters() -> Vec<RandomParameter> {
        vec![RandomParameter::Count(1..5)]
    }

    fn random(map: ShadowMap, numbers: &[f32]) -> MapTechnique<PcfHardware> {
        PcfHardware {
            samples: numbers[0] as u32,
        }
        .on(map)
    }
}

impl CataloguedKernel for HardwareKernel {
    fn cost_per_receiver(&self) -> KernelCost {
        KernelCost::samples(self.0.samples.unsigned_abs().pow(2))
    }

    fn layer(&self, position: Vec3) -> Option<u32> {
        Some(self.0.lookup.layer_of(position))
    }
}
