//! Clipping of triangles to the view volume (Sutherland and Hodgman 1974, "Reentrant Polygon
//! Clipping").
//!
//! `umbrage-core` also has a clipper, in 64 bits. This one must stay separate, since it follows
//! Mesa's software rasterisers in 32 bits. It has their order of planes, and interpolates a
//! crossing from the end closer to the plane. It marks the same corners as new, since these are
//! projected by another formula. Clipped edges thus have Mesa's bits, and masks on the CPU equal
//! those of the driver.

use crate::raster::viewport::Viewport;
use glam::{Vec3, Vec4};
use umbrage_core::Cull;

/// Planes x <= w, -w <= x, y <= w, -w <= y, 0 <= z, z <= w. Bit `i` of an outcode denotes plane
/// `i`.
pub(crate) const PLANES: [[f32; 4]; 6] = [
    [-1.0, 0.0, 0.0, 1.0],
    [1.0, 0.0, 0.0, 1.0],
    [0.0, -1.0, 0.0, 1.0],
    [0.0, 1.0, 0.0, 1.0],
    [0.0, 0.0, 1.0, 0.0],
    [0.0, 0.0, -1.0, 1.0],
];

/// Greatest number of corners: a triangle gains at most one corner per plane.
const MAX_CORNERS: usize = 3 + PLANES.len();

/// Returns the set of planes that a vertex (clip space) is outside of, as bits in the order of
/// [`PLANES`].
#[inline(always)]
pub(crate) fn outcode(p: Vec4) -> u32 {
    u32::from(p.x > p.w)
        | u32::from(p.x + p.w < 0.0) << 1
        | u32::from(p.y > p.w) << 2
        | u32::from(p.y + p.w < 0.0) << 3
        | u32::from(p.z < 0.0) << 4
        | u32::from(p.z > p.w) << 5
}

/// Corner of a polygon.
#[derive(Clone, Copy)]
pub(crate) struct Corner {
    /// Position in clip space.
    pub(crate) position: Vec4,
    /// True if clipping created it.
    is_new: bool,
}

impl Corner {
    /// Returns a vertex of the triangle.
    pub(crate) fn from_position(position: Vec4) -> Self {
        Self {
            position,
            is_new: false,
        }
    }

    /// Returns a corner created by clipping.
    pub(crate) fn new(position: Vec4) -> Self {
        Self {
            position,
            is_new: true,
        }
    }
}

/// Convex polygon of few corners.
pub(crate) struct Polygon {
    corners: [Corner; MAX_CORNERS],
    len: usize,
}

impl Polygon {
    pub(crate) const EMPTY: Self = Self {
        corners: [Corner {
            position: Vec4::ZERO,
            is_new: false,
        }; MAX_CORNERS],
        len: 0,
    };

    /// Returns a triangle (clip space).
    pub(crate) fn new(triangle: [Vec4; 3]) -> Self {
        let mut polygon = Self::EMPTY;
        for position in triangle {
            polygon.push(Corner::from_position(position));
        }
        polygon
    }

    /// Returns the number of corners.
    pub(crate) fn len(&self) -> usize {
        self.len
    }

    /// Makes the corner with this index the first one.
    pub(crate) fn rotate_left(&mut self, corner: usize) {
        self.corners[..self.len].rotate_left(corner);
    }

    fn as_slice(&self) -> &[Corner] {
        &self.corners[..self.len]
    }

    /// Calls `visit` with the corners of each triangle of a fan around the first corner.
    pub(crate) fn for_each_triangle(&self, mut visit: impl FnMut([&Corner; 3])) {
        if let [first, rest @ ..] = self.as_slice() {
            for pair in rest.windows(2) {
                visit([first, &pair[0], &pair[1]]);
            }
        }
    }

    /// Appends a corner. Rounding may make a sliver cross a plane more than twice; corners beyond
    /// `MAX_CORNERS` are dropped.
    pub(crate) fn push(&mut self, corner: Corner) {
        if let Some(slot) = self.corners.get_mut(self.len) {
            *slot = corner;
            self.len += 1;
        }
    }

    /// Returns the part inside a plane, or an empty polygon if a distance isn't finite.
    pub(crate) fn clip_by_plane(&self, plane: &[f32; 4]) -> Self {
        let mut out = Self::EMPTY;
        let corners = self.as_slice();
        for (i, &a) in corners.iter().enumerate() {
            let b = corners[(i + 1) % corners.len()];
            let distance_a = signed_distance(plane, a.position);
            let distance_b = signed_distance(plane, b.position);
            if !(distance_a.is_finite() && distance_b.is_finite()) {
                return Self::EMPTY;
            }
            if distance_a >= 0.0 {
                out.push(a);
            }
            if (distance_a >= 0.0) != (distance_b >= 0.0) {
                let position = crossing_point(a.position, distance_a, b.position, distance_b);
                out.push(Corner::new(position));
            }
        }
        out
    }
}

fn signed_distance(plane: &[f32; 4], p: Vec4) -> f32 {
    p.x * plane[0] + p.y * plane[1] + p.z * plane[2] + p.w * plane[3]
}

/// Returns the intersection of the edge from `a` to `b` with a plane, interpolated from the end
/// closer to it. `distance_a` and `distance_b` are the signed distances of the ends, of different
/// signs.
fn crossing_point(a: Vec4, distance_a: f32, b: Vec4, distance_b: f32) -> Vec4 {
    let span = distance_b - distance_a;
    let b_is_nearer = if distance_b < 0.0 {
        -distance_b < distance_a
    } else {
        -distance_a >= distance_b
    };
    if b_is_nearer {
        b + (distance_b / span) * (a - b)
    } else {
        a + (-distance_a / span) * (b - a)
    }
}

/// Clips a triangle (clip space) to the planes in `mask`, the union of its corners' outcodes. Calls
/// `emit` with the window corners of each resulting triangle.
pub(crate) fn clip(
    triangle: [Vec4; 3],
    mask: u32,
    viewport: &Viewport,
    mut emit: impl FnMut([Vec3; 3]),
) {
    let mut polygon = Polygon::new(triangle);
    for (i, plane) in PLANES.iter().enumerate() {
        if mask & (1 << i) != 0 {
            polygon = polygon.clip_by_plane(plane);
        }
    }
    polygon.for_each_triangle(|corners| emit(corners.map(|corner| project(corner, viewport))));
}

/// Returns whether culling removes a piece of a clipped triangle before its corners (window space)
/// are moved to the grid.
///
/// Mesa's software drivers determine a piece's orientation twice: after clipping, and again on the
/// grid. Both must be faces that are kept. The two differ for pieces thinner than a step of the
/// grid, such as those of a wall that a vertical sun sees edge-on. Without an area, a piece is a
/// back face. (Measured; the first test is Mesa's `draw_pipe_cull.c`.)
pub(crate) fn is_culled(piece: [Vec3; 3], cull: Cull) -> bool {
    let [a, b, c] = piece;
    let from_c_to_a = a - c;
    let from_c_to_b = b - c;
    // Window y points down.
    let turn = from_c_to_a.x * from_c_to_b.y - from_c_to_a.y * from_c_to_b.x;
    let is_front = turn < 0.0;
    match cull {
        Cull::None => false,
        Cull::Front => is_front,
        Cull::Back => !is_front,
    }
}

/// Returns the window position of a corner.
pub(crate) fn project(corner: &Corner, viewport: &Viewport) -> Vec3 {
    if corner.is_new {
        viewport.project_clipped(corner.position)
    } else {
        viewport.project(corner.position)
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
        // Half of each slanted edge is in front of the near plane: three quarters of the area
        // remain.
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
