//! Least depth of each tile of a map: one level of a min pyramid.

use crate::shadow_map::{packing::unpack_depth, variants::stored_depth};
use glam::{UVec2, Vec4};
use umbrage_core::{
    FilterKernel, Inputs, Kernel, Module, SimdTask, UniformBlock, module, uniforms,
};

uniforms! {
    /// Uniforms of [`LeastDepthKernel`].
    pub struct LeastDepthUniforms {
        /// Side of a tile, texels of the input.
        pub ratio: u32,
        /// Side of the input, texels.
        pub size: u32,
    }
}

/// Filter from a square map to a smaller one whose texels hold the least depth of `ratio` x `ratio`
/// texels.
#[derive(Clone, Copy, Debug)]
pub struct LeastDepthKernel {
    pub(crate) uniforms: LeastDepthUniforms,
    /// True if each depth of the input occupies four channels.
    pub(crate) packed: bool,
}

impl Kernel for LeastDepthKernel {
    fn modules(&self) -> Vec<Module> {
        let own = module!("least_depth");
        stored_depth(self.packed).into_iter().chain([own]).collect()
    }

    fn uniforms(&self) -> Option<&dyn UniformBlock> {
        Some(&self.uniforms)
    }
}

impl FilterKernel for LeastDepthKernel {
    fn filter(&self, inputs: &Inputs<'_>, start: UVec2, layer: u32, out: &mut [f32]) {
        let LeastDepthUniforms { ratio, size } = self.uniforms;
        let image = &inputs.images[0];
        let first = start.y * ratio;
        let rows = (first..(first + ratio).min(size)).map(|y| {
            let row = image.index(0, y as i32, layer);
            &image.texels[row..row + size as usize * image.desc.format.channels()]
        });
        // Reduce whole rows first: that runs in lanes, and leaves little work within tiles.
        let mut column = vec![1.0_f32; size as usize];
        for row in rows {
            if self.packed {
                let (texels, _) = row.as_chunks();
                for (least, &channels) in column.iter_mut().zip(texels) {
                    let depth = unpack_depth(Vec4::from_array(channels));
                    *least = least.min(depth);
                }
            } else {
                inputs.simd.run_task(MinOfRows {
                    least: &mut column,
                    row,
                });
            }
        }
        for (out, tile) in out.iter_mut().zip(column.chunks(ratio as usize)) {
            *out = tile.iter().copied().fold(1.0, f32::min);
        }
    }
}

/// Elementwise minimum of `row` and `least`, stored in `least`.
struct MinOfRows<'a> {
    least: &'a mut [f32],
    row: &'a [f32],
}

impl SimdTask for MinOfRows<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (least, &depth) in self.least.iter_mut().zip(self.row) {
            *least = if depth < *least { depth } else { *least };
        }
    }
}
