//! Shaders rewritten for tests, so that a software driver rounds as another driver does.

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

/// Sets how shaders that are made from now on are rewritten. The first call counts; later ones do
/// nothing.
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
