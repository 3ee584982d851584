//! Triangles that get clipped, on devices whose depth planes go through snapped vertices.
//!
//! There the plane goes through the triangle's own vertices, wherever on the window's plane they
//! lie, not through those that clipping made (measured on SwiftShader; hardware with a guard band
//! makes none at the window's edges). They also tell which way the triangle turns: pieces that turn
//! the other way once they are on the grid aren't drawn.

use crate::raster::{
    Rounding,
    plane_error::{PlaneShift, plane_error},
    record::DepthPlane,
    viewport::{Viewport, on_grid},
};
use glam::{DVec3, Vec3, Vec4};
use umbrage_core::{DepthPlanes, Snapping};

/// A triangle before clipping, its vertices moved to the grid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Whole {
    snapping: Snapping,
    /// A vertex, and the changes of depth a pixel to the right and down.
    vertex: DVec3,
    dx: f64,
    dy: f64,
    /// Its sign tells how pieces turn on the window; 0: the triangle has no area on the grid.
    turn: f64,
    /// Whether pieces of a triangle without area on the grid are drawn. They may cover pixels all
    /// the same, where the triangle reaches behind the eye, and what depth they get is left to
    /// devices: SwiftShader divides by zero, others may draw nothing.
    draws_without_area: bool,
    /// The greatest magnitude of the vertices' depths, which may be far beyond 1.
    greatest_depth: f64,
    /// By how much devices may differ in its depths.
    error: f32,
}

impl Whole {
    /// None where planes go through vertices as they are, whole or clipped, and where a vertex has
    /// no place in the window.
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
        let mut whole = Self::through(triangle.map(|clip| viewport.project(clip)), rounding)?;
        // What lies behind the eye is seen upside down and turned round.
        for vertex in triangle {
            if vertex.w < 0.0 {
                whole.turn = -whole.turn;
            }
        }
        Some(whole)
    }

    /// Returns a triangle in front of the eye, given by its corners (window space). `None` if one
    /// of them isn't finite.
    pub(crate) fn through(corners: [Vec3; 3], rounding: Rounding) -> Option<Self> {
        let snapping = rounding.snapping;
        let on_grid = corners.map(|corner| snapped(corner, snapping).as_dvec3());
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

    /// Moves a piece's corners to the grid and into the plane; none if the piece isn't drawn.
    pub(crate) fn place(&self, piece: [Vec3; 3]) -> Option<[Vec3; 3]> {
        let [a, b, c] = piece.map(|corner| snapped(corner, self.snapping).as_dvec3());
        let area = (b - a).cross(c - a).z;
        let placed = [a, b, c].map(|corner| {
            Vec3::new(
                corner.x as f32,
                corner.y as f32,
                self.at(corner.x, corner.y),
            )
        });
        let turns_alike = area * self.turn > 0.0;
        let may_be_drawn = !self.has_area() && self.draws_without_area;
        (turns_alike || may_be_drawn).then_some(placed)
    }

    /// Whether the triangle has an area on the grid. If not, devices may take it for either face
    /// (SwiftShader draws it whatever is culled).
    pub(crate) fn has_area(&self) -> bool {
        self.turn != 0.0
    }

    /// The plane as records hold it. Pieces may be too thin to find it from their corners.
    pub(crate) fn depth(&self) -> DepthPlane {
        DepthPlane {
            at_origin: self.at(0.5, 0.5),
            dx: self.dx as f32,
            dy: self.dy as f32,
            offset: 0.0,
        }
    }

    /// The greatest magnitude of the depths of the triangle's own vertices: the spacing of floats
    /// there is the unit of polygon offset on such devices (measured on SwiftShader; Vulkan doesn't
    /// say whether the primitive is meant clipped or whole).
    pub(crate) fn greatest_depth(&self) -> f32 {
        self.greatest_depth as f32
    }

    /// By how much devices may differ in its depths.
    pub(crate) fn error(&self) -> f32 {
        self.error
    }

    fn at(&self, x: f64, y: f64) -> f32 {
        (self.vertex.z + self.dx * (x - self.vertex.x) + self.dy * (y - self.vertex.y)) as f32
    }
}

fn normal(corners: [DVec3; 3]) -> DVec3 {
    let [a, b, c] = corners;
    (b - a).cross(c - a)
}

fn snapped(v: Vec3, snapping: Snapping) -> Vec3 {
    Vec3::new(on_grid(v.x, snapping), on_grid(v.y, snapping), v.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::UVec2;

    /// A point of a window of 64 x 64 pixels.
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
        // On the grid, depth grows from 0 by 1/96 a pixel; the right corner comes from 0.4 steps
        // further right.
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
