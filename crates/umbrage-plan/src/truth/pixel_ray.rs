//! Camera rays through pixels, in 64 bits.

use glam::{DVec2, DVec3, Vec4};
use umbrage_core::CameraRays;

/// Camera ray through a pixel.
#[derive(Clone, Copy)]
pub(super) struct PixelRay {
    pub(super) origin: DVec3,
    pub(super) direction: DVec3,
}

impl PixelRay {
    /// Returns the ray through a pixel's centre, moved by some pixels.
    pub(super) fn new(rays: &CameraRays, pixel: [u32; 2], by: DVec2) -> Self {
        let x = f64::from(pixel[0]) + 0.5 + by.x;
        let y = f64::from(pixel[1]) + 0.5 + by.y;
        Self {
            origin: linear(rays.origin, rays.origin_dx, rays.origin_dy, x, y),
            direction: linear(rays.dir, rays.dir_dx, rays.dir_dy, x, y),
        }
    }

    /// Returns the intersection with the plane of a triangle; `None` if they are parallel.
    pub(super) fn on_plane(&self, corners: [DVec3; 3]) -> Option<DVec3> {
        let normal = (corners[1] - corners[0])
            .cross(corners[2] - corners[0])
            .try_normalize()?;
        let t = normal.dot(corners[0] - self.origin) / normal.dot(self.direction);
        let p = self.origin + self.direction * t;
        p.is_finite().then_some(p)
    }
}

/// Returns `base + dx * x + dy * y` in 64 bits.
fn linear(base: Vec4, dx: Vec4, dy: Vec4, x: f64, y: f64) -> DVec3 {
    (base.as_dvec4() + dx.as_dvec4() * x + dy.as_dvec4() * y).truncate()
}
