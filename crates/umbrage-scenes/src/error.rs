//! What can be wrong with a scene that somebody asks for.

use crate::Files;
use std::path::Path;
use umbrage_core::Invalid;

/// Why there is no scene: what is wrong, where, and how to help. Each tells all of it itself and
/// has no source, so that reports of chains of errors don't tell it twice.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SceneError {
    /// A file that can't be opened or read.
    #[error("{file}: {why}; {help}")]
    Unreadable {
        /// The file's path.
        file: String,
        /// What is wrong.
        why: String,
        /// What to do about it.
        help: String,
    },
    /// A file that can't be written.
    #[error("{file}: {why}; {help}")]
    Unwritable {
        /// The file's path.
        file: String,
        /// What is wrong.
        why: String,
        /// What to do about it.
        help: String,
    },
    /// A place in a file that can't be understood or used.
    #[error("{place}: {why}; {help}")]
    Fault {
        /// The file, the line and the key.
        place: Place,
        /// What is wrong, with the offending value.
        why: String,
        /// What to do about it.
        help: String,
    },
    /// A file that a scene file names has an error of its own.
    #[error("{place}: {fault}")]
    Named {
        /// Where the file is named.
        place: Place,
        /// What is wrong with it.
        fault: Box<SceneError>,
    },
    /// Neither a built-in scene nor a file that could hold one.
    #[error("there is no scene `{argument}`; {help}")]
    Unknown {
        /// What was asked for.
        argument: String,
        /// Names that are near to it, and what else would do.
        help: String,
    },
    /// A scene that reads well but can't be rendered.
    #[error("{file}: {fault}")]
    Invalid {
        /// The file's path.
        file: String,
        /// What is wrong.
        fault: Invalid,
    },
}

/// A place in a file. Displays as ``file:line: `key` ``.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file's path.
    pub file: String,
    /// The line, counted from 1; none for the file as a whole.
    pub line: Option<usize>,
    /// The key, with its table: `light.radius`; none where there is no key.
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
    /// The error of a file that was looked for among `files`.
    pub(crate) fn unreadable(path: &Path, error: &std::io::Error, files: &dyn Files) -> Self {
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
