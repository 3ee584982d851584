//! Shimmer: the change of a setting's visibility at fixed points, from frame to frame of a pan.
//! Truth does not change there.
//!
//! It is the mean of |V_t - V_(t-1)| over the sampled points visible in all frames, as in the
//! stability matrix. In each frame, points are evaluated one pixel further to the right, so that
//! patterns and noise that follow the pixel count.

use super::{sampled_truth::SampledTruth, scene::PlanScene};
use crate::{
    error::MeasureError,
    motion::{draws_the_picture, pan, pixel_shift},
};
use umbrage_core::{Camera, RecipeError, math::transform};
use umbrage_techniques::TechniquePreset;

/// Number of frames of the pan.
const FRAMES: u32 = 4;

/// Returns the mean change of a preset's visibility from frame to frame of a pan, 0..=1. Returns
/// `None` if the technique is unsupported, or draws into the camera's own image. The latter can't
/// be evaluated at points of another frame.
pub(crate) fn shimmer(
    scene: &mut PlanScene<'_>,
    sampled: &SampledTruth,
    preset: &TechniquePreset,
) -> Result<Option<f64>, MeasureError> {
    let cameras = pan(scene.camera, scene.geometry, FRAMES);
    // Keep the points that all frames see.
    let places: Vec<usize> = (0..sampled.truth.len())
        .filter(|&k| {
            let point = scene.receivers.position(sampled.sample.pixels[k] as usize);
            cameras.iter().all(|camera| sees(camera, point))
        })
        .collect();
    let mut last: Option<Vec<f32>> = None;
    let mut change = 0.0;
    // Evaluate each frame and compare it with the previous one.
    for (frame, camera) in cameras.iter().enumerate() {
        let seen = scene.seen_by(camera)?;
        let recipe = match scene.recipe_for(preset, camera, &seen) {
            Ok(recipe) => recipe,
            Err(RecipeError::Unsupported(_)) => return Ok(None),
            Err(e) => return Err(e.into()),
        };
        if draws_the_picture(&recipe, camera) {
            return Ok(None);
        }
        let shifted = pixel_shift::to_the_right(&scene.receivers, frame);
        let pixels: Vec<u32> = places
            .iter()
            .map(|&k| to_the_right(sampled.sample.pixels[k], frame as u32, camera.size.x))
            .collect();
        let mask = scene.mask_at_receivers(&recipe, &shifted, &pixels)?;
        if let Some(last) = &last {
            change += mean_change(sampled, &places, last, &mask);
        }
        last = Some(mask);
    }
    Ok(Some(change / f64::from(FRAMES - 1)))
}

/// Returns the pixel this many steps to the right. It wraps around within the row.
fn to_the_right(pixel: u32, steps: u32, width: u32) -> u32 {
    let column = (pixel % width + steps) % width;
    pixel - pixel % width + column
}

/// Returns whether a point is within a camera's image, hidden or not.
fn sees(camera: &Camera, point: glam::Vec3) -> bool {
    let clip = transform(camera.space().clip_from_world(), point);
    clip.w > 0.0 && clip.x.abs() < clip.w && clip.y.abs() < clip.w
}

/// Estimates the mean of |after - before| over the image's pixels. The sample indices are `places`.
fn mean_change(sampled: &SampledTruth, places: &[usize], before: &[f32], after: &[f32]) -> f64 {
    let mut change = 0.0;
    let mut pixels = 0.0;
    for (i, &k) in places.iter().enumerate() {
        let share = 1.0 / sampled.sample.chances[k];
        change += share * f64::from((after[i] - before[i]).abs());
        pixels += share;
    }
    if pixels > 0.0 { change / pixels } else { 0.0 }
}
