//! Small pictures of the answers: truth, mask and error, on the first scene of each group.

use super::{PICTURES, groups::WhichGroup};
use crate::{
    LabError,
    compare::{CompareRow, SceneResult},
    output::{Folder, slug},
    report::MeasuredScene,
};
use image::{ImageFormat, RgbImage, imageops};
use std::{
    io::Cursor,
    path::{Path, PathBuf},
};

/// Width of each of the pictures that stand side by side, pixels.
const WIDTH: u32 = 200;
/// Pixels between two of them.
const GAP: u32 = 4;

/// For each group, for each answer, its picture's file, relative to the page; none where the comparison kept none.
pub(super) type Shown = Vec<Vec<Option<String>>>;

/// Writes the pictures of all answers.
pub(super) fn write(
    folder: &Folder,
    groups: &[WhichGroup],
    scenes: &[MeasuredScene],
) -> Result<Shown, LabError> {
    let unfinished = folder.unfinished(PICTURES)?;
    let mut out = Vec::new();
    for group in groups {
        // The first scene by name and place: all of a group are alike in kind.
        let Some(scene) = group.scenes.first().map(|&place| &scenes[place]) else {
            continue;
        };
        let mut of_group = Vec::new();
        for answer in &group.answers {
            let is_answer = |row: &&CompareRow| {
                row.technique == answer.technique && row.settings == answer.settings
            };
            let rows: Vec<&CompareRow> = scene.result.rows.iter().filter(is_answer).collect();
            let Some([mask, error]) = files(&scene.folder, &scene.result, &rows) else {
                of_group.push(None);
                continue;
            };
            let parts = [scene.folder.join("truth.png"), mask, error];
            let words = format!("{} {}", answer.technique, answer.settings);
            let name = format!("{}.{}.png", slug(&group.heading()), slug(&words));
            unfinished.write(&name, &beside(&parts)?)?;
            of_group.push(Some(format!("{PICTURES}/{name}")));
        }
        out.push(of_group);
    }
    folder.finish(PICTURES)?;
    Ok(out)
}

/// Returns the mask's and the error's file of the first row that has them; or of the rows whose figures it repeats.
fn files(folder: &Path, scene: &SceneResult, rows: &[&CompareRow]) -> Option<[PathBuf; 2]> {
    let of_row = |row: &CompareRow| {
        let stem = row.stem();
        let files = [format!("{stem}.png"), format!("{stem}.error.png")];
        Some(files.map(|name| folder.join(name))).filter(|files| files.iter().all(|f| f.is_file()))
    };
    let repeated = rows.iter().filter_map(|row| {
        let like = row.same_as.as_deref()?;
        let name = |other: &CompareRow| format!("{} ({})", other.technique, other.settings);
        scene.rows.iter().find(|other| name(other) == like)
    });
    let mut all = rows.iter().copied().chain(repeated);
    all.find_map(of_row)
}

/// Returns pictures side by side, each as wide as [`WIDTH`], as a PNG.
fn beside(files: &[PathBuf; 3]) -> Result<Vec<u8>, LabError> {
    let mut small: Vec<RgbImage> = Vec::new();
    for file in files {
        let whole = image::open(file)
            .map_err(|e| LabError::write(file, e))?
            .to_rgb8();
        let height = (WIDTH * whole.height())
            .div_ceil(whole.width().max(1))
            .max(1);
        small.push(imageops::resize(
            &whole,
            WIDTH,
            height,
            imageops::FilterType::Triangle,
        ));
    }
    let height = small.iter().map(RgbImage::height).max().unwrap_or(1);
    let width = (WIDTH + GAP) * small.len() as u32 - GAP;
    let mut out = RgbImage::from_pixel(width, height, image::Rgb([255; 3]));
    for (i, picture) in (0..).zip(&small) {
        imageops::replace(&mut out, picture, i * i64::from(WIDTH + GAP), 0);
    }
    let mut bytes = Cursor::new(Vec::new());
    out.write_to(&mut bytes, ImageFormat::Png)
        .map_err(|e| LabError::write(PICTURES, e))?;
    Ok(bytes.into_inner())
}
