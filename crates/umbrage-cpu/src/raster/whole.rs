//! Depth planes of triangles that get clipped, on devices whose planes go through snapped vertices.
//!
//! There the plane goes through the triangle's own vertices, wherever on the window's plane they lie, not through those that
//! clipping made (measured on SwiftShader; hardware with a guard band makes none at the window's edges).

use super::record::DepthPlane;
use super::viewport::{Viewport, on_grid};
use glam::{DVec3, Vec3, Vec4};
use umbrage_core::{DepthPlanes, Snapping};

/// The depth plane of a triangle before clipping, and the grid that its vertices were moved to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WholePlane {
    snapping: Snapping,
    /// A vertex, and the changes of depth a pixel to the right and down.
    vertex: DVec3,
    dx: f64,
    dy: f64,
}

impl WholePlane {
    /// None where planes go through vertices as they are, whole or clipped, and where this one is upright or has a vertex
    /// that has no place in the window.
    #[cold]
    pub(crate) fn new(triangle: [Vec4; 3], viewport: &Viewport, snapping: Snapping) -> Option<Self> {
        if snapping.planes == DepthPlanes::Unsnapped {
            return None;
        }
        let [a, b, c] = triangle.map(|clip| {
            let v = viewport.project(clip);
            Vec3::new(on_grid(v.x, snapping), on_grid(v.y, snapping), v.z).as_dvec3()
        });
        let normal = (b - a).cross(c - a);
        let (dx, dy) = (-normal.x / normal.z, -normal.y / normal.z);
        (dx.is_finite() && dy.is_finite()).then_some(Self { snapping, vertex: a, dx, dy })
    }

    /// Moves a piece's corners to the grid and into the plane.
    pub(crate) fn place(&self, piece: [Vec3; 3]) -> [Vec3; 3] {
        piece.map(|corner| {
            let (x, y) = (on_grid(corner.x, self.snapping), on_grid(corner.y, self.snapping));
            Vec3::new(x, y, self.at(f64::from(x), f64::from(y)))
        })
    }

    /// The plane as records hold it. Pieces may be too thin to find it from their corners.
    pub(crate) fn depth(&self) -> DepthPlane {
        DepthPlane { at_origin: self.at(0.5, 0.5), dx: self.dx as f32, dy: self.dy as f32, offset: 0.0 }
    }

    fn at(&self, x: f64, y: f64) -> f32 {
        (self.vertex.z + self.dx * (x - self.vertex.x) + self.dy * (y - self.vertex.y)) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::UVec2;

    #[test]
    fn corners_come_to_lie_on_the_plane_of_the_whole() {
        let viewport = Viewport::new(UVec2::splat(64));
        // On the grid, depth grows from 0 by 1/96 a pixel; the right corner comes from 0.4 steps further right.
        let right = 64.0 + 32.0 + 0.4 / 16.0;
        let clip = |x: f32, y: f32, z: f32| Vec4::new(x / 32.0 - 1.0, 1.0 - y / 32.0, z, 1.0);
        let triangle = [clip(0.0, 0.0, 0.0), clip(0.0, 64.0, 0.0), clip(right, 32.0, 1.0)];
        assert!(WholePlane::new(triangle, &viewport, Snapping::default()).is_none());
        let plane = WholePlane::new(triangle, &viewport, Snapping::COARSEST).expect("a plane");
        let placed = plane.place([Vec3::new(48.02, 32.0, 0.9), Vec3::ZERO, Vec3::new(24.0, 0.0, 0.9)]);
        assert_eq!(placed, [Vec3::new(48.0, 32.0, 0.5), Vec3::ZERO, Vec3::new(24.0, 0.0, 0.25)]);
        let depth = plane.depth();
        assert_eq!((depth.at_origin * 192.0, depth.dx * 96.0, depth.dy), (1.0, 1.0, 0.0));
        let upright = [triangle[0], triangle[1], clip(0.0, 32.0, 1.0)];
        assert!(WholePlane::new(upright, &viewport, Snapping::COARSEST).is_none());
        let at_the_eye = [triangle[0], triangle[1], Vec4::new(1.0, 0.0, 1.0, 0.0)];
        assert!(WholePlane::new(at_the_eye, &viewport, Snapping::COARSEST).is_none());
    }
}
