//! Blockers of two heights over one receiver: light bleeding in maps that blend depths.

use super::SMALL;
use crate::{
    primitives::{block, grid},
    stage::{Stage, sun},
};
use umbrage_core::Scene;

/// Height of the lower plate's top over the floor, metres.
const LOW: f32 = 1.0;
/// Height of the upper plate's top, metres.
const HIGH: f32 = 5.0;
/// Thickness of both plates, metres.
const THICKNESS: f32 = 0.02;

/// A small plate 5 m above the floor whose shadow crosses that of a larger plate at 1 m. Along the
/// outline of the small plate's shadow, where the larger one darkens all the floor, a filter finds
/// depths of both plates. By their mean and variance (Chebyshev's inequality), up to ((5 - 1) / (5
/// + 1))² = 4/9 of the light may leak: a bright line in a dark area.
///
/// The sun is 45 degrees high and shines along +x. Shadows are therefore offset along +x by the
/// height of the plates.
pub(crate) fn two_plates() -> Scene {
    let low = block([-1.6, LOW - THICKNESS, -0.9], [0.0, LOW, 0.9]);
    let high = block([-6.0, HIGH - THICKNESS, -0.5], [-4.8, HIGH, 0.5]);
    Stage::new("two-plates")
        .put(grid([4.0, 4.0], [1, 1], |_, _| 0.0))
        .put(low)
        .put(high)
        .light(sun(1.0, -1.0, 0.0))
        .shoot([3.2, 2.6, 1.4], [0.25, 0.0, 0.0], 42.0, SMALL)
}
