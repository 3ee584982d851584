//! Texture files of a scene, each read once.

use super::pixels::{EncodedImage, Meaning, PendingImages, unreadable_image};
use crate::{Files, SceneError};
use image::ImageFormat;
use std::collections::HashMap;
use std::io::Read as _;
use std::path::{Path, PathBuf};
use umbrage_core::Texture;

/// Source of textures, and an index of those already read.
pub(crate) struct TextureFiles<'a> {
    /// All files of the scene.
    pub(crate) files: &'a dyn Files,
    known: HashMap<(PathBuf, Meaning), usize>,
    pending: PendingImages,
}

impl<'a> TextureFiles<'a> {
    pub(crate) fn new(files: &'a dyn Files) -> Self {
        Self {
            files,
            known: HashMap::new(),
            pending: PendingImages::default(),
        }
    }

    /// Returns the index of a PNG file's texture among `textures`, and reads the file if it is new.
    /// `None` if the texture only colours surfaces, and no colours are needed. Call
    /// [`decode`](Self::decode) before using texels.
    pub(crate) fn index(
        &mut self,
        path: &Path,
        meaning: Meaning,
        textures: &mut Vec<Texture>,
    ) -> Result<Option<usize>, SceneError> {
        if let Some(&index) = self.known.get(&(path.to_path_buf(), meaning)) {
            return Ok(Some(index));
        }
        let image = self.read(path, meaning)?;
        Ok(self.add(path, image, textures))
    }

    /// Returns the texture of colours with an alpha test where the file has an alpha channel, and
    /// of colours alone where it has none.
    pub(crate) fn index_of_colors(
        &mut self,
        path: &Path,
        textures: &mut Vec<Texture>,
    ) -> Result<Option<usize>, SceneError> {
        for meaning in [Meaning::CutOut, Meaning::Color] {
            if let Some(&index) = self.known.get(&(path.to_path_buf(), meaning)) {
                return Ok(Some(index));
            }
        }
        let mut image = self.read(path, Meaning::Color)?;
        let (_, has_alpha) = image.header().map_err(|e| unreadable_image(path, &e))?;
        if has_alpha {
            image.meaning = Meaning::CutOut;
        }
        Ok(self.add(path, image, textures))
    }

    fn add(
        &mut self,
        path: &Path,
        image: EncodedImage,
        textures: &mut Vec<Texture>,
    ) -> Option<usize> {
        if image.meaning.is_only_shown() && image.color_side == 0 {
            return None;
        }
        let key = (path.to_path_buf(), image.meaning);
        let index = self.pending.add(image, textures);
        self.known.insert(key, index);
        Some(index)
    }

    /// Decodes the images of all textures so far.
    pub(crate) fn decode(&mut self, textures: &mut [Texture]) -> Result<(), SceneError> {
        self.pending.decode(textures).map_err(|(index, why)| {
            let known = self.known.iter().find(|(_, known)| **known == index);
            let path = known.map_or(Path::new(""), |((path, _), _)| path);
            unreadable_image(path, &why)
        })
    }

    /// Reads a file, and checks its header.
    fn read(&self, path: &Path, meaning: Meaning) -> Result<EncodedImage, SceneError> {
        let mut bytes = Vec::new();
        self.files
            .open(path)
            .and_then(|mut source| source.read_to_end(&mut bytes))
            .map_err(|e| SceneError::unreadable_file(path, &e, self.files))?;
        let name = path.file_name().unwrap_or(path.as_os_str());
        let image = EncodedImage {
            name: name.to_string_lossy().into_owned(),
            bytes,
            format: ImageFormat::Png,
            meaning,
            color_side: self.files.color_side(),
        };
        image.header().map_err(|e| unreadable_image(path, &e))?;
        Ok(image)
    }
}
