//! Grain: noise within penumbrae, which a blur would remove and an artist would refuse.
//!
//! Over a sample of penumbra pixels, mask - truth is taken in the 3 x 3 pixels around each, and the
//! difference of two Laplacians of it, `[1 -2 1; -2 4 -2; 1 -2 1]`, whose answer to noise of
//! standard deviation s has one of 6 s, and which is 0 for anything that is linear along rows or
//! along columns: ramps, and edges along either (Immerkær 1996, "Fast noise variance estimation").
//! So a penumbra that is too wide is an error and not grain; the stairs of a coarse map in a soft
//! penumbra are both. Only places count where truth is smooth, since edges sharper than a pixel are
//! never in their place by less than that.
//!
//! Measured on `rising-boxes`, `rising-boxes-disc` and `teapot-lamp`: 4 rays a pixel have a grain
//! of .11 to .12, 6 of .10, 64 of .01; `pcf` with 7 x 7 taps .02 to .05, `pcss` .03, dithered taps
//! .10 to .15, one tap .16 to .19.

use super::{sampled_truth::SampledTruth, scene::PlanScene};
use crate::{
    error::MeasureError,
    truth::{ReceiverPoint, TruthOptions, trace_points},
};
use umbrage_core::{BackendError, Recipe, math::dot3};

/// Penumbra pixels that are looked at: the standard error of a root mean square over so many is a
/// twentieth of it.
const PLACES: usize = 200;
/// The visibility at their middle. Near either end noise has little room.
const MIDDLE: std::ops::RangeInclusive<f32> = 0.1..=0.9;
/// Rays for truth at each of the nine pixels: their noise is far below the grain that matters.
const RAYS: u32 = 512;
/// Fewer places than this say nothing.
const FEWEST: usize = 16;
/// The cosine between the normals of neighbours on one surface, at least.
const SAME_NORMAL: f32 = 0.9;
/// How far a neighbour may lie from the middle's plane, as a share of the distance between the two.
const SAME_PLANE: f32 = 0.3;

/// By how much truth may differ within the 3 x 3 pixels: penumbrae are 6 pixels wide at least.
const MAX_STEP: f32 = 0.33;

/// The operator, rows from the top.
const NOISE: [f64; 9] = [1.0, -2.0, 1.0, -2.0, 4.0, -2.0, 1.0, -2.0, 1.0];
/// The root of the sum of its squares.
const GAIN: f64 = 6.0;

/// Places in penumbrae where grain is measured.
#[derive(Clone, Debug, Default)]
pub(crate) struct GrainProbe {
    /// Nine pixels of each place, rows from the top.
    pixels: Vec<u32>,
    /// Truth there.
    truth: Vec<f32>,
}

impl GrainProbe {
    /// Finds the places and traces their truth; none under ideal lights, which have no penumbrae.
    pub(crate) fn new(
        scene: &PlanScene<'_>,
        sampled: &SampledTruth,
        options: &TruthOptions,
    ) -> Result<Self, MeasureError> {
        let in_penumbra: Vec<u32> = (0..sampled.truth.len())
            .filter(|&k| MIDDLE.contains(&sampled.truth[k].visibility) && !scene.light.is_ideal())
            .map(|k| sampled.sample.pixels[k])
            .collect();
        let around: Vec<[u32; 9]> = in_penumbra
            .into_iter()
            .filter_map(|pixel| around(scene, pixel))
            .collect();
        // Twice as many as are wanted, since some lie across edges.
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

    /// Returns the standard deviation of the noise of a recipe's mask in penumbrae, 0..=1; none
    /// where too few are seen.
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

/// Returns the standard deviation of the noise in places of 3 x 3 numbers each.
fn noise(places: &[f64]) -> f64 {
    let squares = places.chunks_exact(9).map(|place| {
        let answer: f64 = place.iter().zip(NOISE).map(|(e, factor)| e * factor).sum();
        (answer / GAIN).powi(2)
    });
    let count = (places.len() / 9).max(1) as f64;
    (squares.sum::<f64>() / count).sqrt()
}

/// Returns the 3 x 3 pixels around one; none at the image's border or where they do not show one
/// surface.
fn around(scene: &PlanScene<'_>, pixel: u32) -> Option<[u32; 9]> {
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
        // Even over -0.3..=0.3: the standard deviation is 0.3 / sqrt(3).
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
