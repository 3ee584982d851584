//! Which of truth's answers hang on rounding.

use super::{FindReceivers, Seen, TruthOptions, points::ask_receivers, tracer::Tracer};
use crate::LabError;
use glam::Vec2;
use umbrage_core::{Camera, Geometry, Light, Receivers};

/// How far the image is moved, pixels.
const NUDGE: f32 = 0.02;

/// By how much the rays' offset is multiplied.
const LIFT: f32 = 4.0;

/// Images traced: as it is, with a greater offset, and moved in four directions.
pub(super) const PROBES: usize = 6;

/// Marks the pixels whose answer changes under a nudge. An answer is the fraction of the light seen, 0 where unlit and 1
/// where nothing receives; for lights with an extent it must change by more than a threshold.
pub(super) fn find(
    camera: &Camera,
    light: &Light,
    geometry: &Geometry,
    receivers: &Receivers,
    options: &TruthOptions,
    find_receivers: &mut FindReceivers<'_>,
    report: &(dyn Fn(usize) + Sync),
) -> Result<Vec<bool>, LabError> {
    let probe = TruthOptions { samples: options.probe_samples, penumbra_factor: 1, ..*options };
    let tracer = Tracer::new(geometry, light, &probe)?;
    let change = if light.is_ideal() { 0.0 } else { options.ambiguous_change };
    let base = ask_receivers(&tracer, camera, geometry, receivers, 1.0, report);
    let mut out = vec![false; receivers.len()];
    let mut mark = |nudged: &[Seen]| {
        for (out, (a, b)) in out.iter_mut().zip(base.iter().zip(nudged)) {
            *out |= (answer(a) - answer(b)).abs() > change;
        }
    };
    mark(&ask_receivers(&tracer, camera, geometry, receivers, LIFT, report));
    for direction in [Vec2::X, Vec2::NEG_X, Vec2::Y, Vec2::NEG_Y] {
        let nudged = camera.nudged(direction * NUDGE);
        let receivers = find_receivers(&nudged, geometry)?;
        mark(&ask_receivers(&tracer, &nudged, geometry, &receivers, 1.0, report));
    }
    Ok(out)
}

fn answer(seen: &Seen) -> f32 {
    if seen.unlit { 0.0 } else { seen.visibility }
}
