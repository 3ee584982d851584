//! The WGSL of a light set: each kind of kernel once, and `shadow`, which picks a light's.
//!
//! Kernels are written for one light: uniforms `kernel`, tables `table_0` and so on, images behind `load_0` and so on. Here the same texts
//! read what belongs to the light that is asked for: `kernel` becomes an element of an array, tables become parts of one table, and
//! images become layers of arrays. All arrays are in one uniform buffer as long as it holds them: with several, programs that have a
//! few uniform buffers of their own would crash Mesa's lavapipe 22.3, which writes beyond an array where a branch depends on the
//! fourth one of a shader or a later one.

use crate::{
    light_set::buffers::{LightNumbers, NumberSpace},
    prefix::with_prefix,
    tokens::{Token, tokens},
    wgsl::{InputImage, InputKind, KernelInterface, RECEIVER},
};
use std::fmt::Write as _;
use umbrage_core::{Invalid, MATH, Module, join};

/// Most images of a kernel.
pub(crate) const MAX_IMAGES: usize = 4;
/// Most tables of a kernel.
pub(crate) const MAX_TABLES: usize = 5;
/// Most images of a kernel with all tables: the last one's place is where those of further images are.
pub(crate) const MAX_IMAGES_BESIDE_ALL_TABLES: usize = 1;

/// A kernel's WGSL half, and what it needs to be bound: lights of one kind differ in numbers alone.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct KernelKind {
    pub(crate) modules: Vec<Module>,
    /// The uniform struct's name in WGSL, and its size in bytes.
    pub(crate) uniforms: Option<(&'static str, u64)>,
    pub(crate) shape: KernelInterface,
}

/// A texture binding of the set: a class of layers, as some kernels read it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct MapBinding {
    pub(crate) class: usize,
    pub(crate) kind: InputKind,
}

/// What the text of a set is made of.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TextParts<'a> {
    pub(crate) group: u32,
    pub(crate) kinds: &'a [KernelKind],
    pub(crate) numbers: &'a LightNumbers,
    pub(crate) maps: &'a [MapBinding],
    /// For each kind, and in it for each image, the classes (indices of `maps`) in which its lights have layers.
    pub(crate) classes: &'a [Vec<Vec<usize>>],
}

/// Binding of the lights' numbers.
pub(crate) const NUMBERS: u32 = 0;
/// Binding of all tables.
pub(crate) const TABLES: u32 = 1;
/// Binding of the first texture.
pub(crate) const FIRST_MAP: u32 = 2;

/// Declares a light's entry; `LightEntry` is its twin. What every lookup reads is in one word: drivers that run on the CPU read each
/// word of each light for itself.
const ENTRY: &str = "\
struct ShadowLight {
    // x: the kind of kernel, counted from 1 (bits 0 to 7; 0: the light is not served, so it is lit), index of the kernel's uniforms (8
    // to 19), and first layer of image 0 (20 to 31). y: index of each image's texture, 8 bits each. z, w: first layers of images 1, 2
    // (16 bits each) and 3; where there is a fifth table, its number of rows, and its first row.
    places: vec4u,
    // Each of the first four tables' first row.
    rows: vec4u,
    // And their numbers of rows.
    row_counts: vec4u,
}
";
/// The entry of the light that is asked for.
const OF_LIGHT: &str = "shadow_set.lights[shadow_index]";

impl TextParts<'_> {
    /// Returns the text: `fn shadow(light: u32, position: vec3f, normal: vec3f, pixel: vec2u) -> f32` and all that it calls.
    ///
    /// Errors if a kernel's names can't take a prefix.
    pub(crate) fn text(&self) -> Result<String, Invalid> {
        let group = self.group;
        let mut text = format!("// Made by umbrage: a set of lights.\n{RECEIVER}{ENTRY}");
        text += &self.numbers_text();
        let _ = writeln!(
            text,
            "@group({group}) @binding({TABLES}) var<storage> shadow_tables: array<vec4u>;
var<private> shadow_index: u32;"
        );
        let mut binding = FIRST_MAP;
        for (i, map) in self.maps.iter().enumerate() {
            let ty = array_type(map.kind);
            let _ = writeln!(
                text,
                "@group({group}) @binding({binding}) var shadow_maps_{i}: {ty};"
            );
            binding += 1;
        }
        if self.compares() {
            let _ = writeln!(
                text,
                "@group({group}) @binding({binding}) var shadow_comparison: sampler_comparison;"
            );
        }
        for index in 0..self.kinds.len() {
            text += &self.kind_text(index)?;
        }
        Ok(text + &self.entry_points())
    }

    /// Returns whether a kernel reads through the comparison sampler.
    pub(crate) fn compares(&self) -> bool {
        self.maps.iter().any(|map| map.kind == InputKind::Compared)
    }

    /// Returns the declaration of the lights' numbers.
    fn numbers_text(&self) -> String {
        let mut records = String::new();
        let mut fields = String::new();
        for (i, (kind, list)) in self.kinds.iter().zip(&self.numbers.kernels).enumerate() {
            let Some((name, _)) = kind.uniforms else {
                continue;
            };
            let number = i + 1;
            let bytes = list.stride();
            let capacity = list.capacity();
            // Arrays in uniform buffers ask for elements in steps of 16 bytes.
            let _ = writeln!(
                records,
                "struct ShadowRecord_{number} {{ @align(16) @size({bytes}) uniforms: shadow_{number}_{name} }}"
            );
            let _ = writeln!(
                fields,
                "    kernels_{number}: array<ShadowRecord_{number}, {capacity}>,"
            );
        }
        let group = self.group;
        let lights = self.numbers.entries.capacity();
        let space = match self.numbers.space() {
            NumberSpace::Uniform => "uniform",
            NumberSpace::Storage => "storage",
        };
        format!(
            "{records}struct ShadowSet {{
    lights: array<ShadowLight, {lights}>,
{fields}}}
@group({group}) @binding({NUMBERS}) var<{space}> shadow_set: ShadowSet;
"
        )
    }

    /// Returns one kind's kernel under a prefix of its own.
    fn kind_text(&self, index: usize) -> Result<String, Invalid> {
        let kind = &self.kinds[index];
        let number = index + 1;
        let mut own = String::new();
        for (i, image) in kind.shape.images.iter().enumerate() {
            own += &image_functions(i, *image, &self.classes[index][i]);
        }
        own += &join(&[MATH]);
        own += &join(&kind.modules);
        let of_light = read_from_light(&own, number);
        with_prefix(&of_light, &format!("shadow_{number}_"))
    }

    /// Returns `shadow` and `shadow_on`.
    fn entry_points(&self) -> String {
        let mut cases = String::new();
        for i in 1..=self.kinds.len() {
            let _ = writeln!(
                cases,
                "        case {i}u: {{ return shadow_{i}_receive(receiver); }}"
            );
        }
        let lights = self.numbers.entries.capacity();
        format!(
            "\
// Visibility of a light, 0..=1, at a position (world space) with a unit normal. `pixel` turns the patterns of kernels that vary from
// pixel to pixel. Lights that are not served are lit.
fn shadow(light: u32, position: vec3f, normal: vec3f, pixel: vec2u) -> f32 {{
    return shadow_on(light, position, normal, pixel, 0xffffffffu);
}}
// The same on a triangle with a known id, which rays then leave out.
fn shadow_on(light: u32, position: vec3f, normal: vec3f, pixel: vec2u, triangle: u32) -> f32 {{
    if light >= {lights}u {{
        return 1.0;
    }}
    shadow_index = light;
    let receiver = Receiver(position, normal, pixel, triangle);
    switch shadow_set.lights[light].places.x & 0xffu {{
{cases}        default: {{ return 1.0; }}
    }}
}}
"
        )
    }
}

const fn array_type(kind: InputKind) -> &'static str {
    match kind {
        InputKind::Floats => "texture_2d_array<f32>",
        InputKind::Counts | InputKind::Words => "texture_2d_array<u32>",
        InputKind::Compared => "texture_depth_2d_array",
    }
}

/// Returns the functions with which a kernel reads image `i`; its lights have it in these textures.
fn image_functions(i: usize, image: InputImage, maps: &[usize]) -> String {
    let first = first_layer(i);
    let layer = format!("layer + i32({first})");
    let load = |map: usize| {
        let load = format!("textureLoad(shadow_maps_{map}, texel, {layer}, 0)");
        image.kind.channels(&load)
    };
    let size = |map: usize| format!("vec2i(textureDimensions(shadow_maps_{map}))");
    let mut text = String::new();
    let head = format!("fn load_{i}(texel: vec2i, layer: i32) -> vec4f");
    text += &by_map(i, &head, maps, "vec4f()", load);
    text += &by_map(i, &format!("fn size_{i}() -> vec2i"), maps, "vec2i()", size);
    if image.kind != InputKind::Compared {
        return text;
    }
    let compare = |map: usize| {
        format!(
            "textureSampleCompareLevel(shadow_maps_{map}, shadow_comparison, uv, {layer}, depth)"
        )
    };
    let gather = |map: usize| {
        format!("textureGatherCompare(shadow_maps_{map}, shadow_comparison, uv, {layer}, depth)")
    };
    let head = format!("fn compare_{i}(uv: vec2f, layer: i32, depth: f32) -> f32");
    text += &by_map(i, &head, maps, "1.0", compare);
    let head = format!("fn gather_compare_{i}(uv: vec2f, layer: i32, depth: f32) -> vec4f");
    text + &by_map(i, &head, maps, "vec4f(1.0)", gather)
}

/// Returns the expression of the first layer of image `i`.
fn first_layer(i: usize) -> String {
    let bits = ["x >> 20u", "z & 0xffffu", "z >> 16u", "w"][i];
    format!("{OF_LIGHT}.places.{bits}")
}

/// Returns a function that reads image `i` from the texture in which the light has it; `none` where it has none.
fn by_map(
    i: usize,
    head: &str,
    maps: &[usize],
    none: &str,
    read: impl Fn(usize) -> String,
) -> String {
    match maps {
        [] => format!("{head} {{ return {none}; }}\n"),
        // One texture needs no choice, which shaders would make for every tap.
        [only] => format!("{head} {{ return {}; }}\n", read(*only)),
        several => {
            let mut cases = String::new();
            for &map in several {
                let _ = write!(cases, " case {map}u: {{ return {}; }}", read(map));
            }
            format!(
                "{head} {{\n    switch ({OF_LIGHT}.places.y >> {}u) & 0xffu {{{cases} default: {{ return {none}; }} }}\n}}\n",
                8 * i
            )
        }
    }
}

/// Returns the text of a kernel of this kind, counted from 1, with its uniforms and tables read from where the light's are.
fn read_from_light(text: &str, kind: usize) -> String {
    let mut out = String::with_capacity(text.len() + text.len() / 8);
    push_from_light(&tokens(text), kind, &mut out);
    out
}

/// Appends tokens of a kernel's text, as [`read_from_light`] returns them.
fn push_from_light(tokens: &[Token<'_>], kind: usize, out: &mut String) {
    let mut i = 0;
    while let Some(token) = tokens.get(i) {
        let is_field = i > 0 && tokens[i - 1].text == ".";
        let after = &tokens[i + 1..];
        i += 1;
        if token.text == "kernel" && !is_field {
            let _ = write!(
                out,
                "shadow_set.kernels_{kind}[({OF_LIGHT}.places.x >> 8u) & 0xfffu].uniforms"
            );
        } else if let Some(table) = table_of_length(token, after) {
            let _ = write!(out, "{OF_LIGHT}.{}", row_count(table));
            i += TOKENS_OF_ARGUMENT;
        } else if let Some(table) = table_index(token.text)
            && after.first().is_some_and(|next| next.text == "[")
        {
            let closing = closing_bracket(after);
            let first = first_row(table);
            let _ = write!(out, "shadow_tables[{OF_LIGHT}.{first} + u32(");
            push_from_light(&after[1..closing], kind, out);
            out.push_str(")]");
            i += closing + 1;
        } else {
            out.push_str(token.text);
        }
    }
}

/// The tokens of `(&table_0)`.
const TOKENS_OF_ARGUMENT: usize = 4;

/// Returns the table whose `arrayLength` a token and those after it query.
fn table_of_length(token: &Token<'_>, after: &[Token<'_>]) -> Option<usize> {
    let argument = after.get(..TOKENS_OF_ARGUMENT)?;
    let [open, by_reference, name, close] = [0, 1, 2, 3].map(|i| argument[i].text);
    let is_length = token.text == "arrayLength" && [open, by_reference, close] == ["(", "&", ")"];
    is_length.then(|| table_index(name))?
}

/// Returns the index of the bracket that closes the first token, a bracket.
fn closing_bracket(tokens: &[Token<'_>]) -> usize {
    let mut depth = 0_u32;
    let closing = tokens.iter().position(|token| {
        match token.text {
            "[" => depth += 1,
            "]" => depth -= 1,
            _ => {}
        }
        depth == 0
    });
    // A text without the closing bracket is no WGSL; the compiler will say so.
    closing.unwrap_or(tokens.len())
}

/// Returns `n` of a word `table_n`.
fn table_index(word: &str) -> Option<usize> {
    word.strip_prefix("table_")?.parse().ok()
}

/// Returns the field that holds a table's number of rows.
fn row_count(table: usize) -> String {
    if table + 1 == MAX_TABLES {
        "places.z".to_owned()
    } else {
        format!("row_counts[{table}]")
    }
}

/// Returns the field that holds a table's first row.
fn first_row(table: usize) -> String {
    if table + 1 == MAX_TABLES {
        "places.w".to_owned()
    } else {
        format!("rows[{table}]")
    }
}

#[cfg(test)]
mod tests {
    use super::read_from_light;

    #[test]
    fn uniforms_and_tables_are_the_lights() {
        let text = "\
// the kernel of table_0[1]
fn receive(kernel_size: u32) -> f32 {
    let row = table_0[i / 4u];
    let nested = table_1[table_0[kernel.first].x + 1u];
    if i >= arrayLength(&table_0) { return kernel.lookup.kernel; }
    let last = table_4[arrayLength(&table_4) - 1u];
    return f32(arrayLength(&others));
}
";
        let expected = "\
// the kernel of table_0[1]
fn receive(kernel_size: u32) -> f32 {
    let row = shadow_tables[shadow_set.lights[shadow_index].rows[0] + u32(i / 4u)];
    let nested = shadow_tables[shadow_set.lights[shadow_index].rows[1] + u32(shadow_tables[shadow_set.lights[shadow_index].rows[0] + u32(KERNEL.first)].x + 1u)];
    if i >= shadow_set.lights[shadow_index].row_counts[0] { return KERNEL.lookup.kernel; }
    let last = shadow_tables[shadow_set.lights[shadow_index].places.w + u32(shadow_set.lights[shadow_index].places.z - 1u)];
    return f32(arrayLength(&others));
}
";
        let kernel = "shadow_set.kernels_2[(shadow_set.lights[shadow_index].places.x >> 8u) & 0xfffu].uniforms";
        assert_eq!(read_from_light(text, 2), expected.replace("KERNEL", kernel));
    }
}
