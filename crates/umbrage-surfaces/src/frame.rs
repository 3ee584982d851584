//! Coordinates along the light.

use glam::{DVec2, DVec3};

/// Right-handed axes with the third one towards the sun.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    pub(crate) x: DVec3,
    pub(crate) y: DVec3,
    pub(crate) sun: DVec3,
}

impl Frame {
    /// Returns a frame for a unit vector towards the sun: Duff et al. 2017, "Building an
    /// Orthonormal Basis, Revisited".
    pub(crate) fn new(sun: DVec3) -> Self {
        let sign = 1.0_f64.copysign(sun.z);
        let a = -1.0 / (sign + sun.z);
        let b = sun.x * sun.y * a;
        Self {
            x: DVec3::new(1.0 + sign * sun.x * sun.x * a, sign * b, -sign * sun.x),
            y: DVec3::new(b, sign + sun.y * sun.y * a, -sun.y),
            sun,
        }
    }

    /// Returns a position as (x, y, height towards the sun).
    #[inline(always)]
    pub(crate) fn project(&self, p: DVec3) -> DVec3 {
        DVec3::new(self.x.dot(p), self.y.dot(p), self.sun.dot(p))
    }

    /// Returns the position with these coordinates.
    #[inline(always)]
    pub(crate) fn unproject(&self, p: DVec3) -> DVec3 {
        self.x * p.x + self.y * p.y + self.sun * p.z
    }

    /// Returns a position's coordinates across the light.
    #[inline(always)]
    pub(crate) fn across(&self, p: DVec3) -> DVec2 {
        DVec2::new(self.x.dot(p), self.y.dot(p))
    }
}

/// Returns the z component of the cross product.
#[inline(always)]
pub(crate) fn cross(a: DVec2, b: DVec2) -> f64 {
    a.x * b.y - a.y * b.x
}
