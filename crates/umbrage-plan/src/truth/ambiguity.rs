//! Which of truth's answers hang on rounding.
//!
//! Masks are compared with truth where every correct program must agree, however it rounds. So an answer is ambiguous if
//! it changes within what these round:
//!
//! * **Where the pixel lies.** Rasterisers place corners on grids of 1/256 or 1/16 pixel and round projections before
//!   that: the image, and each triangle's by itself, may move by [`NUDGE`] in any direction.
//! * **Where the ray starts.** Its origin is rounded, and lifted off the surface by
//!   [`origin_offset`](umbrage_core::light_sample::origin_offset): it may lie anywhere from the surface to twice that above it, and as much aside as
//!   that. The triangle test of 32 bits moves its triangles by no more (`hit.rs`).
//! * **What is seen**, where two surfaces are as far away as each other within a depth buffer's rounding. Such pixels show
//!   the wrong one; moving the image shows it.
//!
//! For ideal lights, shadows around a seen point are worked out as polygons (`vicinity.rs`): the answer is ambiguous if the
//! point's surroundings hold both light and shadow, however thin either is. Moved images alone would miss what lies between
//! them, such as the shadow of a wire; an offset that grows fourfold missed what happens between the surface and the offset,
//! and told of shadows that lay farther away than any rounding. Moved images tell what happens where another surface is seen.

use super::{
    FindReceivers, PointTruth, TruthOptions,
    points::{ReceiverPoint, TruthRequest},
    tracer::Tracer,
    vicinity::{Around, Vicinity},
};
use crate::MeasureError;
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

/// Images traced: as it is, with a greater offset (or the surroundings of its points), and moved in four directions.
pub(super) const PROBES: usize = 6;

/// Tells of each pixel whether its answer changes within rounding. An answer is the fraction of the light seen, 0 where
/// unlit and 1 where nothing receives; for lights with an extent it must change by more than a threshold.
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
    let changes = |nudged: Vec<PointTruth>| {
        base.iter()
            .zip(nudged)
            .map(|(a, b)| (answer(a) - answer(&b)).abs() > change)
            .collect()
    };
    let mut out: Vec<bool> = if light.is_ideal() {
        let out = light_and_shadow(asked, light, &base);
        report(out.len());
        out
    } else {
        changes(asked.trace(&tracer, LIFT, report))
    };
    for direction in [Vec2::X, Vec2::NEG_X, Vec2::Y, Vec2::NEG_Y] {
        let camera = asked.camera.nudged(direction * nudge.pixels);
        let receivers = find_receivers(&camera, asked.geometry)?;
        let nudged: Vec<bool> = changes(
            TruthRequest {
                camera: &camera,
                receivers: &receivers,
                ..*asked
            }
            .trace(&tracer, 1.0, report),
        );
        out.iter_mut()
            .zip(nudged)
            .for_each(|(out, nudged)| *out |= nudged);
        if nudge.outlines {
            let outline = |i: usize| asked.receivers.receives[i] != receivers.receives[i];
            out.iter_mut()
                .zip(asked.pixels)
                .for_each(|(out, &i)| *out |= outline(i as usize));
        }
    }
    Ok(out)
}

/// Whether both lie around the point that each pixel shows, and matter there.
fn light_and_shadow(asked: &TruthRequest<'_>, light: &Light, base: &[PointTruth]) -> Vec<bool> {
    let vicinity = Vicinity::new(asked.camera, asked.geometry, light, f64::from(NUDGE));
    let both = |ids: &mut Vec<u32>, (&i, seen): (&u32, &PointTruth)| {
        asked.receivers.receives[i as usize] && {
            let point =
                ReceiverPoint::of_pixel(asked.camera, asked.geometry, asked.receivers, i as usize);
            let (x, y) = (i % asked.receivers.size.x, i / asked.receivers.size.x);
            match vicinity.around(&point, [x, y], ids) {
                Around::Both => !seen.unlit,
                Around::Grazed => true,
                Around::Light | Around::Shadow | Around::Neither => false,
            }
        }
    };
    asked
        .pixels
        .par_iter()
        .zip(base)
        .map_init(Vec::new, both)
        .collect()
}

fn answer(seen: &PointTruth) -> f32 {
    if seen.unlit { 0.0 } else { seen.visibility }
}

#[cfg(test)]
#[path = "ambiguity_tests.rs"]
mod tests;
