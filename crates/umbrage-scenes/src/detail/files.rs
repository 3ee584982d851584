//! Texture files of a scene, each read once.

use super::pixels::{EncodedImage, Meaning, PendingImages, picture_format, unreadable_image};
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
    /// `None` for images that are not needed.
    known: HashMap<(PathBuf, Meaning), Option<usize>>,
    /// Results of [`indices_of_colors`](Self::indices_of_colors).
    colors: HashMap<PathBuf, [Option<usize>; 2]>,
    pending: PendingImages,
}

impl<'a> TextureFiles<'a> {
    pub(crate) fn new(files: &'a dyn Files) -> Self {
        Self {
            files,
            known: HashMap::new(),
            colors: HashMap::new(),
            pending: PendingImages::default(),
        }
    }

    /// Returns the index of an image file's texture among `textures`, and reads the file if it is new.
    /// `None` if the texture only colours surfaces, and no colours are needed. Call
    /// [`decode`](Self::decode) before using texels.
    pub(crate) fn index(
        &mut self,
        path: &Path,
        meaning: Meaning,
        textures: &mut Vec<Texture>,
    ) -> Result<Option<usize>, SceneError> {
        if let Some(&index) = self.known.get(&(path.to_path_buf(), meaning)) {
            return Ok(index);
        }
        let image = self.read(path, meaning)?;
        let is_needed = !meaning.is_only_shown() || image.color_side > 0;
        let index = is_needed.then(|| self.pending.add(image, textures));
        self.known.insert((path.to_path_buf(), meaning), index);
        Ok(index)
    }

    /// Returns the textures of colours and of their alpha test, if the file has an alpha channel.
    /// They are one, unless the alpha test is larger than colours may be.
    pub(crate) fn indices_of_colors(
        &mut self,
        path: &Path,
        textures: &mut Vec<Texture>,
    ) -> Result<[Option<usize>; 2], SceneError> {
        if let Some(&indices) = self.colors.get(path) {
            return Ok(indices);
        }
        let indices = self.new_indices_of_colors(path, textures)?;
        self.colors.insert(path.to_path_buf(), indices);
        Ok(indices)
    }

    /// Returns the textures of a file that [`indices_of_colors`](Self::indices_of_colors) has not
    /// seen.
    fn new_indices_of_colors(
        &mut self,
        path: &Path,
        textures: &mut Vec<Texture>,
    ) -> Result<[Option<usize>; 2], SceneError> {
        let image = self.read(path, Meaning::Color)?;
        let (size, has_alpha) = image.header().map_err(|e| unreadable_image(path, &e))?;
        if !has_alpha {
            return Ok([self.index(path, Meaning::Color, textures)?, None]);
        }
        let color_side = image.color_side;
        let alpha = self.index(path, Meaning::CutOut, textures)?;
        if color_side == 0 || size.max_element() <= color_side {
            return Ok([alpha, alpha]);
        }
        Ok([self.index(path, Meaning::CutOutColor, textures)?, alpha])
    }

    /// Decodes the images of all textures so far.
    pub(crate) fn decode(&mut self, textures: &mut [Texture]) -> Result<(), SceneError> {
        self.pending.decode(textures).map_err(|(index, why)| {
            let known = self.known.iter().find(|(_, known)| **known == Some(index));
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
            format: picture_format(path).unwrap_or(ImageFormat::Png),
            meaning,
            color_side: self.files.color_side(),
        };
        image.header().map_err(|e| unreadable_image(path, &e))?;
        Ok(image)
    }
}
