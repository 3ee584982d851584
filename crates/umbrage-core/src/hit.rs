//! Whether a segment meets a triangle, without cracks between triangles.
//!
//! Woop, Benthin, Wald 2013, "Watertight Ray/Triangle Intersection": a shear that depends on the ray alone turns it into
//! the z axis, and the rest happens in the plane. A corner lands on the same point for every triangle that has it, and
//! the sign of `x0 y1 - y0 x1` is never wrong, since rounding is monotone: at worst it is 0. Edges count as inside
//! here, so 0 needs no second look (the paper's double precision), and no ray slips between neighbours, whether at an
//! edge or at a corner.

use crate::{MATH, Module, Twin, twin};
use glam::{Vec3, Vec3A};

/// The WGSL half of the triangle test.
pub const HIT: Module = Module { name: "hit", text: include_str!("hit.wgsl") };

/// A segment, ready for many tests.
#[derive(Clone, Copy, Debug)]
pub struct Segment {
    origin: Vec3A,
    /// Rows of the shear that maps the segment's vector to (0, 0, 1).
    rows: [Vec3A; 3],
}

/// A triangle, ready for many tests: the x of its three corners, their y, their z.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Corners {
    x: Vec3A,
    y: Vec3A,
    z: Vec3A,
}

impl Corners {
    pub(crate) fn new([a, b, c]: [Vec3; 3]) -> Self {
        Self { x: Vec3A::new(a.x, b.x, c.x), y: Vec3A::new(a.y, b.y, c.y), z: Vec3A::new(a.z, b.z, c.z) }
    }
}

impl Segment {
    /// The segment from `o` to `o + d`.
    #[inline(always)]
    pub fn new(o: Vec3, d: Vec3) -> Self {
        Self { origin: o.into(), rows: shear_rows(d) }
    }

    /// The three corners' coordinate along one row of the shear. Sums run from left to right, as in the twin.
    #[inline(always)]
    fn along_row(&self, row: usize, t: &Corners) -> Vec3A {
        let (r, o) = (self.rows[row], self.origin);
        Vec3A::splat(r.x) * (t.x - Vec3A::splat(o.x))
            + Vec3A::splat(r.y) * (t.y - Vec3A::splat(o.y))
            + Vec3A::splat(r.z) * (t.z - Vec3A::splat(o.z))
    }

    /// Whether it meets the triangle, edges and ends included.
    #[inline(always)]
    pub(crate) fn hits(&self, t: &Corners) -> bool {
        let (x, y) = (self.along_row(0, t), self.along_row(1, t));
        // (u, v, w): the signed areas opposite to the corners, as the third axis of a cross product.
        let areas = Vec3A::new(x.y, x.z, x.x) * Vec3A::new(y.z, y.x, y.y)
            - Vec3A::new(y.y, y.z, y.x) * Vec3A::new(x.z, x.x, x.y);
        if !(areas.cmpge(Vec3A::ZERO).all() || areas.cmple(Vec3A::ZERO).all()) {
            return false;
        }
        let along = areas * self.along_row(2, t);
        let (whole, along) = (areas.x + areas.y + areas.z, along.x + along.y + along.z);
        // 0 <= along / whole <= 1, without the division.
        if whole > 0.0 { along >= 0.0 && along <= whole } else { whole < 0.0 && along <= 0.0 && along >= whole }
    }
}

/// Rows of the shear (with a cyclic exchange of axes that brings the longest to the end) that maps `d` to (0, 0, 1).
#[inline(always)]
fn shear_rows(d: Vec3) -> [Vec3A; 3] {
    let size = d.abs();
    let row = Vec3A::new;
    if size.z >= size.x && size.z >= size.y {
        return [row(1.0, 0.0, -(d.x / d.z)), row(0.0, 1.0, -(d.y / d.z)), row(0.0, 0.0, 1.0 / d.z)];
    }
    if size.x >= size.y {
        return [row(-(d.y / d.x), 1.0, 0.0), row(-(d.z / d.x), 0.0, 1.0), row(1.0 / d.x, 0.0, 0.0)];
    }
    [row(0.0, -(d.z / d.y), 1.0), row(1.0, -(d.x / d.y), 0.0), row(0.0, 1.0 / d.y, 0.0)]
}

/// Whether the segment from `o` to `o + d` meets the triangle, edges and ends included.
#[inline(always)]
pub fn segment_hits(o: Vec3, d: Vec3, a: Vec3, b: Vec3, c: Vec3) -> bool {
    Segment::new(o, d).hits(&Corners::new([a, b, c]))
}

/// The pairs, for the lockstep tests.
pub const TWINS: &[Twin] = &[twin!(HIT, hit_word(o: Vec3, d: Vec3, a: Vec3, b: Vec3, c: Vec3) -> u32, needs [MATH])];

fn hit_word(o: Vec3, d: Vec3, a: Vec3, b: Vec3, c: Vec3) -> u32 {
    u32::from(segment_hits(o, d, a, b, c))
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: Vec3 = Vec3::new(-1.0, 0.0, -1.0);
    const B: Vec3 = Vec3::new(1.0, 0.0, -1.0);
    const C: Vec3 = Vec3::new(0.0, 0.0, 1.0);

    #[test]
    fn both_sides_edges_corners_and_ends_are_hit() {
        let down = |x: f32, z: f32| segment_hits(Vec3::new(x, 1.0, z), Vec3::new(0.0, -2.0, 0.0), A, B, C);
        let up = |x: f32, z: f32| segment_hits(Vec3::new(x, -1.0, z), Vec3::new(0.0, 1.0, 0.0), A, B, C);
        for (x, z) in [(0.0, 0.0), (0.0, -1.0), (-1.0, -1.0), (1.0, -1.0), (0.0, 1.0), (0.5, 0.0)] {
            assert!(down(x, z) && up(x, z), "({x}, {z})");
        }
        for (x, z) in [(0.0, -1.001), (0.51, 0.0), (-0.51, 0.0), (0.0, 1.001)] {
            assert!(!down(x, z) && !up(x, z), "({x}, {z})");
        }
    }

    #[test]
    fn segments_that_end_before_or_begin_behind_miss() {
        let hit = |o: f32, d: f32| segment_hits(Vec3::new(0.0, o, 0.0), Vec3::new(0.0, d, 0.0), A, B, C);
        assert!(hit(1.0, -1.0) && hit(0.0, 1.0));
        assert!(!hit(1.0, -0.999) && !hit(-0.001, -1.0) && !hit(0.001, 1.0));
    }

    #[test]
    fn flat_triangles_and_parallel_segments_miss() {
        assert!(!segment_hits(Vec3::Y, Vec3::NEG_Y * 2.0, A, B, B));
        assert!(!segment_hits(Vec3::Y, Vec3::X, A, B, C));
        assert!(!segment_hits(Vec3::new(-5.0, 0.0, 0.0), Vec3::X * 10.0, A, B, C));
    }

    /// Segments aimed at the corners and edges of a fan that closes around the origin: each must hit one of its triangles.
    #[test]
    fn fans_have_no_cracks() {
        let mut hash = 1_u32;
        let mut random = || {
            hash = crate::light_sample::hash(hash);
            hash as f32 / 4_294_967_296.0 - 0.5
        };
        for _ in 0..2_000 {
            let hub = Vec3::new(random(), random() * 0.1, random());
            let rim: Vec<Vec3> = (0..7)
                .map(|i| {
                    let angle = i as f32 * 0.9 + random() * 0.2;
                    hub + Vec3::new(angle.cos(), random() * 0.1, angle.sin())
                })
                .collect();
            let triangles: Vec<[Vec3; 3]> = (0..7).map(|i| [hub, rim[i], rim[(i + 1) % 7]]).collect();
            for (i, &corner) in rim.iter().enumerate() {
                let target = hub.lerp(corner, (random() + 0.5) * 0.9 * (i % 2) as f32);
                let o = target + Vec3::new(random() * 3.0, 4.0 + random(), random() * 3.0);
                let d = (target - o) * 2.0;
                assert!(triangles.iter().any(|t| segment_hits(o, d, t[0], t[1], t[2])), "a crack at {target}");
            }
        }
    }
}
