//! Errors of measuring and planning.

use umbrage_core::{BackendError, Invalid, RecipeError};

/// Reason why truth, a cost or a plan could not be computed.
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
    /// A plan was cancelled: see [`Cancel`](crate::Cancel).
    #[error("the plan was cancelled")]
    Cancelled,
}
