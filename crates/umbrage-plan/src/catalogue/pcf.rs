//! Catalogue entry of `pcf`.

use super::{
    Candidate, CataloguedTechnique, RandomParameter,
    kernel::{self, CataloguedKernel, KernelCost},
    sweeps,
};
use umbrage_core::{Fit, Light, ReceiveKernel, glam::Vec3};
use umbrage_techniques::{
    Bias, MAX_UNROLLED_RADIUS, MapFilter as _, MapTechnique, Pcf, PcfKernel, ShadowMap,
};

impl CataloguedTechnique for MapTechnique<Pcf> {
    fn kernel_reach(&self) -> Option<f32> {
        Some(self.filter.radius as f32)
    }

    fn kernel(kernel: &dyn ReceiveKernel) -> Option<&dyn CataloguedKernel> {
        kernel::downcast::<PcfKernel>(kernel)
    }

    fn compared_settings(map_sizes: &[u32], fit: Fit) -> Vec<Self> {
        let swept = |radius: u32| {
            let biases = sweeps::wide_biases(radius as f32);
            sweeps::sweep(map_sizes, fit, &biases, |map| Pcf::new(radius).on(map))
        };
        let mut out = swept(1);
        let radius = 2;
        out.extend(sweeps::middle(map_sizes, fit, &[Bias::ADAPTIVE], |map| {
            Pcf::new(radius).on(map)
        }));
        out.extend(swept(3));
        out.extend(sweeps::cascades(map_sizes, fit, Bias::ADAPTIVE, |map| {
            Pcf::new(1).on(map)
        }));
        out
    }

    fn headline(map_sizes: &[u32], fit: Fit) -> Vec<Self> {
        let bias = [Bias::ADAPTIVE];
        let larger = &map_sizes[map_sizes.len() / 2..];
        let mut out = sweeps::maps(larger, fit, &bias, |map| Pcf::new(1).on(map));
        out.extend(sweeps::middle(map_sizes, fit, &bias, |map| {
            Pcf::new(3).on(map)
        }));
        out.extend(sweeps::cascades(map_sizes, fit, Bias::ADAPTIVE, |map| {
            Pcf::new(1).on(map)
        }));
        out
    }

    fn exhaustive(map_size: u32) -> Vec<Self> {
        let mut out = Vec::new();
        for radius in [0, 1, 2, 3, 6] {
            out.extend(sweeps::every_bias(map_size, |map| Pcf::new(radius).on(map)));
        }
        out
    }

    fn candidates(map: ShadowMap, _: &Light) -> Vec<Candidate<Self>> {
        [1, 2, 3, 5]
            .map(|radius| Candidate::from_setting(Pcf::new(radius).on(map)))
            .to_vec()
    }

    const RANDOM_WEIGHT: u32 = 3;

    fn random_parameters() -> Vec<RandomParameter> {
        let unrolled = MAX_UNROLLED_RADIUS + 1;
        vec![RandomParameter::Count(0..RADII + unrolled)]
    }

    fn random(map: ShadowMap, numbers: &[f32]) -> MapTechnique<Pcf> {
        // Radii with the text for all, then unrolled ones.
        let number = numbers[0] as u32;
        let unrolled = number >= RADII;
        let radius = if unrolled { number - RADII } else { number };
        Pcf { radius, unrolled }.on(map)
    }
}

/// Number of radii of random settings that are not unrolled.
const RADII: u32 = 8;

impl CataloguedKernel for PcfKernel {
    fn cost_per_receiver(&self) -> KernelCost {
        let side = 2 * self.uniforms.radius.unsigned_abs() + 1;
        KernelCost::taps(side * side.div_ceil(NEIGHBOURS_A_TAP))
    }

    fn layer(&self, position: Vec3) -> Option<u32> {
        Some(self.uniforms.lookup.layer_of(position))
    }
}

/// Number of adjacent taps in a row that cost at most as much as one tap elsewhere. From 3x3 to
/// 7x7, a tap adds .10 ns on the CPU and 1.2 ns on lavapipe. In the disc of `pcf_disc`, it adds .75
/// and 2.6 ns (`recorded.csv`).
const NEIGHBOURS_A_TAP: u32 = 3;
