//! Several images in one file, to reduce the number of files of a page.

use anyhow::{Context as _, Result, ensure};
use image::{
    DynamicImage, GenericImage as _, Rgb, RgbImage,
    codecs::png::{CompressionType, FilterType, PngEncoder},
    imageops::{self, resize},
};
use std::{
    fs::{self, File},
    io::BufWriter,
    path::Path,
};
use umbrage::glam::UVec2;

/// Pixels between two images.
const GAP: u32 = 4;
/// Greatest width of a file, pixels. Pages scale wider images down.
const MAX_WIDTH: u32 = 1000;

/// Images in rows of `columns`.
pub struct Sheet {
    columns: u32,
    images: Vec<RgbImage>,
}

impl Sheet {
    /// Returns a sheet without images.
    pub fn new(columns: u32) -> Self {
        Self {
            columns: columns.max(1),
            images: Vec::new(),
        }
    }

    /// Appends an image to its row.
    pub fn push(&mut self, image: RgbImage) {
        self.images.push(image);
    }

    /// Adds the image of a PNG file's bytes.
    ///
    /// # Errors
    /// Returns an error if they are not a PNG file.
    pub fn push_png(&mut self, png: &[u8]) -> Result<()> {
        self.push(image::load_from_memory(png)?.to_rgb8());
        Ok(())
    }

    /// Adds a mask: white is lit.
    pub fn push_mask(&mut self, size: UVec2, mask: &[f32]) {
        self.push(color_image(size, |i| [(mask[i] * 255.0).round() as u8; 3]));
    }

    /// Writes all images into a file, as grey if none has colours.
    ///
    /// # Errors
    /// Returns an error if there is no image, if sizes differ, or if the file can't be written.
    pub fn save(&self, path: &Path) -> Result<()> {
        let name = path.display();
        let first = self.images.first().context("a sheet without images")?;
        let cell = first.dimensions();
        let step = [cell.0 + GAP, cell.1 + GAP];
        let count = self.images.len() as u32;
        let width = step[0] * self.columns.min(count) - GAP;
        let height = step[1] * count.div_ceil(self.columns) - GAP;
        let mut all = RgbImage::from_pixel(width, height, Rgb([255; 3]));
        for (i, image) in (0..).zip(&self.images) {
            let size = image.dimensions();
            ensure!(
                size == cell,
                "images of {cell:?} and {size:?} pixels in {name}: use one size"
            );
            let corner = [step[0] * (i % self.columns), step[1] * (i / self.columns)];
            all.copy_from(image, corner[0], corner[1])?;
        }
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
        }
        if width > MAX_WIDTH {
            let height = height * MAX_WIDTH / width;
            all = resize(&all, MAX_WIDTH, height, imageops::FilterType::Triangle);
        }
        let is_grey = all.pixels().all(|pixel| pixel.0 == [pixel[0]; 3]);
        let all = DynamicImage::from(all);
        let file = BufWriter::new(File::create(path).with_context(|| name.to_string())?);
        // Compress as much as possible: the repository's history keeps each version.
        let encoder =
            PngEncoder::new_with_quality(file, CompressionType::Best, FilterType::NoFilter);
        let written = if is_grey {
            all.to_luma8().write_with_encoder(encoder)
        } else {
            all.write_with_encoder(encoder)
        };
        written.with_context(|| name.to_string())?;
        println!("{name}: {} x {}", all.width(), all.height());
        Ok(())
    }
}

/// Returns an image from the colour of each pixel, by its index.
pub fn color_image(size: UVec2, color: impl Fn(usize) -> [u8; 3]) -> RgbImage {
    RgbImage::from_fn(size.x, size.y, |x, y| Rgb(color((y * size.x + x) as usize)))
}
