//! Atomic writing of files.

use crate::error::LabError;
use std::{
    fs, io,
    path::{Path, PathBuf},
};

/// A folder whose files are written under temporary names and renamed when they are complete.
#[derive(Clone, Debug)]
pub(crate) struct Folder(PathBuf);

impl Folder {
    /// Creates the folder and its parents.
    pub(crate) fn create(path: &Path) -> Result<Self, LabError> {
        fs::create_dir_all(path).map_err(|source| LabError::Write {
            path: path.to_owned(),
            source,
        })?;
        Ok(Self(path.to_owned()))
    }

    /// Creates an empty subfolder under a temporary name, until it is [finished](Self::finish).
    pub(crate) fn unfinished_folder(&self, name: &str) -> Result<Self, LabError> {
        let path = self.0.join(format!(".{name}.unfinished"));
        remove(&path)?;
        Self::create(&path)
    }

    /// Renames a finished subfolder. Removes an older one with that name.
    pub(crate) fn finish(&self, name: &str) -> Result<(), LabError> {
        let unfinished = self.0.join(format!(".{name}.unfinished"));
        let path = self.0.join(name);
        remove(&path)?;
        fs::rename(&unfinished, &path).map_err(|source| LabError::Write { path, source })
    }

    /// Removes a file if it exists.
    pub(crate) fn remove(&self, name: &str) -> Result<(), LabError> {
        let path = self.0.join(name);
        match fs::remove_file(&path) {
            Err(source) if source.kind() != io::ErrorKind::NotFound => {
                Err(LabError::Write { path, source })
            }
            _ => Ok(()),
        }
    }

    /// Writes a file atomically.
    pub(crate) fn write(&self, name: &str, bytes: &[u8]) -> Result<(), LabError> {
        let path = self.0.join(name);
        let unfinished = self
            .0
            .join(format!(".{name}.{}.unfinished", std::process::id()));
        let written = fs::write(&unfinished, bytes).and_then(|()| fs::rename(&unfinished, &path));
        written.map_err(|source: io::Error| {
            // Ignore a failure to remove the leftover: the error is returned anyway.
            let _ = fs::remove_file(&unfinished);
            LabError::Write { path, source }
        })
    }
}

/// Removes a folder if it exists.
fn remove(path: &Path) -> Result<(), LabError> {
    match fs::remove_dir_all(path) {
        Err(e) if e.kind() != io::ErrorKind::NotFound => Err(LabError::Write {
            path: path.to_owned(),
            source: e,
        }),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_replaced_and_leave_nothing_else() {
        let dir = tempfile::tempdir().expect("a temporary folder");
        let folder = Folder::create(&dir.path().join("a/b")).expect("writable");
        folder.write("x.txt", b"one").expect("writable");
        folder.write("x.txt", b"two").expect("writable");
        assert_eq!(
            fs::read(dir.path().join("a/b/x.txt")).expect("there"),
            b"two"
        );
        assert_eq!(
            fs::read_dir(dir.path().join("a/b")).expect("there").count(),
            1
        );
    }

    #[test]
    fn errors_name_the_file() {
        let dir = tempfile::tempdir().expect("a temporary folder");
        fs::write(dir.path().join("file"), b"").expect("writable");
        let e = Folder::create(&dir.path().join("file/inside")).expect_err("a file is in the way");
        assert!(e.to_string().contains("inside"), "{e}");
        let folder = Folder::create(dir.path()).expect("writable");
        assert!(
            folder
                .write("none/x.txt", b"")
                .expect_err("no such folder")
                .to_string()
                .contains("x.txt")
        );
    }
}
