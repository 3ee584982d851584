//! Segment-box test, and the box around a triangle.
//!
//! The slab test of Kay and Kajiya 1986, "Ray Tracing Complex Scenes". It uses only subtraction,
//! multiplication, minimum and maximum. These are monotone, and so is rounding: if `x <= y`, the
//! rounded `x` is at most the rounded `y`. A segment that enters a box therefore enters every box
//! around it, **to the last bit**, at any distance. A search with this test never skips a triangle
//! whose own box is entered, if every box of the hierarchy contains those below it. This needs no
//! margin for rounding.
//!
//! Margins are needed so that a segment enters the box of every triangle that it hits;
//! `ray_triangle.rs` derives their size. One is proportional to the size of the triangle
//! ([`padded_box`]). The other is proportional to the distance from the segment's start
//! ([`EXIT_SLACK`], as in Ize 2013, "Robust BVH Ray Traversal").

use crate::recipe::shader::Module;
use glam::{Vec3, Vec3A};

/// The WGSL half.
pub const RAY_BOX: Module = crate::module!("ray_box");

/// Factor by which a segment may enter a box later than it leaves it: 32 roundings of 2^-24.
pub(crate) const EXIT_SLACK: f32 = 1.0 + 1.0 / 524_288.0;

/// 16 roundings of 2^-24.
const SIZE_PAD: f32 = 1.0 / 1_048_576.0;

/// 4 roundings of 2^-24.
const REACH_PAD: f32 = 1.0 / 4_194_304.0;

/// Returns the inverse of a segment's vector, for [`span`]. A component of zero gets a huge
/// inverse, since the product of infinity and 0 is NaN.
#[inline(always)]
pub(crate) fn slab_inverse(d: Vec3) -> Vec3A {
    Vec3A::new(safe_inverse(d.x), safe_inverse(d.y), safe_inverse(d.z))
}

#[inline(always)]
pub(crate) fn safe_inverse(x: f32) -> f32 {
    if x.abs() < 1e-30 {
        if x >= 0.0 { 1e30 } else { -1e30 }
    } else {
        1.0 / x
    }
}

/// Returns the range of fractions of a segment's vector at which it is within a box, given the
/// box's least and greatest corner. The segment enters the box if the first is at most
/// [`EXIT_SLACK`] times the second. `inverse` is [`slab_inverse`] of the vector.
#[inline(always)]
pub(crate) fn span(o: Vec3A, inverse: Vec3A, corners: [Vec3A; 2]) -> [f32; 2] {
    let [low, high] = corners;
    let a = (low - o) * inverse;
    let b = (high - o) * inverse;
    [
        a.min(b).max_element().max(0.0),
        a.max(b).min_element().min(1.0),
    ]
}

/// Returns whether a segment enters a box, given its least and greatest corner.
#[inline(always)]
pub(crate) fn enters_box(o: Vec3A, inverse: Vec3A, corners: [Vec3A; 2]) -> bool {
    let [entry, exit] = span(o, inverse, corners);
    entry <= exit * EXIT_SLACK
}

/// Returns the least and greatest corner of the box around a triangle. It is grown on all sides by
/// the greater of 2^-20 of its longest side and 2^-22 of its greatest coordinate. (It is not grown
/// by their sum: see `SUM_ORDER` in umbrage-wgpu's drivers.rs.)
#[inline(always)]
pub(crate) fn padded_box(corners: [Vec3A; 3]) -> [Vec3A; 2] {
    let [a, b, c] = corners;
    let low = a.min(b).min(c);
    let high = a.max(b).max(c);
    let size = (high - low).max_element();
    let reach = low.abs().max(high.abs()).max_element();
    let pad = (size * SIZE_PAD).max(reach * REACH_PAD);
    [low - pad, high + pad]
}

/// Returns whether a segment starts outside a box and moves away from it along an axis, so that it
/// surely misses. The comparisons are exact.
#[inline(always)]
pub(crate) fn leaves_box(o: Vec3A, inverse: Vec3A, corners: [Vec3A; 2]) -> bool {
    let [low, high] = corners;
    let above = o.cmpgt(high) & inverse.cmpgt(Vec3A::ZERO);
    let below = o.cmplt(low) & inverse.cmplt(Vec3A::ZERO);
    (above | below).any()
}

/// Returns whether the bounding rectangle of a triangle contains the origin, given the x and the y
/// of the triangle's corners.
#[inline(always)]
pub(crate) fn holds_origin(x: Vec3A, y: Vec3A) -> bool {
    x.min_element() <= 0.0
        && y.min_element() <= 0.0
        && x.max_element() >= 0.0
        && y.max_element() >= 0.0
}

/// Returns 2^-e for a number of size m 2^e, 1 <= m < 2: its exponent, negated. Products with it are
/// exact.
#[inline(always)]
pub(crate) fn inverse_power(x: f32) -> f32 {
    f32::from_bits(0x7f00_0000_u32.wrapping_sub(x.to_bits() & 0x7f80_0000))
}

/// The twins, for the lockstep tests.
#[cfg(feature = "testing")]
pub(crate) const TWINS: [crate::recipe::twin::Twin; 7] = [
    crate::twin!(RAY_BOX, safe_inverse(x: f32) -> f32),
    crate::twin!(RAY_BOX, enters_word(o: Vec3, inverse: Vec3, low: Vec3, high: Vec3) -> u32),
    crate::twin!(RAY_BOX, leaves_word(o: Vec3, inverse: Vec3, low: Vec3, high: Vec3) -> u32),
    crate::twin!(RAY_BOX, padded_low(a: Vec3, b: Vec3, c: Vec3) -> Vec3),
    crate::twin!(RAY_BOX, padded_high(a: Vec3, b: Vec3, c: Vec3) -> Vec3),
    crate::twin!(RAY_BOX, holds_origin_word(a: glam::Vec2, b: glam::Vec2, c: glam::Vec2) -> u32),
    crate::twin!(RAY_BOX, inverse_power(x: f32) -> f32),
];

#[cfg(feature = "testing")]
fn enters_word(o: Vec3, inverse: Vec3, low: Vec3, high: Vec3) -> u32 {
    u32::from(enters_box(
        o.into(),
        inverse.into(),
        [low.into(), high.into()],
    ))
}

#[cfg(feature = "testing")]
fn leaves_word(o: Vec3, inverse: Vec3, low: Vec3, high: Vec3) -> u32 {
    u32::from(leaves_box(
        o.into(),
        inverse.into(),
        [low.into(), high.into()],
    ))
}

#[cfg(feature = "testing")]
fn padded_low(a: Vec3, b: Vec3, c: Vec3) -> Vec3 {
    padded_box([a, b, c].map(Vec3A::from))[0].into()
}

#[cfg(feature = "testing")]
fn padded_high(a: Vec3, b: Vec3, c: Vec3) -> Vec3 {
    padded_box([a, b, c].map(Vec3A::from))[1].into()
}

#[cfg(feature = "testing")]
fn holds_origin_word(a: glam::Vec2, b: glam::Vec2, c: glam::Vec2) -> u32 {
    u32::from(holds_origin(
        Vec3A::new(a.x, b.x, c.x),
        Vec3A::new(a.y, b.y, c.y),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::light_sample::hash;

    /// Returns -1..1 times a power of ten from 1e-4 to 1e6, and often a round number.
    fn random(state: &mut u32) -> f32 {
        let mut next = || {
            *state = hash(*state);
            (*state >> 8) as f32 / 8_388_608.0 - 1.0
        };
        let value = next();
        let power = next();
        if power > 0.8 {
            (value * 4.0).round()
        } else {
            value * 10.0_f32.powf(power * 5.0 + 1.0)
        }
    }

    fn vector(state: &mut u32) -> Vec3 {
        Vec3::new(random(state), random(state), random(state))
    }

    /// The invariant of searches: a segment that enters a box enters every box around it, to the
    /// last bit.
    #[test]
    fn boxes_around_a_box_that_is_entered_are_entered() {
        let mut state = 9;
        let mut entered = 0;
        for i in 0..400_000 {
            let p = vector(&mut state);
            let q = vector(&mut state);
            let inner = [p.min(q), p.max(q)].map(Vec3A::from);
            // Often widen the box by only one unit in the last place, on one side.
            let outer = match i % 3 {
                0 => [inner[0].map(f32::next_down), inner[1]],
                1 => [
                    inner[0],
                    Vec3A::new(inner[1].x, inner[1].y.next_up(), inner[1].z),
                ],
                _ => [
                    inner[0].min(vector(&mut state).into()),
                    inner[1].max(vector(&mut state).into()),
                ],
            };
            // Aim at a point of the box's surface, where rounding decides.
            let o = vector(&mut state);
            let target = p
                .lerp(q, random(&mut state).abs().min(1.0))
                .with_x(if i % 2 == 0 { p.x } else { q.x });
            let d = (target - o) * [1.0, 0.5, 2.0, 1.0 - f32::EPSILON][i % 4];
            let o = Vec3A::from(o);
            let inverse = slab_inverse(d);
            let enters = enters_box(o, inverse, inner);
            entered += u32::from(enters);
            assert!(
                !enters || enters_box(o, inverse, outer),
                "{inner:?} in {outer:?}, from {o} along {d}"
            );
        }
        assert!(
            (50_000..350_000).contains(&entered),
            "too few hits to be meaningful: {entered}"
        );
    }

    #[test]
    fn vectors_along_an_axis_enter_what_they_run_through() {
        let corners = [Vec3A::ZERO, Vec3A::ONE];
        let enters = |o: Vec3, d: Vec3| enters_box(o.into(), slab_inverse(d), corners);
        for d in [
            Vec3::X,
            Vec3::new(1.0, -0.0, 0.0),
            Vec3::new(2.0, 1e-38, -1e-38),
        ] {
            assert!(
                enters(Vec3::new(-0.5, 1e-6, 0.999_999), d)
                    && enters(Vec3::new(0.5, 0.999_999, 1e-6), d)
            );
            assert!(
                !enters(Vec3::new(-0.5, -1e-6, 0.5), d)
                    && !enters(Vec3::new(-0.5, 0.5, 1.000_001), d)
            );
            assert!(!enters(Vec3::new(-2.5, 0.5, 0.5), d) && !enters(Vec3::new(1.5, 0.5, 0.5), d));
        }
    }
}
