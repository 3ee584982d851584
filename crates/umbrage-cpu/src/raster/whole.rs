//! Clipped triangles, on devices whose depth planes go through snapped vertices.
//!
//! On such devices, the plane goes through the triangle's own vertices, at any distance from the
//! window, not through those created by clipping. (Measured on SwiftShader; hardware with a guard
//! band creates none at the window's edges.) The vertices also define the orientation of the
//! triangle. Pieces with the other orientation on the grid aren't drawn.

use crate::raster::{
    Rounding,
    plane_error::{PlaneShift, plane_error},
    record::DepthPlane,
    viewport::{Viewport, on_grid},
};
use glam::{DVec3, Vec3, Vec4};
use umbrage_core::{DepthPlanes, Snapping};

/// Triangle before clipping, with its vertices moved to the grid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Whole {
    snapping: Snapping,
    /// Vertex; the fields below are the changes of depth per pixel to the right and down.
    vertex: DVec3,
    dx: f64,
    dy: f64,
    /// Orientation of pieces on the window, by sign; 0 if the triangle has no area on the grid.
    turn: f64,
    /// True if pieces of a triangle without area on the grid are drawn. They may still cover pixels
    /// if the triangle extends behind the eye, and their depth depends on the device: SwiftShader
    /// divides by zero, others may draw nothing.
    draws_without_area: bool,
    /// Greatest magnitude of the vertices' depths, which may be far above 1.
    greatest_depth: f64,
    /// Greatest difference between devices in its depths.
    error: f32,
}

impl Whole {
    /// Returns `None` if planes go through the vertices as they are, whole or clipped, or if a
    /// vertex has no position in the window.
    #[cold]
    pub(crate) fn new(
        triangle: [Vec4; 3],
        viewport: &Viewport,
        rounding: Rounding,
    ) -> Option<Self> {
        let snapping = rounding.snapping;
        if snapping.planes == DepthPlanes::Unsnapped {
            return None;
        }
        let mut whole =
            Self::through_corners(triangle.map(|clip| viewport.project(clip)), rounding)?;
        // Geometry behind the eye appears upside down and reversed.
        for vertex in triangle {
            if vertex.w < 0.0 {
                whole.turn = -whole.turn;
            }
        }
        Some(whole)
    }

    /// Returns a triangle in front of the eye, given by its corners (window space). Returns `None`
    /// if one of them isn't finite.
    pub(crate) fn through_corners(corners: [Vec3; 3], rounding: Rounding) -> Option<Self> {
        let snapping = rounding.snapping;
        let on_grid = corners.map(|corner| snap_corner(corner, snapping).as_dvec3());
        let [a, b, c] = match snapping.planes {
            DepthPlanes::Unsnapped => corners.map(Vec3::as_dvec3),
            DepthPlanes::Snapped => on_grid,
        };
        let normal = normal([a, b, c]);
        let (dx, dy) = if normal.z == 0.0 {
            (0.0, 0.0)
        } else {
            (-normal.x / normal.z, -normal.y / normal.z)
        };
        let whole = Self {
            snapping,
            vertex: a,
            dx,
            dy,
            turn: self::normal(on_grid).z,
            draws_without_area: rounding.plane_shift != PlaneShift::NONE,
            error: plane_error([a, b, c]),
            greatest_depth: a.z.abs().max(b.z.abs()).max(c.z.abs()),
        };
        normal.is_finite().then_some(whole)
    }

    /// Moves a piece's corners to the grid and into the plane. Returns `None` if the piece isn't
    /// drawn.
    pub(crate) fn place(&self, piece: [Vec3; 3]) -> Option<[Vec3; 3]> {
        let [a, b, c] = piece.map(|corner| snap_corner(corner, self.snapping).as_dvec3());
        let area = (b - a).cross(c - a).z;
        let placed = [a, b, c].map(|corner| {
            Vec3::new(
                corner.x as f32,
                corner.y as f32,
                self.depth_at(corner.x, corner.y),
            )
        });
        let turns_alike = area * self.turn > 0.0;
        let may_be_drawn = !self.has_area() && self.draws_without_area;
        (turns_alike || may_be_drawn).then_some(placed)
    }

    /// Returns whether the triangle has an area on the grid. If not, devices may treat it as either
    /// face (SwiftShader draws it with any culling).
    pub(crate) fn has_area(&self) -> bool {
        self.turn != 0.0
    }

    /// Returns the plane in the form of records. Pieces may be too thin to compute it from their
    /// corners.
    pub(crate) fn depth(&self) -> DepthPlane {
        DepthPlane {
            at_origin: self.depth_at(0.5, 0.5),
            dx: self.dx as f32,
            dy: self.dy as f32,
            offset: 0.0,
        }
    }

    /// Returns the greatest magnitude of the depths of the triangle's own vertices. The spacing of
    /// floats there is the unit of polygon offset on such devices. (Measured on SwiftShader; Vulkan
    /// doesn't specify whether the primitive is clipped or whole.)
    pub(crate) fn greatest_depth(&self) -> f32 {
        self.greatest_depth as f32
    }

    /// Returns the greatest difference between devices in its depths.
    pub(crate) fn error(&self) -> f32 {
        self.error
    }

    fn depth_at(&self, x: f64, y: f64) -> f32 {
        (self.vertex.z + self.dx * (x - self.vertex.x) + self.dy * (y - self.vertex.y)) as f32
    }
}

fn normal(corners: [DVec3; 3]) -> DVec3 {
    let [a, b, c] = corners;
    (b - a).cross(c - a)
}

fn snap_corner(v: Vec3, snapping: Snapping) -> Vec3 {
    Vec3::new(on_grid(v.x, snapping), on_grid(v.y, snapping), v.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::UVec2;

    /// Returns a point of a window of 64 x 64 pixels.
    fn clip(x: f32, y: f32, z: f32) -> Vec4 {
        Vec4::new(x / 32.0 - 1.0, 1.0 - y / 32.0, z, 1.0)
    }

    fn rounding(snapping: Snapping) -> Rounding {
        Rounding {
            snapping,
            ..Rounding::default()
        }
    }

    fn whole(triangle: [Vec4; 3]) -> Option<Whole> {
        Whole::new(
            triangle,
            &Viewport::new(UVec2::splat(64)),
            rounding(Snapping::COARSEST),
        )
    }

    #[test]
    fn corners_come_to_lie_on_the_plane_of_the_whole() {
        // On the grid, depth grows from 0 by 1/96 per pixel. The right corner was 0.4 steps farther
        // right.
        let right = 64.0 + 32.0 + 0.4 / 16.0;
        let triangle = [
            clip(0.0, 0.0, 0.0),
            clip(0.0, 64.0, 0.0),
            clip(right, 32.0, 1.0),
        ];
        assert!(
            Whole::new(
                triangle,
                &Viewport::new(UVec2::splat(64)),
                rounding(Snapping::default())
            )
            .is_none()
        );
        let plane = whole(triangle).expect("all vertices have a place");
        let piece = [
            Vec3::ZERO,
            Vec3::new(24.0, 0.0, 0.9),
            Vec3::new(48.02, 32.0, 0.9),
        ];
        let [a, b, c] = piece;
        assert_eq!(
            plane.place([a, c, b]),
            Some([a, Vec3::new(48.0, 32.0, 0.5), Vec3::new(24.0, 0.0, 0.25)])
        );
        assert_eq!(plane.place(piece), None, "it turns the other way");
        let depth = plane.depth();
        assert_eq!(
            (depth.at_origin * 192.0, depth.dx * 96.0, depth.dy),
            (1.0, 1.0, 0.0)
        );
        let at_the_eye = [triangle[0], triangle[1], Vec4::new(1.0, 0.0, 1.0, 0.0)];
        assert!(whole(at_the_eye).is_none());
    }

    #[test]
    fn what_has_no_area_on_the_grid_is_not_drawn() {
        let sliver = [
            clip(0.0, 0.0, 0.0),
            clip(0.01, 0.01, 0.0),
            clip(96.0, 80.0, 1.0),
        ];
        let piece = [
            Vec3::ZERO,
            Vec3::new(64.0, 53.0, 0.0),
            Vec3::new(64.0, 54.0, 0.0),
        ];
        let [a, b, c] = piece;
        for piece in [piece, [a, c, b]] {
            assert_eq!(
                whole(sliver)
                    .expect("all vertices have a place")
                    .place(piece),
                None
            );
        }
    }
}
