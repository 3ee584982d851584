//! Mean of two depth images, which midpoint maps store.

use glam::UVec2;
use std::sync::Arc;
use umbrage_core::{FilterKernel, ImageView, Inputs, Kernel, Module, module};

/// Returns the filter that computes the mean of two depth images.
pub(crate) fn depth_mean_filter() -> Arc<dyn FilterKernel> {
    Arc::new(BetweenKernel)
}

/// Filter that computes the mean of two images.
#[derive(Clone, Copy, Debug)]
pub struct BetweenKernel;

impl Kernel for BetweenKernel {
    fn modules(&self) -> Vec<Module> {
        vec![module!("between")]
    }
}

impl FilterKernel for BetweenKernel {
    fn filter(&self, inputs: &Inputs<'_>, start: UVec2, layer: u32, out: &mut [f32]) {
        let first = row(&inputs.images[0], start, layer, out.len());
        let second = row(&inputs.images[1], start, layer, out.len());
        for ((out, a), b) in out.iter_mut().zip(first).zip(second) {
            *out = (a + b) * 0.5;
        }
    }
}

/// Returns `count` texels of a layer, from `start` to the right.
fn row<'a>(image: &ImageView<'a>, start: UVec2, layer: u32, count: usize) -> &'a [f32] {
    let first = image.index(start.x as i32, start.y as i32, layer);
    &image.texels[first..first + count]
}
