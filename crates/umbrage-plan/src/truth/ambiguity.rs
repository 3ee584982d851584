//! Finds the pixels at which truth depends on rounding.
//!
//! Masks are compared with truth where every correct program must agree, however it rounds. So a
//! pixel is ambiguous if its visibility changes within the rounding of:
//!
//! * **Where the pixel lies.** Rasterisers place corners on grids of 1/256 or 1/16 pixel and round
//!   projections before that: the image, and each triangle's by itself, may move by [`NUDGE`] in
//!   any direction.
//! * **Where the ray starts.** Its origin is rounded, and lifted off the surface by
//!   [`origin_offset`](umbrage_core::light_sample::origin_offset): it may lie anywhere from the
//!   surface to twice that above it, and as much aside as that. The triangle test of 32 bits moves
//!   its triangles by no more (`hit.rs`).
//! * **What is seen**, where two surfaces are as far away as each other within a depth buffer's
//!   rounding. Such pixels show the wrong one; moving the image shows it.
//!
//! For ideal lights, shadows around a seen point are computed as polygons (`vicinity.rs`): the
//! pixel is ambiguous if the point's surroundings hold both light and shadow, however thin either
//! is. Moved images alone would miss what lies between them, such as the shadow of a wire. A
//! fourfold offset alone misses what happens between the surface and the offset, and finds shadows
//! that are farther away than any rounding. Moved images show what happens where another surface is
//! seen.

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

/// How far rounding alone may move the image, pixels.
const NUDGE: f32 = 0.02;

/// A movement of the image.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nudge {
    /// How far, pixels.
    pub(super) pixels: f32,
    /// Whether pixels are ambiguous, too, that come to show nothing that receives, or no longer do.
    pub(super) outlines: bool,
}

impl Nudge {
    /// What truth takes for rounding. Next to an outline it is no less sure of what is lit.
    pub(super) const ROUNDING: Self = Self {
        pixels: NUDGE,
        outlines: false,
    };
}

/// By how much the rays' offset is multiplied, for lights with an extent.
const LIFT: f32 = 4.0;

/// Images traced: as it is, with a greater offset (or the surroundings of its points), and moved in
/// four directions.
pub const PROBES: usize = 6;

/// Returns for each pixel whether its visibility changes within rounding: the fraction of the light
/// seen, 0 where unlit and 1 where nothing receives. For lights with an extent it must change by
/// more than [`TruthOptions::ambiguous_change`].
pub(super) fn find(
    asked: &TruthRequest<'_>,
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
    let tracer = Tracer::new(asked.geometry, light, &probe)?;
    let change = if light.is_ideal() {
        0.0
    } else {
        options.ambiguous_change
    };
    let base = asked.trace(&tracer, 1.0, report);
    let mut out = if light.is_ideal() {
        let out = light_and_shadow(asked, light, &base);
        report(out.len());
        out
    } else {
        let lifted = asked.trace(&tracer, LIFT, report);
        let mut out = vec![false; base.len()];
        mark_changes(&mut out, &base, &lifted, change);
        out
    };
    for direction in [Vec2::X, Vec2::NEG_X, Vec2::Y, Vec2::NEG_Y] {
        let camera = asked.camera.nudged(direction * nudge.pixels);
        let receivers = find_receivers(&camera, asked.geometry)?;
        let nudged_request = TruthRequest {
            camera: &camera,
            receivers: &receivers,
            ..*asked
        };
        let nudged = nudged_request.trace(&tracer, 1.0, report);
        mark_changes(&mut out, &base, &nudged, change);
        if nudge.outlines {
            for (out, &i) in out.iter_mut().zip(asked.pixels) {
                let i = i as usize;
                *out |= asked.receivers.receives[i] != receivers.receives[i];
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

/// Returns for each pixel whether both light and shadow lie around the point that it shows, and
/// matter there.
fn light_and_shadow(asked: &TruthRequest<'_>, light: &Light, base: &[PointTruth]) -> Vec<bool> {
    let vicinity = Vicinity::new(asked.camera, asked.geometry, light, f64::from(NUDGE));
    asked
        .pixels
        .par_iter()
        .zip(base)
        .map_init(Vec::new, |ids, (&i, seen)| {
            has_both(asked, &vicinity, i, seen, ids)
        })
        .collect()
}

/// Whether both lie around pixel `i`'s point. `ids` is scratch memory.
fn has_both(
    asked: &TruthRequest<'_>,
    vicinity: &Vicinity<'_>,
    i: u32,
    seen: &PointTruth,
    ids: &mut Vec<u32>,
) -> bool {
    if !asked.receivers.receives[i as usize] {
        return false;
    }
    let point = ReceiverPoint::of_pixel(asked.camera, asked.geometry, asked.receivers, i as usize);
    let x = i % asked.receivers.size.x;
    let y = i / asked.receivers.size.x;
    match vicinity.around(&point, [x, y], ids) {
        Around::Both => !seen.unlit,
        Around::Grazed => true,
        Around::Light | Around::Shadow | Around::Neither => false,
    }
}

/// Returns the visibility that is compared: 0 where the point is unlit.
fn answer(seen: &PointTruth) -> f32 {
    if seen.unlit { 0.0 } else { seen.visibility }
}

#[cfg(test)]
#[path = "ambiguity_tests.rs"]
mod tests;
