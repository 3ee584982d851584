//! Catalogue entry of `pcf_disc`.

use super::{
    Candidate, CataloguedTechnique, ClosedFormDemand, RandomParameter,
    kernel::{self, CataloguedKernel, KernelCost},
    sweeps,
};
use umbrage_core::{Fit, Light, ReceiveKernel, glam::Vec3};
use umbrage_techniques::{
    Bias, ListedTechnique as _, MapFilter as _, MapTechnique, Pattern, PcfDisc, PcfDiscKernel,
    ShadowMap,
};

impl CataloguedTechnique for MapTechnique<PcfDisc> {
    fn kernel_reach(&self) -> Option<f32> {
        Some(self.filter.radius)
    }

    fn kernel(kernel: &dyn ReceiveKernel) -> Option<&dyn CataloguedKernel> {
        kernel::downcast::<PcfDiscKernel>(kernel)
    }

    fn compared_settings(map_sizes: &[u32], fit: Fit) -> Vec<Self> {
        let few = PcfDisc {
            taps: 8,
            ..PcfDisc::default()
        }
        .on(ShadowMap::default());
        let usual = PcfDisc {
            taps: 16,
            ..PcfDisc::default()
        }
        .on(ShadowMap::default());
        let many = PcfDisc {
            taps: 32,
            ..PcfDisc::default()
        }
        .on(ShadowMap::default());
        let poisson = PcfDisc {
            pattern: Pattern::Poisson,
            ..PcfDisc::default()
        }
        .on(ShadowMap::default());
        let bias = [Bias::ADAPTIVE];
        let mut out = sweeps::middle(map_sizes, fit, &bias, |map| few.with_map(map));
        out.extend(sweeps::sweep(map_sizes, fit, &bias, |map| {
            usual.with_map(map)
        }));
        out.extend(sweeps::middle(map_sizes, fit, &bias, |map| {
            many.with_map(map)
        }));
        out.extend(sweeps::middle(map_sizes, fit, &bias, |map| {
            poisson.with_map(map)
        }));
        out
    }

    fn exhaustive(map_size: u32) -> Vec<Self> {
        let mut out = sweeps::every_bias(map_size, |map| PcfDisc::default().on(map));
        for pattern in [Pattern::Grid, Pattern::Poisson] {
            out.extend(sweeps::slope_and_adaptive(map_size, |map| {
                PcfDisc {
                    pattern,
                    rotate: false,
                    taps: 9,
                    ..PcfDisc::default()
                }
                .on(map)
            }));
        }
        out
    }

    fn candidates(map: ShadowMap, _: &Light) -> Vec<Candidate<Self>> {
        let mut out = Vec::new();
        for (radius, taps) in [(2.0, 8), (4.0, 16), (8.0, 32), (16.0, 32)] {
            out.push(Candidate::from_setting(
                PcfDisc {
                    radius,
                    taps,
                    ..PcfDisc::default()
                }
                .on(map),
            ));
        }
        out
    }

    fn closed_form(map: ShadowMap) -> Option<ClosedFormDemand<Self>> {
        let radius = 2.0;
        let technique = PcfDisc {
            radius,
            ..PcfDisc::default()
        }
        .on(map);
        Some(ClosedFormDemand::new(technique, radius))
    }

    const RANDOM_WEIGHT: u32 = 2;

    fn random_parameters() -> Vec<RandomParameter> {
        vec![
            RandomParameter::Length(0.1..6.0),
            RandomParameter::Count(1..40),
            RandomParameter::Pattern,
            RandomParameter::Switch,
        ]
    }

    fn random(map: ShadowMap, numbers: &[f32]) -> MapTechnique<PcfDisc> {
        PcfDisc {
            radius: numbers[0],
            taps: numbers[1] as u32,
            pattern: Pattern::ALL[numbers[2] as usize],
            rotate: numbers[3] > 0.0,
        }
        .on(map)
    }
}

impl CataloguedKernel for PcfDiscKernel {
    fn cost_per_receiver(&self) -> KernelCost {
        KernelCost::taps(self.uniforms.taps)
    }

    fn layer(&self, position: Vec3) -> Option<u32> {
        Some(self.uniforms.lookup.layer_of(position))
    }
}
