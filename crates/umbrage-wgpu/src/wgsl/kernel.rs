//! The interface of a kernel's WGSL half, and its declarations: the contract of [`Kernel`].

use crate::wgsl::resolver::with_prefix;
use std::fmt::Write as _;
use umbrage_core::{Format, ImageDesc, Invalid, Kernel, MATH, Recipe, join};

/// The part of a kernel's inputs that determines its shader text.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct KernelInterface {
    /// True if there are uniforms.
    pub(crate) uniforms: bool,
    pub(crate) images: Vec<InputImage>,
    /// Number of tables.
    pub(crate) tables: u32,
}

/// Access of a kernel's shader to one image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct InputImage {
    pub(crate) kind: InputKind,
    /// True if there are several layers.
    pub(crate) layered: bool,
}

/// Access to the texels of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum InputKind {
    /// Loaded floats, including depth.
    Floats,
    /// Loaded integers.
    Counts,
    /// Loaded words, of two channels each: [`Format::Rg16`] and [`Format::Rgba16`].
    Words,
    /// Depth, loaded and compared.
    Compared,
}

impl KernelInterface {
    /// Treats images that the recipe lacks as floats: recipes are validated elsewhere.
    pub(crate) fn new(
        recipe: &Recipe,
        kernel: &dyn Kernel,
        images: &[usize],
        tables: &[usize],
    ) -> Self {
        let compares = kernel.compares();
        let image = |&id: &usize| {
            let desc: Option<&ImageDesc> = recipe.images.get(id);
            InputImage {
                kind: InputKind::of_format(desc.map(|desc| desc.format), compares),
                layered: desc.is_some_and(|desc| desc.layers > 1),
            }
        };
        Self {
            uniforms: kernel.uniforms().is_some(),
            images: images.iter().map(image).collect(),
            tables: tables.len() as u32,
        }
    }

    /// Returns whether the kernel uses the comparison sampler.
    pub(crate) fn compares(&self) -> bool {
        let mut images = self.images.iter();
        images.any(|image| image.kind == InputKind::Compared)
    }
}

impl InputKind {
    fn of_format(format: Option<Format>, compares: bool) -> Self {
        match format {
            Some(Format::Stencil8) => Self::Counts,
            Some(Format::Rg16 | Format::Rgba16) => Self::Words,
            Some(format) if compares && format.is_depth() => Self::Compared,
            _ => Self::Floats,
        }
    }

    /// Returns a texel's channels, given the expression that loads it.
    fn channels(self, load: &str) -> String {
        match self {
            Self::Floats => load.to_owned(),
            Self::Counts => format!("vec4f(f32({load}.x), 0.0, 0.0, 0.0)"),
            // A texture of one word has 0 in the second. The bound changes nothing, but prevents
            // drivers from moving the factor out of differences of two channels, which would round
            // differently.
            Self::Words => format!(
                "min(vec4f(({load}.xxyy >> vec4u(0u, 16u, 0u, 16u)) & vec4u(0xffffu)) * (1.0 / 65535.0), vec4f(1.0))"
            ),
            Self::Compared => format!("vec4f({load}, 0.0, 0.0, 1.0)"),
        }
    }

    /// Returns the WGSL type of the texture.
    pub(crate) const fn texture_type(self, layered: bool) -> &'static str {
        match (self, layered) {
            (Self::Floats, false) => "texture_2d<f32>",
            (Self::Floats, true) => "texture_2d_array<f32>",
            (Self::Counts | Self::Words, false) => "texture_2d<u32>",
            (Self::Counts | Self::Words, true) => "texture_2d_array<u32>",
            (Self::Compared, false) => "texture_depth_2d",
            (Self::Compared, true) => "texture_depth_2d_array",
        }
    }
}

/// Returns the receive stage of a recipe as WGSL to insert into your shader.
///
/// It defines `struct Receiver` and `fn receive(r: Receiver) -> f32` (visibility of the light,
/// 0..=1). Call it with your positions and normals (world space). Its bindings are in bind group
/// `group`: bind [`ShadowRenderer::receive_bind_group`](crate::ShadowRenderer::receive_bind_group)
/// there. The entries are uniforms, images, tables and possibly a comparison sampler, as declared
/// in the text.
///
/// `prefix` is prepended to every name that the text declares: with `"sun_"` call
/// `sun_receive(sun_Receiver(..))`. The texts of several lights thus fit into one shader, each with
/// its own prefix and group. With `""` names are as given above.
///
/// # Errors
/// Errors if the prefix can't begin a WGSL identifier.
pub fn receive_wgsl(recipe: &Recipe, group: u32, prefix: &str) -> Result<String, Invalid> {
    let receive = &recipe.receive;
    let shape = KernelInterface::new(recipe, &*receive.kernel, &receive.inputs, &receive.tables);
    with_prefix(&kernel_wgsl(&*receive.kernel, &shape, group), prefix)
}

/// Returns the declarations of the contract, as bindings of one group, then the kernel's modules.
pub(crate) fn kernel_wgsl(kernel: &dyn Kernel, shape: &KernelInterface, group: u32) -> String {
    let mut text = format!("// Made by umbrage.\n{}", include_str!("receiver.wgsl"));
    let mut bindings = 0..;
    let mut declare = |text: &mut String, variable: &str| {
        let binding = bindings.next().unwrap_or(0);
        let _ = writeln!(text, "@group({group}) @binding({binding}) {variable};");
    };
    if let Some(block) = kernel.uniforms() {
        let name = block.uniform_layout().name;
        declare(&mut text, &format!("var<uniform> kernel: {name}"));
    }
    for (i, &InputImage { kind, layered }) in shape.images.iter().enumerate() {
        let ty = kind.texture_type(layered);
        declare(&mut text, &format!("var image_{i}: {ty}"));
        let texture = ImageSource {
            number: 0,
            name: format!("image_{i}"),
            layer: if layered { " layer," } else { "" }.to_owned(),
        };
        text += &image_functions(i, kind, &[texture], "umbrage_comparison", "");
    }
    for j in 0..shape.tables {
        declare(&mut text, &format!("var<storage> table_{j}: array<vec4u>"));
    }
    if shape.compares() {
        declare(&mut text, "var umbrage_comparison: sampler_comparison");
    }
    text + &join(&[MATH]) + &join(&kernel.modules())
}

/// A texture that may contain a kernel's image.
pub(crate) struct ImageSource {
    pub(crate) number: usize,
    pub(crate) name: String,
    /// The layer as an argument, ` layer,`; empty if there is only one.
    pub(crate) layer: String,
}

/// Returns the functions with which a kernel reads image `i`. If several textures may contain it,
/// they read the one whose number is the value of the expression `choice`.
pub(crate) fn image_functions(
    i: usize,
    kind: InputKind,
    textures: &[ImageSource],
    sampler: &str,
    choice: &str,
) -> String {
    let mut text = String::new();
    let mut add = |head: &str, none: &str, read: &dyn Fn(&str, &str) -> String| {
        let read = |source: &ImageSource| read(&source.name, &source.layer);
        let _ = match textures {
            [] => writeln!(text, "fn {head} {{ return {none}; }}"),
            // Omit the switch for one texture: shaders would execute it for every sample.
            [only] => writeln!(text, "fn {head} {{ return {}; }}", read(only)),
            several => {
                let case =
                    |s: &ImageSource| format!(" case {}u: {{ return {}; }}", s.number, read(s));
                let cases: String = several.iter().map(case).collect();
                writeln!(
                    text,
                    "fn {head} {{\n    switch {choice} {{{cases} default: {{ return {none}; }} }}\n}}"
                )
            }
        };
    };
    // Define the expressions that access a texture.
    let load =
        |name: &str, layer: &str| kind.channels(&format!("textureLoad({name}, texel,{layer} 0)"));
    let size = |name: &str, _: &str| format!("vec2i(textureDimensions({name}))");
    let arguments = |name: &str, layer: &str| format!("({name}, {sampler}, uv,{layer} depth)");
    let compare =
        |name: &str, layer: &str| format!("textureSampleCompareLevel{}", arguments(name, layer));
    let gather =
        |name: &str, layer: &str| format!("textureGatherCompare{}", arguments(name, layer));
    // Declare the functions.
    add(
        &format!("load_{i}(texel: vec2i, layer: i32) -> vec4f"),
        "vec4f()",
        &load,
    );
    add(&format!("size_{i}() -> vec2i"), "vec2i()", &size);
    if kind == InputKind::Compared {
        let lookup = "(uv: vec2f, layer: i32, depth: f32)";
        add(&format!("compare_{i}{lookup} -> f32"), "1.0", &compare);
        add(
            &format!("gather_compare_{i}{lookup} -> vec4f"),
            "vec4f(1.0)",
            &gather,
        );
    }
    text
}
