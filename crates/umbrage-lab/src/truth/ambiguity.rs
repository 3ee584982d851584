//! Which of truth's answers hang on rounding.

use super::{FindReceivers, Seen, TruthOptions, points::Asked, tracer::Tracer};
use crate::LabError;
use glam::Vec2;
use umbrage_core::Light;

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
    pub(super) const ROUNDING: Self = Self { pixels: 0.02, outlines: false };
}

/// By how much the rays' offset is multiplied.
const LIFT: f32 = 4.0;

/// Images traced: as it is, with a greater offset, and moved in four directions.
pub(super) const PROBES: usize = 6;

/// Tells of each pixel whether its answer changes under a nudge. An answer is the fraction of the light seen, 0 where unlit and
/// 1 where nothing receives; for lights with an extent it must change by more than a threshold.
pub(super) fn find(
    asked: &Asked<'_>,
    light: &Light,
    options: &TruthOptions,
    nudge: Nudge,
    find_receivers: &mut FindReceivers<'_>,
    report: &(dyn Fn(usize) + Sync),
) -> Result<Vec<bool>, LabError> {
    let probe = TruthOptions { samples: options.probe_samples, penumbra_factor: 1, ..*options };
    let tracer = Tracer::new(asked.geometry, light, &probe)?;
    let change = if light.is_ideal() { 0.0 } else { options.ambiguous_change };
    let base = asked.trace(&tracer, 1.0, report);
    let mut out = vec![false; base.len()];
    let mark = |out: &mut [bool], nudged: &[Seen]| {
        for (out, (a, b)) in out.iter_mut().zip(base.iter().zip(nudged)) {
            *out |= (answer(a) - answer(b)).abs() > change;
        }
    };
    mark(&mut out, &asked.trace(&tracer, LIFT, report));
    for direction in [Vec2::X, Vec2::NEG_X, Vec2::Y, Vec2::NEG_Y] {
        let camera = asked.camera.nudged(direction * nudge.pixels);
        let receivers = find_receivers(&camera, asked.geometry)?;
        mark(&mut out, &Asked { camera: &camera, receivers: &receivers, ..*asked }.trace(&tracer, 1.0, report));
        if nudge.outlines {
            let outline = |i: usize| asked.receivers.receives[i] != receivers.receives[i];
            out.iter_mut().zip(asked.pixels).for_each(|(out, &i)| *out |= outline(i as usize));
        }
    }
    Ok(out)
}

fn answer(seen: &Seen) -> f32 {
    if seen.unlit { 0.0 } else { seen.visibility }
}
