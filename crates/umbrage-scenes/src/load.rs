//! Common entry points for all kinds of scenes.

use crate::{
    Files, FilesOnDisk, ModelTriangles, SceneError, all, file, find, gltf, model_triangles,
    nearest::{list_words, nearest},
    obj,
    scene_of_file::SceneOfFile,
};
use std::path::{Path, PathBuf};
use umbrage_core::Scene;

/// Extensions of scene files, for errors.
#[cfg(feature = "gltf")]
const ENDINGS: &str = ".toml, .obj, .glb or .gltf";
#[cfg(not(feature = "gltf"))]
const ENDINGS: &str = ".toml or .obj";

/// Returns the scene of a command-line argument: the name of a built-in scene, or the path of a
/// `.toml`, `.obj`, `.glb` or `.gltf` file. After `#`, paths of the last two may have the name or
/// number of one of the file's scenes.
///
/// # Errors
/// Returns an error with similar names if it is neither, or the error of [`load`].
pub fn by_argument(argument: &str) -> Result<Scene, SceneError> {
    match find(argument) {
        Some(entry) => Ok((entry.build)()),
        None if FileKind::of_path(Path::new(argument)).is_some() => load(Path::new(argument)),
        None => {
            let near = nearest(argument, all().iter().map(|entry| entry.name));
            let meant = if near.is_empty() {
                String::new()
            } else {
                format!("did you mean {}, or ", list_words(&near))
            };
            let list = if near.is_empty() {
                "name a built-in scene, or give "
            } else {
                ""
            };
            let end = if near.is_empty() { "" } else { "?" };
            let help = format!("{meant}{list}the path of a {ENDINGS} file{end}");
            Err(SceneError::Unknown {
                argument: argument.to_owned(),
                help,
            })
        }
    }
}

/// Loads a scene file (`.toml`) or a model (`.obj`; with the feature `gltf` also `.glb` and
/// `.gltf`). A model without a camera and a light receives a camera and a sun.
///
/// # Errors
/// Returns an error if the file can't be read, parsed or rendered, with the file, the line and the
/// key, if any.
pub fn load(path: impl AsRef<Path>) -> Result<Scene, SceneError> {
    read(path, &FilesOnDisk)
}

/// Reads a scene from the text of a scene file. `name` is the name of the file in errors, and of
/// the scene if the text has none. Paths of models are relative to `folder`.
///
/// # Errors
/// Returns an error if [`load`] does.
pub fn parse(text: &str, name: &str, folder: impl AsRef<Path>) -> Result<Scene, SceneError> {
    file::parse(text, Path::new(name), folder.as_ref(), &FilesOnDisk)
}

/// Reads a scene file or a model that is not on disk, or not stored as files: see
/// [`FilesInMemory`](crate::FilesInMemory). Files that it names are also read from `files`: models,
/// `.mtl` files and textures.
///
/// # Errors
/// Returns an error if [`load`] does.
pub fn read(path: impl AsRef<Path>, files: &dyn Files) -> Result<Scene, SceneError> {
    let path = path.as_ref();
    match FileKind::of_path(path) {
        Some(FileKind::SceneFile) => file::read(path, files),
        Some(FileKind::Obj) => obj::read_scene(path, files),
        Some(FileKind::Gltf(wanted)) => gltf::read_scene(&wanted, files),
        None => Err(neither(path)),
    }
}

/// Loads the triangles of a model (`.obj`; with the feature `gltf` also `.glb` and `.gltf`), without
/// a floor, a camera or a sun.
///
/// # Errors
/// Returns an error if the file is no model, or can't be read or parsed.
pub fn load_triangles(path: impl AsRef<Path>) -> Result<ModelTriangles, SceneError> {
    let path = path.as_ref();
    match FileKind::of_path(path) {
        Some(FileKind::Obj) => obj::read_triangles(path, &FilesOnDisk),
        Some(FileKind::Gltf(wanted)) => model_triangles::of_gltf(&wanted, &FilesOnDisk),
        Some(FileKind::SceneFile) | None => Err(SceneError::Unreadable {
            file: path.display().to_string(),
            why: "is not a model".to_owned(),
            help: "use an .obj, .glb or .gltf file".to_owned(),
        }),
    }
}

/// Reports whether a path has the name of a supported model.
pub fn is_model(path: impl AsRef<Path>) -> bool {
    match FileKind::of_path(path.as_ref()) {
        Some(FileKind::Obj) => true,
        Some(FileKind::Gltf(_)) => cfg!(feature = "gltf"),
        Some(FileKind::SceneFile) | None => false,
    }
}

/// Reports whether a file has lights. Scene files do and `.obj` files don't. Some glTF files do
/// (`KHR_lights_punctual`, unless all of them are off). [`load`] adds a sun to files without one.
///
/// # Errors
/// Returns an error if the file can't be read or parsed as far as its lights require.
pub fn brings_light(path: impl AsRef<Path>) -> Result<bool, SceneError> {
    let path = path.as_ref();
    match FileKind::of_path(path) {
        Some(FileKind::SceneFile) => Ok(true),
        Some(FileKind::Obj) => Ok(false),
        Some(FileKind::Gltf(wanted)) => gltf::brings_light(&wanted, &FilesOnDisk),
        None => Err(neither(path)),
    }
}

/// Returns the file of a path if its name is that of a scene file or a model: `model.glb` for
/// `model.glb#night`.
///
/// ```
/// use std::path::Path;
/// use umbrage_scenes::file_of;
///
/// assert_eq!(file_of("rooms/hall.obj").as_deref(), Some(Path::new("rooms/hall.obj")));
/// assert_eq!(file_of("cubes"), None);
/// # #[cfg(feature = "gltf")]
/// assert_eq!(file_of("model.glb#night").as_deref(), Some(Path::new("model.glb")));
/// ```
pub fn file_of(path: impl AsRef<Path>) -> Option<PathBuf> {
    let path = path.as_ref();
    match FileKind::of_path(path)? {
        FileKind::Gltf(wanted) => cfg!(feature = "gltf").then_some(wanted.file),
        FileKind::SceneFile | FileKind::Obj => Some(path.to_path_buf()),
    }
}

fn neither(path: &Path) -> SceneError {
    SceneError::Unreadable {
        file: path.display().to_string(),
        why: format!("is not a {ENDINGS} file"),
        help: "use a scene file or a model with one of these extensions".to_owned(),
    }
}

/// Kind of file, by its name.
#[derive(Clone, Debug, PartialEq)]
enum FileKind {
    SceneFile,
    Obj,
    Gltf(SceneOfFile),
}

impl FileKind {
    fn of_path(path: &Path) -> Option<Self> {
        if let Some(wanted) = SceneOfFile::of_path(path) {
            return Some(Self::Gltf(wanted));
        }
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "toml" => Some(Self::SceneFile),
            "obj" => Some(Self::Obj),
            _ => None,
        }
    }
}

#[cfg(test)]
#[path = "load_tests.rs"]
mod tests;
