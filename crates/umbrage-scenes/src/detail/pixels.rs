//! Textures from images.

use crate::{Files, SceneError};
use image::{
    DynamicImage, ImageError, ImageFormat, ImageReader, ImageResult, Limits, error::DecodingError,
};
use std::{
    io::{BufRead, Read, Result as IoResult, Seek, SeekFrom},
    path::Path,
};
use umbrage_core::glam::UVec2;
use umbrage_core::{Texture, picture};

/// Greatest number of texels along a side: 1 GiB in memory for a square.
pub(crate) const PICTURE_SIDE: u32 = 8192;

/// Meaning of a file's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Meaning {
    /// Colours encoded as sRGB. This module decodes them, and no other.
    Color,
    /// Normals or heights, without conversion.
    Data,
    /// Opacity: the file's alpha, or the unconverted first channel of a file without alpha. The
    /// colours are white.
    Alpha,
}

/// Loads a texture from a PNG file of 8 or 16 bits a channel; 1, 2 and 4 bits are widened. Grey
/// fills all three channels. Alpha is 1 if the file has none.
pub(crate) fn load_texture(
    path: &Path,
    files: &dyn Files,
    meaning: Meaning,
) -> Result<Texture, SceneError> {
    let image = load_image(path, files)?;
    let name = path
        .file_name()
        .unwrap_or(path.as_os_str())
        .to_string_lossy()
        .into_owned();
    Ok(texture_of(name, &image, meaning))
}

/// Converts an image to a texture: see [`load_texture`].
pub(crate) fn texture_of(name: String, picture: &DynamicImage, meaning: Meaning) -> Texture {
    let mut texels = texels(picture, meaning);
    if meaning == Meaning::Alpha {
        let channel = if picture.color().has_alpha() { 3 } else { 0 };
        for texel in &mut texels {
            *texel = [1.0, 1.0, 1.0, texel[channel]];
        }
    }
    Texture {
        name,
        size: UVec2::new(picture.width(), picture.height()),
        texels,
    }
}

pub(super) fn load_image(path: &Path, files: &dyn Files) -> Result<DynamicImage, SceneError> {
    let source = files
        .open(path)
        .map_err(|e| SceneError::unreadable_file(path, &e, files))?;
    decode_picture(source, ImageFormat::Png).map_err(|e| SceneError::Unreadable {
        file: path.display().to_string(),
        why: format!("can't be read as a PNG image: {e}"),
        help: format!("save it as PNG, at most {PICTURE_SIDE} texels a side"),
    })
}

/// Decodes an image of at most [`PICTURE_SIDE`] texels a side.
pub(crate) fn decode_picture(
    mut source: impl BufRead + Seek,
    format: ImageFormat,
) -> ImageResult<DynamicImage> {
    if format == ImageFormat::Png {
        // Reject palettes that end within a colour: the crate `png` 0.18.1 panics on them.
        let begin = source.stream_position()?;
        let bytes = palette_bytes(&mut source)?;
        source.seek(SeekFrom::Start(begin))?;
        if bytes % 3 != 0 {
            let why = format!("its palette has {bytes} bytes, which is not a multiple of 3");
            return Err(ImageError::Decoding(DecodingError::new(format.into(), why)));
        }
    }
    let mut limits = Limits::default();
    limits.max_image_width = Some(PICTURE_SIDE);
    limits.max_image_height = Some(PICTURE_SIDE);
    let mut reader = ImageReader::with_format(source, format);
    reader.limits(limits);
    reader.decode()
}

/// Returns the declared length of a PNG file's palette, bytes. It is 0 if the file has no palette
/// before its pixels, or is truncated. Each chunk is its length, its name, its bytes and a
/// checksum: "Portable Network Graphics (PNG) Specification (Third Edition)", W3C 2025, 5.3.
fn palette_bytes(source: &mut (impl Read + Seek)) -> IoResult<u64> {
    const SIGNATURE: i64 = 8;
    const CHECKSUM: i64 = 4;
    source.seek(SeekFrom::Current(SIGNATURE))?;
    loop {
        let mut head = [0; 8];
        if source.read_exact(&mut head).is_err() {
            return Ok(0);
        }
        let [a, b, c, d, name @ ..] = head;
        let length = u32::from_be_bytes([a, b, c, d]);
        match &name {
            b"PLTE" => return Ok(length.into()),
            b"IDAT" | b"IEND" => return Ok(0),
            _ => source.seek(SeekFrom::Current(i64::from(length) + CHECKSUM))?,
        };
    }
}

fn texels(image: &DynamicImage, meaning: Meaning) -> Vec<[f32; 4]> {
    let channels = u32::from(image.color().channel_count()).max(1);
    let bits = u32::from(image.color().bits_per_pixel()) / channels;
    if bits > 8 {
        let value = match meaning {
            Meaning::Color => picture::decode_16,
            Meaning::Data | Meaning::Alpha => |word| f32::from(word) / 65535.0,
        };
        let wide = image.to_rgba16();
        return wide
            .pixels()
            .map(|p| texel(p.0.map(value), f32::from(p.0[3]) / 65535.0))
            .collect();
    }
    let value = match meaning {
        Meaning::Color => picture::decode,
        Meaning::Data | Meaning::Alpha => |byte| f32::from(byte) / 255.0,
    };
    // Tabulate the decoding: a power for each texel would take longer than reading the file.
    let table: [f32; 256] = std::array::from_fn(|i| value(i as u8));
    let narrow = image.to_rgba8();
    narrow
        .pixels()
        .map(|p| {
            texel(
                p.0.map(|byte| table[usize::from(byte)]),
                f32::from(p.0[3]) / 255.0,
            )
        })
        .collect()
}

/// Returns a texel's decoded colour with its alpha, which is always linear.
fn texel(decoded: [f32; 4], alpha: f32) -> [f32; 4] {
    let [red, green, blue, _] = decoded;
    [red, green, blue, alpha]
}

#[cfg(test)]
#[path = "pixels_tests.rs"]
mod tests;
