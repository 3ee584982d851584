//! The WGSL of a light set: each kind of kernel once, and `shadow`, which picks a light's.
//!
//! Kernels are written for one light: uniforms `kernel`, tables `table_0` and so on, images behind `load_0` and so on. Here the same texts
//! read what belongs to the light that is asked for: `kernel` becomes an element of an array, tables become parts of one table, and
//! images become layers of arrays.

use crate::{
    prefix::with_prefix,
    wgsl::{InputImage, InputKind, KernelInterface, RECEIVER},
};
use std::fmt::Write as _;
use umbrage_core::{Invalid, MATH, Module, join};

/// Most images and most tables of a kernel.
pub(crate) const MAX_INPUTS: usize = 4;

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
    pub(crate) maps: &'a [MapBinding],
    /// For each kind, and in it for each image, the classes (indices of `maps`) in which its lights have layers.
    pub(crate) classes: &'a [Vec<Vec<usize>>],
}

/// Binding of the lights' entries.
pub(crate) const ENTRIES: u32 = 0;
/// Binding of all tables.
pub(crate) const TABLES: u32 = 1;
/// Binding of the first kind's uniforms.
pub(crate) const FIRST_KIND: u32 = 2;

/// Declares a light's entry; `LightEntry` is its twin.
const ENTRY: &str = "\
struct ShadowInput {
    // Index of the texture, or the table's first row.
    at: u32,
    // First layer, or number of rows.
    first: u32,
}
struct ShadowLight {
    // 0: not served, so it is lit. Else the kind of kernel, counted from 1.
    kind: u32,
    // Index of the kernel's uniforms.
    kernel: u32,
    images: array<ShadowInput, 4>,
    tables: array<ShadowInput, 4>,
}
";

impl TextParts<'_> {
    /// Returns the text: `fn shadow(light: u32, position: vec3f, normal: vec3f, pixel: vec2u) -> f32` and all that it calls.
    ///
    /// Errors if a kernel's names can't take a prefix.
    pub(crate) fn text(&self) -> Result<String, Invalid> {
        let group = self.group;
        let mut text = format!("// Made by umbrage: a set of lights.\n{RECEIVER}{ENTRY}");
        let _ = writeln!(
            text,
            "@group({group}) @binding({ENTRIES}) var<storage> shadow_lights: array<ShadowLight>;
@group({group}) @binding({TABLES}) var<storage> shadow_tables: array<vec4u>;
var<private> shadow_index: u32;"
        );
        let mut binding = FIRST_KIND + self.kinds.len() as u32;
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

    /// Returns one kind's kernel under a prefix of its own.
    fn kind_text(&self, index: usize) -> Result<String, Invalid> {
        let kind = &self.kinds[index];
        let mut own = String::new();
        if let Some((name, _)) = kind.uniforms {
            let group = self.group;
            let binding = FIRST_KIND + index as u32;
            let _ = writeln!(
                own,
                "@group({group}) @binding({binding}) var<storage> kernels: array<{name}>;"
            );
        }
        for (i, image) in kind.shape.images.iter().enumerate() {
            own += &image_functions(i, *image, &self.classes[index][i]);
        }
        own += &join(&[MATH]);
        own += &join(&kind.modules);
        let of_light = read_from_light(&own);
        with_prefix(&of_light, &format!("shadow_{}_", index + 1))
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
        format!(
            "\
// Visibility of a light, 0..=1, at a position (world space) with a unit normal. `pixel` turns the patterns of kernels that vary from
// pixel to pixel. Lights that are not served are lit.
fn shadow(light: u32, position: vec3f, normal: vec3f, pixel: vec2u) -> f32 {{
    return shadow_on(light, position, normal, pixel, 0xffffffffu);
}}
// The same on a triangle with a known id, which rays then leave out.
fn shadow_on(light: u32, position: vec3f, normal: vec3f, pixel: vec2u, triangle: u32) -> f32 {{
    if light >= arrayLength(&shadow_lights) {{
        return 1.0;
    }}
    shadow_index = light;
    let receiver = Receiver(position, normal, pixel, triangle);
    switch shadow_lights[light].kind {{
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
        InputKind::Counts => "texture_2d_array<u32>",
        InputKind::Compared => "texture_depth_2d_array",
    }
}

/// Returns the functions with which a kernel reads image `i`; its lights have it in these textures.
fn image_functions(i: usize, image: InputImage, maps: &[usize]) -> String {
    let layer = format!("layer + i32(shadow_lights[shadow_index].images[{i}].first)");
    let load = |map: usize| {
        let load = format!("textureLoad(shadow_maps_{map}, texel, {layer}, 0)");
        match image.kind {
            InputKind::Floats => load,
            InputKind::Counts => format!("vec4f(f32({load}.x), 0.0, 0.0, 0.0)"),
            InputKind::Compared => format!("vec4f({load}, 0.0, 0.0, 1.0)"),
        }
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
                "{head} {{\n    switch shadow_lights[shadow_index].images[{i}].at {{{cases} default: {{ return {none}; }} }}\n}}\n"
            )
        }
    }
}

/// Returns a kernel's text with its uniforms and tables read from where the light's are.
fn read_from_light(text: &str) -> String {
    let mut out = String::with_capacity(text.len() + text.len() / 8);
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        if let Some(after) = rest.strip_prefix("//") {
            let end = after.find('\n').map_or(rest.len(), |n| n + 2);
            out.push_str(&rest[..end]);
            rest = &rest[end..];
            continue;
        }
        if !(first.is_ascii_alphanumeric() || first == '_') {
            out.push(first);
            rest = &rest[first.len_utf8()..];
            continue;
        }
        let end = rest
            .find(|c: char| !c.is_ascii_alphanumeric() && c != '_')
            .unwrap_or(rest.len());
        let word = &rest[..end];
        rest = &rest[end..];
        let is_field = out.ends_with('.');
        if word == "kernel" && !is_field {
            out.push_str("kernels[shadow_lights[shadow_index].kernel]");
        } else if word == "arrayLength" {
            rest = push_table_length(&mut out, rest);
        } else if let Some(table) = table_index(word)
            && rest.starts_with('[')
        {
            rest = push_table_row(&mut out, table, rest);
        } else {
            out.push_str(word);
        }
    }
    out
}

/// Returns `n` of a word `table_n`.
fn table_index(word: &str) -> Option<usize> {
    word.strip_prefix("table_")?.parse().ok()
}

/// Appends what stands for `arrayLength`, and returns what follows; `rest` begins behind that word.
fn push_table_length<'a>(out: &mut String, rest: &'a str) -> &'a str {
    let argument = rest
        .strip_prefix("(&")
        .and_then(|inside| inside.split_once(')'));
    if let Some((name, after)) = argument
        && let Some(table) = table_index(name)
    {
        let _ = write!(out, "shadow_lights[shadow_index].tables[{table}].first");
        return after;
    }
    out.push_str("arrayLength");
    rest
}

/// Appends what stands for a row of a table, and returns what follows; `rest` begins with the bracket behind the table's name.
fn push_table_row<'a>(out: &mut String, table: usize, rest: &'a str) -> &'a str {
    let mut depth = 0_u32;
    let closing = rest.char_indices().find(|&(_, c)| {
        match c {
            '[' => depth += 1,
            ']' => depth -= 1,
            _ => {}
        }
        depth == 0
    });
    // A text without the closing bracket is no WGSL; the compiler will say so.
    let (end, _) = closing.unwrap_or((rest.len() - 1, ']'));
    let row = read_from_light(&rest[1..end]);
    let _ = write!(
        out,
        "shadow_tables[shadow_lights[shadow_index].tables[{table}].at + u32({row})]"
    );
    &rest[end + 1..]
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
    return f32(arrayLength(&others));
}
";
        let expected = "\
// the kernel of table_0[1]
fn receive(kernel_size: u32) -> f32 {
    let row = shadow_tables[shadow_lights[shadow_index].tables[0].at + u32(i / 4u)];
    let nested = shadow_tables[shadow_lights[shadow_index].tables[1].at + u32(shadow_tables[shadow_lights[shadow_index].tables[0].at + u32(kernels[shadow_lights[shadow_index].kernel].first)].x + 1u)];
    if i >= shadow_lights[shadow_index].tables[0].first { return kernels[shadow_lights[shadow_index].kernel].lookup.kernel; }
    return f32(arrayLength(&others));
}
";
        assert_eq!(read_from_light(text), expected);
    }
}
