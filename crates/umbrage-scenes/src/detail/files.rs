//! Texture files of a scene, each read once.

use super::pixels::{Meaning, load_texture};
use crate::{Files, SceneError};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use umbrage_core::Texture;

/// Source of textures, and an index of those already read.
pub(crate) struct TextureFiles<'a> {
    /// All files of the scene.
    pub(crate) files: &'a dyn Files,
    known: HashMap<(PathBuf, Meaning), usize>,
}

impl<'a> TextureFiles<'a> {
    pub(crate) fn new(files: &'a dyn Files) -> Self {
        Self {
            files,
            known: HashMap::new(),
        }
    }

    /// Returns the index of a file's texture among `textures`, and reads the file if it is new.
    pub(crate) fn index(
        &mut self,
        path: &Path,
        meaning: Meaning,
        textures: &mut Vec<Texture>,
    ) -> Result<usize, SceneError> {
        let key = (path.to_path_buf(), meaning);
        if let Some(&index) = self.known.get(&key) {
            return Ok(index);
        }
        textures.push(load_texture(path, self.files, meaning)?);
        self.known.insert(key, textures.len() - 1);
        Ok(textures.len() - 1)
    }
}
