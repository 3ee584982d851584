//! How much light the moments of a neighbourhood's depths allow: the greatest share of it that may
//! lie at the receiver's depth or beyond, over all distributions of depth with these moments. It is
//! what filtering all comparisons would give, or more: what is more shows as light that leaks.

use glam::Vec2;
use umbrage_core::{Module, module};

/// The WGSL half.
pub(crate) const BOUNDS: Module = module!("bounds");

/// Returns the greatest share of a distribution that may lie `distance` or more from its mean on
/// one side (Cantelli's one-sided form of Chebyshev's inequality).
#[inline(always)]
pub(crate) fn chebyshev(distance: f32, variance: f32) -> f32 {
    variance / (variance + distance * distance)
}

/// Returns `lit` with all up to `amount` darkened to 0, and the rest stretched to 0..=1 by `scale`,
/// which is 1 / (1 - `amount`) (Lauritzen 2007, "Summed-area variance shadow maps", GPU Gems 3).
#[inline(always)]
#[expect(
    clippy::manual_clamp,
    reason = "WGSL's min and max, in this order, also for NaN"
)]
pub(crate) fn without_bleeding(lit: f32, amount: f32, scale: f32) -> f32 {
    ((lit - amount) * scale).max(0.0).min(1.0)
}

/// Returns the share of light at a centred depth, by the mean of depth and of its square.
#[inline(always)]
pub(crate) fn lit_by_variance(moments: Vec2, depth: f32, least_variance: f32) -> f32 {
    let distance = depth - moments.x;
    let variance = (moments.y - moments.x * moments.x).max(least_variance);
    let lit = chebyshev(distance, variance);
    if distance > 0.0 { lit } else { 1.0 }
}

/// Returns the share of light by the mean of an exponential that rises with depth, and of its
/// square; `receiver` is the exponential of the receiver's depth. All is counted in units of that,
/// so that squares neither overflow nor vanish.
#[inline(always)]
pub(crate) fn lit_by_rising(moments: Vec2, receiver: f32, least_variance: f32) -> f32 {
    let scale = 1.0 / receiver;
    let mean = moments.x * scale;
    let variance = (moments.y * scale * scale - mean * mean).max(least_variance);
    let lit = chebyshev(1.0 - mean, variance);
    if moments.x < receiver { lit } else { 1.0 }
}

/// Returns the same of an exponential that falls with depth, in units of its mean.
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
