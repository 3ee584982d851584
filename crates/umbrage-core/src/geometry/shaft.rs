//! Shaft-box test: whether any segment of a bundle enters an axis-aligned box. It replaces separate
//! tests of all shadow rays of an area light.
//!
//! Haines and Wallace 1991, "Shaft Culling for Efficient Ray-Traced Radiosity". A [`Shaft`]
//! contains all segments that start in one box and end in another. At the fraction t of their
//! lengths all of them are within an interpolated box, whose corners move along lines. The test
//! computes, axis by axis, for which t that box meets the other one. It is the slab test of
//! `ray_box.rs` with two origins.
//!
//! The test is conservative: it never misses a segment that enters a box, but may report a shaft
//! that only passes close by.

use crate::{
    geometry::{
        aabb::Aabb,
        ray_box::{EXIT_SLACK, slab_inverse},
    },
    math::{greater, lesser},
    recipe::shader::Module,
};
use glam::{Vec3, Vec4};

/// The WGSL half. It calls [`RAY_BOX`](super::bvh::RAY_BOX).
pub const SHAFT: Module = crate::module!("shaft");

/// Widening of a shaft at its end, as a fraction of its length (2^-17): far more than the rounding
/// of tests of its segments.
const SHAFT_MARGIN: f32 = 1.0 / 131_072.0;

/// All segments from the points of one box to those of another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shaft {
    /// The starting box.
    low: Vec3,
    high: Vec3,
    /// Inverse of the displacement of the box's least corner, and of its greatest corner.
    low_inverse: Vec3,
    high_inverse: Vec3,
}

impl Shaft {
    /// Builds the shaft of all segments from a point of `start` along a vector in the box from
    /// `low` to `high`.
    #[inline(always)]
    pub fn along_direction(start: &Aabb, low: Vec3, high: Vec3) -> Self {
        let length = low.abs().max(high.abs()).max_element();
        let margin = length * SHAFT_MARGIN;
        Self {
            low: start.min,
            high: start.max,
            low_inverse: slab_inverse(low - margin).into(),
            high_inverse: slab_inverse(high + margin).into(),
        }
    }

    /// Builds the shaft of all segments from a point of `start` to a point of `end`.
    #[inline(always)]
    pub fn between_boxes(start: &Aabb, end: &Aabb) -> Self {
        // At the fraction t, a segment from s to e is at s (1 - t) + e t. That is at least the
        // value for the least s and e.
        Self::along_direction(start, end.min - start.min, end.max - start.max)
    }
}

/// A search for the casters in a [`Shaft`], see [`Bvh::in_shaft`](super::bvh::Bvh::in_shaft).
pub trait ShaftSearch {
    /// Returns which of four boxes have to be searched: a subset of the bits in `entered`. `low`
    /// and `high` are the boxes' sides along x, y, z.
    fn keep(&mut self, entered: u32, low: [Vec4; 3], high: [Vec4; 3]) -> u32;

    /// Visits a caster. Returns whether the search has enough.
    fn visit(&mut self, id: u32, corners: [Vec3; 3]) -> bool;
}

/// Returns whether a segment of the shaft enters a box, given its least and greatest corner.
///
/// The shaft's least corner crosses the box's greatest side. It is inside from then on if it comes
/// from beyond that side, and until then otherwise. The greatest corner and the least side behave
/// likewise.
///
/// This is the reference for the shader, for [`ShaftLanes`] (four boxes) and for [`Shafts`] (many
/// shafts).
#[cfg(any(test, feature = "testing"))]
fn enters(shaft: &Shaft, low: Vec3, high: Vec3) -> bool {
    let at_high = (high - shaft.low) * shaft.low_inverse;
    let at_low = (low - shaft.high) * shaft.high_inverse;
    let mut entry = 0.0_f32;
    let mut exit = 1.0_f32;
    for axis in 0..3 {
        if shaft.low_inverse[axis] >= 0.0 {
            exit = exit.min(at_high[axis]);
        } else {
            entry = entry.max(at_high[axis]);
        }
        if shaft.high_inverse[axis] >= 0.0 {
            entry = entry.max(at_low[axis]);
        } else {
            exit = exit.min(at_low[axis]);
        }
    }
    entry <= exit * EXIT_SLACK
}

/// Number of shafts tested against a box at once.
pub const SHAFT_LANES: usize = 8;

/// One number per shaft.
type ShaftNumbers = [f32; SHAFT_LANES];

/// Shafts, for the test of one box by all of them at once.
#[derive(Clone, Copy, Debug)]
pub struct Shafts {
    low: [ShaftNumbers; 3],
    high: [ShaftNumbers; 3],
    low_inverse: [ShaftNumbers; 3],
    high_inverse: [ShaftNumbers; 3],
}

impl Shafts {
    /// Returns the same shaft in all lanes.
    #[inline(always)]
    pub fn all(shaft: &Shaft) -> Self {
        let splat = |v: Vec3| v.to_array().map(|x| [x; SHAFT_LANES]);
        Self {
            low: splat(shaft.low),
            high: splat(shaft.high),
            low_inverse: splat(shaft.low_inverse),
            high_inverse: splat(shaft.high_inverse),
        }
    }

    /// Sets the shaft of a lane.
    ///
    /// # Panics
    /// Panics if `lane` is not less than [`SHAFT_LANES`].
    #[inline(always)]
    pub fn set(&mut self, lane: usize, shaft: &Shaft) {
        for axis in 0..3 {
            self.low[axis][lane] = shaft.low[axis];
            self.high[axis][lane] = shaft.high[axis];
            self.low_inverse[axis][lane] = shaft.low_inverse[axis];
            self.high_inverse[axis][lane] = shaft.high_inverse[axis];
        }
    }

    /// Returns all bits set for each shaft that enters a box, no bits for others. Only shafts with
    /// bits set in `queried` are tested.
    #[inline(always)]
    pub fn entered_boxes(
        &self,
        low: Vec3,
        high: Vec3,
        queried: &[u32; SHAFT_LANES],
    ) -> [u32; SHAFT_LANES] {
        let mut out = [0; SHAFT_LANES];
        for i in 0..SHAFT_LANES {
            let mut entry = 0.0;
            let mut exit = 1.0;
            for axis in 0..3 {
                let low_inverse = self.low_inverse[axis][i];
                let at_high = (high[axis] - self.low[axis][i]) * low_inverse;
                let rises = low_inverse >= 0.0;
                exit = lesser(exit, if rises { at_high } else { 1.0 });
                entry = greater(entry, if rises { 0.0 } else { at_high });
                let high_inverse = self.high_inverse[axis][i];
                let at_low = (low[axis] - self.high[axis][i]) * high_inverse;
                let rises = high_inverse >= 0.0;
                entry = greater(entry, if rises { at_low } else { 0.0 });
                exit = lesser(exit, if rises { 1.0 } else { at_low });
            }
            out[i] = if entry <= exit * EXIT_SLACK {
                queried[i]
            } else {
                0
            };
        }
        out
    }
}

/// A shaft, for the test of four boxes at once.
pub(super) struct ShaftLanes {
    low: [Vec4; 3],
    high: [Vec4; 3],
    low_inverse: [Vec4; 3],
    high_inverse: [Vec4; 3],
    /// True where corners move towards greater coordinates.
    low_rises: [bool; 3],
    high_rises: [bool; 3],
}

impl ShaftLanes {
    #[inline(always)]
    pub(super) fn new(shaft: &Shaft) -> Self {
        let splat = |v: Vec3| v.to_array().map(Vec4::splat);
        let rises = |v: Vec3| v.to_array().map(|x| x >= 0.0);
        Self {
            low: splat(shaft.low),
            high: splat(shaft.high),
            low_inverse: splat(shaft.low_inverse),
            high_inverse: splat(shaft.high_inverse),
            low_rises: rises(shaft.low_inverse),
            high_rises: rises(shaft.high_inverse),
        }
    }

    /// Returns the octant of the shaft's direction, for the order of visits: a bit for each axis, x
    /// the highest.
    #[inline(always)]
    pub(super) fn octant(&self) -> u32 {
        let [x, y, z] = self.high_rises.map(u32::from);
        x << 2 | y << 1 | z
    }

    /// Returns a bit for each of four boxes that is entered; `low` and `high` are their sides along
    /// x, y, z.
    #[inline(always)]
    pub(super) fn entered_lanes(&self, low: [Vec4; 3], high: [Vec4; 3]) -> u32 {
        let mut entry = Vec4::ZERO;
        let mut exit = Vec4::ONE;
        for axis in 0..3 {
            let at_high = (high[axis] - self.low[axis]) * self.low_inverse[axis];
            if self.low_rises[axis] {
                exit = exit.min(at_high);
            } else {
                entry = entry.max(at_high);
            }
            let at_low = (low[axis] - self.high[axis]) * self.high_inverse[axis];
            if self.high_rises[axis] {
                entry = entry.max(at_low);
            } else {
                exit = exit.min(at_low);
            }
        }
        entry.cmple(exit * EXIT_SLACK).bitmask()
    }
}

/// The twins, for the lockstep tests.
#[cfg(feature = "testing")]
pub(crate) const TWINS: [crate::recipe::twin::Twin; 1] = [
    crate::twin!(SHAFT, shaft_enters_word(o: Vec3, low: Vec3, high: Vec3, box_low: Vec3, box_high: Vec3) -> u32, needs [super::ray_box::RAY_BOX]),
];

#[cfg(feature = "testing")]
fn shaft_enters_word(o: Vec3, low: Vec3, high: Vec3, box_low: Vec3, box_high: Vec3) -> u32 {
    let shaft = Shaft::along_direction(&Aabb::from_points([o]), low, high);
    u32::from(enters(&shaft, box_low, box_high))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{
        random::Random,
        ray_box::{enters_box, slab_inverse},
    };

    /// Every box that a segment enters is entered by every shaft that contains the segment. A shaft
    /// in another direction doesn't enter it.
    #[test]
    fn shafts_enter_what_their_segments_enter() {
        let mut random = Random(23);
        let mut entered = 0;
        let mut passed = 0;
        for i in 0..60_000_u32 {
            let distance = [0.0, 10.0, 1e6][i as usize % 3];
            let mut point = || random.vector() + distance;
            let box_of = |p: Vec3, q: Vec3| [p.min(q), p.max(q)];
            let start = box_of(point(), point());
            let ends = box_of(point() - distance, point() - distance);
            let [low, high] = box_of(point(), point());
            let mut share = || random.vector() * 0.5 + 0.5;
            let o = start[0] + (start[1] - start[0]) * share();
            let d = ends[0] + (ends[1] - ends[0]) * share();
            let around = Aabb {
                min: start[0],
                max: start[1],
            };
            let shaft = Shaft::along_direction(&around, ends[0], ends[1]);
            let lanes = ShaftLanes::new(&shaft).entered_lanes(
                low.to_array().map(Vec4::splat),
                high.to_array().map(Vec4::splat),
            );
            let enters = enters(&shaft, low, high);
            assert_eq!(lanes == 0xf, enters);
            let querying = [u32::MAX; SHAFT_LANES];
            let of_all = Shafts::all(&shaft).entered_boxes(low, high, &querying);
            assert_eq!(of_all, querying.map(|bits| if enters { bits } else { 0 }));
            let is_entered = enters_box(o.into(), slab_inverse(d), [low.into(), high.into()]);
            assert!(!is_entered || enters, "{i}: {o} along {d}, {low} to {high}");
            entered += u32::from(is_entered);
            passed += u32::from(!enters);
        }
        assert!(entered > 2000 && passed > 2000, "{entered}, {passed}");
    }
}
