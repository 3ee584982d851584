//! Upper bounds of light from the moments of a neighbourhood's depths. A bound is the greatest
//! fraction at the receiver's depth or beyond, over all depth distributions with these moments. It
//! is at least the result of filtering all comparisons; the excess appears as light leaks.

use glam::Vec2;
use umbrage_core::{Module, module};

/// The WGSL half.
pub(crate) const BOUNDS: Module = module!("bounds");

/// Returns the greatest fraction of a distribution that is `distance` or more from its mean on one
/// side (Cantelli's one-sided form of Chebyshev's inequality).
#[inline(always)]
pub(crate) fn chebyshev(distance: f32, variance: f32) -> f32 {
    variance / (variance + distance * distance)
}

/// Returns `lit` with values up to `amount` mapped to 0, and the rest stretched to 0..=1. `scale`
/// is 1 / (1 - `amount`) (Lauritzen 2007, "Summed-area variance shadow maps", GPU Gems 3).
#[inline(always)]
#[expect(
    clippy::manual_clamp,
    reason = "WGSL's min and max, in this order, also for NaN"
)]
pub(crate) fn without_bleeding(lit: f32, amount: f32, scale: f32) -> f32 {
    ((lit - amount) * scale).max(0.0).min(1.0)
}

/// Returns the fraction of light at a centred depth, from the means of depth and of its square.
#[inline(always)]
pub(crate) fn lit_by_variance(moments: Vec2, depth: f32, least_variance: f32) -> f32 {
    let distance = depth - moments.x;
    let variance = (moments.y - moments.x * moments.x).max(least_variance);
    let lit = chebyshev(distance, variance);
    if distance > 0.0 { lit } else { 1.0 }
}

/// Returns the fraction of light from the means of an exponential that rises with depth and of its
/// square. `receiver` is the exponential of the receiver's depth. Values are relative to it, so
/// that squares neither overflow nor vanish.
#[inline(always)]
pub(crate) fn lit_by_rising(moments: Vec2, receiver: f32, least_variance: f32) -> f32 {
    let scale = 1.0 / receiver;
    let mean = moments.x * scale;
    let variance = (moments.y * scale * scale - mean * mean).max(least_variance);
    let lit = chebyshev(1.0 - mean, variance);
    if moments.x < receiver { lit } else { 1.0 }
}

/// Returns the fraction of light from an exponential that falls with depth. Values are relative to
/// its mean.
#[inline(always)]
pub(crate) fn lit_by_falling(moments: Vec2, receiver: f32, least_variance: f32) -> f32 {
    let scale = 1.0 / moments.x;
    let depth = receiver * scale;
    let variance = (moments.y * scale * scale - 1.0).max(least_variance);
    let lit = chebyshev(1.0 - depth, variance);
    if receiver < moments.x { lit } else { 1.0 }
}

/// All twins of this module, for the tests that compare them.
#[cfg(feature = "testing")]
pub(crate) const TWINS: &[umbrage_core::Twin] = &[
    umbrage_core::twin!(BOUNDS, without_bleeding(lit: f32, amount: f32, scale: f32) -> f32, needs []),
    umbrage_core::twin!(BOUNDS, lit_by_variance(moments: Vec2, depth: f32, least_variance: f32) -> f32, needs []),
    umbrage_core::twin!(BOUNDS, lit_by_rising(moments: Vec2, receiver: f32, least_variance: f32) -> f32, needs []),
    umbrage_core::twin!(BOUNDS, lit_by_falling(moments: Vec2, receiver: f32, least_variance: f32) -> f32, needs []),
];

#[cfg(test)]
#[path = "bounds_tests.rs"]
mod tests;
