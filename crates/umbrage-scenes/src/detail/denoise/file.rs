//! Maps on disk: a grey PNG of 16 bits, and a small file next to it for scale and bias.

use super::DisplacementMap;
use crate::{FilesOnDisk, SceneError, detail::pixels::load_image};
use image::{ImageBuffer, Luma};
use std::path::{Path, PathBuf};
use umbrage_core::glam::UVec2;
use umbrage_core::{Invalid, invalid};

impl DisplacementMap {
    /// Writes the map to `path` as a grey PNG of 16 bits. Writes scale and bias, in metres, to
    /// `path` with `.toml` added.
    ///
    /// Most painting programs drop unknown text chunks of a PNG, and a map without its scale is
    /// useless. A missing file is easier to notice, so scale and bias have their own file.
    ///
    /// # Errors
    /// Returns an error if one of the two files can't be written.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), SceneError> {
        let path = path.as_ref();
        let image =
            ImageBuffer::<Luma<u16>, _>::from_raw(self.size.x, self.size.y, self.greys.clone());
        let image =
            image.ok_or_else(|| unwritable_file(path, &"its size doesn't fit its texels"))?;
        image
            .save_with_format(path, image::ImageFormat::Png)
            .map_err(|e| unwritable_file(path, &e))?;
        let metres = metadata_path(path);
        let text = format!(
            "# Metres of a displacement map: bias + scale (2 h - 1), where h is 0 for black and 1 for white.\n\
             scale = {:?}\nbias = {:?}\n",
            self.scale, self.bias
        );
        std::fs::write(&metres, text).map_err(|e| unwritable_file(&metres, &e))
    }

    /// Reads the files of [`DisplacementMap::save`]. Other programs may have changed the image:
    /// only its first channel is used, with 8 or 16 bits.
    ///
    /// # Errors
    /// Returns an error if one of the two files can't be read or is invalid.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, SceneError> {
        let path = path.as_ref();
        let [scale, bias] = read_metres(&metadata_path(path))?;
        let image = load_image(path, &FilesOnDisk)?.to_rgba16();
        let size = UVec2::new(image.width(), image.height());
        let file = path.display().to_string();
        super::map::check_size(size).map_err(|fault| SceneError::Invalid { file, fault })?;
        Ok(Self {
            size,
            greys: image.pixels().map(|p| p.0[0]).collect(),
            scale,
            bias,
        })
    }
}

fn unwritable_file(file: &Path, why: &dyn std::fmt::Display) -> SceneError {
    SceneError::Unwritable {
        file: file.display().to_string(),
        why: format!("can't be written: {why}"),
        help: "check that its folder exists and is writable".to_owned(),
    }
}

/// Returns `map.png.toml` for `map.png`: adjacent in a list of files, and never the name of a
/// scene.
fn metadata_path(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".toml");
    PathBuf::from(name)
}

/// Returns scale and bias, metres.
fn read_metres(path: &Path) -> Result<[f32; 2], SceneError> {
    let text = std::fs::read_to_string(path)
        .map_err(|e| SceneError::unreadable_file(path, &e, &FilesOnDisk))?;
    parse_metres(&text).map_err(|fault| SceneError::Invalid {
        file: path.display().to_string(),
        fault,
    })
}

fn parse_metres(text: &str) -> Result<[f32; 2], Invalid> {
    let table: toml::Table = text.parse().map_err(|e: toml::de::Error| {
        Invalid::new(
            "scale and bias of the map",
            e.message(),
            "save the map again",
        )
    })?;
    let scale = number(&table, "scale")?;
    let bias = number(&table, "bias")?;
    invalid::not_negative("`scale`", scale)?;
    invalid::finite("`bias`", &[bias])?;
    Ok([scale, bias])
}

fn number(table: &toml::Table, key: &str) -> Result<f32, Invalid> {
    match table.get(key) {
        Some(toml::Value::Float(value)) => Ok(*value as f32),
        Some(toml::Value::Integer(value)) => Ok(*value as f64 as f32),
        _ => {
            let help = format!("add `{key} = 0.01`");
            Err(Invalid::new(
                format!("`{key}`"),
                "is missing or not a number",
                help,
            ))
        }
    }
}
