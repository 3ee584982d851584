//! Sources of a scene's files: on disk, in memory, or in a program's own store.

use crate::detail::PICTURE_SIDE;
use std::{
    collections::BTreeSet,
    fmt, fs,
    io::{self, BufRead, BufReader, Cursor, Seek},
    path::{Component, Path, PathBuf},
    sync::{Mutex, PoisonError},
};

/// Operations of an opened file.
pub trait OpenFile: BufRead + Seek {}

impl<T: BufRead + Seek> OpenFile for T {}

/// Source of the files of a scene: the scene file or the model, and the files that these name.
///
/// The first path is that of [`read`](crate::read). A path in a file has that file's folder in
/// front.
pub trait Files {
    /// Opens a file.
    ///
    /// # Errors
    /// Returns an error of kind [`NotFound`](io::ErrorKind::NotFound) if there is no such file, or
    /// an error if it can't be read.
    fn open(&self, path: &Path) -> io::Result<Box<dyn OpenFile + '_>>;

    /// Reports whether a file exists. Models are read without missing looks.
    fn has(&self, path: &Path) -> bool {
        match self.open(path) {
            Ok(_) => true,
            Err(error) => error.kind() != io::ErrorKind::NotFound,
        }
    }

    /// Returns the greatest side, texels, of textures without effect on shadows. Larger images are
    /// reduced by averaging. They are not decoded where this is 0: shadows need images for alpha tests
    /// and heights only, and these keep their sizes.
    fn color_side(&self) -> u32 {
        PICTURE_SIDE
    }

    /// Returns the remedy for a missing file: the end of its error message.
    fn help_for_missing(&self) -> &str {
        "check the path"
    }
}

/// Files on disk.
#[derive(Clone, Copy, Debug, Default)]
pub struct FilesOnDisk;

impl Files for FilesOnDisk {
    fn open(&self, path: &Path) -> io::Result<Box<dyn OpenFile + '_>> {
        // Reject other kinds first: reading a directory fails with a less useful error, and a pipe
        // might never open or never end.
        if !fs::metadata(path)?.is_file() {
            return Err(io::Error::other("is not a file"));
        }
        Ok(Box::new(BufReader::new(fs::File::open(path)?)))
    }

    fn has(&self, path: &Path) -> bool {
        path.is_file()
    }
}

/// Files on disk, for images of a known size or for shadows alone.
#[derive(Clone, Copy, Debug)]
pub struct SizedFilesOnDisk {
    /// The value of [`Files::color_side`].
    pub color_side: u32,
}

impl Files for SizedFilesOnDisk {
    fn open(&self, path: &Path) -> io::Result<Box<dyn OpenFile + '_>> {
        FilesOnDisk.open(path)
    }

    fn has(&self, path: &Path) -> bool {
        FilesOnDisk.has(path)
    }

    fn color_side(&self) -> u32 {
        self.color_side
    }
}

/// Files in memory, such as those dropped together on a web page.
///
/// A file is found by its path. If no file has that path, it is found by its name alone, in any
/// folder and ignoring case. Browsers don't report folders, and models name folders of the machine
/// they were made on.
///
/// ```
/// let files: umbrage_scenes::FilesInMemory = [
///     ("tile.obj", "mtllib C:\\looks\\Tile.mtl\nv 0 0 0\nv 1 0 0\nv 0 0 -1\nusemtl red\nf 1 2 3"),
///     ("tile.mtl", "newmtl red\nKd 1 0 0"),
/// ]
/// .into_iter()
/// .collect();
/// let scene = umbrage_scenes::read("tile.obj", &files)?;
/// assert_eq!(scene.materials[0].diffuse.to_array(), [1.0, 0.0, 0.0]);
/// assert!(files.missing_files().is_empty());
/// # Ok::<(), umbrage_scenes::SceneError>(())
/// ```
#[derive(Default)]
pub struct FilesInMemory {
    files: Vec<(PathBuf, Vec<u8>)>,
    /// Requested paths that were missing.
    missing: Mutex<BTreeSet<PathBuf>>,
}

impl FilesInMemory {
    /// Adds a file, or replaces the file of the same path.
    pub fn insert(&mut self, path: impl AsRef<Path>, bytes: impl Into<Vec<u8>>) {
        let path = plain(path.as_ref());
        self.files.retain(|(known, _)| *known != path);
        self.files.push((path, bytes.into()));
    }

    /// Returns the requested paths that were missing when a scene was read.
    pub fn missing_files(&self) -> Vec<PathBuf> {
        let missing = self.missing.lock().unwrap_or_else(PoisonError::into_inner);
        missing.iter().cloned().collect()
    }

    /// Returns the bytes of an existing file.
    #[cfg(all(test, feature = "gltf"))]
    pub(crate) fn bytes_of(&self, path: &Path) -> Vec<u8> {
        let found = self.find(path).expect("one file is meant");
        found.expect("it is there").to_vec()
    }

    /// Returns the bytes of a file. `None` if there is no such file.
    ///
    /// # Errors
    /// Returns an error if several files match.
    fn find(&self, path: &Path) -> io::Result<Option<&[u8]>> {
        let path = plain(path);
        if let Some((_, bytes)) = self.files.iter().find(|(known, _)| *known == path) {
            return Ok(Some(bytes));
        }
        let mut named = self
            .files
            .iter()
            .filter(|(known, _)| same_name(known, &path));
        let Some((first, bytes)) = named.next() else {
            return Ok(None);
        };
        match named.next() {
            None => Ok(Some(bytes)),
            Some((second, _)) => Err(io::Error::other(format!(
                "could be `{}` or `{}`",
                first.display(),
                second.display()
            ))),
        }
    }
}

impl Files for FilesInMemory {
    fn open(&self, path: &Path) -> io::Result<Box<dyn OpenFile + '_>> {
        match self.find(path)? {
            Some(bytes) => Ok(Box::new(Cursor::new(bytes))),
            None => {
                let mut missing = self.missing.lock().unwrap_or_else(PoisonError::into_inner);
                missing.insert(plain(path));
                Err(io::Error::new(
                    io::ErrorKind::NotFound,
                    "is not among the given files",
                ))
            }
        }
    }

    fn help_for_missing(&self) -> &str {
        "provide it together with the file that names it"
    }
}

impl<P: AsRef<Path>, B: Into<Vec<u8>>> FromIterator<(P, B)> for FilesInMemory {
    fn from_iter<I: IntoIterator<Item = (P, B)>>(files: I) -> Self {
        let mut out = Self::default();
        for (path, bytes) in files {
            out.insert(path, bytes);
        }
        out
    }
}

impl fmt::Debug for FilesInMemory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let lengths = self.files.iter().map(|(path, bytes)| (path, bytes.len()));
        f.debug_map().entries(lengths).finish()
    }
}

/// Returns a path without `.`, and without `..` where the folder before it is known.
fn plain(path: &Path) -> PathBuf {
    let mut out = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir if out.file_name().is_some() => {
                out.pop();
            }
            part => out.push(part),
        }
    }
    out
}

fn same_name(a: &Path, b: &Path) -> bool {
    match (a.file_name(), b.file_name()) {
        (Some(a), Some(b)) => {
            a.to_string_lossy().to_lowercase() == b.to_string_lossy().to_lowercase()
        }
        _ => false,
    }
}

#[cfg(test)]
#[path = "files_tests.rs"]
mod tests;
