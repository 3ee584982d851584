//! Errors of the lab.

use std::path::PathBuf;
use umbrage_core::{BackendError, Invalid, RecipeError};
use umbrage_plan::MeasureError;

/// Errors of a comparison.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LabError {
    /// Invalid input.
    #[error(transparent)]
    Invalid(#[from] Invalid),
    /// A backend failed.
    #[error(transparent)]
    Backend(#[from] BackendError),
    /// A technique has invalid parameters.
    #[error(transparent)]
    Plan(#[from] RecipeError),
    /// Truth, a cost or a plan could not be computed.
    #[error(transparent)]
    Measure(MeasureError),
    /// A backend reports no times.
    #[error("{0} cannot time its passes; choose another adapter with WGPU_ADAPTER_NAME")]
    NotTimed(String),
    /// A file or folder of results could not be written or read.
    #[error("{path}: {source}; check the name, permissions and free space", path = .path.display())]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// Truth and a technique see different triangles, so that their comparison would be
    /// meaningless.
    #[error("scene `{scene}`: {what}; this is a bug in umbrage, please report it")]
    NotComparable {
        /// The scene's name.
        scene: String,
        /// Description of the difference.
        what: String,
    },
}

impl LabError {
    /// Returns the error of a file that could not be written.
    pub(crate) fn write(
        path: impl Into<PathBuf>,
        source: impl Into<Box<dyn std::error::Error + Send + Sync>>,
    ) -> Self {
        Self::Write {
            path: path.into(),
            source: std::io::Error::other(source),
        }
    }
}

impl From<MeasureError> for LabError {
    /// Keeps the kind of error if both have it.
    fn from(e: MeasureError) -> Self {
        match e {
            MeasureError::Invalid(e) => Self::Invalid(e),
            MeasureError::Backend(e) => Self::Backend(e),
            MeasureError::Plan(e) => Self::Plan(e),
            other => Self::Measure(other),
        }
    }
}
