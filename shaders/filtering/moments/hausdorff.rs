//! Hausdorff's moment problem: like [`hamburger`](super::hamburger), for depths within -1 and 1.
//!
//! Peters and Klein 2015, "Moment shadow mapping" (I3D).

use crate::filtering::moments::hamburger::{
    bound_to_unit, central_moments, lit_by_three, not_zero, other_depths, share_at,
};
use glam::Vec4;
use umbrage_core::{Module, module};

/// The WGSL half. It needs [`HAMBURGER`](super::hamburger::HAMBURGER).
pub(crate) const HAUSDORFF: Module = module!("hausdorff");

/// Least distance between two depths, which is a divisor.
const LEAST_DISTANCE: f32 = 1e-9;

/// Returns the depth -1 relative to the mean. The bound of 0 has no effect, since no mean is
/// nearer. It keeps drivers from splitting the difference and adding its terms to other sums.
#[inline(always)]
fn near_end(central: Vec4) -> f32 {
    (-1.0 - central.x).min(0.0)
}

/// Returns the depth 1 relative to the mean, bounded likewise.
#[inline(always)]
fn far_end(central: Vec4) -> f32 {
    (1.0 - central.x).max(0.0)
}

/// Returns the fraction that isn't nearer than `own`, for the unique distribution of four depths
/// with these moments. One depth is at `own`, and one at either end of the map, -1 and 1.
///
/// The fourth, `free`, follows from the mean of (1 + z)(1 - z)(m - own)(m - free), which is zero.
/// So with depths weighted by (1 + z)(1 - z), `own` and `free` are on either side of their mean,
/// and the product of their distances from it is their variance. If almost all the weight is at one
/// depth, the variance is less than the rounding of its terms. (An empty map is an example: its
/// depth 1 has no weight, and only the bias' depth 0 remains.) Near that depth, `free` and the
/// result are then arbitrary, so `hausdorff` bounds the result.
#[inline(always)]
pub(crate) fn lit_by_four(central: Vec4, own: f32) -> f32 {
    let near = near_end(central);
    let far = far_end(central);
    // Compute the means of (1 + z)(1 - z), times 1, m and m², with the symbols of
    // `central_moments`: the mean of m³ is -t y, that of m⁴ is w + y (y + t²). Drivers simplify
    // some expressions, so differences with a known result (t minus twice the mean) are
    // precomputed, and sums of products with a common factor are written as one product.
    let square = 1.0 - central.x * central.x;
    let g0 = square - central.y;
    let tilt = 2.0 * central.x - central.z;
    let g1 = -(central.y * central.z);
    let g2 = central.y * (square - central.y + tilt * central.z) - central.w;
    let free = (g2 - own * g1) / not_zero(g1 - own * g0);
    let to_near = (own - near).max(LEAST_DISTANCE);
    if free < own {
        // Compute the mean of the cubic that is 1 at `far` and `own`, 0 at `free` and `near`.
        // Newton's divided differences in that order: the second is -1 / (to_free to_far), and the
        // third is the second times (to_near + to_far) / (2 to_near).
        let to_free = (own - free).max(LEAST_DISTANCE);
        let to_far = (far - free).max(LEAST_DISTANCE);
        let second_mean = central.y + far * own;
        let third_mean = -(tilt + far + own + free) * central.y - far * own * free;
        let cubic = (to_near + to_far) / (2.0 * to_near) * third_mean;
        return 1.0 - (second_mean + cubic) / (to_free * to_far);
    }
    // Only the depth `near` is nearer: compute the mean of the cubic that is 1 there and 0 at the
    // others.
    let mean = own * free * far + (own + free + far + tilt) * central.y;
    1.0 - mean / (2.0 * to_near * (free - near).max(LEAST_DISTANCE))
}

/// Returns the fraction of light at a centred depth, for depths within the map's near and far
/// plane: Hausdorff's moment problem (Peters and Klein 2015, algorithm 3), which leaks less.
#[inline(always)]
#[expect(
    clippy::manual_clamp,
    reason = "WGSL's min and max, in this order, also for NaN"
)]
pub(crate) fn hausdorff(moments: Vec4, depth: f32) -> f32 {
    let central = central_moments(moments);
    let own = bound_to_unit(depth) - central.x;
    let others = other_depths(central, own);
    let share = share_at(central, own);
    let by_three = lit_by_three(central, own, share, others);
    let lit = if others.x < near_end(central) || others.y > far_end(central) {
        // Bound the result by the distribution of three depths. For every distribution with these
        // moments, bounded or not, the fraction behind `own` is at most that of the three depths.
        // It is at least that without the share at `own`: the inequalities of Chebyshev, Markov and
        // Stieltjes (Akhiezer 1965, "The classical moment problem"). So these bounds change nothing
        // in exact arithmetic. If the four depths are ill-conditioned, the bounds of the three,
        // which aren't, remain. (A greater least distance of `free` from `own` is no substitute:
        // with 1e-4, receivers behind a blocker at the near plane are lit.)
        lit_by_four(central, own)
            .max(by_three - share)
            .min(by_three)
    } else {
        by_three
    };
    lit.max(0.0).min(1.0)
}

/// All twins of this module, for the tests that compare them.
#[cfg(feature = "testing")]
pub(crate) const TWINS: &[umbrage_core::Twin] = &[
    umbrage_core::twin!(HAUSDORFF, hausdorff(moments: Vec4, depth: f32) -> f32, needs [super::hamburger::HAMBURGER]),
];
