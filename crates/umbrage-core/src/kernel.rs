//! Kernels: one function written twice. A kernel cannot exist on one side only, since its trait asks for both halves.

use crate::{ImageView, Module, Simd, Span, UniformLayout};
use glam::UVec2;
use std::fmt::Debug;

/// The WGSL half, and what both halves share.
///
/// The player puts before the modules: [`MATH`](crate::MATH); `struct Receiver { position: vec3f, normal: vec3f, pixel: vec2u,
/// triangle: u32 }`; `var<uniform> kernel: NAME` with the uniform struct that the modules declare; for input image `i` the
/// functions `load_i(texel: vec2i, layer: i32) -> vec4f` and `size_i() -> vec2i` (a function, so that one compiled shader
/// serves maps of all sizes); for input table `j` a `var<storage> table_j: array<vec4u>`. Texels passed to `load_i` must
/// lie within the image.
pub trait Kernel: Debug + Send + Sync {
    /// WGSL modules in order; the last one has the entry function.
    fn modules(&self) -> Vec<Module>;
    /// The uniform struct's bytes ([`Uniforms::to_bytes`](crate::Uniforms::to_bytes)).
    fn uniform_bytes(&self) -> Vec<u8>;
    /// The uniform struct's layout.
    fn layout(&self) -> UniformLayout;
}

/// Asks, for seen points, how much light arrives. Its WGSL entry is `fn receive(r: Receiver) -> f32`.
pub trait ReceiveKernel: Kernel {
    /// The Rust half: visibility 0..=1 of each entry of the span, into `out` of the same length.
    fn receive(&self, inputs: &Inputs<'_>, span: &Span<'_>, out: &mut [f32]);
}

/// Makes an image from images of any size. Its WGSL entry is `fn filter_texel(texel: vec2i, layer: i32) -> vec4f`.
pub trait FilterKernel: Kernel {
    /// The Rust half: one row of the output, channels interleaved; `start` is the row's first texel.
    fn filter(&self, inputs: &Inputs<'_>, start: UVec2, layer: u32, out: &mut [f32]);
}

/// What a kernel's Rust half may read.
#[derive(Clone, Copy, Debug)]
pub struct Inputs<'a> {
    /// The stage's input images, in the recipe's order.
    pub images: &'a [ImageView<'a>],
    /// The instructions that loops are to be compiled for.
    pub simd: Simd,
}
