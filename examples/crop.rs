//! Cuts 320x240 pixels out of a picture, for pages: `cargo run --example crop -- FROM.png LEFT,TOP TO.png`.

use anyhow::{Context as _, ensure};
use image::{
    DynamicImage,
    codecs::png::{CompressionType, FilterType, PngEncoder},
};
use std::{fs::File, io::BufWriter};

const SIZE: [u32; 2] = [320, 240];

fn main() -> anyhow::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [from, corner, to] = &arguments[..] else {
        anyhow::bail!("use: crop FROM.png LEFT,TOP TO.png");
    };
    let (left, top) = corner
        .split_once(',')
        .with_context(|| format!("`{corner}` is no place: use LEFT,TOP, such as 60,170"))?;
    let left: u32 = left.parse().with_context(|| format!("`{left}`"))?;
    let top: u32 = top.parse().with_context(|| format!("`{top}`"))?;
    let picture = image::open(from).with_context(|| from.clone())?;
    let is_inside = left.saturating_add(SIZE[0]) <= picture.width()
        && top.saturating_add(SIZE[1]) <= picture.height();
    ensure!(
        is_inside,
        "{from} has {} x {} pixels: 320 x 240 from {left},{top} on are not all in it",
        picture.width(),
        picture.height()
    );
    let part = picture.crop_imm(left, top, SIZE[0], SIZE[1]).to_rgb8();
    let is_gray = part.pixels().all(|pixel| pixel.0 == [pixel[0]; 3]);
    let file = BufWriter::new(File::create(to).with_context(|| to.clone())?);
    // Pages and their history keep these pictures, so they are made as small as can be.
    let encoder = PngEncoder::new_with_quality(file, CompressionType::Best, FilterType::NoFilter);
    let written = if is_gray {
        DynamicImage::from(part)
            .to_luma8()
            .write_with_encoder(encoder)
    } else {
        part.write_with_encoder(encoder)
    };
    written.with_context(|| to.clone())
}
