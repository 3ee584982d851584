//! The WGSL that stands before and after a kernel's modules: the contract of [`Kernel`](umbrage_core::Kernel).

use crate::prefix::with_prefix;
use umbrage_core::{Format, Invalid, Kernel, MATH, Recipe, join};

/// What a kernel reads, as far as its shader text shows it.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct KernelInterface {
    /// Whether there are uniforms.
    pub(crate) uniforms: bool,
    /// For each image, what it is read as, and whether it has several layers.
    pub(crate) images: Vec<(InputKind, bool)>,
    /// How many tables.
    pub(crate) tables: u32,
}

/// What an image is read as.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum InputKind {
    /// Loaded, depth among them.
    Floats,
    /// Loaded whole numbers.
    Counts,
    /// Depth, loaded and compared.
    Compared,
}

impl KernelInterface {
    pub(crate) fn new(
        recipe: &Recipe,
        kernel: &dyn Kernel,
        images: &[usize],
        tables: &[usize],
    ) -> Self {
        let compares = kernel.compares();
        let kind = |format: Format| match format {
            Format::Stencil8 => InputKind::Counts,
            _ if compares && format.is_depth() => InputKind::Compared,
            _ => InputKind::Floats,
        };
        let read = |&i: &usize| {
            recipe
                .images
                .get(i)
                .map_or((InputKind::Floats, false), |d| {
                    (kind(d.format), d.layers > 1)
                })
        };
        Self {
            uniforms: kernel.uniforms().is_some(),
            images: images.iter().map(read).collect(),
            tables: tables.len() as u32,
        }
    }

    /// Whether it reads through the comparison sampler.
    pub(crate) fn compares(&self) -> bool {
        self.images
            .iter()
            .any(|&(kind, _)| kind == InputKind::Compared)
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

/// Returns the receive stage of a recipe as WGSL to paste into your own shader.
///
/// It defines `struct Receiver` and `fn receive(r: Receiver) -> f32` (visibility of the light, 0..=1), which you call with your
/// own positions and normals (world space). What it reads is in bind group `group`: bind
/// [`ShadowRenderer::receive_bind_group`](crate::ShadowRenderer::receive_bind_group) there; its entries, uniforms, images,
/// tables and perhaps a comparison sampler, are as the text declares them.
///
/// `prefix` stands before every name that the text declares: with `"sun_"` call `sun_receive(sun_Receiver(..))`. So the texts of
/// several lights fit into one shader, each with a prefix and a group of its own. With `""` names are as said above.
///
/// # Errors
/// Errors if the prefix can't begin a WGSL identifier.
pub fn receive_wgsl(recipe: &Recipe, group: u32, prefix: &str) -> Result<String, Invalid> {
    let receive = &recipe.receive;
    let shape = KernelInterface::new(recipe, &*receive.kernel, &receive.inputs, &receive.tables);
    with_prefix(&kernel_wgsl(&*receive.kernel, &shape, group), prefix)
}

/// The contract's names, then the kernel's modules.
pub(crate) fn kernel_wgsl(kernel: &dyn Kernel, shape: &KernelInterface, group: u32) -> String {
    let mut text = format!("// Made by umbrage.\n{RECEIVER}");
    let uniforms = kernel.uniforms().map(|block| block.uniform_layout().name);
    declare(&mut text, uniforms, shape, group);
    text + &join(&[MATH]) + &join(&kernel.modules())
}

fn declare(text: &mut String, uniforms: Option<&str>, shape: &KernelInterface, group: u32) {
    let mut binding = 0;
    let mut declare = |text: &mut String, what: &str| {
        text.push_str(&format!("@group({group}) @binding({binding}) {what};\n"));
        binding += 1;
    };
    if let Some(uniforms) = uniforms {
        declare(text, &format!("var<uniform> kernel: {uniforms}"));
    }
    for (i, &(kind, layered)) in shape.images.iter().enumerate() {
        declare(
            text,
            &format!("var image_{i}: {}", texture_type(kind, layered)),
        );
        text.push_str(&image_functions(i, kind, layered));
    }
    (0..shape.tables).for_each(|j| declare(text, &format!("var<storage> table_{j}: array<vec4u>")));
    if shape.compares() {
        declare(text, "var umbrage_comparison: sampler_comparison");
    }
}

const fn texture_type(kind: InputKind, layered: bool) -> &'static str {
    match (kind, layered) {
        (InputKind::Floats, false) => "texture_2d<f32>",
        (InputKind::Floats, true) => "texture_2d_array<f32>",
        (InputKind::Counts, false) => "texture_2d<u32>",
        (InputKind::Counts, true) => "texture_2d_array<u32>",
        (InputKind::Compared, false) => "texture_depth_2d",
        (InputKind::Compared, true) => "texture_depth_2d_array",
    }
}

/// How a kernel reads image `i`.
fn image_functions(i: usize, kind: InputKind, layered: bool) -> String {
    let layer = if layered { " layer," } else { "" };
    let load = format!("textureLoad(image_{i}, texel,{layer} 0)");
    let texel = match kind {
        InputKind::Floats => load,
        InputKind::Counts => format!("vec4f(f32({load}.x), 0.0, 0.0, 0.0)"),
        InputKind::Compared => format!("vec4f({load}, 0.0, 0.0, 1.0)"),
    };
    let text = format!(
        "fn load_{i}(texel: vec2i, layer: i32) -> vec4f {{ return {texel}; }}
fn size_{i}() -> vec2i {{ return vec2i(textureDimensions(image_{i})); }}
"
    );
    if kind != InputKind::Compared {
        return text;
    }
    let arguments = format!("(image_{i}, umbrage_comparison, uv,{layer} depth)");
    text + &format!(
        "fn compare_{i}(uv: vec2f, layer: i32, depth: f32) -> f32 {{ return textureSampleCompareLevel{arguments}; }}
fn gather_compare_{i}(uv: vec2f, layer: i32, depth: f32) -> vec4f {{ return textureGatherCompare{arguments}; }}
"
    )
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

/// A whole shader that colours what shows a triangle; the mask is the last thing in `gbuffer_group`. Where a ray ran
/// along its triangle's plane, nothing is seen though there is an id: the normal is zero.
pub(crate) fn shade_shader(kernel: &str, gbuffer_group: u32) -> String {
    let g = gbuffer_group;
    format!(
        "{kernel}// ---- the player's entry points
@group({g}) @binding(0) var umbrage_position: texture_2d<f32>;
@group({g}) @binding(1) var umbrage_normal: texture_2d<f32>;
@group({g}) @binding(2) var umbrage_triangle: texture_2d<u32>;
@group({g}) @binding(3) var umbrage_mask: texture_2d<f32>;
{FULLSCREEN}
@fragment fn umbrage_shade(@builtin(position) at: vec4f) -> @location(0) vec4f {{
    let at_texel = vec2i(at.xy);
    let triangle = textureLoad(umbrage_triangle, at_texel, 0).x;
    let normal = textureLoad(umbrage_normal, at_texel, 0).xyz;
    if triangle == 0xffffffffu || all(normal == vec3f()) {{
        discard;
    }}
    let position = textureLoad(umbrage_position, at_texel, 0).xyz;
    let visibility = textureLoad(umbrage_mask, at_texel, 0).x;
    return shade(Receiver(position, normal, vec2u(at_texel), triangle), visibility);
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
