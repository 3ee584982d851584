//! Images of cells: truth, mask and error side by side, or a strip of frames.

use super::case_truth::CaseTruth;
use crate::{error::LabError, output::png};
use glam::{UVec2, Vec3};

/// Pixels between two images.
const GAP: usize = 4;
/// Number of frames in a strip.
const FRAMES: usize = 4;
/// Mean change of visibility that has full color.
const FULL_COLOR_CHANGE: f32 = 0.25;

/// Returns truth, mask and error side by side, as a PNG.
pub(super) fn side_by_side(case_truth: &CaseTruth, mask: &[f32]) -> Result<Vec<u8>, LabError> {
    let truth = &case_truth.truth;
    let parts = [
        png::mask_colors(&truth.visibility, &truth.pixels),
        png::mask_colors(mask, &truth.pixels),
        png::error_colors(mask, &truth.visibility, &truth.pixels),
    ];
    row(truth.size, &parts)
}

/// Returns the first frames' masks side by side, then an image of their changes in orange, as a
/// PNG.
pub(super) fn strip(
    case_truth: &CaseTruth,
    masks: &[Vec<f32>],
    marked: &[bool],
) -> Result<Vec<u8>, LabError> {
    let pixels = &case_truth.truth.pixels;
    let mut parts: Vec<Vec<Vec3>> = masks
        .iter()
        .take(FRAMES)
        .map(|m| png::mask_colors(m, pixels))
        .collect();
    parts.push(changes(masks, marked));
    row(case_truth.truth.size, &parts)
}

/// Returns each pixel's color from the mean of |V_t - V_(t-1)| over all pairs of neighboring
/// frames.
fn changes(masks: &[Vec<f32>], marked: &[bool]) -> Vec<Vec3> {
    let pairs = masks.len().saturating_sub(1).max(1) as f32;
    let mut colors = Vec::with_capacity(marked.len());
    for (i, is_marked) in marked.iter().enumerate() {
        let mut sum = 0.0_f32;
        for pair in masks.windows(2) {
            sum += (pair[0][i] - pair[1][i]).abs();
        }
        let mean = sum / pairs;
        // Give points that count a darker background.
        let background = Vec3::splat(if *is_marked { 0.85 } else { 0.95 });
        let strength = (mean / FULL_COLOR_CHANGE).min(1.0);
        colors.push(background.lerp(png::FALSE_LIGHT, strength));
    }
    colors
}

/// Returns images of one size in a row, as a PNG.
fn row(size: UVec2, parts: &[Vec<Vec3>]) -> Result<Vec<u8>, LabError> {
    let part_width = size.x as usize;
    let height = size.y as usize;
    let width = parts.len() * (part_width + GAP) - GAP;
    let mut colors = vec![Vec3::ONE; width * height];
    for (k, part) in parts.iter().enumerate() {
        for y in 0..height {
            let start = y * width + k * (part_width + GAP);
            let source = &part[y * part_width..][..part_width];
            colors[start..start + part_width].copy_from_slice(source);
        }
    }
    png::encode(UVec2::new(width as u32, size.y), colors.into_iter())
}
