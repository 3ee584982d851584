//! The WGSL that stands before and after a kernel's modules: the contract of [`Kernel`](umbrage_core::Kernel).

use std::fmt::Write;
use umbrage_core::{Kernel, MATH, Recipe, join};

/// What a kernel reads, as far as its shader text shows it.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Shape {
    /// For each image, whether it has several layers.
    pub(crate) layered: Vec<bool>,
    /// How many tables.
    pub(crate) tables: u32,
}

impl Shape {
    pub(crate) fn new(recipe: &Recipe, images: &[usize], tables: &[usize]) -> Self {
        let layered = images.iter().map(|&i| recipe.images.get(i).is_some_and(|image| image.layers > 1)).collect();
        Self { layered, tables: tables.len() as u32 }
    }
}

const RECEIVER: &str = "\
struct Receiver {
    position: vec3f,
    normal: vec3f,
    pixel: vec2u,
    triangle: u32,
}
";

/// The receive stage of a recipe as WGSL to paste into your own shader. It defines `struct Receiver` and
/// `fn receive(r: Receiver) -> f32` (visibility of the light, 0..=1), which you call with your own positions and normals.
/// What it reads is in bind group `group`: bind
/// [`ShadowRenderer::receive_bind_group`](crate::ShadowRenderer::receive_bind_group) there.
pub fn receive_wgsl(recipe: &Recipe, group: u32) -> String {
    let receive = &recipe.receive;
    let shape = Shape::new(recipe, &receive.inputs, &receive.tables);
    kernel_wgsl(&*receive.kernel, &shape, group)
}

/// The contract's names, then the kernel's modules.
pub(crate) fn kernel_wgsl(kernel: &dyn Kernel, shape: &Shape, group: u32) -> String {
    let mut text = format!("// Made by umbrage.\n{RECEIVER}");
    declare(&mut text, kernel.layout().name, shape, group);
    text + &join(&[MATH]) + &join(&kernel.modules())
}

fn declare(text: &mut String, uniforms: &str, shape: &Shape, group: u32) {
    let mut add = |line: std::fmt::Arguments<'_>| text.write_fmt(line).unwrap_or_default();
    add(format_args!("@group({group}) @binding(0) var<uniform> kernel: {uniforms};\n"));
    for (i, &layered) in shape.layered.iter().enumerate() {
        let (ty, layer) = if layered { ("texture_2d_array<f32>", " layer,") } else { ("texture_2d<f32>", "") };
        add(format_args!(
            "@group({group}) @binding({}) var image_{i}: {ty};\n\
             fn load_{i}(texel: vec2i, layer: i32) -> vec4f {{ return textureLoad(image_{i}, texel,{layer} 0); }}\n\
             fn size_{i}() -> vec2i {{ return vec2i(textureDimensions(image_{i})); }}\n",
            i + 1
        ));
    }
    for j in 0..shape.tables {
        let binding = 1 + shape.layered.len() + j as usize;
        add(format_args!("@group({group}) @binding({binding}) var<storage> table_{j}: array<vec4u>;\n"));
    }
}

/// A whole shader that answers for every pixel of the G-buffer in `gbuffer_group`.
pub(crate) fn receive_shader(kernel: &str, gbuffer_group: u32, triangles: bool) -> String {
    let g = gbuffer_group;
    let (declaration, load) = if triangles {
        (
            format!("@group({g}) @binding(2) var umbrage_triangle: texture_2d<u32>;\n"),
            "textureLoad(umbrage_triangle, at_texel, 0).x",
        )
    } else {
        (String::new(), "0xffffffffu")
    };
    format!(
        "{kernel}// ---- the player's entry points
@group({g}) @binding(0) var umbrage_position: texture_2d<f32>;
@group({g}) @binding(1) var umbrage_normal: texture_2d<f32>;
{declaration}
{FULLSCREEN}
@fragment fn umbrage_receive(@builtin(position) at: vec4f) -> @location(0) f32 {{
    let at_texel = vec2i(at.xy);
    let position = textureLoad(umbrage_position, at_texel, 0);
    if position.w == 0.0 {{
        return 1.0;
    }}
    let normal = textureLoad(umbrage_normal, at_texel, 0).xyz;
    return receive(Receiver(position.xyz, normal, vec2u(at_texel), {load}));
}}
"
    )
}

/// One triangle that covers the target.
pub(crate) const FULLSCREEN: &str = "\
@vertex fn umbrage_fullscreen(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
    return vec4f(f32(i32(i & 1u) * 4 - 1), f32(i32(i & 2u) * 2 - 1), 0.0, 1.0);
}
";

/// A whole shader that makes every texel of a layer; the layer is the instance.
pub(crate) fn filter_shader(kernel: &str) -> String {
    format!(
        "{kernel}// ---- the player's entry points
struct UmbrageTexel {{
    @builtin(position) at: vec4f,
    @location(0) @interpolate(flat) layer: u32,
}}
@vertex fn umbrage_fullscreen(@builtin(vertex_index) i: u32, @builtin(instance_index) layer: u32) -> UmbrageTexel {{
    return UmbrageTexel(vec4f(f32(i32(i & 1u) * 4 - 1), f32(i32(i & 2u) * 2 - 1), 0.0, 1.0), layer);
}}
@fragment fn umbrage_filter(texel: UmbrageTexel) -> @location(0) vec4f {{
    return filter_texel(vec2i(texel.at.xy), i32(texel.layer));
}}
"
    )
}
