//! Small images of the answers: truth, mask and error on the first scene of each group.

use super::{PICTURES, groups::WhichGroup};
use crate::{
    compare::{CompareRow, SceneResult},
    error::LabError,
    output::{folder::Folder, png, slug},
    report::MeasuredScene,
};
use glam::UVec2;
use image::RgbImage;
use std::path::{Path, PathBuf};

/// Width of each of the images side by side, pixels.
const WIDTH: usize = 168;
/// Gap between two of them, pixels.
const GAP: usize = 4;

/// Image file of each answer, by group, relative to the page; `None` if the comparison kept none.
pub(super) type Shown = Vec<Vec<Option<String>>>;

/// Writes the images of all answers.
pub(super) fn write(
    folder: &Folder,
    groups: &[WhichGroup],
    scenes: &[MeasuredScene],
) -> Result<Shown, LabError> {
    let unfinished = folder.unfinished_folder(PICTURES)?;
    let mut out = Vec::new();
    for group in groups {
        // Use the first scene: all scenes of a group are of one kind.
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
            unfinished.write(&name, &side_by_side(&parts)?)?;
            of_group.push(Some(format!("{PICTURES}/{name}")));
        }
        out.push(of_group);
    }
    folder.finish(PICTURES)?;
    Ok(out)
}

/// Returns the mask's and the error's file of the first row that has them, else of the first such
/// row that one of `rows` repeats.
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

/// Returns images side by side, each [`WIDTH`] wide, as a PNG.
fn side_by_side(files: &[PathBuf; 3]) -> Result<Vec<u8>, LabError> {
    let mut small: Vec<Small> = Vec::new();
    for file in files {
        let whole = image::open(file).map_err(|e| LabError::write(file, e))?;
        small.push(Small::downscaled(&whole.to_rgb8()));
    }
    let height = small
        .iter()
        .map(|picture| picture.height)
        .max()
        .unwrap_or(1);
    let width = (WIDTH + GAP) * small.len() - GAP;
    let mut texels = vec![255; 3 * width * height];
    for (i, picture) in small.iter().enumerate() {
        for y in 0..picture.height {
            let start = 3 * (y * width + i * (WIDTH + GAP));
            let line = &picture.texels[3 * WIDTH * y..][..3 * WIDTH];
            texels[start..start + 3 * WIDTH].copy_from_slice(line);
        }
    }
    png::encode_rgb(UVec2::new(width as u32, height as u32), &texels)
}

/// An image [`WIDTH`] wide, three bytes per pixel.
struct Small {
    height: usize,
    texels: Vec<u8>,
}

impl Small {
    /// Averages blocks of a larger image.
    fn downscaled(whole: &RgbImage) -> Self {
        let [w, h] = [whole.width(), whole.height()].map(|side| side.max(1) as usize);
        let height = (WIDTH * h).div_ceil(w);
        // First source pixel of a small image's pixel; each pixel has at least one.
        let from = |i: usize, sides: [usize; 2]| i * sides[0] / sides[1];
        let range = |i, sides: [usize; 2]| {
            let first = from(i, sides).min(sides[0] - 1);
            first..from(i + 1, sides).clamp(first + 1, sides[0])
        };
        let mut texels = Vec::with_capacity(3 * WIDTH * height);
        for y in 0..height {
            for x in 0..WIDTH {
                let mut sum = [0_u32; 3];
                let mut count = 0;
                for v in range(y, [h, height]) {
                    for u in range(x, [w, WIDTH]) {
                        let color = whole.get_pixel(u as u32, v as u32).0;
                        for (sum, c) in sum.iter_mut().zip(color) {
                            *sum += u32::from(c);
                        }
                        count += 1;
                    }
                }
                texels.extend(sum.map(|sum| coarse(sum / count)));
            }
        }
        Self { height, texels }
    }
}

/// Quantizes a component, 0..=255, to sixteen levels: files are half as large, and the difference
/// is invisible at this size.
fn coarse(component: u32) -> u8 {
    ((component + LEVEL / 2) / LEVEL * LEVEL).min(255) as u8
}

/// Step between two levels.
const LEVEL: u32 = 17;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_pictures_are_means_in_sixteen_levels() {
        let whole = RgbImage::from_fn(2 * WIDTH as u32, 4, |x, _| {
            image::Rgb(if x % 2 == 0 {
                [0, 255, 60]
            } else {
                [100, 255, 60]
            })
        });
        let small = Small::downscaled(&whole);
        assert_eq!((small.height, small.texels.len()), (2, 6 * WIDTH));
        // Half of 100 is 50; the nearest level is 51.
        assert_eq!(small.texels[..3], [51, 255, 68]);
        // A smaller image's pixels are repeated.
        let tiny = RgbImage::from_pixel(4, 3, image::Rgb([255, 0, 0]));
        assert_eq!(Small::downscaled(&tiny).height, WIDTH * 3 / 4);
    }
}
