//! Ray-traced truth: the unweighted fraction of the light that each seen point sees.
//!
//! Surfaces are opaque and two-sided. A receiver's normal is turned to the camera; light points
//! below its tangent plane are not seen. Rays start a few units in the last place above the
//! surface, in proportion to the lengths in play (so the same scene at another scale gives the same
//! mask), skip the receiver's own triangle, and end 2^-14 of their length before the light (a
//! lamp's own mesh doesn't hide it). The samples are those of [`umbrage_core::light_sample`].

mod ambiguity;
mod blockers;
mod judged;
mod options;
#[cfg(test)]
mod oracle;
mod points;
mod polygon;
mod sampled;
mod tracer;
mod vicinity;

pub use ambiguity::PROBES;
pub use options::{FindReceivers, Progress, TruthOptions};
pub use points::{PointTruth, ReceiverPoint, TruthRequest, trace_points};
pub use sampled::PREVIEW_SAMPLES;
pub(crate) use sampled::drawn;

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

/// What every technique's mask is compared with.
#[derive(Clone, Debug)]
pub struct Truth {
    /// Image size, pixels.
    pub size: UVec2,
    /// Fraction of the light seen, 0..=1, rows from the top; 1 where nothing receives. A preview
    /// where pixels are unsampled.
    pub visibility: Vec<f32>,
    /// Standard error of `visibility`, 0..=1; 0 for ideal lights.
    pub error: Vec<f32>,
    /// What counts: which pixels are empty, unlit or ambiguous.
    pub pixels: Vec<Pixel>,
    /// Whether the visibility changes under a nudge by .02 pixels or another ray offset; also of
    /// unlit pixels. False beside the sample that is judged.
    pub ambiguous: Vec<bool>,
    /// From each receiver in shadow to the blocker nearest to the light, metres; infinite where
    /// there is none.
    pub blocker: Vec<f32>,
    /// Blockers closer than this touch their shadows, metres.
    pub contact: f32,
    /// The points at which truth was traced.
    pub receivers: Receivers,
    /// The [`Geometry::fingerprint`] of the triangles.
    pub fingerprint: u64,
    /// How long it took.
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

    /// Returns what is needed to tell the causes of a mask's error apart.
    ///
    /// # Errors
    /// Errors if the fields don't fit each other.
    pub fn image(&self) -> Result<TruthImage<'_>, Invalid> {
        TruthImage::new(
            self.size,
            &self.visibility,
            &self.pixels,
            &self.blocker,
            self.contact,
        )
    }

    /// Whether the light's shadow, or part of it, falls on any pixel that counts.
    pub fn has_shadow(&self) -> bool {
        self.visibility
            .iter()
            .zip(&self.pixels)
            .any(|(v, p)| *v < 1.0 && *p == Pixel::Counted)
    }
}

/// Traces truth for what the camera sees.
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
    /// As [`Truth::visibility`].
    pub visibility: f32,
    /// As [`Truth::error`].
    pub error: f32,
    /// As [`Truth::pixels`].
    pub pixel: Pixel,
}

/// Traces truth at some pixels of what a camera sees, in the order of the request's pixels. It is
/// the same, bit by bit, as that of [`trace`] at these pixels.
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

/// Returns for each pixel of a request whether truth will be [`Pixel::Unlit`] there. That takes no
/// rays.
///
/// # Errors
/// Errors if the light is not valid.
pub(crate) fn unlit(
    request: &TruthRequest<'_>,
    light: &Light,
    options: &TruthOptions,
) -> Result<Vec<bool>, Invalid> {
    Ok(request.unlit(&Tracer::new(request.geometry, light, options)?))
}

/// Returns which of truth's pixels are ambiguous on a device whose grid of sub-pixels has this
/// step, pixels. None if the step is no larger than what truth itself allows for rounding (nudges
/// by .02 pixels), so that [`Truth::ambiguous`] holds.
///
/// Devices move a vertex by up to half a step right or left and as much up or down, and so an edge
/// by up to `sqrt(1/2)` steps across itself. A shadow's edge is where two things meet, what throws
/// it and what it falls on: `sqrt(2)` steps. Nudges of the image by two steps along each axis move
/// every edge by as much at least. Outlines count, too: there the device's depth is that of a plane
/// beyond its edge.
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
    let mut pixels = Vec::new();
    for i in 0..truth.receivers.len() {
        if truth.pixels[i] != Pixel::Unsampled {
            pixels.push(i as u32);
        }
    }
    let asked = TruthRequest {
        camera,
        geometry,
        receivers: &truth.receivers,
        pixels: &pixels,
    };
    let found = ambiguity::find(&asked, light, options, nudge, find, &|_| {})?;
    let mut out = vec![false; truth.receivers.len()];
    for (&i, ambiguous) in pixels.iter().zip(found) {
        out[i as usize] = ambiguous;
    }
    Ok(Some(out))
}

#[cfg(test)]
mod tests;
