//! The shaders that are assembled from files, alone or after the text of a kernel or a set.

use crate::{
    resources::images::texture_format,
    wgsl::resolver::{assemble, constant},
};
use umbrage_core::{
    Format, MATH, Module,
    bvh::{RAY_BOX, RAY_TRIANGLE},
    cut_out::{CUT_OUT, HOLE},
    hashed_alpha::{HASHED_ALPHA, HASHED_HOLE},
    resolve::RESOLVE,
};

/// Declares the module of a `.wgsl` file in this folder.
macro_rules! file {
    ($name:literal) => {
        Module {
            name: $name,
            text: include_str!(concat!($name, ".wgsl")),
        }
    };
}

/// All modules that files import.
const FILES: &[Module] = &[
    MATH,
    RESOLVE,
    RAY_BOX,
    RAY_TRIANGLE,
    CUT_OUT,
    HOLE,
    HASHED_ALPHA,
    HASHED_HOLE,
    file!("cast"),
    file!("cast_coverage"),
    file!("cast_holes"),
    file!("convert"),
    file!("corners"),
    file!("depth"),
    file!("depth_pass"),
    file!("depth_samples"),
    file!("depth_single"),
    file!("filter"),
    file!("filter_tile"),
    file!("filter_words"),
    file!("fullscreen"),
    file!("fullscreen_instances"),
    file!("gbuffer_coverage"),
    file!("gbuffer_holes"),
    file!("gbuffer_resolve"),
    file!("gbuffer_visibility"),
    file!("holes"),
    file!("holes_bindings"),
    file!("holes_coverage"),
    file!("holes_hashed"),
    file!("holes_nearest"),
    file!("mask"),
    file!("mask_bytes"),
    file!("mask_choice"),
    file!("mask_floats"),
    file!("no_triangle_ids"),
    file!("pixel_block"),
    file!("probe_fusing"),
    file!("receive"),
    file!("receive_compute"),
    file!("seen"),
    file!("seen_in_depth"),
    file!("seen_in_depth_and_normals"),
    file!("seen_in_gbuffer"),
    file!("shade"),
    file!("sort"),
    file!("triangle_ids"),
    file!("words"),
];

/// Lookup of alpha textures for images.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum HoleRule {
    /// All textures use the nearest texel.
    Nearest,
    /// Some textures use mipmapped coverages.
    Hashed,
}

/// Source of the receivers of a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ReceiverSource {
    /// Positions and normals.
    GBuffer { triangles: bool },
    /// A depth buffer, multisampled or not.
    Depth { samples: bool },
    DepthAndNormals {
        samples: bool,
        halved: bool,
        octahedral: bool,
    },
}

/// Returns the shader assembled from these files.
pub(crate) fn shader_of(files: &[&str]) -> String {
    assemble(FILES, files)
}

/// Returns the shader that calls a kernel's `receive` for every pixel of the G-buffer in bind group
/// `group`. If it is a compute shader, the mask is the last binding of that group.
pub(crate) fn receive_shader(kernel: &str, group: u32, triangles: bool, computes: bool) -> String {
    let receivers = ReceiverSource::GBuffer { triangles };
    let text = kernel.to_owned() + &seen_wgsl(group, receivers);
    if computes {
        text + &mask_constant(receivers) + &shader_of(&["receive_compute"])
    } else {
        text + &shader_of(&["receive"])
    }
}

/// Returns the shader that calls a kernel's `shade`. The mask is the last binding of the G-buffer's
/// group.
pub(crate) fn shade_shader(kernel: &str, group: u32) -> String {
    kernel.to_owned() + &group_constant(group) + &shader_of(&["shade"])
}

/// Returns the shader that computes a layer of an image with a kernel's `filter_texel`; the
/// instance is the layer.
pub(crate) fn filter_shader(kernel: &str, output: Format) -> String {
    let file = match output {
        Format::Rg16 | Format::Rgba16 => "filter_words",
        _ => "filter",
    };
    kernel.to_owned() + &shader_of(&[file])
}

/// Bind group of the image that compute filters write.
pub(crate) const FILTER_OUTPUT_GROUP: u32 = 1;

/// Returns the shader that computes an image by tiles, with a kernel's `filter_tile`. `layered` is
/// true if the image has several layers.
pub(crate) fn tile_filter_shader(kernel: &str, output: Format, layered: bool) -> String {
    // WGSL's name of a format is wgpu's in lower case.
    let format = format!("{:?}", texture_format(output)).to_lowercase();
    let (kind, layer) = match layered {
        true => ("texture_storage_2d_array", " layer,"),
        false => ("texture_storage_2d", ""),
    };
    let (value, words) = match output {
        Format::Rg16 | Format::Rgba16 => ("vec4u(umbrage_words(channels), vec2u())", "words"),
        _ => ("channels", ""),
    };
    let files = [words, "filter_tile"];
    let files: Vec<&str> = files.into_iter().filter(|file| !file.is_empty()).collect();
    let store = format!(
        "@group({FILTER_OUTPUT_GROUP}) @binding(0) var umbrage_output: {kind}<{format}, write>;
fn store_texel(texel: vec2i, layer: i32, channels: vec4f) {{
    textureStore(umbrage_output, texel,{layer} {value});
}}
"
    );
    kernel.to_owned() + &store + &shader_of(&files)
}

/// Returns the shader of masks, which calls a set's `shadow_on`; the instance is the light.
pub(crate) fn mask_shader(set: &str, group: u32, receivers: ReceiverSource) -> String {
    set.to_owned() + &seen_wgsl(group, receivers) + &shader_of(&["mask"])
}

/// Returns the compute shader of masks. The last bindings of bind group `group` are the choice of a
/// light, and the output: `bytes` in a buffer, or floats in a texture.
pub(crate) fn mask_compute_shader(
    set: &str,
    group: u32,
    receivers: ReceiverSource,
    bytes: bool,
) -> String {
    let file = if bytes { "mask_bytes" } else { "mask_floats" };
    set.to_owned() + &seen_wgsl(group, receivers) + &mask_constant(receivers) + &shader_of(&[file])
}

/// Returns the number of the first binding after those of the receivers.
fn mask_constant(receivers: ReceiverSource) -> String {
    let first = match receivers {
        ReceiverSource::GBuffer { triangles: false } | ReceiverSource::Depth { .. } => 2,
        ReceiverSource::GBuffer { triangles: true } | ReceiverSource::DepthAndNormals { .. } => 3,
    };
    constant("UMBRAGE_MASK_BINDING", format!("{first}u"))
}

/// Returns `umbrage_seen` for bind group `group`.
fn seen_wgsl(group: u32, receivers: ReceiverSource) -> String {
    let text = match receivers {
        ReceiverSource::GBuffer { triangles: true } => shader_of(&["triangle_ids"]),
        ReceiverSource::GBuffer { triangles: false } => shader_of(&["no_triangle_ids"]),
        ReceiverSource::Depth { samples } => shader_of(&[depth_file(samples), "seen_in_depth"]),
        ReceiverSource::DepthAndNormals {
            samples,
            halved,
            octahedral,
        } => {
            constant("NORMALS_ARE_HALVED", halved)
                + &constant("NORMALS_ARE_OCTAHEDRAL", octahedral)
                + &shader_of(&[depth_file(samples), "seen_in_depth_and_normals"])
        }
    };
    group_constant(group) + &text
}

fn group_constant(group: u32) -> String {
    constant("UMBRAGE_GROUP", format!("{group}u"))
}

fn depth_file(samples: bool) -> &'static str {
    if samples {
        "depth_samples"
    } else {
        "depth_single"
    }
}

/// Returns the shader that computes a G-buffer from the depth buffer in group 0.
pub(crate) fn depth_wgsl(samples: bool) -> String {
    group_constant(0) + &shader_of(&[depth_file(samples), "depth_pass"])
}

/// Returns the shader of casts, with this alpha test if given.
pub(crate) fn cast_wgsl(holes: Option<HoleRule>) -> String {
    match holes {
        None => shader_of(&["cast"]),
        Some(HoleRule::Nearest) => shader_of(&["cast_holes", "holes_nearest"]),
        Some(HoleRule::Hashed) => shader_of(&["cast_holes", "cast_coverage"]),
    }
}

/// Returns the shader that draws triangle ids, with this alpha test if given.
pub(crate) fn ids_wgsl(holes: Option<HoleRule>) -> String {
    match holes {
        None => shader_of(&["gbuffer_visibility"]),
        Some(HoleRule::Nearest) => shader_of(&["gbuffer_holes", "holes_nearest"]),
        Some(HoleRule::Hashed) => shader_of(&["gbuffer_holes", "gbuffer_coverage"]),
    }
}

/// Returns `is_hole` with its bindings, in bind group `group`.
pub(crate) fn holes_wgsl(rule: HoleRule, group: u32) -> String {
    let text = match rule {
        HoleRule::Nearest => shader_of(&["holes_bindings", "holes_nearest"]),
        HoleRule::Hashed => shader_of(&["holes_bindings", "holes_coverage"]),
    };
    group_constant(group) + &text
}

/// Returns the name and the text of each shader that computes vertex or receiver positions.
#[cfg(feature = "testing")]
pub fn placing_shaders() -> Vec<(&'static str, String)> {
    let nearest = Some(HoleRule::Nearest);
    let hashed = Some(HoleRule::Hashed);
    vec![
        ("cast", cast_wgsl(None)),
        ("cast with holes", cast_wgsl(nearest)),
        ("cast with hashed holes", cast_wgsl(hashed)),
        ("ids", ids_wgsl(None)),
        ("ids with holes", ids_wgsl(nearest)),
        ("ids with hashed holes", ids_wgsl(hashed)),
        ("receivers", shader_of(&["gbuffer_resolve"])),
        ("receivers from depth", depth_wgsl(false)),
        ("receivers from samples of depth", depth_wgsl(true)),
        ("corners", shader_of(&["corners"])),
    ]
}

#[cfg(test)]
mod tests {
    use super::{FILES, shader_of};

    #[test]
    fn imports_are_there_once() {
        let text = shader_of(&["gbuffer_holes", "gbuffer_coverage"]);
        for name in [
            "math",
            "gbuffer_visibility",
            "holes",
            "hashed_hole",
            "gbuffer_coverage",
        ] {
            let headers = text.matches(&format!("// ---- {name}.wgsl\n")).count();
            assert_eq!(headers, 1, "{name}");
        }
        for file in FILES {
            for line in file.text.lines() {
                let names = line.strip_prefix("// import ").unwrap_or_default();
                for name in names.split(", ").filter(|name| !name.is_empty()) {
                    let is_there = FILES.iter().any(|other| other.name == name);
                    assert!(is_there, "{} imports {name}", file.name);
                }
            }
        }
    }
}
