//! The depth halfway between two images of depth: what a map of midpoints holds.

use glam::UVec2;
use std::sync::Arc;
use umbrage_core::{FilterKernel, Inputs, Kernel, Module};

/// From two images of depth to their mean.
pub(crate) fn between() -> Arc<dyn FilterKernel> {
    Arc::new(BetweenKernel)
}

/// The mean of two images.
#[derive(Clone, Copy, Debug)]
pub struct BetweenKernel;

impl Kernel for BetweenKernel {
    fn modules(&self) -> Vec<Module> {
        vec![Module {
            name: "between",
            text: include_str!("between.wgsl"),
        }]
    }
}

impl FilterKernel for BetweenKernel {
    fn filter(&self, inputs: &Inputs<'_>, start: UVec2, layer: u32, out: &mut [f32]) {
        let [first, second] = [0, 1].map(|i| {
            let image = &inputs.images[i];
            let from = image.index(start.x as i32, start.y as i32, layer);
            &image.texels[from..from + out.len()]
        });
        for ((out, a), b) in out.iter_mut().zip(first).zip(second) {
            *out = (a + b) * 0.5;
        }
    }
}
