//! Errors of measuring and planning.

use umbrage_core::{BackendError, Invalid, RecipeError};

/// Why truth, a cost or a plan could not be found.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeasureError {
    /// Input that cannot be used.
    #[error(transparent)]
    Invalid(#[from] Invalid),
    /// The CPU backend failed.
    #[error(transparent)]
    Backend(#[from] BackendError),
    /// A technique has parameters that cannot be used.
    #[error(transparent)]
    Plan(#[from] RecipeError),
    /// A plan was called off: see [`Cancel`](crate::Cancel).
    #[error("the plan was called off")]
    Cancelled,
}
