//! Segment-triangle test: without cracks between triangles, without distant false hits, and
//! independent of order.
//!
//! A segment from `o` along `d` hits a triangle if four tests pass. They depend only on the
//! segment and the triangle, not on the hierarchy or on earlier tests.
//!
//! 1. Woop, Benthin, Wald 2013, "Watertight Ray/Triangle Intersection". A shear that depends only
//!    on the segment maps it to the z axis; the test then happens in the xy plane. A corner is
//!    mapped to the same point for every triangle that shares it. The sign of `x0 y1 - y0 x1` is
//!    never wrong, since rounding is monotone: at worst it is 0. Edges count as inside here, so 0
//!    needs no fallback to double precision as in the paper.
//! 2. The bounding rectangle of the triangle in that plane contains the origin.
//! 3. The segment enters the triangle's own box, by the box test of the hierarchies (`ray_box.rs`).
//! 4. The segment doesn't start outside the triangle's exact box and move away from it.
//!
//! **No cracks.** In a closed mesh, some triangle contains the plane's origin after its corners are
//! rounded, because neighbours share rounded corners. It passes test 1, as no sign is wrong, and
//! test 2. It also passes test 3 if the segment meets it:
//!
//! * Let z be the longest axis of `d`, `r = d.x / d.z` (at most 1), `u = 2^-24` the greatest
//!   relative error of one rounding, and (X, Y, Z) a corner minus `o`. The sheared `x = X - r Z`
//!   has an error of at most `2u |X| + 4u |r Z|`: the roundings of X, of r, Z and their product,
//!   and of the sum, whose size is at most `|X| + |r Z|`.
//! * Apply the barycentric weights of the origin among the rounded corners to the exact corners:
//!   this gives a point Q of the triangle. At Q's z, the distance from the segment's line to Q is
//!   at most the mean of those errors. With `w` the longest side of the triangle's box and `D` the
//!   distance between Q and `o` along x, `|X|` and `|r Z|` are at most `D + w`, so the distance is
//!   `6u (D + w)`. The same holds along y.
//! * The box is grown by the greater of `16u w` and `4u c` (c: its greatest coordinate), hence by
//!   at least `8u w + 2u c`. Its own rounding uses about `u c` of that. The rest covers the part
//!   with w.
//! * The other part moves the parameter `t` at which a side is crossed by at most `6u t`. The slab
//!   test's difference, inverse and product add `3u t`. So the box is entered before `t (1 + 9u)`
//!   and left after `t (1 - 9u)`, and `EXIT_SLACK = 1 + 32u` is more than their ratio.
//!
//! **No distant false hits.** Test 1 alone accepts undecided cases. Where all products round to 0
//! or to each other, a small or thin triangle is "hit" from any distance on the lines of its edges.
//! Test 2 keeps the origin within a triangle's size of its corners. There, a sign that is 0 by
//! rounding means that the origin is within a few `u` times that size of the edge. A segment that
//! hits therefore comes within a few roundings of the triangle.
//!
//! **No hits of a plane that a ray leaves.** Test 1 rounds in proportion to the triangle's size, so a
//! ray that starts just above a giant plane could hit the plane's other triangles. Test 4 has no
//! rounding: it decides all triangles in planes across an axis. It rejects only triangles that the
//! segment doesn't meet, so it opens no crack.
//!
//! **Independent of order.** By test 3, the box of a triangle that is hit is entered, and so are
//! all boxes around it (`ray_box.rs`). Every search that skips boxes only by that test finds a hit
//! if brute force does.

use crate::{
    geometry::ray_box::{
        enters_box, holds_origin, inverse_power, leaves_box, padded_box, slab_inverse,
    },
    recipe::shader::Module,
};
use glam::{Vec3, Vec3A};

/// The WGSL half of the triangle test. It calls [`RAY_BOX`](super::bvh::RAY_BOX).
pub const RAY_TRIANGLE: Module = crate::module!("ray_triangle");

/// A segment, prepared for many tests.
#[derive(Clone, Copy, Debug)]
pub struct Segment {
    pub(crate) origin: Vec3A,
    /// Inverse of its vector, for box tests.
    pub(crate) inverse: Vec3A,
    /// Rows of the shear that maps its vector to (0, 0, 1).
    rows: [Vec3A; 3],
}

/// A triangle, prepared for many tests: the x of its three corners, their y, their z.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Corners {
    x: Vec3A,
    y: Vec3A,
    z: Vec3A,
}

impl Corners {
    pub(crate) fn new(corners: [Vec3; 3]) -> Self {
        let [a, b, c] = corners;
        Self {
            x: Vec3A::new(a.x, b.x, c.x),
            y: Vec3A::new(a.y, b.y, c.y),
            z: Vec3A::new(a.z, b.z, c.z),
        }
    }

    /// Returns the three corners.
    #[cfg(feature = "rays")]
    #[inline(always)]
    pub(crate) fn points(&self) -> [Vec3; 3] {
        let Self { x, y, z } = self;
        [
            Vec3::new(x.x, y.x, z.x),
            Vec3::new(x.y, y.y, z.y),
            Vec3::new(x.z, y.z, z.z),
        ]
    }

    /// Returns the triangle's exact box, of test 4.
    #[inline(always)]
    fn exact_box(&self) -> [Vec3A; 2] {
        let Self { x, y, z } = self;
        [
            Vec3A::new(x.min_element(), y.min_element(), z.min_element()),
            Vec3A::new(x.max_element(), y.max_element(), z.max_element()),
        ]
    }

    /// Returns the triangle's box of test 3.
    #[inline(always)]
    pub(crate) fn padded_box(&self) -> [Vec3A; 2] {
        let Self { x, y, z } = self;
        padded_box([
            Vec3A::new(x.x, y.x, z.x),
            Vec3A::new(x.y, y.y, z.y),
            Vec3A::new(x.z, y.z, z.z),
        ])
    }
}

impl Segment {
    /// Returns the segment from `o` to `o + d`.
    #[inline(always)]
    pub fn new(o: Vec3, d: Vec3) -> Self {
        Self {
            origin: o.into(),
            inverse: slab_inverse(d),
            rows: shear_rows(d),
        }
    }

    /// Returns the three corners' coordinates along one row of the shear. Adds from left to right,
    /// as in the twin.
    #[inline(always)]
    fn along_row(&self, row: usize, t: &Corners) -> Vec3A {
        let r = self.rows[row];
        let o = self.origin;
        Vec3A::splat(r.x) * (t.x - Vec3A::splat(o.x))
            + Vec3A::splat(r.y) * (t.y - Vec3A::splat(o.y))
            + Vec3A::splat(r.z) * (t.z - Vec3A::splat(o.z))
    }

    /// Returns the signed areas of the triangle test: the barycentric coordinates of the point
    /// where the segment's line meets the triangle's plane, times their sum.
    #[inline(always)]
    pub(crate) fn areas(&self, t: &Corners) -> Vec3A {
        areas(self.along_row(0, t), self.along_row(1, t))
    }

    /// Returns whether the segment meets the triangle, edges and ends included.
    #[inline(always)]
    pub(crate) fn hits(&self, t: &Corners) -> bool {
        let x = self.along_row(0, t);
        let y = self.along_row(1, t);
        let areas = areas(x, y);
        if !(areas.cmpge(Vec3A::ZERO).all() || areas.cmple(Vec3A::ZERO).all()) {
            return false;
        }
        // The corners' coordinates along the segment, weighted by the areas: the fraction of the
        // segment's vector times the whole area.
        let weighted = areas * self.along_row(2, t);
        let whole = areas.x + areas.y + areas.z;
        let along = weighted.x + weighted.y + weighted.z;
        // 0 <= along / whole <= 1, without the division.
        let between = if whole > 0.0 {
            along >= 0.0 && along <= whole
        } else {
            whole < 0.0 && along <= 0.0 && along >= whole
        };
        // Few segments get here: the rest costs almost nothing.
        between
            && holds_origin(x, y)
            && !leaves_box(self.origin, self.inverse, t.exact_box())
            && enters_box(self.origin, self.inverse, t.padded_box())
    }
}

/// Returns (u, v, w): the signed areas opposite to the corners, as the z components of cross
/// products, given the corners' x and y in the shear.
#[inline(always)]
fn areas(x: Vec3A, y: Vec3A) -> Vec3A {
    Vec3A::new(x.y, x.z, x.x) * Vec3A::new(y.z, y.x, y.y)
        - Vec3A::new(y.y, y.z, y.x) * Vec3A::new(x.z, x.x, x.y)
}

/// Returns the rows of the shear that maps `d` to (0, 0, 1), including a cyclic permutation that
/// moves the longest axis to the end. The first two rows are scaled by a power of two, which is
/// exact. Products of lengths proportional to `d` then stay within range.
#[inline(always)]
fn shear_rows(d: Vec3) -> [Vec3A; 3] {
    let size = d.abs();
    let s = inverse_power(size.max_element());
    let row = Vec3A::new;
    if size.z >= size.x && size.z >= size.y {
        return [
            row(s, 0.0, -(d.x / d.z) * s),
            row(0.0, s, -(d.y / d.z) * s),
            row(0.0, 0.0, 1.0 / d.z),
        ];
    }
    if size.x >= size.y {
        return [
            row(-(d.y / d.x) * s, s, 0.0),
            row(-(d.z / d.x) * s, 0.0, s),
            row(1.0 / d.x, 0.0, 0.0),
        ];
    }
    [
        row(0.0, -(d.z / d.y) * s, s),
        row(s, -(d.x / d.y) * s, 0.0),
        row(0.0, 1.0 / d.y, 0.0),
    ]
}

/// Returns whether the segment from `o` to `o + d` meets the triangle, edges and ends included.
/// False if a number is not finite or `d` is zero.
#[inline(always)]
pub fn segment_hits(o: Vec3, d: Vec3, a: Vec3, b: Vec3, c: Vec3) -> bool {
    Segment::new(o, d).hits(&Corners::new([a, b, c]))
}

/// Returns whether the segment from `o` to `o + d` meets the triangle, in 64 bits: by the signs of
/// the volumes between the segment's line and the sides (Segura, Feito 2001, "Algorithms to Test
/// Ray-Triangle Intersection"). Edges and ends are included. Triangles that share a side compute
/// its volume with the same bits and opposite signs, so there are no cracks.
///
/// Hits are within some 2^-49 of the triangle's extent and distance, which is far below the
/// rounding of the 32-bit box tests around it. It has no twin.
#[cfg(feature = "rays")]
pub(crate) fn hits_in_f64(o: Vec3, d: Vec3, corners: [Vec3; 3]) -> bool {
    let volumes = volumes_in_f64(o, d, corners);
    let d = d.as_dvec3();
    let [a, b, c] = corners.map(|corner| corner.as_dvec3() - o.as_dvec3());
    if !(volumes.iter().all(|v| *v >= 0.0) || volumes.iter().all(|v| *v <= 0.0)) {
        return false;
    }
    // Intersect the line with the plane: t = n.a / n.d. NaN and infinity are no hits.
    let normal = (b - a).cross(c - a);
    (0.0..=1.0).contains(&(normal.dot(a) / normal.dot(d)))
}

/// Returns the volumes between a segment's line and a triangle's sides, each opposite to a corner.
/// They are the barycentric coordinates of the point where the line meets the triangle's plane,
/// times their sum.
#[cfg(feature = "rays")]
pub(crate) fn volumes_in_f64(o: Vec3, d: Vec3, corners: [Vec3; 3]) -> [f64; 3] {
    let d = d.as_dvec3();
    let [a, b, c] = corners.map(|corner| corner.as_dvec3() - o.as_dvec3());
    [d.dot(b.cross(c)), d.dot(c.cross(a)), d.dot(a.cross(b))]
}

/// The twins, for the lockstep tests.
#[cfg(feature = "testing")]
pub const TWINS: &[crate::recipe::twin::Twin] = &[
    crate::twin!(RAY_TRIANGLE, hit_word(o: Vec3, d: Vec3, a: Vec3, b: Vec3, c: Vec3) -> u32, needs [super::ray_box::RAY_BOX]),
    super::ray_box::TWINS[0],
    super::ray_box::TWINS[1],
    super::ray_box::TWINS[2],
    super::ray_box::TWINS[3],
    super::ray_box::TWINS[4],
    super::ray_box::TWINS[5],
    super::ray_box::TWINS[6],
    super::shaft::TWINS[0],
];

#[cfg(feature = "testing")]
fn hit_word(o: Vec3, d: Vec3, a: Vec3, b: Vec3, c: Vec3) -> u32 {
    u32::from(segment_hits(o, d, a, b, c))
}

#[cfg(test)]
#[path = "ray_triangle_tests.rs"]
mod tests;
