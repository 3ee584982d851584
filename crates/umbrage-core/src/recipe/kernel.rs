//! Kernels: one function written twice. A kernel cannot exist on one side only, since its trait
//! asks for both halves.

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

/// The WGSL half, and what both halves share.
///
/// The player puts before the modules: [`MATH`](crate::MATH); `struct Receiver { position: vec3f,
/// normal: vec3f, pixel: vec2u, triangle: u32 }`; `var<uniform> kernel: NAME` with the uniform
/// struct that the modules declare, if there is one; for input image `i` the functions
/// `load_i(texel: vec2i, layer: i32) -> vec4f` and `size_i() -> vec2i` (a function, so that one
/// compiled shader serves maps of all sizes); for input table `j` a
/// `var<storage> table_j: array<vec4u>`. Texels passed to `load_i` must lie within the image. If
/// [`compares`](Kernel::compares) says so, then for every input image `i` of depth also
/// `compare_i(uv: vec2f, layer: i32, depth: f32) -> f32`, the comparison sampler's linear blend of
/// the 2x2 answers to `depth <= stored` around `uv` (0..=1, origin top left, clamped to the edge),
/// and `gather_compare_i(uv, layer, depth) -> vec4f`, those four answers in the order of
/// `textureGatherCompare`.
pub trait Kernel: Any + Debug + Send + Sync {
    /// WGSL modules in order; the last one has the entry function.
    fn modules(&self) -> Vec<Module>;
    /// The uniform struct; `None` for kernels that read no uniforms, whose WGSL half has no
    /// `kernel` then.
    fn uniforms(&self) -> Option<&dyn UniformBlock> {
        None
    }
    /// Whether the WGSL half uses the comparison sampler.
    fn compares(&self) -> bool {
        false
    }
    /// Whether the WGSL half means nothing without triangle ids.
    fn needs_triangles(&self) -> bool {
        false
    }
}

/// A kernel that returns, for seen points, how much light arrives: visibility, 0..=1. Its WGSL
/// entry is `fn receive(r: Receiver) -> f32`.
pub trait ReceiveKernel: Kernel {
    /// The Rust half: visibility 0..=1 of each entry of the span, into `out` of the same length.
    fn receive(&self, inputs: &Inputs<'_>, span: &Span<'_>, out: &mut [f32]);

    /// Returns the visibility of all receivers of a picture at once, as [`receive`](Self::receive)
    /// has it of each, and 1 where a pixel doesn't receive. None: no way is quicker than asking
    /// span by span.
    fn receive_all(&self, simd: Simd, receivers: &Receivers) -> Option<Vec<f32>> {
        let _ = (simd, receivers);
        None
    }
}

/// Makes an image from images of any size. Its WGSL entry is
/// `fn filter_texel(texel: vec2i, layer: i32) -> vec4f`.
pub trait FilterKernel: Kernel {
    /// The Rust half: one row of the output, channels interleaved; `start` is the row's first
    /// texel.
    fn filter(&self, inputs: &Inputs<'_>, start: UVec2, layer: u32, out: &mut [f32]);
}

/// Colours what is seen. Its WGSL entry is `fn shade(r: Receiver, visibility: f32) -> vec4f`; what
/// it answers is linear, not sRGB-encoded.
pub trait ShadeKernel: Kernel {
    /// The Rust half: the linear colour of each entry of the span, given the light's visibility
    /// there (1 where nothing receives). Entries that show nothing are thrown away.
    fn shade(&self, span: &Span<'_>, visibility: &[f32], out: &mut [[f32; 4]]);
}

/// What a kernel's Rust half may read.
#[derive(Clone, Copy, Debug)]
pub struct Inputs<'a> {
    /// The stage's input images, in the recipe's order.
    pub images: &'a [ImageView<'a>],
    /// The instructions that loops are to be compiled for.
    pub simd: Simd,
}
