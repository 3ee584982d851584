//! Names of glTF files and their scenes.

use std::path::{Path, PathBuf};

/// A path of a glTF file, and one of its scenes.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct SceneOfFile {
    pub(crate) file: PathBuf,
    /// The name or number of a scene. `None` for the file's default scene.
    pub(crate) scene: Option<String>,
}

impl SceneOfFile {
    /// Splits `model.glb#2` or `model.glb#night` at the last `#`. `None` if it is not a glTF file.
    pub(crate) fn of_path(path: &Path) -> Option<Self> {
        let whole = || Self {
            file: path.to_path_buf(),
            scene: None,
        };
        if is_gltf(path) {
            return Some(whole());
        }
        let (file, scene) = path.to_str()?.rsplit_once('#')?;
        is_gltf(Path::new(file)).then(|| Self {
            file: PathBuf::from(file),
            scene: Some(scene.to_owned()),
        })
    }
}

/// Reports whether a path has an extension of glTF files.
fn is_gltf(path: &Path) -> bool {
    path.extension().is_some_and(|ending| {
        ending.eq_ignore_ascii_case("glb") || ending.eq_ignore_ascii_case("gltf")
    })
}
