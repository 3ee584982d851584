//! Minimal kernels that use every feature of kernels.

use glam::{Mat4, UVec2, Vec4};
use umbrage_core::{FilterKernel, Inputs, Module, ReceiveKernel, Span, math::transform, uniforms};

uniforms! {
    /// Uniforms of all kernels here.
    pub struct Numbers {
        /// Transform from world to the light's clip space.
        pub clip_from_world: Mat4,
        /// Kernel-specific numbers.
        pub numbers: Vec4,
    }
}

pub(crate) const STRUCT: Module = Module {
    name: "numbers",
    text: "struct Numbers { clip_from_world: mat4x4f, numbers: vec4f }\n",
};

macro_rules! kernel {
    ($name:ident, $text:expr $(, compares $compares:literal)?) => {
        #[derive(Clone, Copy, Debug)]
        pub(crate) struct $name(pub(crate) $crate::kernels::Numbers);

        impl umbrage_core::Kernel for $name {
            fn modules(&self) -> Vec<umbrage_core::Module> {
                vec![$crate::kernels::STRUCT, umbrage_core::Module { name: stringify!($name), text: $text }]
            }

            fn uniforms(&self) -> Option<&dyn umbrage_core::UniformBlock> {
                Some(&self.0)
            }

            $(fn compares(&self) -> bool {
                $compares
            })?
        }
    };
}
pub(crate) use kernel;

kernel!(
    Compare,
    "fn receive(r: Receiver) -> f32 {
        let clip = transform(kernel.clip_from_world, r.position);
        let size = vec2f(size_0());
        let x = i32(floor((clip.x * 0.5 + 0.5) * size.x));
        let y = i32(floor((0.5 - clip.y * 0.5) * size.y));
        return select(0.0, 1.0, clip.z - kernel.numbers.x <= load_0(vec2i(x, y), 0).x);
    }"
);

/// Orthographic lookup of one texel, with bias `numbers.x`. Receivers must be on the map.
impl ReceiveKernel for Compare {
    fn receive(&self, inputs: &Inputs<'_>, span: &Span<'_>, out: &mut [f32]) {
        let map = inputs.images[0];
        for (i, out) in out.iter_mut().enumerate() {
            let clip = transform(self.0.clip_from_world, span.position(i));
            let size = map.desc.size.as_vec2();
            let x = (clip.x * 0.5 + 0.5) * size.x;
            let y = (0.5 - clip.y * 0.5) * size.y;
            let stored = map.load(x.floor() as i32, y.floor() as i32, 0);
            *out = f32::from(u8::from(clip.z - self.0.numbers.x <= stored));
        }
    }
}

kernel!(
    Everything,
    "fn receive(r: Receiver) -> f32 {
        let row = table_0[r.triangle];
        let layer = i32(kernel.numbers.x);
        let texel = load_0(vec2i(r.pixel) % size_0(), layer);
        return texel.z + f32(row.y) + r.normal.y * 100.0 + f32(r.pixel.x) * 1000.0;
    }"
);

/// Reads a layered image, a table, pixel, normal and triangle, so that a mistake in any of them
/// changes the sum.
impl ReceiveKernel for Everything {
    fn receive(&self, _: &Inputs<'_>, _: &Span<'_>, out: &mut [f32]) {
        out.fill(0.0);
    }
}

kernel!(
    Paint,
    "fn filter_texel(texel: vec2i, layer: i32) -> vec4f {
        return vec4f(f32(texel.x), f32(texel.y), f32(layer), 1.0) * kernel.numbers.x;
    }"
);

impl FilterKernel for Paint {
    fn filter(&self, inputs: &Inputs<'_>, start: UVec2, layer: u32, out: &mut [f32]) {
        assert!(inputs.images.is_empty(), "it paints from nothing");
        for (i, texel) in out.chunks_exact_mut(4).enumerate() {
            let v = Vec4::new(
                (start.x as usize + i) as f32,
                start.y as f32,
                layer as f32,
                1.0,
            );
            texel.copy_from_slice(&(v * self.0.numbers.x).to_array());
        }
    }
}

kernel!(
    Halve,
    "fn filter_texel(texel: vec2i, layer: i32) -> vec4f {
        return load_0(texel, layer) * 0.5;
    }"
);

impl FilterKernel for Halve {
    fn filter(&self, inputs: &Inputs<'_>, start: UVec2, layer: u32, out: &mut [f32]) {
        let first = inputs.images[0].index(start.x as i32, start.y as i32, layer);
        out.iter_mut()
            .zip(&inputs.images[0].texels[first..])
            .for_each(|(to, from)| *to = from * 0.5);
    }
}

kernel!(
    Same,
    "fn filter_texel(texel: vec2i, layer: i32) -> vec4f { return load_0(texel, layer); }"
);

/// Copies what a shader loads, in floats.
impl FilterKernel for Same {
    fn filter(&self, inputs: &Inputs<'_>, start: UVec2, layer: u32, out: &mut [f32]) {
        let first = inputs.images[0].index(start.x as i32, start.y as i32, layer);
        out.copy_from_slice(&inputs.images[0].texels[first..][..out.len()]);
    }
}

kernel!(
    Broken,
    "fn receive(r: Receiver) -> f32 { return no_such_name; }"
);

impl ReceiveKernel for Broken {
    fn receive(&self, _: &Inputs<'_>, _: &Span<'_>, out: &mut [f32]) {
        out.fill(0.0);
    }
}

/// Runs the Rust half over all pixels; 1 for pixels that don't receive.
pub(crate) fn reference(
    kernel: &dyn ReceiveKernel,
    images: &[umbrage_core::Image],
    receivers: &umbrage_core::Receivers,
) -> Vec<f32> {
    let views: Vec<_> = images.iter().map(umbrage_core::Image::view).collect();
    let inputs = Inputs {
        images: &views,
        simd: umbrage_core::Simd::Native,
    };
    let width = receivers.size.x as usize;
    let mut mask = vec![1.0; receivers.len()];
    for (row, out) in mask.chunks_exact_mut(width).enumerate() {
        kernel.receive(&inputs, &receivers.span(row * width, width), out);
    }
    for (value, receives) in mask.iter_mut().zip(&receivers.receives) {
        *value = if *receives { *value } else { 1.0 };
    }
    mask
}
