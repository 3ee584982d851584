//! Errors of the lab.

use std::path::PathBuf;
use umbrage_core::{BackendError, Invalid, RecipeError};
use umbrage_plan::MeasureError;

/// Why a comparison stopped.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LabError {
    /// Input that cannot be used.
    #[error(transparent)]
    Invalid(#[from] Invalid),
    /// A backend failed.
    #[error(transparent)]
    Backend(#[from] BackendError),
    /// A technique has parameters that cannot be used.
    #[error(transparent)]
    Plan(#[from] RecipeError),
    /// Truth, a cost or a plan could not be found.
    #[error(transparent)]
    Measure(MeasureError),
    /// A backend reports no times.
    #[error("{0} cannot time its passes; choose another adapter with WGPU_ADAPTER_NAME")]
    NotTimed(String),
    /// A file or folder of results could not be written, or not be read again.
    #[error("{path}: {source}; check the folder's name, rights and space", path = .path.display())]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// Truth and a technique did not see the same triangles, so their comparison would mean
    /// nothing.
    #[error("scene `{scene}`: {what}; this is a fault in umbrage, please report it")]
    NotComparable {
        /// The scene's name.
        scene: String,
        /// What differs.
        what: String,
    },
}

impl LabError {
    /// A file that could not be written.
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
    /// Keeps the kind of error where both have it.
    fn from(e: MeasureError) -> Self {
        match e {
            MeasureError::Invalid(e) => Self::Invalid(e),
            MeasureError::Backend(e) => Self::Backend(e),
            MeasureError::Plan(e) => Self::Plan(e),
            other => Self::Measure(other),
        }
    }
}
