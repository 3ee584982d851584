//! The images of the documentation's pages: `cargo run --release --example gallery -- failures`.

mod causes;
mod denoise;
mod failures;
mod lists;
mod penumbrae;
mod textbook;

use anyhow::{Context as _, Result};
use clap::Parser;
use image::{Rgb, RgbImage};
use std::path::{Path, PathBuf};
use umbrage_examples::sheet::Sheet;

/// Size of the crop of `--crop`, pixels.
const CROP: [u32; 2] = [320, 240];

/// Generates the images of the documentation's pages.
#[derive(Parser)]
enum Gallery {
    /// Textbook shadow effects, artefacts next to fixes, as an HTML page.
    Textbook {
        /// Folder for the page and its images.
        #[arg(default_value = "target/textbook")]
        folder: PathBuf,
    },
    /// Failures next to fixes, and the table of their errors in `docs/failures.md`.
    Failures {
        /// Folder for the images. If it is set, the table is not written.
        folder: Option<PathBuf>,
    },
    /// A mask and its errors for each cause of error.
    Causes {
        #[arg(default_value = "docs/causes.png")]
        file: PathBuf,
    },
    /// Penumbrae of `pcss`, of rays in about the time of `soft`, and of `soft`.
    Penumbrae {
        #[arg(default_value = "docs/soft.png")]
        file: PathBuf,
    },
    /// The lists that `exact` reads: their lengths, their cells, and the mask.
    Lists {
        #[arg(default_value = "docs/exact.png")]
        file: PathBuf,
    },
    /// Noisy meshes, and the same meshes after denoising by displacement maps.
    Denoise {
        /// Folder for maps and images.
        #[arg(default_value = "target/denoise")]
        folder: PathBuf,
    },
    /// Images in rows, as one file.
    Sheet {
        file: PathBuf,
        /// PNG files of one size; `-` leaves a position empty.
        #[arg(required = true)]
        images: Vec<PathBuf>,
        /// Number of images in a row.
        #[arg(long, default_value_t = 2)]
        columns: u32,
        /// Crops each image to 320x240 pixels from this corner: LEFT,TOP.
        #[arg(long, value_parser = parse_corner)]
        crop: Option<[u32; 2]>,
    },
}

fn main() -> Result<()> {
    match Gallery::parse() {
        Gallery::Textbook { folder } => textbook::write(&folder),
        Gallery::Failures { folder } => failures::write(folder.as_deref()),
        Gallery::Causes { file } => causes::write(&file),
        Gallery::Penumbrae { file } => penumbrae::write(&file),
        Gallery::Lists { file } => lists::write(&file),
        Gallery::Denoise { folder } => denoise::write(&folder),
        Gallery::Sheet {
            file,
            images,
            columns,
            crop,
        } => sheet(&file, &images, columns, crop),
    }
}

fn parse_corner(text: &str) -> Result<[u32; 2], String> {
    let help = || format!("`{text}` is not a position: use LEFT,TOP, such as 60,170");
    let (left, top) = text.split_once(',').ok_or_else(help)?;
    let number = |text: &str| text.parse().map_err(|_| help());
    Ok([number(left)?, number(top)?])
}

fn sheet(file: &Path, paths: &[PathBuf], columns: u32, crop: Option<[u32; 2]>) -> Result<()> {
    let images = paths.iter().map(|path| read(path, crop));
    let images: Vec<Option<RgbImage>> = images.collect::<Result<_>>()?;
    let size = images.iter().flatten().next().map(RgbImage::dimensions);
    let (width, height) = size.context("a sheet of empty places")?;
    let mut sheet = Sheet::new(columns);
    for image in images {
        let empty = || RgbImage::from_pixel(width, height, Rgb([255; 3]));
        sheet.push(image.unwrap_or_else(empty));
    }
    sheet.save(file)
}

/// Reads an image, or a part of it; `None` for `-`.
fn read(path: &Path, crop: Option<[u32; 2]>) -> Result<Option<RgbImage>> {
    if path == Path::new("-") {
        return Ok(None);
    }
    let name = path.display().to_string();
    let image = image::open(path).with_context(|| name.clone())?.to_rgb8();
    let Some([left, top]) = crop else {
        return Ok(Some(image));
    };
    let is_inside = left.saturating_add(CROP[0]) <= image.width()
        && top.saturating_add(CROP[1]) <= image.height();
    anyhow::ensure!(
        is_inside,
        "{name} has {} x {} pixels: 320 x 240 from {left},{top} on are not all in it",
        image.width(),
        image.height()
    );
    let part = image::imageops::crop_imm(&image, left, top, CROP[0], CROP[1]);
    Ok(Some(part.to_image()))
}
