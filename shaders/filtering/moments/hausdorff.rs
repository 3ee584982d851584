//! Hausdorff's moment problem: as [`hamburger`](super::hamburger), of depths that don't lie beyond
//! -1 and 1.
//!
//! Peters and Klein 2015, "Moment shadow mapping" (I3D).

use crate::filtering::moments::hamburger::{
    bounded, central_moments, lit_by_three, not_zero, other_depths, share_at,
};
use glam::Vec4;
use umbrage_core::{Module, module};

/// The WGSL half. It needs [`HAMBURGER`](super::hamburger::HAMBURGER).
pub(crate) const HAUSDORFF: Module = module!("hausdorff");

/// Least distance between two depths, by which is divided.
const LEAST_DISTANCE: f32 = 1e-9;

/// Returns the depth -1, counted from the mean. The bound by 0 changes nothing, as no mean is
/// nearer; but it keeps drivers from taking the difference apart and adding its parts to other
/// sums.
#[inline(always)]
fn near_end(central: Vec4) -> f32 {
    (-1.0 - central.x).min(0.0)
}

/// Returns the depth 1, counted from the mean, bounded likewise.
#[inline(always)]
fn far_end(central: Vec4) -> f32 {
    (1.0 - central.x).max(0.0)
}

/// Returns the same of the only distribution of four depths that has these moments, with one at
/// `own`, and one at either end of the map, -1 and 1.
///
/// The fourth, `free`, follows from the mean of (1 + z)(1 - z)(m - own)(m - free), which is zero.
/// That is, where (1 + z)(1 - z) weighs depths, `own` and `free` lie on either side of their mean,
/// and the product of their distances from it is their variance. Where almost all that weighs has
/// one depth (an empty map, whose depth 1 weighs nothing, has only the bias' depth 0), the variance
/// is less than what its terms are rounded by: near that depth `free` is then any number, and the
/// answer with it. `hausdorff` bounds it.
#[inline(always)]
pub(crate) fn lit_by_four(central: Vec4, own: f32) -> f32 {
    let near = near_end(central);
    let far = far_end(central);
    // Means of (1 + z)(1 - z), times 1, m and m², with the letters of `central_moments`: the mean
    // of m³ is -t y, that of m⁴ is w + y (y + t²). Differences of which drivers know the result (t
    // less twice the mean) are put in ready-made, and sums of products with one factor in common
    // are one product: drivers would make that of them.
    let square = 1.0 - central.x * central.x;
    let g0 = square - central.y;
    let tilt = 2.0 * central.x - central.z;
    let g1 = -(central.y * central.z);
    let g2 = central.y * (square - central.y + tilt * central.z) - central.w;
    let free = (g2 - own * g1) / not_zero(g1 - own * g0);
    let to_near = (own - near).max(LEAST_DISTANCE);
    if free < own {
        // The mean of the cubic that is 1 at `far` and `own`, 0 at `free` and `near`: by Newton's
        // divided differences, in that order, of which the second and the third are -1 / (to_free
        // to_far) and that times (to_near + to_far) / (2 to_near).
        let to_free = (own - free).max(LEAST_DISTANCE);
        let to_far = (far - free).max(LEAST_DISTANCE);
        let second_mean = central.y + far * own;
        let third_mean = -(tilt + far + own + free) * central.y - far * own * free;
        let cubic = (to_near + to_far) / (2.0 * to_near) * third_mean;
        return 1.0 - (second_mean + cubic) / (to_free * to_far);
    }
    // Only what lies at `near` is nearer: the mean of the cubic that is 1 there and 0 at the
    // others.
    let mean = own * free * far + (own + free + far + tilt) * central.y;
    1.0 - mean / (2.0 * to_near * (free - near).max(LEAST_DISTANCE))
}

/// Returns the same where no depth lies beyond the map's near or far plane: Hausdorff's moment
/// problem (Peters and Klein 2015, algorithm 3), which leaks less.
#[inline(always)]
#[expect(
    clippy::manual_clamp,
    reason = "WGSL's min and max, in this order, also for NaN"
)]
pub(crate) fn hausdorff(moments: Vec4, depth: f32) -> f32 {
    let central = central_moments(moments);
    let own = bounded(depth) - central.x;
    let others = other_depths(central, own);
    let share = share_at(central, own);
    let by_three = lit_by_three(central, own, share, others);
    let lit = if others.x < near_end(central) || others.y > far_end(central) {
        // All distributions with these moments, bounded or not, have no more behind `own` than the
        // one of three depths, and no less than that without its share at `own`: the inequalities
        // of Chebyshev, Markov and Stieltjes (Akhiezer 1965, "The classical moment problem"). So in
        // exact arithmetic these bounds change nothing; and where the four depths are ill
        // conditioned, they leave what the three allow, which aren't. (A greater least distance of
        // `free` from `own` would not do: with 1e-4, what lies behind a blocker at the near plane
        // is lit.)
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
