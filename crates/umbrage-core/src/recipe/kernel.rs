//! Kernels: functions written once in Rust and once in WGSL. The trait requires both halves.

use crate::{
    gbuffer::receivers::{Receivers, Span},
    recipe::{
        image::ImageView,
        shader::{Module, UniformBlock},
    },
    simd::Simd,
};
use glam::UVec2;
use std::{any::Any, fmt::Debug};

/// The WGSL half, and the properties of both halves.
///
/// The backend declares these items before the modules:
///
/// * [`MATH`](crate::MATH);
/// * `struct Receiver { position: vec3f, normal: vec3f, pixel: vec2u, triangle: u32 }`;
/// * `var<uniform> kernel: NAME` with the uniform struct that the modules declare, if there is one;
/// * for input image `i` the functions `load_i(texel: vec2i, layer: i32) -> vec4f` and
///   `size_i() -> vec2i` (a function, so that one compiled shader serves maps of all sizes); texels
///   passed to `load_i` must be within the image;
/// * for input table `j` a `var<storage> table_j: array<vec4u>`;
/// * if [`compares`](Kernel::compares) is true, for every input depth image `i` also
///   `compare_i(uv: vec2f, layer: i32, depth: f32) -> f32` and
///   `gather_compare_i(uv, layer, depth) -> vec4f`.
///
/// `compare_i` returns the comparison sampler's linear blend of the 2x2 results of
/// `depth <= stored` around `uv` (0..=1, origin top left, clamped to the edge). `gather_compare_i`
/// returns those four results in the order of `textureGatherCompare`.
pub trait Kernel: Any + Debug + Send + Sync {
    /// Returns the WGSL modules in order; the last one contains the entry function.
    fn modules(&self) -> Vec<Module>;
    /// Returns the uniform struct. `None` for kernels without uniforms, whose WGSL half has no
    /// `kernel`.
    fn uniforms(&self) -> Option<&dyn UniformBlock> {
        None
    }
    /// Returns whether the WGSL half uses the comparison sampler.
    fn compares(&self) -> bool {
        false
    }
    /// Returns whether the WGSL half requires triangle ids.
    fn needs_triangles(&self) -> bool {
        false
    }
}

/// A kernel that computes the visibility of the light, 0..=1, at visible points. Its WGSL entry is
/// `fn receive(r: Receiver) -> f32`.
pub trait ReceiveKernel: Kernel {
    /// Runs the Rust half: writes the visibility 0..=1 of each entry of the span to `out`, which
    /// has the same length.
    fn receive(&self, inputs: &Inputs<'_>, span: &Span<'_>, out: &mut [f32]);

    /// Returns whether the GPU backend computes masks in compute passes instead of drawing them.
    /// Return true for kernels with long loops over tables, such as rays: some devices have far
    /// fewer units for fragments than for compute. Results are the same. Forward shading calls the
    /// WGSL half in fragment shaders in any case.
    fn in_compute(&self) -> bool {
        false
    }

    /// Returns the visibility of all receivers of an image at once, equal to that of
    /// [`receive`](Self::receive), and 1 for pixels that don't receive. `None` if this is no faster
    /// than `receive` for each span.
    fn receive_all(&self, simd: Simd, receivers: &Receivers) -> Option<Vec<f32>> {
        let _ = (simd, receivers);
        None
    }
}

/// A kernel that computes an image from images of any size. Its WGSL entry is
/// `fn filter_texel(texel: vec2i, layer: i32) -> vec4f`, called for each texel, or that of
/// [`tile`](Self::tile), called for each tile of texels.
pub trait FilterKernel: Kernel {
    /// Runs the Rust half: writes one row of the output, channels interleaved. `start` is the row's
    /// first texel.
    fn filter(&self, inputs: &Inputs<'_>, start: UVec2, layer: u32, out: &mut [f32]);

    /// Writes consecutive rows of the output of `row_len` floats each, equal to those of
    /// [`filter`](Self::filter). `first` is the first row. Kernels whose rows share work override
    /// it.
    fn filter_rows(
        &self,
        inputs: &Inputs<'_>,
        first: u32,
        layer: u32,
        row_len: usize,
        out: &mut [f32],
    ) {
        for (y, row) in (first..).zip(out.chunks_exact_mut(row_len)) {
            self.filter(inputs, UVec2::new(0, y), layer, row);
        }
    }

    /// Returns the size in texels of the tiles that compute workgroups write. `None` for kernels
    /// whose WGSL half is `filter_texel`.
    ///
    /// With a tile the WGSL entry is `fn filter_tile(tile: vec2i, layer: i32, lane: vec2i)`. All
    /// 8 x 8 invocations of a workgroup call it in uniform control flow, so it may have workgroup
    /// variables (at most 16,352 bytes) and barriers. `tile` is the tile's column and row, `lane`
    /// is 0..8 along each axis. It calls `store_texel(texel: vec2i, layer: i32, channels: vec4f)`,
    /// declared by the backend, for each texel of the tile that is within the output.
    fn tile(&self) -> Option<UVec2> {
        None
    }
}

/// A kernel that shades visible geometry. Its WGSL entry is
/// `fn shade(r: Receiver, visibility: f32) -> vec4f`; the result is linear, not sRGB-encoded.
pub trait ShadeKernel: Kernel {
    /// Runs the Rust half: writes the linear colour of each entry of the span, given the light's
    /// visibility (1 for entries that don't receive). Empty entries are discarded.
    fn shade(&self, span: &Span<'_>, visibility: &[f32], out: &mut [[f32; 4]]);
}

/// Inputs of a kernel's Rust half.
#[derive(Clone, Copy, Debug)]
pub struct Inputs<'a> {
    /// The stage's input images, in the recipe's order.
    pub images: &'a [ImageView<'a>],
    /// The instruction set for which loops are compiled.
    pub simd: Simd,
}
