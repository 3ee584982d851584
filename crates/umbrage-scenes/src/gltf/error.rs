//! What is wrong with a glTF file, before it is known which file it is.

use crate::{SceneError, error::Place};
use umbrage_core::Invalid;

/// What is wrong: with the file, or with one that it names.
#[derive(Debug)]
pub(super) enum GltfError {
    /// With the file itself: the things on the way to it by name and number.
    Document(Invalid),
    /// With another file.
    Named {
        /// What names it.
        what: String,
        source: Box<SceneError>,
    },
}

impl GltfError {
    pub(super) fn new(
        what: impl Into<String>,
        why: impl Into<String>,
        help: impl Into<String>,
    ) -> Self {
        Self::Document(Invalid::new(what, why, help))
    }

    /// The error of a file that only damage or a faulty program could have made so.
    pub(super) fn broken(what: impl Into<String>, why: impl Into<String>) -> Self {
        Self::new(
            what,
            why,
            "export the model again; https://github.khronos.org/glTF-Validator tells all faults of a file",
        )
    }

    /// Returns the same error, seen from a thing that holds or refers to what is wrong.
    pub(super) fn within(self, outer: impl std::fmt::Display) -> Self {
        match self {
            Self::Document(invalid) => Self::Document(invalid.within(outer)),
            Self::Named { what, source } => Self::Named {
                what: format!("{outer}, {what}"),
                source,
            },
        }
    }

    /// Returns the error of the file at this path.
    pub(super) fn in_file(self, file: &str) -> SceneError {
        match self {
            Self::Document(source) => SceneError::Invalid {
                file: file.to_owned(),
                source,
            },
            Self::Named { what, source } => SceneError::Named {
                place: Place {
                    file: format!("{file}: {what}"),
                    line: None,
                    key: None,
                },
                source,
            },
        }
    }
}

impl From<Invalid> for GltfError {
    fn from(invalid: Invalid) -> Self {
        Self::Document(invalid)
    }
}
