//! Hamburger's moment problem: the greatest share that may lie at a depth or beyond, by four
//! moments, whatever depths there may be.
//!
//! Peters and Klein 2015, "Moment shadow mapping" (I3D).

use glam::{Vec2, Vec4};
use umbrage_core::{Module, module};

/// The WGSL half.
pub(crate) const HAMBURGER: Module = module!("hamburger");

/// Least variance of depth, and of its square where depth says nothing of it: by both is divided.
const LEAST_VARIANCE: f32 = 1e-9;

/// Returns the number, or the nearest from -1 to 1. It takes one number and not four, so that loops
/// over receivers become vector instructions.
#[inline(always)]
#[expect(
    clippy::manual_clamp,
    reason = "WGSL's min and max, in this order, also for NaN"
)]
pub(crate) fn bounded(x: f32) -> f32 {
    x.max(-1.0).min(1.0)
}

/// Returns what four moments say of depths z: x is their mean, y their variance, z the slope of the
/// line that is closest to z², and w the variance of z² around that line.
///
/// This is the Cholesky decomposition of the matrix of moments (Peters and Klein 2015, "Moment
/// shadow mapping", algorithm 1). With depths counted from the mean, m, three polynomials are
/// orthogonal: 1, m, and m² + t m - y, where t, the tilt, is twice the mean less the slope; their
/// mean squares are 1, y and w.
#[inline(always)]
pub(crate) fn central_moments(moments: Vec4) -> Vec4 {
    // Means of numbers from -1 to 1 are such numbers; so nothing overflows, whatever is asked.
    let [mean, mean2, mean3, mean4] = moments.to_array().map(bounded);
    let variance = (mean2 - mean * mean).max(LEAST_VARIANCE);
    let covariance = mean3 - mean * mean2;
    let slope = covariance / variance;
    let residual = (mean4 - mean2 * mean2 - slope * covariance).max(LEAST_VARIANCE);
    Vec4::new(mean, variance, slope, residual)
}

/// Returns a number that can be divided by.
#[inline(always)]
pub(crate) fn not_zero(x: f32) -> f32 {
    if x.abs() < 1e-12 { 1e-12 } else { x }
}

/// Returns the other two depths of the only distribution of three depths that has these moments and
/// one of them at `own`: nearer first, counted from the mean like `own`.
///
/// They are the zeros m of the kernel polynomial 1 + own m / y + (own² + t own - y)(m² + t m - y) /
/// w, with the letters of [`central_moments`]. Each is computed by the formula in which nothing
/// cancels.
#[inline(always)]
pub(crate) fn other_depths(central: Vec4, own: f32) -> Vec2 {
    let tilt = 2.0 * central.x - central.z;
    let square = own * (own + tilt) - central.y;
    let a = not_zero(square);
    let b = square * tilt + central.w / central.y * own;
    let c = central.w - square * central.y;
    let root = (b * b - 4.0 * square * c).max(0.0).sqrt();
    let size = (0.5 * (b.abs() + root)).max(1e-20);
    // With the sign that b doesn't have, by its bit: so -0 and 0 are told apart alike in both
    // halves.
    let opposite = !b.to_bits() & 0x8000_0000;
    let q = f32::from_bits(size.to_bits() | opposite);
    let first = q / a;
    let second = c / q;
    Vec2::new(first.min(second), first.max(second))
}

/// Returns what of that distribution lies at `own`: one over the kernel polynomial there.
#[inline(always)]
pub(crate) fn share_at(central: Vec4, own: f32) -> f32 {
    let tilt = 2.0 * central.x - central.z;
    let square = own * (own + tilt) - central.y;
    1.0 / (1.0 + own * own / central.y + square * square / central.w)
}

/// Returns what of that distribution isn't nearer than `own`, where it has `share`.
#[inline(always)]
pub(crate) fn lit_by_three(central: Vec4, own: f32, share: f32, others: Vec2) -> f32 {
    let span = ((own - others.x) * (others.y - others.x)).max(1e-20);
    // What lies at the nearest depth: the mean of Lagrange's polynomial that is 1 there and 0 at
    // the other two.
    let nearer = (central.y + own * others.y) / span;
    let between = if others.x < own { 1.0 - nearer } else { 1.0 };
    if others.y < own { share } else { between }
}

/// Returns the share of light at a centred depth by the first four moments of depth, whatever
/// depths there may be: Hamburger's moment problem (Peters and Klein 2015, algorithm 2).
#[inline(always)]
#[expect(
    clippy::manual_clamp,
    reason = "WGSL's min and max, in this order, also for NaN"
)]
pub(crate) fn hamburger(moments: Vec4, depth: f32) -> f32 {
    let central = central_moments(moments);
    let own = bounded(depth) - central.x;
    let share = share_at(central, own);
    let lit = lit_by_three(central, own, share, other_depths(central, own));
    lit.max(0.0).min(1.0)
}

/// All twins of this module, for the tests that compare them. What it calls is part of it.
#[cfg(feature = "testing")]
pub(crate) const TWINS: &[umbrage_core::Twin] =
    &[umbrage_core::twin!(HAMBURGER, hamburger(moments: Vec4, depth: f32) -> f32, needs [])];
