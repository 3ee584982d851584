//! The WGSL that stands before and after a kernel's modules: the contract of [`Kernel`](umbrage_core::Kernel).

use crate::prefix::with_prefix;
use umbrage_core::{Format, ImageDesc, Invalid, Kernel, MATH, Recipe, join};

/// The part of a kernel's inputs that its shader text depends on.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct KernelInterface {
    /// Whether there are uniforms.
    pub(crate) uniforms: bool,
    pub(crate) images: Vec<InputImage>,
    /// Number of tables.
    pub(crate) tables: u32,
}

/// How a kernel's shader sees one image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct InputImage {
    pub(crate) kind: InputKind,
    /// Whether there are several layers.
    pub(crate) layered: bool,
}

/// What an image is read as.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum InputKind {
    /// Loaded, depth among them.
    Floats,
    /// Loaded whole numbers.
    Counts,
    /// Loaded words, of two channels each: [`Format::Rg16`] and [`Format::Rgba16`].
    Words,
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
        let images = images
            .iter()
            .map(|&id| InputImage::new(recipe.images.get(id), compares))
            .collect();
        Self {
            uniforms: kernel.uniforms().is_some(),
            images,
            tables: tables.len() as u32,
        }
    }

    /// Returns whether the kernel reads through the comparison sampler.
    pub(crate) fn compares(&self) -> bool {
        self.images
            .iter()
            .any(|image| image.kind == InputKind::Compared)
    }
}

impl InputImage {
    /// Returns how a kernel sees an image. An id that names none is taken for floats: recipes are validated elsewhere.
    fn new(desc: Option<&ImageDesc>, compares: bool) -> Self {
        let Some(desc) = desc else {
            return Self {
                kind: InputKind::Floats,
                layered: false,
            };
        };
        let kind = match desc.format {
            Format::Stencil8 => InputKind::Counts,
            Format::Rg16 | Format::Rgba16 => InputKind::Words,
            format if compares && format.is_depth() => InputKind::Compared,
            _ => InputKind::Floats,
        };
        Self {
            kind,
            layered: desc.layers > 1,
        }
    }
}

impl InputKind {
    /// Returns a texel's channels, given the expression that loads it.
    pub(crate) fn channels(self, load: &str) -> String {
        match self {
            Self::Floats => load.to_owned(),
            Self::Counts => format!("vec4f(f32({load}.x), 0.0, 0.0, 0.0)"),
            // A texture of one word has 0 in the second. The bound changes nothing, but keeps drivers from taking the factor out of
            // differences of two channels, which would round otherwise.
            Self::Words => format!(
                "min(vec4f(({load}.xxyy >> vec4u(0u, 16u, 0u, 16u)) & vec4u(0xffffu)) * (1.0 / 65535.0), vec4f(1.0))"
            ),
            Self::Compared => format!("vec4f({load}, 0.0, 0.0, 1.0)"),
        }
    }
}

pub(crate) const RECEIVER: &str = "\
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

/// Returns the declarations that the contract names, then the kernel's modules.
pub(crate) fn kernel_wgsl(kernel: &dyn Kernel, shape: &KernelInterface, group: u32) -> String {
    let mut text = format!("// Made by umbrage.\n{RECEIVER}");
    let uniforms = kernel.uniforms().map(|block| block.uniform_layout().name);
    declare_inputs(&mut text, uniforms, shape, group);
    text + &join(&[MATH]) + &join(&kernel.modules())
}

/// Appends the declarations of all that a kernel reads; `uniforms` is the type of its uniform block.
fn declare_inputs(text: &mut String, uniforms: Option<&str>, shape: &KernelInterface, group: u32) {
    let mut declarations = Declarations {
        text,
        group,
        binding: 0,
    };
    if let Some(uniforms) = uniforms {
        declarations.add(&format!("var<uniform> kernel: {uniforms}"));
    }
    for (i, &image) in shape.images.iter().enumerate() {
        declarations.add(&format!("var image_{i}: {}", texture_type(image)));
        declarations.text.push_str(&image_functions(i, image));
    }
    for j in 0..shape.tables {
        declarations.add(&format!("var<storage> table_{j}: array<vec4u>"));
    }
    if shape.compares() {
        declarations.add("var umbrage_comparison: sampler_comparison");
    }
}

/// Module-scope variables at consecutive bindings of one group.
struct Declarations<'a> {
    text: &'a mut String,
    group: u32,
    /// The next declaration's binding.
    binding: u32,
}

impl Declarations<'_> {
    fn add(&mut self, variable: &str) {
        let group = self.group;
        let binding = self.binding;
        let line = format!("@group({group}) @binding({binding}) {variable};\n");
        self.text.push_str(&line);
        self.binding += 1;
    }
}

const fn texture_type(image: InputImage) -> &'static str {
    match (image.kind, image.layered) {
        (InputKind::Floats, false) => "texture_2d<f32>",
        (InputKind::Floats, true) => "texture_2d_array<f32>",
        (InputKind::Counts | InputKind::Words, false) => "texture_2d<u32>",
        (InputKind::Counts | InputKind::Words, true) => "texture_2d_array<u32>",
        (InputKind::Compared, false) => "texture_depth_2d",
        (InputKind::Compared, true) => "texture_depth_2d_array",
    }
}

/// Returns the functions with which a kernel reads image `i`.
fn image_functions(i: usize, image: InputImage) -> String {
    let layer = if image.layered { " layer," } else { "" };
    let load = format!("textureLoad(image_{i}, texel,{layer} 0)");
    let texel = image.kind.channels(&load);
    let text = format!(
        "fn load_{i}(texel: vec2i, layer: i32) -> vec4f {{ return {texel}; }}
fn size_{i}() -> vec2i {{ return vec2i(textureDimensions(image_{i})); }}
"
    );
    if image.kind != InputKind::Compared {
        return text;
    }
    let arguments = format!("(image_{i}, umbrage_comparison, uv,{layer} depth)");
    text + &format!(
        "fn compare_{i}(uv: vec2f, layer: i32, depth: f32) -> f32 {{ return textureSampleCompareLevel{arguments}; }}
fn gather_compare_{i}(uv: vec2f, layer: i32, depth: f32) -> vec4f {{ return textureGatherCompare{arguments}; }}
"
    )
}

/// Returns a whole shader that calls the receive kernel for every pixel of the G-buffer in `gbuffer_group`; `triangles` says
/// whether that holds triangle ids.
pub(crate) fn receive_shader(kernel: &str, gbuffer_group: u32, triangles: bool) -> String {
    let g = gbuffer_group;
    let mut declaration = String::new();
    // NO_TRIANGLE.
    let mut load = "0xffffffffu";
    if triangles {
        declaration = format!("@group({g}) @binding(2) var umbrage_triangle: texture_2d<u32>;\n");
        load = "textureLoad(umbrage_triangle, at_texel, 0).x";
    }
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

/// Returns a whole shader that colours the pixels that show a triangle; the mask is the last binding of `gbuffer_group`. Where
/// a ray ran along its triangle's plane, nothing is seen though there is an id: the normal is zero.
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

/// Vertex shader of one triangle that covers the target.
pub(crate) const FULLSCREEN: &str = "\
@vertex fn umbrage_fullscreen(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
    return vec4f(f32(i32(i & 1u) * 4 - 1), f32(i32(i & 2u) * 2 - 1), 0.0, 1.0);
}
";

/// Returns a whole shader that makes every texel of a layer of an image; the instance index is the layer.
pub(crate) fn filter_shader(kernel: &str, output: Format) -> String {
    let in_words = matches!(output, Format::Rg16 | Format::Rgba16);
    let (kind, stored) = if in_words {
        ("vec2u", "umbrage_words(made)")
    } else {
        ("vec4f", "made")
    };
    let words = if in_words { WORDS } else { "" };
    format!(
        "{kernel}// ---- the player's entry points
struct UmbrageTexel {{
    @builtin(position) at: vec4f,
    @location(0) @interpolate(flat) layer: u32,
}}
@vertex fn umbrage_fullscreen(@builtin(vertex_index) i: u32, @builtin(instance_index) layer: u32) -> UmbrageTexel {{
    return UmbrageTexel(vec4f(f32(i32(i & 1u) * 4 - 1), f32(i32(i & 2u) * 2 - 1), 0.0, 1.0), layer);
}}
{words}@fragment fn umbrage_filter(texel: UmbrageTexel) -> @location(0) {kind} {{
    let made = filter_texel(vec2i(texel.at.xy), i32(texel.layer));
    return {stored};
}}
"
    )
}

/// Puts channels into words of two, each as the nearest of 65536 steps from 0 to 1. WGSL's `pack2x16unorm` would leave halves to drivers.
const WORDS: &str = "\
fn umbrage_words(channels: vec4f) -> vec2u {
    let steps = vec4u(floor(min(max(channels, vec4f(0.0)), vec4f(1.0)) * 65535.0 + 0.5));
    return steps.xz | (steps.yw << vec2u(16u));
}
";
