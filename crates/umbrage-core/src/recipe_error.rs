//! The error of [`ShadowTechnique::recipe`](crate::ShadowTechnique::recipe).

use crate::invalid::Invalid;

/// Reason why a technique has no recipe.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RecipeError {
    /// The technique does not support this light or scene. Reports print a dash and the reason.
    #[error("not supported: {0}")]
    Unsupported(String),
    /// A parameter or the view can't be used.
    #[error(transparent)]
    Invalid(#[from] Invalid),
}

impl RecipeError {
    /// Returns an [`Unsupported`](Self::Unsupported) error with this reason.
    pub fn unsupported_because(reason: impl Into<String>) -> Self {
        Self::Unsupported(reason.into())
    }
}
