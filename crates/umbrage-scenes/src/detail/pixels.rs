//! Textures from images.

use crate::{Files, SceneError};
use image::{
    DynamicImage, ImageDecoder as _, ImageError, ImageFormat, ImageReader, ImageResult, Limits,
    error::DecodingError,
};
use std::{
    io::{BufRead, Cursor, Read, Result as IoResult, Seek, SeekFrom},
    ops::Range,
    path::Path,
    sync::Arc,
};
use umbrage_core::glam::UVec2;
use umbrage_core::{Texels, Texture, parallel::prelude::*, picture};

/// Returns the kinds of images that are read, for messages.
pub(crate) fn kinds_of_pictures() -> &'static str {
    if cfg!(feature = "gltf") {
        "PNG or JPEG"
    } else {
        "PNG"
    }
}

/// Returns the format of an image file by its ending; `None` if it isn't read. JPEG needs the
/// feature `gltf`.
pub(crate) fn picture_format(path: &Path) -> Option<ImageFormat> {
    let format = ImageFormat::from_path(path).ok()?;
    let is_read =
        format == ImageFormat::Png || format == ImageFormat::Jpeg && cfg!(feature = "gltf");
    is_read.then_some(format)
}

/// Greatest number of texels along a side: 256 MiB in memory for a square, or 1 GiB as floats.
pub(crate) const PICTURE_SIDE: u32 = 8192;

/// Meaning of a file's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Meaning {
    /// Colours encoded as sRGB. This module decodes them, and no other. Alpha is not used.
    Color,
    /// Colours encoded as sRGB of an alpha-tested surface, whose alpha test is another texture.
    /// Means are weighted by alpha: the colours of holes don't show.
    CutOutColor,
    /// Colours encoded as sRGB, with an alpha test.
    CutOut,
    /// Normals, without conversion.
    Normals,
    /// Heights, without conversion.
    Heights,
    /// Opacity: the file's alpha, or the unconverted first channel of a file without alpha. The
    /// colours are white.
    Alpha,
}

impl Meaning {
    /// Returns whether shadows don't depend on it.
    pub(crate) fn is_only_shown(self) -> bool {
        matches!(self, Self::Color | Self::CutOutColor | Self::Normals)
    }

    /// Returns whether the file's colours are encoded as sRGB.
    fn is_encoded(self) -> bool {
        matches!(self, Self::Color | Self::CutOut | Self::CutOutColor)
    }
}

/// An encoded image, to be decoded to a texture.
#[derive(Clone, Debug)]
pub(crate) struct EncodedImage {
    pub(crate) name: String,
    pub(crate) bytes: Vec<u8>,
    pub(crate) format: ImageFormat,
    pub(crate) meaning: Meaning,
    /// Greatest side of a texture that has no effect on shadows: see
    /// [`Files::color_side`](crate::Files::color_side).
    pub(crate) color_side: u32,
}

impl EncodedImage {
    /// Reads the size from the header, and whether there is an alpha channel.
    pub(crate) fn header(&self) -> ImageResult<(UVec2, bool)> {
        let source = Cursor::new(&self.bytes);
        let decoder = ImageReader::with_format(source, self.format).into_decoder()?;
        let size = UVec2::from(decoder.dimensions());
        Ok((size, decoder.color_type().has_alpha()))
    }

    /// Decodes the image. PNG files have 8 or 16 bits a channel; 1, 2 and 4 bits are widened. Grey
    /// fills all three channels. Alpha is 1 if the file has none.
    pub(crate) fn texture(&self) -> ImageResult<Texture> {
        let image = decode_picture(Cursor::new(&self.bytes), self.format)?;
        // Without a transparent texel, an alpha test has no holes at any size.
        let is_reduced =
            self.meaning.is_only_shown() || self.meaning == Meaning::CutOut && is_opaque(&image);
        let size = UVec2::new(image.width(), image.height());
        let size = if is_reduced {
            reduced_size(size, self.color_side)
        } else {
            size
        };
        let is_whole = size == UVec2::new(image.width(), image.height());
        let texels = if is_whole && has_bytes(&image) {
            whole_texels(image, self.meaning)
        } else {
            averaged_texels(&image, self.meaning, size)
        };
        Ok(Texture {
            name: self.name.clone(),
            size,
            texels,
        })
    }
}

/// Images that are decoded together, on all threads.
#[derive(Clone, Debug, Default)]
pub(crate) struct PendingImages {
    images: Vec<(usize, EncodedImage)>,
}

impl PendingImages {
    /// Adds a texture without texels for an image, and returns its index.
    pub(crate) fn add(&mut self, image: EncodedImage, textures: &mut Vec<Texture>) -> usize {
        textures.push(Texture {
            name: image.name.clone(),
            ..Texture::default()
        });
        self.images.push((textures.len() - 1, image));
        textures.len() - 1
    }

    /// Decodes the images. Returns the first texture whose image can't be decoded, and why.
    pub(crate) fn decode(&mut self, textures: &mut [Texture]) -> Result<(), (usize, ImageError)> {
        let images = std::mem::take(&mut self.images);
        let decoded: Vec<_> = images
            .into_par_iter()
            .map(|(index, image)| (index, image.texture()))
            .collect();
        for (index, texture) in decoded {
            textures[index] = texture.map_err(|why| (index, why))?;
        }
        Ok(())
    }
}

/// Returns the size of a texture of at most `side` texels a side: whole numbers of texels are
/// averaged.
fn reduced_size(size: UVec2, side: u32) -> UVec2 {
    let factor = size.max_element().div_ceil(side.max(1)).max(1);
    UVec2::new(size.x.div_ceil(factor), size.y.div_ceil(factor))
}

/// Returns whether no texel is transparent. `false` for transparent channels of 16 bits, which are
/// rare.
fn is_opaque(image: &DynamicImage) -> bool {
    let channels = match image {
        DynamicImage::ImageLumaA8(_) => 2,
        DynamicImage::ImageRgba8(_) => 4,
        _ => return !image.color().has_alpha(),
    };
    let alphas = image.as_bytes().iter().skip(channels - 1).step_by(channels);
    let mut alphas = alphas.copied();
    alphas.all(|alpha| alpha == u8::MAX)
}

pub(super) fn load_image(path: &Path, files: &dyn Files) -> Result<DynamicImage, SceneError> {
    let source = files
        .open(path)
        .map_err(|e| SceneError::unreadable_file(path, &e, files))?;
    decode_picture(source, ImageFormat::Png).map_err(|e| unreadable_image(path, &e))
}

/// Returns the error of an image file that can't be decoded.
pub(super) fn unreadable_image(path: &Path, why: &ImageError) -> SceneError {
    SceneError::Unreadable {
        file: path.display().to_string(),
        why: format!("can't be read as a {} image: {why}", kinds_of_pictures()),
        help: format!(
            "save it as {}, at most {PICTURE_SIDE} texels a side",
            kinds_of_pictures()
        ),
    }
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

/// Returns whether channels have 8 bits.
fn has_bytes(image: &DynamicImage) -> bool {
    image.color().bytes_per_pixel() == image.color().channel_count()
}

/// Returns the texels of an image of 8 bits a channel, at its size.
fn whole_texels(image: DynamicImage, meaning: Meaning) -> Texels {
    let has_alpha = image.color().has_alpha();
    let mut texels = rgba_bytes(image);
    if meaning == Meaning::Alpha {
        let channel = if has_alpha { 3 } else { 0 };
        for texel in &mut texels {
            *texel = [u8::MAX, u8::MAX, u8::MAX, texel[channel]];
        }
    }
    if meaning.is_encoded() {
        Texels::Srgb8(Arc::new(texels))
    } else {
        Texels::Unorm8(Arc::new(texels))
    }
}

/// Returns four bytes for each pixel of an image of 8 bits a channel. One channel is grey; the last
/// of two or four is opacity.
fn rgba_bytes(image: DynamicImage) -> Vec<[u8; 4]> {
    let channels = usize::from(image.color().channel_count()).max(1);
    let mut samples = image.into_bytes();
    if channels < 4 {
        // Widen in place, from the end: a copy would double the memory.
        let count = samples.len() / channels;
        samples.resize(4 * count, u8::MAX);
        let [green, blue] = if channels < 3 { [0, 0] } else { [1, 2] };
        for i in (0..count).rev() {
            let pixel = &samples[channels * i..channels * (i + 1)];
            let alpha = match channels % 2 {
                0 => pixel[channels - 1],
                _ => u8::MAX,
            };
            let texel = [pixel[0], pixel[green], pixel[blue], alpha];
            samples[4 * i..4 * i + 4].copy_from_slice(&texel);
        }
    }
    bytemuck::cast_slice_box(samples.into_boxed_slice()).into_vec()
}

/// Returns texels of an image, reduced to `size`.
fn averaged_texels(image: &DynamicImage, meaning: Meaning, size: UVec2) -> Texels {
    let mut texels = averaged_values(image, meaning, size);
    if meaning == Meaning::Alpha {
        let channel = if image.color().has_alpha() { 3 } else { 0 };
        for texel in &mut texels {
            *texel = [1.0, 1.0, 1.0, texel[channel]];
        }
    }
    texels.into()
}

/// Returns the means of an image's channels for each texel of `size`.
fn averaged_values(image: &DynamicImage, meaning: Meaning, size: UVec2) -> Vec<[f32; 4]> {
    let is_color = meaning.is_encoded();
    let weighs = meaning == Meaning::CutOutColor;
    let from = UVec2::new(image.width(), image.height());
    let channels = usize::from(image.color().channel_count()).max(1);
    if !has_bytes(image) {
        let opacity = |word: u16| f32::from(word) / 65535.0;
        let value = if is_color {
            picture::decode_16
        } else {
            opacity
        };
        let wide = image.to_rgba16();
        return averages(wide.as_raw(), 4, from, size, weighs, &value, &opacity);
    }
    let opacity = |byte: u8| f32::from(byte) / 255.0;
    let value = if is_color { picture::decode } else { opacity };
    let table: [f32; 256] = std::array::from_fn(|i| value(i as u8));
    let value = |byte: u8| table[usize::from(byte)];
    // Read the file's own channels: a copy with four of them takes as long as decoding.
    averages(
        image.as_bytes(),
        channels,
        from,
        size,
        weighs,
        &value,
        &opacity,
    )
}

/// Weight of a colour without opacity: where all of a box is transparent, its mean is that of the
/// colours. Elsewhere it is far below one step of 8 bits.
const LEAST_WEIGHT: f32 = 1.0 / 1_048_576.0;

/// Returns the means of boxes of pixels, one for each texel of the size `to`. Means of colours are
/// those of linear light, and weighted by opacity if `weighs`. One channel is grey; the last of two
/// or four is opacity.
fn averages<T: Copy + Sync>(
    samples: &[T],
    channels: usize,
    from: UVec2,
    to: UVec2,
    weighs: bool,
    value: &(impl Fn(T) -> f32 + Sync),
    opacity: &(impl Fn(T) -> f32 + Sync),
) -> Vec<[f32; 4]> {
    let [green, blue] = if channels < 3 { [0, 0] } else { [1, 2] };
    let pixel = |sample: &[T]| {
        let alpha = match channels % 2 {
            0 => opacity(sample[channels - 1]),
            _ => 1.0,
        };
        let weight = if weighs { alpha + LEAST_WEIGHT } else { 1.0 };
        [
            weight * value(sample[0]),
            weight * value(sample[green]),
            weight * value(sample[blue]),
            alpha,
            weight,
        ]
    };
    let add = |sum: &mut [f32; 5], part: [f32; 5]| {
        sum.iter_mut()
            .zip(part)
            .for_each(|(sum, part)| *sum += part);
    };
    let width = from.x as usize * channels;
    let mut out = vec![[0.0; 4]; (to.x * to.y) as usize];
    let rows = out.par_chunks_mut(to.x as usize).enumerate();
    rows.for_each(|(j, row)| {
        let down = box_of(j, from.y, to.y);
        let mut sums = vec![[0.0; 5]; row.len()];
        // Add the pixels of each box, a row of pixels at a time.
        for line in samples[down.start * width..down.end * width].chunks_exact(width) {
            for (i, sum) in sums.iter_mut().enumerate() {
                let across = box_of(i, from.x, to.x);
                let mut part = [0.0; 5];
                line[across.start * channels..across.end * channels]
                    .chunks_exact(channels)
                    .for_each(|sample| add(&mut part, pixel(sample)));
                add(sum, part);
            }
        }
        for (i, (texel, sum)) in row.iter_mut().zip(sums).enumerate() {
            let count = down.len() * box_of(i, from.x, to.x).len();
            let [red, green, blue, alpha, weight] = sum;
            // Divide: products with 1 / count would not keep an alpha of 1.
            *texel = [
                red / weight,
                green / weight,
                blue / weight,
                alpha / count as f32,
            ];
        }
    });
    out
}

/// Returns the pixels along one axis, of `from`, that texel `i` of `to` averages.
fn box_of(i: usize, from: u32, to: u32) -> Range<usize> {
    let (from, to) = (from as usize, to as usize);
    i * from / to..(i + 1) * from / to
}

#[cfg(test)]
#[path = "pixels_tests.rs"]
mod tests;
