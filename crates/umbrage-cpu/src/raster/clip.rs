//! Clipping of triangles to the view volume (Sutherland, Hodgman: Reentrant Polygon Clipping, 1974), in the order and
//! arithmetic of Mesa's software rasterisers, so that cut edges get the same bits as theirs.

use crate::raster::viewport::Viewport;
use glam::{Vec3, Vec4};

/// The planes x <= w, -w <= x, y <= w, -w <= y, 0 <= z, z <= w; bit `i` of an outcode stands for plane `i`.
const PLANES: [[f32; 4]; 6] = [
    [-1.0, 0.0, 0.0, 1.0],
    [1.0, 0.0, 0.0, 1.0],
    [0.0, -1.0, 0.0, 1.0],
    [0.0, 1.0, 0.0, 1.0],
    [0.0, 0.0, 1.0, 0.0],
    [0.0, 0.0, -1.0, 1.0],
];

/// A triangle gains at most one corner a plane.
const MAX_CORNERS: usize = 3 + PLANES.len();

/// Which planes a vertex lies outside of.
#[inline(always)]
pub(crate) fn outcode(p: Vec4) -> u32 {
    let bit = |outside: bool, i: u32| u32::from(outside) << i;
    bit(p.x > p.w, 0)
        | bit(p.x + p.w < 0.0, 1)
        | bit(p.y > p.w, 2)
        | bit(p.y + p.w < 0.0, 3)
        | bit(p.z < 0.0, 4)
        | bit(p.z > p.w, 5)
}

/// A corner in clip space, and whether clipping made it.
type Corner = (Vec4, bool);

/// A convex polygon of few corners.
struct Polygon {
    corners: [Corner; MAX_CORNERS],
    len: usize,
}

impl Polygon {
    const EMPTY: Self = Self {
        corners: [(Vec4::ZERO, false); MAX_CORNERS],
        len: 0,
    };

    fn as_slice(&self) -> &[Corner] {
        &self.corners[..self.len]
    }

    /// Rounding may make a sliver cross a plane more than twice: corners beyond the most possible are left out.
    fn push(&mut self, corner: Corner) {
        if let Some(slot) = self.corners.get_mut(self.len) {
            *slot = corner;
            self.len += 1;
        }
    }

    /// The part inside a plane; empty if a distance isn't finite.
    fn clipped(&self, plane: &[f32; 4]) -> Self {
        let mut out = Self::EMPTY;
        let corners = self.as_slice();
        for (i, &a) in corners.iter().enumerate() {
            let b = corners[(i + 1) % corners.len()];
            let (da, db) = (distance(plane, a.0), distance(plane, b.0));
            if !(da.is_finite() && db.is_finite()) {
                return Self::EMPTY;
            }
            if da >= 0.0 {
                out.push(a);
            }
            if (da >= 0.0) != (db >= 0.0) {
                out.push((crossing(a.0, da, b.0, db), true));
            }
        }
        out
    }
}

fn distance(plane: &[f32; 4], p: Vec4) -> f32 {
    p.x * plane[0] + p.y * plane[1] + p.z * plane[2] + p.w * plane[3]
}

/// Where the edge from `a` to `b` crosses the plane, measured from the end that is nearer to it.
fn crossing(a: Vec4, da: f32, b: Vec4, db: f32) -> Vec4 {
    let span = db - da;
    let nearer_b = if db < 0.0 { -db < da } else { -da >= db };
    if nearer_b {
        b + (db / span) * (a - b)
    } else {
        a + (-da / span) * (b - a)
    }
}

/// Clips a triangle to the planes in `mask` (the union of its corners' outcodes) and hands on the window corners of
/// each piece: a fan around the first corner that is left.
pub(crate) fn clip(
    triangle: [Vec4; 3],
    mask: u32,
    viewport: &Viewport,
    mut emit: impl FnMut([Vec3; 3]),
) {
    let mut polygon = Polygon::EMPTY;
    triangle.iter().for_each(|&p| polygon.push((p, false)));
    for (_, plane) in PLANES
        .iter()
        .enumerate()
        .filter(|(i, _)| mask & (1 << i) != 0)
    {
        polygon = polygon.clipped(plane);
    }
    let project = |&(p, made): &Corner| {
        if made {
            viewport.project_clipped(p)
        } else {
            viewport.project(p)
        }
    };
    if let [first, rest @ ..] = polygon.as_slice() {
        for pair in rest.windows(2) {
            emit([project(first), project(&pair[0]), project(&pair[1])]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::UVec2;

    fn pieces(triangle: [Vec4; 3]) -> Vec<[Vec3; 3]> {
        let mut out = Vec::new();
        let mask = triangle.iter().fold(0, |m, &p| m | outcode(p));
        clip(triangle, mask, &Viewport::new(UVec2::splat(100)), |t| {
            out.push(t)
        });
        out
    }

    fn area(t: &[Vec3; 3]) -> f32 {
        (t[1] - t[0]).cross(t[2] - t[0]).z.abs() * 0.5
    }

    #[test]
    fn outcodes_name_their_planes() {
        for (i, p) in [
            (0, [2.0, 0.0, 0.5]),
            (1, [-2.0, 0.0, 0.5]),
            (2, [0.0, 2.0, 0.5]),
        ] {
            assert_eq!(outcode(Vec4::new(p[0], p[1], p[2], 1.0)), 1 << i);
        }
        for (i, p) in [
            (3, [0.0, -2.0, 0.5]),
            (4, [0.0, 0.0, -0.5]),
            (5, [0.0, 0.0, 1.5]),
        ] {
            assert_eq!(outcode(Vec4::new(p[0], p[1], p[2], 1.0)), 1 << i);
        }
        assert_eq!(
            outcode(Vec4::new(1.0, -1.0, 1.0, 1.0)),
            0,
            "the planes themselves are inside"
        );
    }

    #[test]
    fn a_triangle_over_everything_becomes_the_window() {
        let far = |x, y| Vec4::new(x, y, 0.5, 1.0);
        let out = pieces([far(-9.0, -9.0), far(9.0, -9.0), far(0.0, 19.0)]);
        assert!(
            (out.iter().map(area).sum::<f32>() - 10_000.0).abs() < 0.1,
            "{out:?}"
        );
    }

    #[test]
    fn cutting_at_near_keeps_the_part_in_front() {
        // Half of each slanted edge lies before the near plane: three quarters of the area remain.
        let out = pieces([
            Vec4::new(0.0, 0.5, -0.5, 1.0),
            Vec4::new(-0.5, -0.5, 0.5, 1.0),
            Vec4::new(0.5, -0.5, 0.5, 1.0),
        ]);
        assert_eq!(out.len(), 2);
        assert!(
            (out.iter().map(area).sum::<f32>() - 0.75 * 1250.0).abs() < 0.1,
            "{out:?}"
        );
        assert!(out.iter().flatten().all(|p| p.z >= 0.0));
    }

    #[test]
    fn nothing_of_not_a_number_is_drawn() {
        let triangle = [
            Vec4::new(f32::NAN, 0.0, 0.5, 1.0),
            Vec4::new(3.0, 0.0, 0.5, 1.0),
            Vec4::new(0.0, 0.5, 0.5, 1.0),
        ];
        assert!(pieces(triangle).is_empty());
    }
}
