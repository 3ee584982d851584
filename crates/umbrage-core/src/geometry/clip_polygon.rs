//! Clipping of small convex polygons by planes, without allocation: Sutherland and Hodgman 1974,
//! "Reentrant Polygon Clipping".
//!
//! The CPU rasteriser has its own clipper, which must be bit-equal to Mesa's.

use glam::DVec3;

/// A convex polygon of at most `MAX` corners, in order.
#[derive(Clone, Copy, Debug)]
pub struct Polygon<P, const MAX: usize> {
    corners: [P; MAX],
    count: usize,
}

impl<P: Copy + Default, const MAX: usize> Polygon<P, MAX> {
    /// Returns the polygon without corners.
    pub fn empty() -> Self {
        Self {
            corners: [P::default(); MAX],
            count: 0,
        }
    }

    /// Returns a triangle.
    pub fn triangle(corners: [P; 3]) -> Self {
        Self::from_corners(corners)
    }

    /// Returns the polygon with these corners, at most `MAX`.
    pub fn from_corners<const COUNT: usize>(corners: [P; COUNT]) -> Self {
        let mut polygon = Self::empty();
        for corner in corners {
            polygon.push(corner);
        }
        polygon
    }

    /// Returns the corners in order.
    pub fn corners(&self) -> &[P] {
        &self.corners[..self.count]
    }

    /// Returns the polygon with `f` applied to each corner.
    pub fn map(&self, f: impl Fn(P) -> P) -> Self {
        Self {
            corners: self.corners.map(f),
            count: self.count,
        }
    }

    /// Returns the part of the polygon where `signed_distance` is not negative.
    ///
    /// `crossing(p, q, distance_p, distance_q)` returns the corner at which the edge from `p` to
    /// `q` crosses the plane, or `None` if it doesn't. The last two parameters are the signed
    /// distances of its ends. Callers provide `crossing` because they interpolate by different
    /// formulas, with different rounding.
    pub fn clip(
        &self,
        signed_distance: impl Fn(P) -> f64,
        crossing: impl Fn(P, P, f64, f64) -> Option<P>,
    ) -> Self {
        let mut inside = Self::empty();
        for (i, &p) in self.corners().iter().enumerate() {
            let q = self.corners[(i + 1) % self.count];
            let distance_p = signed_distance(p);
            let distance_q = signed_distance(q);
            if distance_p >= 0.0 {
                inside.push(p);
            }
            if let Some(corner) = crossing(p, q, distance_p, distance_q) {
                inside.push(corner);
            }
        }
        inside
    }

    /// Appends a corner. A plane that cuts a convex polygon removes at least one corner and adds
    /// two, so `MAX` must be three plus the number of planes. Where an edge runs along a plane,
    /// rounding may add more crossings. Corners beyond `MAX` are dropped; they are on the outline
    /// anyway.
    fn push(&mut self, corner: P) {
        if let Some(slot) = self.corners.get_mut(self.count) {
            *slot = corner;
            self.count += 1;
        }
    }
}

/// Returns the point at which the edge from `p` to `q` crosses a plane, given the signed distances
/// of both. `None` if both are on one side. An end on the plane counts as inside, so an edge that
/// leaves or enters there has that end as its crossing.
pub fn edge_crossing(p: DVec3, q: DVec3, distance_p: f64, distance_q: f64) -> Option<DVec3> {
    if (distance_p >= 0.0) == (distance_q >= 0.0) {
        return None;
    }
    // The distance is linear along the edge, and 0 at this fraction of it.
    let fraction = distance_p / (distance_p - distance_q);
    Some(p.lerp(q, fraction))
}
