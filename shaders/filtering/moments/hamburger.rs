//! Hamburger's moment problem: the greatest fraction at a depth or beyond, from four moments, for
//! unbounded depths.
//!
//! Peters and Klein 2015, "Moment shadow mapping" (I3D).

use glam::{Vec2, Vec4};
use umbrage_core::{Module, module};

/// The WGSL half.
pub(crate) const HAMBURGER: Module = module!("hamburger");

/// Least variance of depth, and of its square around the fitted line. Both are divisors.
const LEAST_VARIANCE: f32 = 1e-9;

/// Clamps a number to -1..1. It takes one number and not four, so that loops over receivers are
/// vectorised.
#[inline(always)]
#[expect(
    clippy::manual_clamp,
    reason = "WGSL's min and max, in this order, also for NaN"
)]
pub(crate) fn bound_to_unit(x: f32) -> f32 {
    x.max(-1.0).min(1.0)
}

/// Returns central moments of depths z. x is their mean and y their variance. z is the slope of the
/// line that is closest to z², and w the variance of z² around that line.
///
/// This is the Cholesky decomposition of the matrix of moments (Peters and Klein 2015, "Moment
/// shadow mapping", algorithm 1). Let m be depth relative to the mean, and t, the tilt, twice the
/// mean minus the slope. The polynomials 1, m, and m² + t m - y are orthogonal. Their mean squares
/// are 1, y and w.
#[inline(always)]
pub(crate) fn central_moments(moments: Vec4) -> Vec4 {
    // Clamp means to -1..1, the range of valid input, so that nothing overflows for any input.
    let [mean, mean2, mean3, mean4] = moments.to_array().map(bound_to_unit);
    let variance = (mean2 - mean * mean).max(LEAST_VARIANCE);
    let covariance = mean3 - mean * mean2;
    let slope = covariance / variance;
    let residual = (mean4 - mean2 * mean2 - slope * covariance).max(LEAST_VARIANCE);
    Vec4::new(mean, variance, slope, residual)
}

/// Returns the number, or a small one if it is too close to zero for division.
#[inline(always)]
pub(crate) fn not_zero(x: f32) -> f32 {
    if x.abs() < 1e-12 { 1e-12 } else { x }
}

/// Returns the other two depths of the unique distribution of three depths with these moments, one
/// of which is at `own`. The nearer is first; like `own`, they are relative to the mean.
///
/// They are the zeros m of the kernel polynomial 1 + own m / y + (own² + t own - y)(m² + t m - y) /
/// w, with the symbols of [`central_moments`]. Each is computed by the formula without
/// cancellation.
#[inline(always)]
pub(crate) fn other_depths(central: Vec4, own: f32) -> Vec2 {
    let tilt = 2.0 * central.x - central.z;
    let square = own * (own + tilt) - central.y;
    let a = not_zero(square);
    let b = square * tilt + central.w / central.y * own;
    let c = central.w - square * central.y;
    let root = (b * b - 4.0 * square * c).max(0.0).sqrt();
    let size = (0.5 * (b.abs() + root)).max(1e-20);
    // Use the opposite sign of b, from its sign bit, so that both halves distinguish -0 and 0.
    let opposite = !b.to_bits() & 0x8000_0000;
    let q = f32::from_bits(size.to_bits() | opposite);
    let first = q / a;
    let second = c / q;
    Vec2::new(first.min(second), first.max(second))
}

/// Returns the fraction of that distribution at `own`: one over the kernel polynomial there.
#[inline(always)]
pub(crate) fn share_at(central: Vec4, own: f32) -> f32 {
    let tilt = 2.0 * central.x - central.z;
    let square = own * (own + tilt) - central.y;
    1.0 / (1.0 + own * own / central.y + square * square / central.w)
}

/// Returns the fraction of that distribution that isn't nearer than `own`; `share` is the fraction
/// at `own`.
#[inline(always)]
pub(crate) fn lit_by_three(central: Vec4, own: f32, share: f32, others: Vec2) -> f32 {
    let span = ((own - others.x) * (others.y - others.x)).max(1e-20);
    // Compute the fraction at the nearest depth: the mean of Lagrange's polynomial that is 1 there
    // and 0 at the other two.
    let nearer = (central.y + own * others.y) / span;
    let between = if others.x < own { 1.0 - nearer } else { 1.0 };
    if others.y < own { share } else { between }
}

/// Returns the fraction of light at a centred depth from the first four moments, for unbounded
/// depths: Hamburger's moment problem (Peters and Klein 2015, algorithm 2).
#[inline(always)]
#[expect(
    clippy::manual_clamp,
    reason = "WGSL's min and max, in this order, also for NaN"
)]
pub(crate) fn hamburger(moments: Vec4, depth: f32) -> f32 {
    let central = central_moments(moments);
    let own = bound_to_unit(depth) - central.x;
    let share = share_at(central, own);
    let lit = lit_by_three(central, own, share, other_depths(central, own));
    lit.max(0.0).min(1.0)
}

/// All twins of this module, for the tests that compare them. They include the called functions.
#[cfg(feature = "testing")]
pub(crate) const TWINS: &[umbrage_core::Twin] =
    &[umbrage_core::twin!(HAMBURGER, hamburger(moments: Vec4, depth: f32) -> f32, needs [])];
