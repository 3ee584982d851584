//! Rewriting of shaders for tests, so that a software driver rounds like another driver.

use std::{borrow::Cow, sync::OnceLock};
use wgpu::Features;

/// Rewriting rule for all shaders of the process.
#[derive(Clone, Copy, Debug)]
pub struct ShaderRewriter {
    /// Returns the replacement of a WGSL text.
    pub rewrite: fn(&str) -> String,
    /// Device features required by rewritten shaders.
    pub features: Features,
}

static REWRITER: OnceLock<ShaderRewriter> = OnceLock::new();

/// Sets the rewriting rule for shaders created from now on. Only the first call has an effect.
pub fn rewrite_shaders(rewriter: ShaderRewriter) {
    let _ = REWRITER.set(rewriter);
}

/// Returns whether a rewriting rule is set.
pub(crate) fn is_set() -> bool {
    REWRITER.get().is_some()
}

/// Returns the WGSL text to compile for an original text.
pub(crate) fn rewrite_text(text: &str) -> Cow<'_, str> {
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
