//! Why a technique has no recipe.

use crate::invalid::Invalid;

/// Why there is no recipe.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RecipeError {
    /// The technique is not made for this: a value rather than a fault. Reports print a dash and
    /// the reason.
    #[error("not supported: {0}")]
    Unsupported(String),
    /// A parameter or the view can't be used.
    #[error(transparent)]
    Invalid(#[from] Invalid),
}

impl RecipeError {
    /// The technique can't serve this, for this reason.
    pub fn unsupported(reason: impl Into<String>) -> Self {
        Self::Unsupported(reason.into())
    }
}
