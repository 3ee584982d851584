//! The WGSL of a light set: one copy of each kind of kernel, and `shadow`, which calls a light's.
//!
//! Kernels are written for one light. Here the same texts read the data of the light
//! `shadow_index`: `kernel` becomes an array element, tables become parts of one table, and images
//! become layers of arrays.

use crate::{
    light_set::buffers::{LightNumbers, MAX_TABLES, NumberSpace},
    wgsl::{
        kernel::{ImageSource, InputKind, KernelInterface, image_functions},
        resolver::{InputPlaces, constant, with_prefix},
    },
};
use std::fmt::Write as _;
use umbrage_core::{Invalid, MATH, Module, join};

/// A kernel's WGSL half, and its binding requirements: lights of one kind differ only in data.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct KernelKind {
    pub(crate) modules: Vec<Module>,
    /// Name of the uniform struct in WGSL, and its size in bytes.
    pub(crate) uniforms: Option<(&'static str, u64)>,
    pub(crate) shape: KernelInterface,
    /// True if masks are computed, not drawn.
    pub(crate) in_compute: bool,
}

/// A texture binding of the set: a class of layers, and how kernels read it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct MapBinding {
    pub(crate) class: usize,
    pub(crate) kind: InputKind,
}

/// Inputs for the text of a set.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TextParts<'a> {
    pub(crate) group: u32,
    pub(crate) kinds: &'a [KernelKind],
    pub(crate) numbers: &'a LightNumbers,
    pub(crate) maps: &'a [MapBinding],
    /// For each kind and each of its images, the classes (indices of `maps`) in which its lights
    /// have layers.
    pub(crate) classes: &'a [Vec<Vec<usize>>],
}

/// The entry of the evaluated light.
const LIGHT: &str = "shadow_set.lights[shadow_index]";

/// A text whose bindings have no numbers yet.
#[derive(Debug)]
pub(crate) struct UnnumberedText {
    head: String,
    group: u32,
    /// Declarations of the bindings, without their attributes.
    variables: Vec<String>,
    body: String,
}

impl UnnumberedText {
    /// Returns the text with bindings numbered from `first`.
    pub(crate) fn numbered(&self, first: u32) -> String {
        let group = self.group;
        let mut text = self.head.clone();
        for (binding, variable) in (first..).zip(&self.variables) {
            let _ = writeln!(text, "@group({group}) @binding({binding}) {variable};");
        }
        text + &self.body
    }
}

impl TextParts<'_> {
    /// Returns the text of `fn shadow(light: u32, position: vec3f, normal: vec3f, pixel: vec2u) ->
    /// f32` and all functions that it calls.
    ///
    /// Errors if a kernel's names can't be prefixed.
    pub(crate) fn text(&self) -> Result<UnnumberedText, Invalid> {
        let receiver = include_str!("receiver.wgsl");
        let light = include_str!("light.wgsl");
        let shadow = include_str!("shadow.wgsl");
        let mut head = format!("// Made by umbrage: a set of lights.\n{receiver}{light}");
        self.declare_uniforms(&mut head);
        let mut text = String::new();
        let rows: [_; MAX_TABLES] = std::array::from_fn(rows_of_table);
        let mut cases = String::new();
        // Append the text of each kind of kernel, with its names prefixed.
        for (index, kind) in self.kinds.iter().enumerate() {
            let number = index + 1;
            let mut own = String::new();
            for (i, image) in kind.shape.images.iter().enumerate() {
                own += &light_image_functions(i, image.kind, &self.classes[index][i]);
            }
            own += &join(&[MATH]);
            own += &join(&kind.modules);
            let uniforms =
                format!("shadow_set.kernels_{number}[({LIGHT}.places.x >> 8u) & 0xfffu].uniforms");
            let places = InputPlaces {
                uniforms: &uniforms,
                tables: "shadow_tables",
                rows: &rows,
            };
            text += &with_prefix(&places.resolve(&own), &format!("shadow_{number}_"))?;
            let _ = write!(
                cases,
                " case {number}u: {{ return shadow_{number}_receive(r); }}"
            );
        }
        let lights = format!("{}u", self.numbers.entries.capacity());
        // Append the dispatch by kind, and `shadow`.
        text += &format!(
            "fn shadow_of_kind(kind: u32, r: Receiver) -> f32 {{
    switch kind {{{cases} default: {{ return 1.0; }} }}
}}
"
        );
        text += &constant("SHADOW_LIGHTS", lights);
        text += shadow;
        Ok(UnnumberedText {
            head,
            group: self.group,
            variables: self.variables(),
            body: text,
        })
    }

    /// Appends the structs of the uniforms.
    fn declare_uniforms(&self, text: &mut String) {
        let mut fields = String::new();
        for (i, (kind, list)) in self.kinds.iter().zip(&self.numbers.kernels).enumerate() {
            let Some((name, _)) = kind.uniforms else {
                continue;
            };
            let number = i + 1;
            let bytes = list.stride();
            let capacity = list.capacity();
            // Elements of arrays in uniform buffers have a size of a multiple of 16 bytes.
            let _ = writeln!(
                text,
                "struct ShadowRecord_{number} {{ @align(16) @size({bytes}) uniforms: shadow_{number}_{name} }}"
            );
            let _ = writeln!(
                fields,
                "    kernels_{number}: array<ShadowRecord_{number}, {capacity}>,"
            );
        }
        let lights = self.numbers.entries.capacity();
        let _ = writeln!(
            text,
            "struct ShadowSet {{\n    lights: array<ShadowLight, {lights}>,\n{fields}}}"
        );
    }

    /// Returns the declarations of the shared resources, in binding order.
    fn variables(&self) -> Vec<String> {
        let space = match self.numbers.space() {
            NumberSpace::Uniform => "uniform",
            NumberSpace::Storage => "storage",
        };
        let mut variables = vec![
            format!("var<{space}> shadow_set: ShadowSet"),
            "var<storage> shadow_tables: array<vec4u>".to_owned(),
        ];
        for (i, map) in self.maps.iter().enumerate() {
            variables.push(format!(
                "var shadow_maps_{i}: {}",
                map.kind.texture_type(true)
            ));
        }
        if self.maps.iter().any(|map| map.kind == InputKind::Compared) {
            variables.push("var shadow_comparison: sampler_comparison".to_owned());
        }
        variables
    }
}

/// Returns the functions with which a kernel reads image `i`; its lights have it in these textures.
fn light_image_functions(i: usize, kind: InputKind, maps: &[usize]) -> String {
    let first_layer = ["x >> 20u", "z & 0xffffu", "z >> 16u", "w"][i];
    let texture = |&map: &usize| ImageSource {
        number: map,
        name: format!("shadow_maps_{map}"),
        layer: format!(" layer + i32({LIGHT}.places.{first_layer}),"),
    };
    let textures: Vec<ImageSource> = maps.iter().map(texture).collect();
    let choice = format!("({LIGHT}.places.y >> {}u) & 0xffu", 8 * i);
    image_functions(i, kind, &textures, "shadow_comparison", &choice)
}

/// Returns the fields with a table's first row and its number of rows.
fn rows_of_table(table: usize) -> [String; 2] {
    if table + 1 == MAX_TABLES {
        return [format!("{LIGHT}.places.w"), format!("{LIGHT}.places.z")];
    }
    [
        format!("{LIGHT}.rows[{table}]"),
        format!("{LIGHT}.row_counts[{table}]"),
    ]
}
