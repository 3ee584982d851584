//! Hausdorff's moment problem: as [`hamburger`](super::hamburger), of depths that don't lie beyond -1 and 1.
//!
//! Peters and Klein 2015, "Moment shadow mapping" (I3D).

use crate::filtering::moments::hamburger::{central_moments, lit_by_three, not_zero, other_depths};
use glam::Vec4;
use umbrage_core::Module;

/// The WGSL half. It needs [`HAMBURGER`](super::hamburger::HAMBURGER).
pub(crate) const HAUSDORFF: Module = Module {
    name: "hausdorff",
    text: include_str!("hausdorff.wgsl"),
};

/// Least distance between two depths, by which is divided.
const LEAST_DISTANCE: f32 = 1e-9;

/// Returns the same of the only distribution of four depths that has these moments, with one at `own`, and one at either end of the
/// map, -1 and 1.
///
/// The fourth, `free`, follows from the mean of (1 + z)(1 - z)(w - own)(w - free), which is zero.
#[inline(always)]
pub(crate) fn lit_by_four(central: Vec4, own: f32) -> f32 {
    let near = -1.0 - central.x;
    let far = 1.0 - central.x;
    // Means of (1 + z)(1 - z), times 1, w and w². The mean of w³ is -z y, that of w⁴ is w + y (y + z²). Sums of products with one factor
    // in common are written as one product: drivers would make that of them.
    let square = 1.0 - central.x * central.x;
    let g0 = square - central.y;
    let g1 = central.y * (central.z - 2.0 * central.x);
    let g2 =
        central.y * (square - central.y - central.z * (central.z - 2.0 * central.x)) - central.w;
    let free = (g2 - own * g1) / not_zero(g1 - own * g0);
    let to_near = (own - near).max(LEAST_DISTANCE);
    if free < own {
        // The mean of the cubic that is 1 at `far` and `own`, 0 at `free` and `near`: Newton's divided differences, in that order.
        let to_free = (own - free).max(LEAST_DISTANCE);
        let to_far = (far - free).max(LEAST_DISTANCE);
        let second_difference = -1.0 / (to_free * to_far);
        let third_difference = -0.5 * (1.0 / (to_free * to_near) + 1.0 / (to_free * to_far));
        let second_mean = central.y + far * own;
        let third_mean = -(central.z + far + own + free) * central.y - far * own * free;
        return 1.0 + second_difference * second_mean + third_difference * third_mean;
    }
    // Only what lies at `near` is nearer: the mean of the cubic that is 1 there and 0 at the others.
    let mean = own * free * far + (own + free + far + central.z) * central.y;
    1.0 - mean / (2.0 * to_near * (free - near).max(LEAST_DISTANCE))
}

/// Returns the same where no depth lies beyond the map's near or far plane: Hausdorff's moment problem (Peters and Klein 2015,
/// algorithm 3), which leaks less.
#[inline(always)]
pub(crate) fn hausdorff(moments: Vec4, depth: f32) -> f32 {
    let central = central_moments(moments);
    let own = depth.max(-1.0).min(1.0) - central.x;
    let others = other_depths(central, own);
    let lit = if others.x < -1.0 - central.x || others.y > 1.0 - central.x {
        lit_by_four(central, own)
    } else {
        lit_by_three(central, own, others)
    };
    lit.max(0.0).min(1.0)
}

/// All twins of this module, for the tests that compare them.
#[cfg(feature = "testing")]
pub(crate) const TWINS: &[umbrage_core::Twin] = &[
    umbrage_core::twin!(HAUSDORFF, hausdorff(moments: Vec4, depth: f32) -> f32, needs [super::hamburger::HAMBURGER]),
];
