//! Catalogue entry of `hard`.

use super::{
    CataloguedTechnique,
    kernel::{self, CataloguedKernel},
    sweeps,
};
use umbrage_core::{Fit, ReceiveKernel, glam::Vec3};
use umbrage_techniques::{
    Bias, Hard, HardKernel, MapFilter as _, MapFormat, MapTechnique, ShadowMap,
};

/// Biases to compare, since a single comparison shows their effects best. The first is compared at
/// every map size.
const COMPARED_BIASES: [Bias; 8] = [
    Bias::ADAPTIVE,
    Bias::RECEIVER_PLANE,
    Bias::NONE,
    Bias::CONSTANT,
    Bias::SLOPE,
    Bias::POLYGON_OFFSET,
    Bias::NORMAL_OFFSET,
    Bias::FRONT_CULL,
];

impl CataloguedTechnique for MapTechnique<Hard> {
    fn kernel_reach(&self) -> Option<f32> {
        Some(0.0)
    }

    fn kernel(kernel: &dyn ReceiveKernel) -> Option<&dyn CataloguedKernel> {
        kernel::downcast::<HardKernel>(kernel)
    }

    fn compared_settings(map_sizes: &[u32], fit: Fit) -> Vec<Self> {
        let mut out = sweeps::sweep(map_sizes, fit, &COMPARED_BIASES, |map| Hard {}.on(map));
        for format in [MapFormat::Depth16, MapFormat::Rgba8] {
            out.extend(sweeps::middle(map_sizes, fit, &[Bias::SLOPE], |map| {
                Hard {}.on(ShadowMap { format, ..map })
            }));
        }
        out.extend(sweeps::cascades(map_sizes, fit, Bias::ADAPTIVE, |map| {
            Hard {}.on(map)
        }));
        out
    }

    fn headline(map_sizes: &[u32], fit: Fit) -> Vec<Self> {
        let mut out = sweeps::sweep(map_sizes, fit, &[Bias::ADAPTIVE], |map| Hard {}.on(map));
        out.extend(sweeps::cascades(map_sizes, fit, Bias::ADAPTIVE, |map| {
            Hard {}.on(map)
        }));
        out
    }

    fn exhaustive(map_size: u32) -> Vec<Self> {
        let mut out = sweeps::every_bias(map_size, |map| Hard {}.on(map));
        out.extend(sweeps::kinds_of_map(map_size).map(|map| Hard {}.on(map)));
        out
    }

    const RANDOM_WEIGHT: u32 = 2;
}

impl CataloguedKernel for HardKernel {
    // Lookups use only the receiver's own texel, even where another technique with a larger reach
    // falls back to this kernel.
    fn reach(&self, _: Vec3, _: Vec3) -> Option<f32> {
        Some(0.0)
    }

    fn layer(&self, position: Vec3) -> Option<u32> {
        Some(self.0.lookup.layer_of(position))
    }
}
