//! Ray-traced truth: the unweighted fraction of the light that is visible from each visible point.
//!
//! Surfaces are opaque and two-sided. A receiver's normal is turned to the camera; light points
//! below its tangent plane are not visible. Rays start a few units in the last place above the
//! surface, in proportion to the lengths near the point. The same scene at another scale thus has
//! the same mask. Near triangles that are far larger, such as a ground of kilometres, rays are
//! traced in 64 bits. Rays skip the receiver's own triangle, and end 2^-14 of their length before the
//! light, so that a light's own mesh doesn't hide it. The samples are those of
//! [`umbrage_core::light_sample`].

mod ambiguity;
mod blockers;
mod judged;
mod options;
#[cfg(test)]
mod oracle;
mod pixel_ray;
mod points;
mod polygon;
mod sampled;
mod tracer;
mod vicinity;

pub use ambiguity::PROBES;
pub use options::{FindReceivers, Progress, TruthOptions};
pub use points::{PointTruth, ReceiverPoint, TruthRequest, trace_points};
pub use sampled::PREVIEW_SAMPLES;
pub(crate) use sampled::stratified_pixels;

use crate::error::MeasureError;
use ambiguity::Nudge;
use glam::UVec2;
use judged::{JudgedPoints, class, judge};
use tracer::Tracer;
use umbrage_core::{
    Camera, Geometry, Invalid, Light, Receivers,
    metrics::{Pixel, TruthImage},
};
use web_time::{Duration, Instant};

/// Reference for the masks of all techniques.
#[derive(Clone, Debug)]
pub struct Truth {
    /// Image size, pixels.
    pub size: UVec2,
    /// Visible fraction of the light, 0..=1, rows from the top; 1 without a receiver. It is a
    /// preview at unsampled pixels.
    pub visibility: Vec<f32>,
    /// Standard error of `visibility`, 0..=1; 0 for ideal lights.
    pub error: Vec<f32>,
    /// Class of each pixel, such as empty, unlit or ambiguous.
    pub pixels: Vec<Pixel>,
    /// True if the visibility changes when the image moves by .02 pixels or the ray offset changes,
    /// including unlit pixels. False outside the sample.
    pub ambiguous: Vec<bool>,
    /// Distance from each shadowed receiver to the blocker nearest to the light, metres; infinite
    /// without a blocker.
    pub blocker: Vec<f32>,
    /// Blockers closer than this touch their shadows, metres.
    pub contact: f32,
    /// The points at which truth was traced.
    pub receivers: Receivers,
    /// The [`Geometry::fingerprint`] of the triangles.
    pub fingerprint: u64,
    /// Time that it took.
    pub elapsed: Duration,
}

impl Truth {
    /// Returns the mean and the greatest standard error over the pixels that count; 0 without any.
    pub fn standard_error(&self) -> [f32; 2] {
        let counted: Vec<f32> = (0..self.error.len())
            .filter(|&i| self.pixels[i] == Pixel::Counted)
            .map(|i| self.error[i])
            .collect();
        let sum: f64 = counted.iter().copied().map(f64::from).sum();
        let mean = sum / counted.len().max(1) as f64;
        let max = counted.iter().copied().fold(0.0, f32::max);
        [mean as f32, max]
    }

    /// Returns the data for separating the causes of a mask's error.
    ///
    /// # Errors
    /// Errors if the fields are inconsistent.
    pub fn image(&self) -> Result<TruthImage<'_>, Invalid> {
        TruthImage::new(
            self.size,
            &self.visibility,
            &self.pixels,
            &self.blocker,
            self.contact,
        )
    }

    /// Returns whether the light's shadow or penumbra covers any pixel that counts.
    pub fn has_shadow(&self) -> bool {
        self.visibility
            .iter()
            .zip(&self.pixels)
            .any(|(v, p)| *v < 1.0 && *p == Pixel::Counted)
    }
}

/// Traces truth for the points visible to the camera.
///
/// # Errors
/// Errors if the camera or light is not valid, or receivers cannot be found.
pub fn trace(
    camera: &Camera,
    light: &Light,
    geometry: &Geometry,
    options: &TruthOptions,
    find: &mut FindReceivers<'_>,
    progress: &Progress<'_>,
) -> Result<Truth, MeasureError> {
    camera.validate()?;
    let start = Instant::now();
    let receivers = find(camera, geometry)?;
    let image = sampled::Image {
        camera,
        light,
        geometry,
        receivers: &receivers,
    };
    let traced = sampled::trace(&image, options, find, progress)?;
    let seen = &traced.seen;
    Ok(Truth {
        size: receivers.size,
        visibility: seen.iter().map(|s| s.visibility).collect(),
        error: seen.iter().map(|s| s.error).collect(),
        pixels: traced.pixels,
        ambiguous: traced.ambiguous,
        blocker: blockers::find(light, geometry, &receivers, seen),
        contact: blockers::contact(&receivers),
        receivers,
        fingerprint: geometry.fingerprint(),
        elapsed: start.elapsed(),
    })
}

/// Truth at one pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelTruth {
    /// Visible fraction of the light: [`Truth::visibility`].
    pub visibility: f32,
    /// Standard error: [`Truth::error`].
    pub error: f32,
    /// Class of the pixel: [`Truth::pixels`].
    pub pixel: Pixel,
}

/// Traces truth at some pixels of a camera's image, in the order of the request's pixels. The
/// result has the bits of [`trace`] at these pixels.
///
/// # Errors
/// Errors if the light is not valid, or receivers of the nudged camera cannot be found.
pub fn trace_pixels(
    request: &TruthRequest<'_>,
    light: &Light,
    options: &TruthOptions,
    find: &mut FindReceivers<'_>,
    progress: &Progress<'_>,
) -> Result<Vec<PixelTruth>, MeasureError> {
    let JudgedPoints { seen, ambiguous } = judge(request, light, options, find, progress)?;
    let mut out = Vec::with_capacity(request.pixels.len());
    for (k, &i) in request.pixels.iter().enumerate() {
        let receives = request.receivers.receives[i as usize];
        out.push(PixelTruth {
            visibility: seen[k].visibility,
            error: seen[k].error,
            pixel: class(receives, seen[k], ambiguous[k]),
        });
    }
    Ok(out)
}

/// Returns for each pixel of a request whether truth will be [`Pixel::Unlit`]. It traces no rays.
///
/// # Errors
/// Errors if the light is not valid.
pub(crate) fn unlit_pixels(
    request: &TruthRequest<'_>,
    light: &Light,
    options: &TruthOptions,
) -> Result<Vec<bool>, Invalid> {
    Ok(request.unlit_points(&Tracer::new(request.geometry, light, options)?))
}

/// Returns truth's ambiguous pixels on a device whose sub-pixel grid has this step, pixels.
///
/// Returns `None` if the step is no larger than the rounding that truth itself allows (movements by
/// .02 pixels), so that [`Truth::ambiguous`] holds.
///
/// Devices move a vertex by up to half a step horizontally and vertically, so an edge moves by up
/// to `sqrt(1/2)` steps across itself. A shadow's edge depends on the caster's edge and the
/// receiver: `sqrt(2)` steps. Moving the image by two steps along each axis moves every edge by at
/// least as much. Outlines also count, since the device extrapolates depth beyond the edge of a
/// plane.
///
/// # Errors
/// Errors if the light is not valid, or receivers of the nudged camera cannot be found.
pub fn ambiguous_on(
    step: f32,
    camera: &Camera,
    light: &Light,
    geometry: &Geometry,
    truth: &Truth,
    options: &TruthOptions,
    find: &mut FindReceivers<'_>,
) -> Result<Option<Vec<bool>>, MeasureError> {
    let nudge = Nudge {
        pixels: 2.0 * step,
        outlines: true,
    };
    if nudge.pixels <= Nudge::ROUNDING.pixels {
        return Ok(None);
    }
    // Collect the sampled pixels.
    let mut pixels = Vec::new();
    for i in 0..truth.receivers.len() {
        if truth.pixels[i] != Pixel::Unsampled {
            pixels.push(i as u32);
        }
    }
    let requested = TruthRequest {
        camera,
        geometry,
        receivers: &truth.receivers,
        pixels: &pixels,
    };
    // Find the ambiguous ones.
    let found = ambiguity::find(&requested, light, options, nudge, find, &|_| {})?;
    let mut out = vec![false; truth.receivers.len()];
    for (&i, ambiguous) in pixels.iter().zip(found) {
        out[i as usize] = ambiguous;
    }
    Ok(Some(out))
}

#[cfg(test)]
mod tests;
