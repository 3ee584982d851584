//! Catalogue entry of `pcss`.

use super::{
    Candidate, CataloguedTechnique, ClosedFormDemand, RandomParameter,
    kernel::{self, CataloguedKernel, KernelCost},
    sweeps,
};
use umbrage_core::{Fit, Light, ReceiveKernel, glam::Vec3};
use umbrage_techniques::{
    Bias, ListedTechnique as _, MapFilter as _, MapTechnique, Pattern, Pcss, PcssKernel, ShadowMap,
};

impl CataloguedTechnique for MapTechnique<Pcss> {
    /// Returns the least reach, one texel. The kernel is as wide as the penumbra, which varies.
    fn kernel_reach(&self) -> Option<f32> {
        Some(1.0)
    }

    fn kernel(kernel: &dyn ReceiveKernel) -> Option<&dyn CataloguedKernel> {
        kernel::downcast::<PcssKernel>(kernel)
    }

    fn compared_settings(map_sizes: &[u32], fit: Fit) -> Vec<Self> {
        let few = with_taps(8, 16);
        let usual = with_taps(16, 32);
        let many = with_taps(32, 64);
        let bias = [Bias::ADAPTIVE];
        let biases = [Bias::ADAPTIVE, Bias::SLOPE];
        let mut out = sweeps::middle(map_sizes, fit, &bias, |map| few.with_map(map));
        out.extend(sweeps::sweep(map_sizes, fit, &biases, |map| {
            usual.with_map(map)
        }));
        out.extend(sweeps::middle(map_sizes, fit, &bias, |map| {
            many.with_map(map)
        }));
        out
    }

    fn headline(map_sizes: &[u32], fit: Fit) -> Vec<Self> {
        let usual = Self::default();
        let many = with_taps(32, 64);
        let bias = [Bias::ADAPTIVE];
        let mut out = sweeps::middle(map_sizes, fit, &bias, |map| usual.with_map(map));
        out.extend(sweeps::middle(map_sizes, fit, &bias, |map| {
            many.with_map(map)
        }));
        out
    }

    fn exhaustive(map_size: u32) -> Vec<Self> {
        let default = Self::default();
        let mut out = sweeps::every_bias(map_size, |map| default.with_map(map));
        for pattern in [Pattern::Grid, Pattern::Poisson] {
            let still = Pcss {
                pattern,
                rotate: false,
                ..with_taps(7, 9).filter
            }
            .on(with_taps(7, 9).map);
            out.extend(sweeps::slope_and_adaptive(map_size, |map| {
                still.with_map(map)
            }));
        }
        out.extend(sweeps::kinds_of_map(map_size).map(|map| default.with_map(map)));
        out
    }

    fn candidates(map: ShadowMap, light: &Light) -> Vec<Candidate<Self>> {
        // Ideal lights have no penumbrae.
        if light.is_ideal() {
            return Vec::new();
        }
        [(4, 8), (8, 16), (16, 32), (32, 64)]
            .map(|(blocker_taps, filter_taps)| {
                Candidate::from_setting(with_taps(blocker_taps, filter_taps).with_map(map))
            })
            .to_vec()
    }

    fn closed_form(map: ShadowMap) -> Option<ClosedFormDemand<Self>> {
        // An ideal light has no extent to search.
        Some(ClosedFormDemand::new(Self::default().with_map(map), 0.0))
    }

    const RANDOM_WEIGHT: u32 = 3;

    fn random_parameters() -> Vec<RandomParameter> {
        vec![
            RandomParameter::Count(1..40),
            RandomParameter::Count(1..40),
            RandomParameter::Pattern,
            RandomParameter::Switch,
        ]
    }

    fn random(map: ShadowMap, numbers: &[f32]) -> MapTechnique<Pcss> {
        Pcss {
            blocker_taps: numbers[0] as u32,
            filter_taps: numbers[1] as u32,
            pattern: Pattern::ALL[numbers[2] as usize],
            rotate: numbers[3] > 0.0,
        }
        .on(map)
    }
}

impl CataloguedKernel for PcssKernel {
    /// Counts no second comparisons at a tap: they are few, and about as many receivers need no
    /// search.
    fn cost_per_receiver(&self) -> KernelCost {
        KernelCost::taps(1 + self.uniforms.blocker_taps + self.uniforms.filter_taps)
    }

    fn horizon_error(&self) -> Option<f32> {
        Some(0.0)
    }

    fn reach(&self, position: Vec3, normal: Vec3) -> Option<f32> {
        Some(self.lookup_reach(position, normal))
    }

    fn layer(&self, position: Vec3) -> Option<u32> {
        Some(self.uniforms.lookup.layer_of(position))
    }
}

/// Returns the default settings with other counts of taps.
fn with_taps(blocker_taps: u32, filter_taps: u32) -> MapTechnique<Pcss> {
    Pcss {
        blocker_taps,
        filter_taps,
        ..Pcss::default()
    }
    .on(ShadowMap::default())
}
