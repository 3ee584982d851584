//! The files of each shader that is not a kernel's alone.

use crate::wgsl::resolver::constant;
use umbrage_core::{
    Format, MATH, Module,
    bvh::{RAY_BOX, RAY_TRIANGLE},
    cut_out::{CUT_OUT, HOLE},
    hashed_alpha::{HASHED_ALPHA, HASHED_HOLE},
    join,
    resolve::RESOLVE,
};

/// The module of a `.wgsl` file in this folder.
macro_rules! file {
    ($name:literal) => {
        Module {
            name: $name,
            text: include_str!(concat!($name, ".wgsl")),
        }
    };
}

/// Vertex shader of one triangle that covers the target.
pub(crate) const FULLSCREEN: Module = file!("fullscreen");

/// How images look up alpha textures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum HoleRule {
    /// All at the nearest texel.
    Nearest,
    /// Some in mipmapped coverages.
    Hashed,
}

/// What a full-screen pass reads its receivers from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ReceiverSource {
    /// Positions and normals.
    GBuffer { triangles: bool },
    /// A depth buffer, of several samples a pixel or of one.
    Depth { samples: bool },
    DepthAndNormals {
        samples: bool,
        halved: bool,
        octahedral: bool,
    },
}

/// Returns the shader that calls a kernel's `receive` for every pixel of the G-buffer in group `group`.
pub(crate) fn receive_shader(kernel: &str, group: u32, triangles: bool) -> String {
    let seen = seen_wgsl(group, ReceiverSource::GBuffer { triangles });
    kernel.to_owned() + &seen + &join(&[file!("receive"), FULLSCREEN])
}

/// Returns the shader that calls a kernel's `shade`. The mask is the last binding of the G-buffer's group.
pub(crate) fn shade_shader(kernel: &str, group: u32) -> String {
    let seen = seen_wgsl(group, ReceiverSource::GBuffer { triangles: true });
    kernel.to_owned() + &seen + &join(&[file!("shade"), FULLSCREEN])
}

/// Returns the shader that computes a layer of an image by a kernel's `filter_texel`; the instance is the layer.
pub(crate) fn filter_shader(kernel: &str, output: Format) -> String {
    let stage = match output {
        Format::Rg16 | Format::Rgba16 => file!("filter_words"),
        _ => file!("filter"),
    };
    kernel.to_owned() + &join(&[file!("fullscreen_instances"), stage])
}

/// Returns the shader of masks, which calls a set's `shadow_on`; the instance is the light.
pub(crate) fn mask_shader(set: &str, group: u32, receivers: ReceiverSource) -> String {
    let seen = seen_wgsl(group, receivers);
    set.to_owned() + &seen + &join(&[file!("fullscreen_instances"), file!("mask")])
}

/// Returns `umbrage_seen`, which reads bind group `group`.
fn seen_wgsl(group: u32, receivers: ReceiverSource) -> String {
    let seen = file!("seen");
    let declared = constant("UMBRAGE_GROUP", format!("{group}u"));
    declared
        + &match receivers {
            ReceiverSource::GBuffer { triangles: true } => {
                join(&[seen, file!("triangle_ids"), file!("seen_in_gbuffer")])
            }
            ReceiverSource::GBuffer { triangles: false } => {
                join(&[seen, file!("no_triangle_ids"), file!("seen_in_gbuffer")])
            }
            ReceiverSource::Depth { samples } => {
                unproject_wgsl(samples) + &join(&[seen, file!("seen_in_depth")])
            }
            ReceiverSource::DepthAndNormals {
                samples,
                halved,
                octahedral,
            } => {
                constant("NORMALS_ARE_HALVED", halved)
                    + &constant("NORMALS_ARE_OCTAHEDRAL", octahedral)
                    + &unproject_wgsl(samples)
                    + &join(&[seen, file!("seen_in_depth_and_normals")])
            }
        }
}

/// Returns the functions that unproject the depth buffer in group `UMBRAGE_GROUP`.
fn unproject_wgsl(samples: bool) -> String {
    let texture = if samples {
        file!("depth_samples")
    } else {
        file!("depth_single")
    };
    join(&[MATH, texture, file!("depth")])
}

/// Returns the shader that makes a G-buffer of the depth buffer in group 0.
pub(crate) fn depth_wgsl(samples: bool) -> String {
    let group = constant("UMBRAGE_GROUP", "0u");
    group + &unproject_wgsl(samples) + &join(&[file!("depth_pass"), FULLSCREEN])
}

/// Returns the shader of casts, of triangles with holes by this rule if there is one.
pub(crate) fn cast_wgsl(holes: Option<HoleRule>) -> String {
    match holes {
        None => join(&[MATH, file!("cast")]),
        Some(HoleRule::Nearest) => {
            holes_wgsl(HoleRule::Nearest) + &join(&[file!("cast"), file!("cast_holes")])
        }
        Some(HoleRule::Hashed) => {
            let files = [file!("cast"), file!("cast_holes"), file!("cast_coverage")];
            holes_wgsl(HoleRule::Hashed) + &join(&files)
        }
    }
}

/// Returns the shader that draws triangle ids, of triangles with holes by this rule if there is one.
pub(crate) fn ids_wgsl(holes: Option<HoleRule>) -> String {
    let visibility = file!("gbuffer_visibility");
    match holes {
        None => join(&[MATH, RESOLVE, visibility]),
        Some(HoleRule::Nearest) => {
            holes_wgsl(HoleRule::Nearest) + &join(&[visibility, file!("gbuffer_holes")])
        }
        Some(HoleRule::Hashed) => {
            let files = [
                visibility,
                file!("gbuffer_holes"),
                file!("gbuffer_coverage"),
            ];
            holes_wgsl(HoleRule::Hashed) + &join(&files)
        }
    }
}

/// Returns the name and the text of each shader that places vertices or receivers.
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
        ("receivers", points_wgsl()),
        ("receivers from depth", depth_wgsl(false)),
        ("receivers from samples of depth", depth_wgsl(true)),
        ("corners", corners_wgsl()),
    ]
}

/// Returns the shader that turns triangle ids into receivers.
pub(crate) fn points_wgsl() -> String {
    ids_wgsl(None) + &join(&[file!("gbuffer_resolve"), FULLSCREEN])
}

/// Returns the shader that places the corners of casters.
pub(crate) fn corners_wgsl() -> String {
    join(&[MATH, file!("corners")])
}

/// Returns `is_hole`, which reads `cut_outs`, `corner` and, by the hashed rule, `coverage`.
fn holes_wgsl(rule: HoleRule) -> String {
    let common = join(&[MATH, RESOLVE, RAY_BOX, RAY_TRIANGLE, CUT_OUT, HOLE]);
    let rule = match rule {
        HoleRule::Nearest => join(&[file!("holes"), file!("holes_nearest")]),
        HoleRule::Hashed => {
            let files = [
                HASHED_ALPHA,
                HASHED_HOLE,
                file!("holes"),
                file!("holes_hashed"),
            ];
            join(&files)
        }
    };
    common + &rule
}

/// Returns `is_hole` with what it reads, in bind group `group`.
pub(crate) fn bound_holes_wgsl(rule: HoleRule, group: u32) -> String {
    let files = match rule {
        HoleRule::Nearest => &[file!("holes_bindings")][..],
        HoleRule::Hashed => &[file!("holes_bindings"), file!("holes_coverage")],
    };
    holes_wgsl(rule) + &constant("UMBRAGE_GROUP", format!("{group}u")) + &join(files)
}
