//! Grain: noise within penumbrae that a blur would remove and an artist would reject.
//!
//! At each of a sample of penumbra pixels, the difference mask - truth over 3 x 3 pixels is
//! convolved with a difference of two Laplacians, `[1 -2 1; -2 4 -2; 1 -2 1]` (Immerkær 1996, "Fast
//! noise variance estimation"). Its response to noise of standard deviation s has a standard
//! deviation of 6 s. Its response to anything linear along rows or columns is 0: ramps, and edges
//! along either. A penumbra that is too wide is thus an error and not grain. The stairs of a coarse
//! map in a soft penumbra are both. Only points with smooth truth count, since edges sharper than a
//! pixel always deviate by a fraction of a pixel.
//!
//! Measured on `rising-boxes`, `rising-boxes-disc` and `teapot-lamp`: 4 rays a pixel have a grain
//! of .11 to .12, 6 rays .10, 64 rays .01. `pcf` with 7 x 7 taps has .02 to .05, `pcss` .03,
//! dithered taps .10 to .15, one tap .16 to .19.

use super::{sampled_truth::SampledTruth, scene::PlanScene};
use crate::{
    error::MeasureError,
    truth::{ReceiverPoint, TruthOptions, trace_points},
};
use umbrage_core::{BackendError, Recipe, math::dot3};

/// Number of penumbra pixels evaluated. The relative standard error of a root mean square over this
/// many is a twentieth.
const PLACES: usize = 200;
/// Visibility range of their centres. Near 0 and 1, noise is clipped.
const MIDDLE: std::ops::RangeInclusive<f32> = 0.1..=0.9;
/// Rays for truth at each of the nine pixels. Their noise is far below the grain that matters.
const RAYS: u32 = 512;
/// Least number of points for a valid measurement.
const FEWEST: usize = 16;
/// Least cosine between the normals of neighbours on one surface.
const SAME_NORMAL: f32 = 0.9;
/// Greatest distance of a neighbour from the centre's plane, relative to the distance between the
/// two.
const SAME_PLANE: f32 = 0.3;

/// Greatest difference of truth within the 3 x 3 pixels: penumbrae are at least 6 pixels wide.
const MAX_STEP: f32 = 0.33;

/// Noise operator, rows from the top.
const NOISE: [f64; 9] = [1.0, -2.0, 1.0, -2.0, 4.0, -2.0, 1.0, -2.0, 1.0];
/// Root of the sum of its squares.
const GAIN: f64 = 6.0;

/// Points in penumbrae at which grain is measured.
#[derive(Clone, Debug, Default)]
pub(crate) struct GrainProbe {
    /// Nine pixels of each point, rows from the top.
    pixels: Vec<u32>,
    /// Truth at these pixels.
    truth: Vec<f32>,
}

impl GrainProbe {
    /// Finds the points and traces their truth. Finds none under ideal lights, which have no
    /// penumbrae.
    pub(crate) fn new(
        scene: &PlanScene<'_>,
        sampled: &SampledTruth,
        options: &TruthOptions,
    ) -> Result<Self, MeasureError> {
        // Find sampled receivers in penumbrae.
        let in_penumbra: Vec<u32> = (0..sampled.truth.len())
            .filter(|&k| MIDDLE.contains(&sampled.truth[k].visibility) && !scene.light.is_ideal())
            .map(|k| sampled.sample.pixels[k])
            .collect();
        let around: Vec<[u32; 9]> = in_penumbra
            .into_iter()
            .filter_map(|pixel| neighbours_of(scene, pixel))
            .collect();
        // Use twice as many as needed, since some are across edges.
        let step = around.len().div_ceil(2 * PLACES).max(1);
        let pixels: Vec<u32> = around.into_iter().step_by(step).flatten().collect();
        let points: Vec<ReceiverPoint> = pixels
            .iter()
            .map(|&i| {
                ReceiverPoint::of_pixel(scene.camera, scene.geometry, &scene.receivers, i as usize)
            })
            .collect();
        let careful = TruthOptions {
            samples: RAYS,
            penumbra_factor: 1,
            ..*options
        };
        let truth = trace_points(scene.geometry, scene.light, &points, &careful)?;
        let truth: Vec<f32> = truth.into_iter().map(|t| t.visibility).collect();
        // Keep the points with smooth truth.
        let mut out = Self::default();
        for (pixels, truth) in pixels.chunks_exact(9).zip(truth.chunks_exact(9)) {
            let min = truth.iter().copied().fold(1.0, f32::min);
            let max = truth.iter().copied().fold(0.0, f32::max);
            if max - min <= MAX_STEP {
                out.pixels.extend(pixels);
                out.truth.extend(truth);
            }
        }
        Ok(out)
    }

    /// Returns the standard deviation of the noise of a recipe's mask in penumbrae, 0..=1. Returns
    /// `None` if too few are visible.
    pub(crate) fn grain(
        &self,
        scene: &mut PlanScene<'_>,
        recipe: &Recipe,
    ) -> Result<Option<f64>, BackendError> {
        if self.pixels.len() < 9 * FEWEST {
            return Ok(None);
        }
        let mask = scene.mask_at(recipe, &self.pixels)?;
        let errors: Vec<f64> = mask
            .iter()
            .zip(&self.truth)
            .map(|(mask, truth)| f64::from(*mask) - f64::from(*truth))
            .collect();
        Ok(Some(noise(&errors)))
    }
}

/// Returns the standard deviation of the noise in blocks of 3 x 3 numbers each.
fn noise(places: &[f64]) -> f64 {
    let squares = places.chunks_exact(9).map(|place| {
        let answer: f64 = place.iter().zip(NOISE).map(|(e, factor)| e * factor).sum();
        (answer / GAIN).powi(2)
    });
    let count = (places.len() / 9).max(1) as f64;
    (squares.sum::<f64>() / count).sqrt()
}

/// Returns the 3 x 3 pixels around one. Returns `None` at the image's border, or if they show
/// several surfaces.
fn neighbours_of(scene: &PlanScene<'_>, pixel: u32) -> Option<[u32; 9]> {
    let receivers = &scene.receivers;
    let [width, height] = receivers.size.to_array();
    let x = pixel % width;
    let y = pixel / width;
    if x == 0 || y == 0 || x + 1 >= width || y + 1 >= height {
        return None;
    }
    let mut out = [pixel; 9];
    for (k, neighbor) in out.iter_mut().enumerate() {
        *neighbor = (y - 1 + k as u32 / 3) * width + (x - 1 + k as u32 % 3);
    }
    let position = receivers.position(pixel as usize);
    let normal = receivers.normal(pixel as usize);
    let is_on_surface = |&i: &u32| {
        let i = i as usize;
        let step = receivers.position(i) - position;
        receivers.receives[i]
            && dot3(normal, receivers.normal(i)) >= SAME_NORMAL
            && dot3(normal, step).abs() <= SAME_PLANE * step.length()
    };
    out.iter().all(is_on_surface).then_some(out)
}

#[cfg(test)]
mod tests {
    use super::noise;
    use umbrage_core::light_sample::hash;

    #[test]
    fn ramps_and_straight_edges_are_no_grain() {
        let ramp: Vec<f64> = (0..9)
            .map(|i| f64::from(i % 3) * 0.1 + f64::from(i / 3))
            .collect();
        let edge: Vec<f64> = (0..9).map(|i| if i % 3 == 2 { 1.0 } else { 0.0 }).collect();
        assert!(noise(&ramp) < 1e-12 && noise(&edge) < 1e-12);
        assert_eq!(noise(&[]), 0.0);
    }

    #[test]
    fn noise_is_measured_by_its_standard_deviation() {
        // Even distribution over -0.3..=0.3: the standard deviation is 0.3 / sqrt(3).
        let numbers: Vec<f64> = (0..9 * 4000)
            .map(|i| 0.6 * (f64::from(hash(i)) / f64::from(u32::MAX) - 0.5))
            .collect();
        let found = noise(&numbers);
        assert!(
            (found / (0.3 / 3.0_f64.sqrt()) - 1.0).abs() < 0.03,
            "{found}"
        );
    }
}
