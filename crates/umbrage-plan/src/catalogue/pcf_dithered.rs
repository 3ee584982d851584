//! Catalogue entry of `pcf_dithered`.

use super::{
    CataloguedTechnique,
    kernel::{self, CataloguedKernel, KernelCost},
    sweeps,
};
use umbrage_core::{Fit, ReceiveKernel, glam::Vec3};
use umbrage_techniques::{MapFilter as _, MapTechnique, PcfDithered, PcfDitheredKernel};

impl CataloguedTechnique for MapTechnique<PcfDithered> {
    fn kernel_reach(&self) -> Option<f32> {
        Some(1.5)
    }

    fn kernel(kernel: &dyn ReceiveKernel) -> Option<&dyn CataloguedKernel> {
        kernel::downcast::<PcfDitheredKernel>(kernel)
    }

    fn compared_settings(map_sizes: &[u32], fit: Fit) -> Vec<Self> {
        sweeps::sweep(map_sizes, fit, &sweeps::two_biases(1.5), |map| {
            PcfDithered {}.on(map)
        })
    }

    const RANDOM_WEIGHT: u32 = 2;
}

impl CataloguedKernel for PcfDitheredKernel {
    fn cost_per_receiver(&self) -> KernelCost {
        KernelCost::taps(4)
    }

    fn layer(&self, position: Vec3) -> Option<u32> {
        Some(self.0.lookup.layer_of(position))
    }
}
