//! Small convex polygons, clipped without allocating.

use glam::DVec3;

/// A triangle loses at most one corner and gains at most two at each of five planes.
const MOST: usize = 8;

/// A convex polygon of up to eight corners.
#[derive(Clone, Copy, Debug)]
pub(super) struct Polygon {
    corners: [DVec3; MOST],
    count: usize,
}

impl Polygon {
    pub(super) fn triangle([a, b, c]: [DVec3; 3]) -> Self {
        let mut corners = [DVec3::ZERO; MOST];
        corners[..3].copy_from_slice(&[a, b, c]);
        Self { corners, count: 3 }
    }

    pub(super) fn corners(&self) -> &[DVec3] {
        &self.corners[..self.count]
    }

    /// The same shape, corner by corner.
    pub(super) fn map(&self, f: impl Fn(DVec3) -> DVec3) -> Self {
        Self {
            corners: self.corners.map(f),
            count: self.count,
        }
    }

    /// What is left where `normal . p >= distance`: Sutherland and Hodgman 1974, "Reentrant Polygon Clipping".
    pub(super) fn clip(&self, normal: DVec3, distance: f64) -> Self {
        let mut out = Self {
            corners: [DVec3::ZERO; MOST],
            count: 0,
        };
        for (i, &p) in self.corners().iter().enumerate() {
            let q = self.corners[(i + 1) % self.count];
            let (at_p, at_q) = (normal.dot(p) - distance, normal.dot(q) - distance);
            if at_p >= 0.0 {
                out.push(p);
            }
            if (at_p >= 0.0) != (at_q >= 0.0) {
                out.push(p.lerp(q, at_p / (at_p - at_q)));
            }
        }
        out
    }

    fn push(&mut self, p: DVec3) {
        // Rounding may give a corner too many where a side runs along the plane: it lies on the outline anyway.
        if self.count < MOST {
            self.corners[self.count] = p;
            self.count += 1;
        }
    }
}
