//! Pictures of cells: truth, mask and error side by side, or frames.

use super::case_truth::CaseTruth;
use crate::{LabError, output::png};
use glam::{UVec2, Vec3};

/// Pixels between two pictures.
const BETWEEN: usize = 4;
/// Frames shown of a strip.
const FRAMES: usize = 4;
/// What changes by this much on average is shown in full colour: a quarter of the light.
const CHANGE: f32 = 0.25;

/// Truth, mask and error side by side, a PNG.
pub(super) fn beside(case_truth: &CaseTruth, mask: &[f32]) -> Result<Vec<u8>, LabError> {
    let truth = &case_truth.truth;
    let parts = [
        png::mask_colors(&truth.visibility, &truth.pixels),
        png::mask_colors(mask, &truth.pixels),
        png::error_colors(mask, &truth.visibility, &truth.pixels),
    ];
    row(truth.size, &parts)
}

/// The first frames' masks side by side, then where they change: orange. A PNG.
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

fn changes(masks: &[Vec<f32>], marked: &[bool]) -> Vec<Vec3> {
    let pairs = masks.len().saturating_sub(1).max(1) as f32;
    let mean = |i: usize| {
        masks
            .array_windows()
            .map(|[a, b]| (a[i] - b[i]).abs())
            .sum::<f32>()
            / pairs
    };
    let color = |i: usize| {
        let background = Vec3::splat(if marked[i] { 0.85 } else { 0.95 });
        background.lerp(png::FALSE_LIGHT, (mean(i) / CHANGE).min(1.0))
    };
    (0..marked.len()).map(color).collect()
}

/// Pictures of one size in a row.
fn row(size: UVec2, parts: &[Vec<Vec3>]) -> Result<Vec<u8>, LabError> {
    let (w, h) = (size.x as usize, size.y as usize);
    let whole = parts.len() * (w + BETWEEN) - BETWEEN;
    let mut colors = vec![Vec3::ONE; whole * h];
    for (k, part) in parts.iter().enumerate() {
        for y in 0..h {
            let start = y * whole + k * (w + BETWEEN);
            colors[start..start + w].copy_from_slice(&part[y * w..][..w]);
        }
    }
    png::encode(UVec2::new(whole as u32, size.y), colors.into_iter())
}
