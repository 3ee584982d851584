//! How much light the moments of a neighbourhood's depths allow: the greatest share of it that may lie at the receiver's depth or
//! beyond, over all distributions of depth with these moments. It is what filtering all comparisons would give, or more: what is more
//! shows as light that leaks.

use glam::{Vec2, Vec4};
use umbrage_core::Module;

/// The WGSL half.
pub(crate) const BOUNDS: Module = Module {
    name: "bounds",
    text: include_str!("bounds.wgsl"),
};

/// Least variance of depth in four moments, and of its square where depth says nothing of it: a division needs some.
const LEAST_VARIANCE: f32 = 1e-9;
/// Least distance between two depths, by which is divided.
const LEAST_DISTANCE: f32 = 1e-9;

/// Returns the greatest share of a distribution that may lie `distance` or more from its mean on one side (Cantelli's one-sided form
/// of Chebyshev's inequality).
#[inline(always)]
pub(crate) fn chebyshev(distance: f32, variance: f32) -> f32 {
    variance / (variance + distance * distance)
}

/// Returns `lit` with all up to `amount` darkened to 0, and the rest stretched to 0..=1 by `scale`, which is 1 / (1 - `amount`)
/// (Lauritzen 2007, "Summed-area variance shadow maps", GPU Gems 3).
#[inline(always)]
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

/// Returns the share of light by the mean of an exponential that rises with depth, and of its square; `receiver` is the exponential
/// of the receiver's depth. All is counted in units of that, so that squares neither overflow nor vanish.
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

/// What four moments of depth say of depths counted from their mean, w.
///
/// x: the mean. y: the mean of w². z: what makes w² + z w - y have a mean of 0 with every line in w (so -z y is the mean of w³). w: the
/// mean of its square. The three polynomials 1, w and w² + z w - y are orthogonal: this is the Cholesky decomposition of the matrix
/// of moments (Peters and Klein 2015, "Moment shadow mapping", algorithm 1), with depths counted from the mean.
#[inline(always)]
pub(crate) fn central_moments(b: Vec4) -> Vec4 {
    let variance = (b.y - b.x * b.x).max(LEAST_VARIANCE);
    let covariance = b.z - b.x * b.y;
    let slope = covariance / variance;
    let residual = (b.w - b.y * b.y - slope * covariance).max(LEAST_VARIANCE);
    Vec4::new(b.x, variance, 2.0 * b.x - slope, residual)
}

/// Returns a number that can be divided by.
#[inline(always)]
pub(crate) fn not_zero(x: f32) -> f32 {
    if x.abs() < 1e-12 { 1e-12 } else { x }
}

/// Returns the other two depths of the only distribution of three depths that has these moments and one of them at `own`: nearer first,
/// counted from the mean like `own`.
///
/// They are the zeros of the kernel polynomial 1 + own w / y + (own² + z own - y)(w² + z w - y) / w. Each is computed by
/// the formula in which nothing cancels.
#[inline(always)]
pub(crate) fn other_depths(central: Vec4, own: f32) -> Vec2 {
    let square = own * own + central.z * own - central.y;
    let a = not_zero(square);
    let b = square * central.z + central.w / central.y * own;
    let c = central.w - square * central.y;
    let root = (b * b - 4.0 * square * c).max(0.0).sqrt();
    let size = (0.5 * (b.abs() + root)).max(1e-20);
    // With the sign that b doesn't have, by its bit: so -0 and 0 are told apart alike in both halves.
    let opposite = !b.to_bits() & 0x8000_0000;
    let q = f32::from_bits(size.to_bits() | opposite);
    let first = q / a;
    let second = c / q;
    Vec2::new(first.min(second), first.max(second))
}

/// Returns what of that distribution isn't nearer than `own`.
#[inline(always)]
pub(crate) fn lit_by_three(central: Vec4, own: f32, others: Vec2) -> f32 {
    let square = own * own + central.z * own - central.y;
    // What lies at the receiver's own depth: one over the kernel polynomial there.
    let share = 1.0 / (1.0 + own * own / central.y + square * square / central.w);
    let span = ((own - others.x) * (others.y - others.x)).max(1e-20);
    // What lies at the nearest depth: the mean of Lagrange's polynomial that is 1 there and 0 at the other two.
    let nearer = (central.y + own * others.y) / span;
    let between = if others.x < own { 1.0 - nearer } else { 1.0 };
    if others.y < own { share } else { between }
}

/// Returns the same of the only distribution of four depths that has these moments, with one at `own`, and one at either end of the
/// map, -1 and 1.
///
/// The fourth, `free`, follows from the mean of (1 + z)(1 - z)(w - own)(w - free), which is zero.
#[inline(always)]
pub(crate) fn lit_by_four(central: Vec4, own: f32) -> f32 {
    let near = -1.0 - central.x;
    let far = 1.0 - central.x;
    let third = -(central.z * central.y);
    let fourth = central.w + central.y * (central.y + central.z * central.z);
    // Means of (1 + z)(1 - z), times 1, w and w².
    let square = 1.0 - central.x * central.x;
    let g0 = square - central.y;
    let g1 = -third - 2.0 * central.x * central.y;
    let g2 = square * central.y - fourth - 2.0 * central.x * third;
    let free = (g2 - own * g1) / not_zero(g1 - own * g0);
    let to_near = (own - near).max(LEAST_DISTANCE);
    if free < own {
        // The mean of the cubic that is 1 at `far` and `own`, 0 at `free` and `near`: Newton's divided differences, in that order.
        let to_free = (own - free).max(LEAST_DISTANCE);
        let to_far = (far - free).max(LEAST_DISTANCE);
        let second_difference = -1.0 / (to_free * to_far);
        let third_difference = -0.5 * (1.0 / (to_free * to_near) + 1.0 / (to_free * to_far));
        let second_mean = central.y + far * own;
        let third_mean = third - (far + own + free) * central.y - far * own * free;
        return 1.0 + second_difference * second_mean + third_difference * third_mean;
    }
    // Only what lies at `near` is nearer: the mean of the cubic that is 1 there and 0 at the others.
    let mean = own * free * far + (own + free + far) * central.y - third;
    1.0 - mean / (2.0 * to_near * (free - near).max(LEAST_DISTANCE))
}

/// Returns the share of light at a centred depth by the first four moments of depth, whatever depths there may be: Hamburger's moment
/// problem (Peters and Klein 2015, algorithm 2).
#[inline(always)]
pub(crate) fn hamburger(moments: Vec4, depth: f32) -> f32 {
    let central = central_moments(moments);
    let own = depth - central.x;
    let lit = lit_by_three(central, own, other_depths(central, own));
    lit.max(0.0).min(1.0)
}

/// Returns the same where no depth lies beyond the map's near or far plane: Hausdorff's moment problem (Peters and Klein 2015,
/// algorithm 3), which leaks less.
#[inline(always)]
pub(crate) fn hausdorff(moments: Vec4, depth: f32) -> f32 {
    let central = central_moments(moments);
    let own = depth - central.x;
    let others = other_depths(central, own);
    let lit = if others.x < -1.0 - central.x || others.y > 1.0 - central.x {
        lit_by_four(central, own)
    } else {
        lit_by_three(central, own, others)
    };
    lit.max(0.0).min(1.0)
}

/// All twins of this module, for the tests that compare them. What [`lit_by_three`] and [`lit_by_four`] compute is part of the last two.
#[cfg(feature = "testing")]
pub(crate) const TWINS: &[umbrage_core::Twin] = &[
    umbrage_core::twin!(BOUNDS, without_bleeding(lit: f32, amount: f32, scale: f32) -> f32, needs []),
    umbrage_core::twin!(BOUNDS, lit_by_variance(moments: Vec2, depth: f32, least_variance: f32) -> f32, needs []),
    umbrage_core::twin!(BOUNDS, lit_by_rising(moments: Vec2, receiver: f32, least_variance: f32) -> f32, needs []),
    umbrage_core::twin!(BOUNDS, lit_by_falling(moments: Vec2, receiver: f32, least_variance: f32) -> f32, needs []),
    umbrage_core::twin!(BOUNDS, hamburger(moments: Vec4, depth: f32) -> f32, needs []),
    umbrage_core::twin!(BOUNDS, hausdorff(moments: Vec4, depth: f32) -> f32, needs []),
];

#[cfg(test)]
#[path = "bounds_tests.rs"]
mod tests;
