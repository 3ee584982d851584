//! Detection of pixels at which truth depends on rounding.
//!
//! Masks are compared with truth only where all correct programs must agree, independent of their
//! rounding. A pixel is therefore ambiguous if its visibility changes within the rounding of:
//!
//! * **The pixel's position.** Rasterisers place corners on grids of 1/256 or 1/16 pixel, and round
//!   projections before that. The image as a whole, and each triangle's image separately, may move
//!   by [`NUDGE`] in any direction.
//! * **The ray's origin.** It is rounded, and lifted off the surface by
//!   [`origin_offset`](umbrage_core::light_sample::origin_offset). It may be anywhere from the
//!   surface to twice that height, and as far to each side. The 32-bit triangle test moves its
//!   triangles by no more (`hit.rs`).
//! * **The visible surface**, where two surfaces have the same distance within a depth buffer's
//!   rounding. Such pixels may show the wrong one; moving the image detects it.
//!
//! For ideal lights, shadows around a visible point are computed as polygons (`vicinity.rs`). The
//! pixel is ambiguous if the point's surroundings contain both light and shadow, however thin.
//! Moved images would miss details between them, such as the shadow of a wire. A fourfold offset
//! would miss details between the surface and the offset, and detect shadows beyond any rounding.
//! Moved images detect changes of the visible surface.

use super::{
    options::{FindReceivers, TruthOptions},
    points::{PointTruth, ReceiverPoint, TruthRequest},
    tracer::Tracer,
    vicinity::{Around, Vicinity},
};
use crate::error::MeasureError;
use glam::Vec2;
use rayon::prelude::*;
use umbrage_core::Light;

/// Distance by which rounding may move the image, pixels.
const NUDGE: f32 = 0.02;

/// Movement of the image.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nudge {
    /// Distance, pixels.
    pub(super) pixels: f32,
    /// True if pixels are also ambiguous where receivers appear or disappear.
    pub(super) outlines: bool,
}

impl Nudge {
    /// Movement that truth attributes to rounding. It does not make the lighting next to an outline
    /// ambiguous.
    pub(super) const ROUNDING: Self = Self {
        pixels: NUDGE,
        outlines: false,
    };
}

/// Factor on the rays' offset, for lights with an extent.
const LIFT: f32 = 4.0;

/// Number of traced images: the original, one with a greater offset (or the surroundings of its
/// points), and four moved images.
pub const PROBES: usize = 6;

/// Returns for each pixel whether its visibility changes within rounding. The visibility is the
/// visible fraction of the light, 0 for unlit pixels and 1 for pixels without a receiver. For
/// lights with an extent, the change must exceed [`TruthOptions::ambiguous_change`].
pub(super) fn find(
    request: &TruthRequest<'_>,
    light: &Light,
    options: &TruthOptions,
    nudge: Nudge,
    find_receivers: &mut FindReceivers<'_>,
    report: &(dyn Fn(usize) + Sync),
) -> Result<Vec<bool>, MeasureError> {
    let probe = TruthOptions {
        samples: options.probe_samples,
        penumbra_factor: 1,
        ..*options
    };
    // Trace the original image.
    let tracer = Tracer::new(request.geometry, light, &probe)?;
    let change = if light.is_ideal() {
        0.0
    } else {
        options.ambiguous_change
    };
    let base = request.trace(&tracer, 1.0, report);
    // Vary the ray's origin.
    let mut out = if light.is_ideal() {
        let out = light_and_shadow(request, light, &base);
        report(out.len());
        out
    } else {
        let lifted = request.trace(&tracer, LIFT, report);
        let mut out = vec![false; base.len()];
        mark_changes(&mut out, &base, &lifted, change);
        out
    };
    // Move the image.
    for direction in [Vec2::X, Vec2::NEG_X, Vec2::Y, Vec2::NEG_Y] {
        let camera = request.camera.nudged_by(direction * nudge.pixels);
        let receivers = find_receivers(&camera, request.geometry)?;
        let nudged_request = TruthRequest {
            camera: &camera,
            receivers: &receivers,
            ..*request
        };
        let nudged = nudged_request.trace(&tracer, 1.0, report);
        mark_changes(&mut out, &base, &nudged, change);
        if nudge.outlines {
            for (out, &i) in out.iter_mut().zip(request.pixels) {
                let i = i as usize;
                *out |= request.receivers.receives[i] != receivers.receives[i];
            }
        }
    }
    Ok(out)
}

/// Marks the pixels whose visibility differs by more than `change`.
fn mark_changes(out: &mut [bool], base: &[PointTruth], nudged: &[PointTruth], change: f32) {
    for (out, (a, b)) in out.iter_mut().zip(base.iter().zip(nudged)) {
        *out |= (answer(a) - answer(b)).abs() > change;
    }
}

/// Returns for each pixel whether there is both light and shadow around its point, and the
/// difference matters.
fn light_and_shadow(requested: &TruthRequest<'_>, light: &Light, base: &[PointTruth]) -> Vec<bool> {
    let vicinity = Vicinity::new(
        requested.camera,
        requested.geometry,
        light,
        f64::from(NUDGE),
    );
    requested
        .pixels
        .par_iter()
        .zip(base)
        .map_init(Vec::new, |ids, (&i, seen)| {
            has_both(requested, &vicinity, i, seen, ids)
        })
        .collect()
}

/// Returns whether there is both light and shadow around the point of pixel `i`. `ids` is scratch
/// memory.
fn has_both(
    request: &TruthRequest<'_>,
    vicinity: &Vicinity<'_>,
    i: u32,
    seen: &PointTruth,
    ids: &mut Vec<u32>,
) -> bool {
    if !request.receivers.receives[i as usize] {
        return false;
    }
    let point = ReceiverPoint::of_pixel(
        request.camera,
        request.geometry,
        request.receivers,
        i as usize,
    );
    let x = i % request.receivers.size.x;
    let y = i / request.receivers.size.x;
    match vicinity.around_point(&point, [x, y], ids) {
        Around::Both => !seen.unlit,
        Around::Grazed => true,
        Around::Light | Around::Shadow | Around::Neither => false,
    }
}

/// Returns the visibility to compare: 0 if the point is unlit.
fn answer(seen: &PointTruth) -> f32 {
    if seen.unlit { 0.0 } else { seen.visibility }
}

#[cfg(test)]
#[path = "ambiguity_tests.rs"]
mod tests;
