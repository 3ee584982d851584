//! Errors of requested scenes.

use crate::Files;
use std::path::Path;
use umbrage_core::Invalid;

/// Error of a scene: what is wrong, where, and what to do. Each variant displays all of it and has
/// no source, so that reports of error chains don't repeat it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SceneError {
    /// A file that can't be opened or read.
    #[error("{file}: {why}; {help}")]
    Unreadable {
        /// The file's path.
        file: String,
        /// Description of the error.
        why: String,
        /// Remedy.
        help: String,
    },
    /// A file that can't be written.
    #[error("{file}: {why}; {help}")]
    Unwritable {
        /// The file's path.
        file: String,
        /// Description of the error.
        why: String,
        /// Remedy.
        help: String,
    },
    /// A position in a file whose content can't be parsed or used.
    #[error("{place}: {why}; {help}")]
    Fault {
        /// The file, the line and the key.
        place: Place,
        /// Description of the error, with the offending value.
        why: String,
        /// Remedy.
        help: String,
    },
    /// An error of a file that a scene file names.
    #[error("{place}: {fault}")]
    Named {
        /// Position of the file's name.
        place: Place,
        /// The error of the file.
        fault: Box<SceneError>,
    },
    /// Neither a built-in scene nor a scene file.
    #[error("there is no scene `{argument}`; {help}")]
    Unknown {
        /// The requested name.
        argument: String,
        /// Similar names, and valid alternatives.
        help: String,
    },
    /// A scene that can be read but not rendered.
    #[error("{file}: {fault}")]
    Invalid {
        /// The file's path.
        file: String,
        /// Description of the error.
        fault: Invalid,
    },
}

/// A position in a file. Displays as ``file:line: `key` ``.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file's path.
    pub file: String,
    /// The line, counted from 1. `None` for the file as a whole.
    pub line: Option<usize>,
    /// The key, with its table: `light.radius`. `None` if no key is involved.
    pub key: Option<String>,
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.file)?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        match &self.key {
            Some(key) => write!(f, ": `{key}`"),
            None => Ok(()),
        }
    }
}

impl SceneError {
    /// Returns the error of a file that can't be read from `files`.
    pub(crate) fn unreadable_file(path: &Path, error: &std::io::Error, files: &dyn Files) -> Self {
        let help = match error.kind() {
            std::io::ErrorKind::NotFound => files.help_for_missing(),
            std::io::ErrorKind::PermissionDenied => "allow reading it",
            _ => "check that it is a file that can be read",
        };
        Self::Unreadable {
            file: path.display().to_string(),
            why: format!("can't be read: {error}"),
            help: help.to_owned(),
        }
    }
}
