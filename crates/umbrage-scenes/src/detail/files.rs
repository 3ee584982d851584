//! Texture files of a scene, each read once.

use super::pixels::{Meaning, load_texture};
use crate::SceneError;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use umbrage_core::Texture;

/// What has been read already.
#[derive(Clone, Debug, Default)]
pub(crate) struct TextureFiles {
    known: HashMap<(PathBuf, Meaning), usize>,
}

impl TextureFiles {
    /// The index among `textures` of what a file holds.
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
        textures.push(load_texture(path, meaning)?);
        self.known.insert(key, textures.len() - 1);
        Ok(textures.len() - 1)
    }
}
