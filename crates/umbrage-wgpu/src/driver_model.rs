//! Shaders rewritten so that a software driver rounds as another driver does, and the texts of the
//! shaders that place vertices and receivers: for tests.

use crate::{
    gbuffer::{ids_wgsl, ids_with_holes_wgsl, points_wgsl},
    gbuffer_from_depth::whole_shader_text,
    light_set::corners::corners_wgsl,
    resources::{
        cut_outs::HoleRule,
        pipelines::{cast_wgsl, cast_with_holes_wgsl},
    },
};
use std::{borrow::Cow, sync::OnceLock};
use wgpu::Features;

/// How all shaders of the process are rewritten.
#[derive(Clone, Copy, Debug)]
pub struct ShaderRewriter {
    /// Returns the text to compile instead of a WGSL text.
    pub rewrite: fn(&str) -> String,
    /// What devices must have for such texts.
    pub features: Features,
}

static REWRITER: OnceLock<ShaderRewriter> = OnceLock::new();

/// Sets how shaders that are made from now on are rewritten. The first call counts; later ones do nothing.
pub fn rewrite_shaders(rewriter: ShaderRewriter) {
    let _ = REWRITER.set(rewriter);
}

/// Returns whether shaders are rewritten.
pub(crate) fn is_set() -> bool {
    REWRITER.get().is_some()
}

/// Returns the text to compile instead of a WGSL text.
pub(crate) fn rewritten(text: &str) -> Cow<'_, str> {
    match REWRITER.get() {
        Some(rewriter) => Cow::Owned((rewriter.rewrite)(text)),
        None => Cow::Borrowed(text),
    }
}

/// Returns the features that rewritten shaders need.
pub(crate) fn features() -> Features {
    REWRITER
        .get()
        .map_or(Features::empty(), |rewriter| rewriter.features)
}

/// Returns the name and the text of each shader that places vertices or receivers.
pub fn placing_shaders() -> Vec<(&'static str, String)> {
    vec![
        ("cast", cast_wgsl()),
        ("cast with holes", cast_with_holes_wgsl(HoleRule::Nearest)),
        (
            "cast with hashed holes",
            cast_with_holes_wgsl(HoleRule::Hashed),
        ),
        ("ids", ids_wgsl()),
        ("ids with holes", ids_with_holes_wgsl(HoleRule::Nearest)),
        (
            "ids with hashed holes",
            ids_with_holes_wgsl(HoleRule::Hashed),
        ),
        ("receivers", points_wgsl()),
        ("receivers from depth", whole_shader_text(false)),
        ("receivers from samples of depth", whole_shader_text(true)),
        ("corners", corners_wgsl()),
    ]
}
