//! Kernels: one function written twice. A kernel cannot exist on one side only, since its trait asks for both halves.

use crate::{
    gbuffer::receivers::{Receivers, Span},
    recipe::{
        image::ImageView,
        shader::{Module, UniformBlock},
        work::KernelCost,
    },
    simd::Simd,
};
use glam::{UVec2, Vec3};
use std::fmt::Debug;

/// The WGSL half, and what both halves share.
///
/// The player puts before the modules: [`MATH`](crate::MATH); `struct Receiver { position: vec3f, normal: vec3f, pixel:
/// vec2u, triangle: u32 }`; `var<uniform> kernel: NAME` with the uniform struct that the modules declare, if there is one;
/// for input image `i` the functions `load_i(texel: vec2i, layer: i32) -> vec4f` and `size_i() -> vec2i` (a function, so
/// that one compiled shader serves maps of all sizes); for input table `j` a `var<storage> table_j: array<vec4u>`. Texels
/// passed to `load_i` must lie within the image. If [`compares`](Kernel::compares) says so, then for every input image `i`
/// of depth also `compare_i(uv: vec2f, layer: i32, depth: f32) -> f32`, the comparison sampler's linear blend of the 2x2
/// answers to `depth <= stored` around `uv` (0..=1, origin top left, clamped to the edge), and `gather_compare_i(uv, layer,
/// depth) -> vec4f`, those four answers in the order of `textureGatherCompare`.
pub trait Kernel: Debug + Send + Sync {
    /// WGSL modules in order; the last one has the entry function.
    fn modules(&self) -> Vec<Module>;
    /// The uniform struct; `None` for kernels that read no uniforms, whose WGSL half has no `kernel` then.
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

/// A kernel that returns, for seen points, how much light arrives: visibility, 0..=1. Its WGSL entry is `fn receive(r:
/// Receiver) -> f32`.
pub trait ReceiveKernel: Kernel {
    /// The Rust half: visibility 0..=1 of each entry of the span, into `out` of the same length.
    fn receive(&self, inputs: &Inputs<'_>, span: &Span<'_>, out: &mut [f32]);

    /// Returns the visibility of all receivers of a picture at once, as [`receive`](Self::receive) has it of each, and 1 where a
    /// pixel doesn't receive. None: no way is quicker than asking span by span.
    fn receive_all(&self, simd: Simd, receivers: &Receivers) -> Option<Vec<f32>> {
        let _ = (simd, receivers);
        None
    }

    /// What it does for one receiver, at most: for [`Work`](crate::Work), which the price of a technique is made of.
    fn cost_per_receiver(&self) -> KernelCost {
        KernelCost::default()
    }

    /// The same for these receivers, where it depends on them.
    fn cost_for(&self, receivers: &Receivers) -> KernelCost {
        let _ = receivers;
        self.cost_per_receiver()
    }

    /// How many triangles its tables were made of, each as often as it stands in them: tables that follow the light or the casters
    /// are made anew with them, which costs about as much as drawing as many triangles.
    fn triangles_listed(&self) -> u64 {
        0
    }

    /// Whether it knows which part of a light with an extent the receiver's own tangent plane leaves, and answers that
    /// share where nothing casts. Kernels that don't take the light for its middle, or ask single points of it.
    fn knows_horizon(&self) -> bool {
        false
    }

    /// By how much that share may be wrong, where it is counted in points of the light.
    fn horizon_error(&self) -> f32 {
        0.0
    }

    /// How far, in texels, the lookup of a receiver at `position` (world space) with the unit `normal` goes beyond the
    /// point of the map on which it falls, where that differs from one receiver to the next. None: as far as
    /// [`ShadowTechnique::kernel_reach`](crate::ShadowTechnique::kernel_reach) says of all.
    fn reach(&self, _position: Vec3, _normal: Vec3) -> Option<f32> {
        None
    }

    /// In which layer of its map a receiver at `position` (world space) is looked up, where there are several. None: the layers are
    /// the faces of a cube, and it is that of the face in which the receiver lies.
    fn layer(&self, _position: Vec3) -> Option<u32> {
        None
    }
}

/// Makes an image from images of any size. Its WGSL entry is `fn filter_texel(texel: vec2i, layer: i32) -> vec4f`.
pub trait FilterKernel: Kernel {
    /// The Rust half: one row of the output, channels interleaved; `start` is the row's first texel.
    fn filter(&self, inputs: &Inputs<'_>, start: UVec2, layer: u32, out: &mut [f32]);

    /// How many texels it loads for each that it makes, for [`Work`](crate::Work). One is part of the price of any filter.
    fn loads_per_texel(&self) -> u32 {
        1
    }
}

/// Colours what is seen. Its WGSL entry is `fn shade(r: Receiver, visibility: f32) -> vec4f`; what it answers is linear, not
/// sRGB-encoded.
pub trait ShadeKernel: Kernel {
    /// The Rust half: the linear colour of each entry of the span, given the light's visibility there (1 where nothing
    /// receives). Entries that show nothing are thrown away.
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
