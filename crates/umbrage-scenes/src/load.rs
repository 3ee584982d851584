//! One way in for all kinds of scenes.

use crate::{
    Files, FilesOnDisk, SceneError, all, file, find, gltf,
    nearest::{listed, nearest},
    obj,
    scene_of_file::SceneOfFile,
};
use std::path::{Path, PathBuf};
use umbrage_core::Scene;

/// What scenes are read from, in errors.
#[cfg(feature = "gltf")]
const ENDINGS: &str = ".toml, .obj, .glb or .gltf";
#[cfg(not(feature = "gltf"))]
const ENDINGS: &str = ".toml or .obj";

/// The scene that a command-line argument means: a built-in scene's name, or the path of a `.toml`,
/// `.obj`, `.glb` or `.gltf` file. The last two may name one of the file's scenes behind `#`, by
/// its name or number.
///
/// # Errors
/// Errors if it is neither, with the nearest names; else as [`load`].
pub fn by_argument(argument: &str) -> Result<Scene, SceneError> {
    match find(argument) {
        Some(entry) => Ok((entry.build)()),
        None if Kind::of(Path::new(argument)).is_some() => load(Path::new(argument)),
        None => {
            let near = nearest(argument, all().iter().map(|entry| entry.name));
            let meant = if near.is_empty() {
                String::new()
            } else {
                format!("did you mean {}, or ", listed(&near))
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
/// `.gltf`), which is framed and put in the sun if it has no camera and no light.
///
/// # Errors
/// Errors if the file can't be read, understood or rendered: with the file, the line and the key,
/// as far as there is one.
pub fn load(path: impl AsRef<Path>) -> Result<Scene, SceneError> {
    read(path, &FilesOnDisk)
}

/// Reads a scene from the text of a scene file. `name` stands for the file in errors, and gives the
/// scene its name if the text has none; models are looked for in `folder`.
///
/// # Errors
/// Errors if [`load`] does.
pub fn parse(text: &str, name: &str, folder: impl AsRef<Path>) -> Result<Scene, SceneError> {
    file::parse(text, Path::new(name), folder.as_ref(), &FilesOnDisk)
}

/// Reads a scene file or a model that is not on disk, or not as files: see
/// [`FilesInMemory`](crate::FilesInMemory). All that it names is looked for among `files`, too:
/// models, `.mtl` files and textures.
///
/// # Errors
/// Errors if [`load`] does.
pub fn read(path: impl AsRef<Path>, files: &dyn Files) -> Result<Scene, SceneError> {
    let path = path.as_ref();
    match Kind::of(path) {
        Some(Kind::SceneFile) => file::read(path, files),
        Some(Kind::Obj) => obj::read_scene(path, files),
        Some(Kind::Gltf(wanted)) => gltf::read_scene(&wanted, files),
        None => Err(neither(path)),
    }
}

/// Whether a path is a model's by its name: one that is read here.
pub fn is_model(path: impl AsRef<Path>) -> bool {
    match Kind::of(path.as_ref()) {
        Some(Kind::Obj) => true,
        Some(Kind::Gltf(_)) => cfg!(feature = "gltf"),
        Some(Kind::SceneFile) | None => false,
    }
}

/// Returns whether a file brings lights of its own. Scene files do, `.obj` files don't, and of glTF
/// files some (`KHR_lights_punctual`, unless all of them are off); where there is none, [`load`]
/// adds a sun.
///
/// # Errors
/// Errors if the file can't be read or understood as far as its lights need.
pub fn brings_light(path: impl AsRef<Path>) -> Result<bool, SceneError> {
    let path = path.as_ref();
    match Kind::of(path) {
        Some(Kind::SceneFile) => Ok(true),
        Some(Kind::Obj) => Ok(false),
        Some(Kind::Gltf(wanted)) => gltf::brings_light(&wanted, &FilesOnDisk),
        None => Err(neither(path)),
    }
}

/// Returns the file that a path names if it is a scene file's or a model's by its name: `model.glb`
/// of `model.glb#night`.
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
    match Kind::of(path)? {
        Kind::Gltf(wanted) => cfg!(feature = "gltf").then_some(wanted.file),
        Kind::SceneFile | Kind::Obj => Some(path.to_path_buf()),
    }
}

fn neither(path: &Path) -> SceneError {
    SceneError::Unreadable {
        file: path.display().to_string(),
        why: format!("is no {ENDINGS} file"),
        help: "give a scene file or a model, named so".to_owned(),
    }
}

/// What a path's name says that it is.
#[derive(Clone, Debug, PartialEq)]
enum Kind {
    SceneFile,
    Obj,
    Gltf(SceneOfFile),
}

impl Kind {
    fn of(path: &Path) -> Option<Self> {
        if let Some(wanted) = SceneOfFile::of(path) {
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
