//! Alpha test of triangles: rejected pixels count as outside the triangle.

use crate::raster::tile::LANES;
use umbrage_core::{CameraRays, CutOuts, Geometry};

/// Inputs of the alpha test. Triangle ids are those of the geometry.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Holes<'a> {
    /// Alpha-test data.
    pub(crate) cut_outs: &'a CutOuts,
    /// Triangles.
    pub(crate) geometry: &'a Geometry,
    /// Rays through the image's pixels.
    pub(crate) rays: &'a CameraRays,
}

impl Holes<'_> {
    /// Returns whether the alpha test of a triangle's material rejects the ray through a pixel's
    /// centre.
    pub(crate) fn is_hole(&self, triangle: u32, x: u32, y: u32) -> bool {
        let corners = self.geometry.corners(triangle);
        self.cut_outs
            .is_hole_at_pixel(triangle, corners, self.rays, x, y)
    }
}

/// Alpha test of a fill. A separate type for opaque triangles keeps the test out of their loops.
pub(crate) trait HoleTest {
    /// True if pixels may be rejected.
    const HAS_HOLES: bool;

    /// Rejects the pixels of a row that fail the alpha test, by setting their depth `z` to 1. Skips
    /// pixels that are not closer than `stored`, since no mode with ids keeps farther depths.
    fn take_holes(
        &self,
        triangle: u32,
        first: [i32; 2],
        z: &mut [f32; LANES],
        stored: &[f32; LANES],
    );
}

/// Alpha test that rejects nothing.
pub(crate) struct NoHoles;

impl HoleTest for NoHoles {
    const HAS_HOLES: bool = false;

    #[inline(always)]
    fn take_holes(&self, _: u32, _: [i32; 2], _: &mut [f32; LANES], _: &[f32; LANES]) {}
}

impl HoleTest for Holes<'_> {
    const HAS_HOLES: bool = true;

    fn take_holes(
        &self,
        triangle: u32,
        first: [i32; 2],
        z: &mut [f32; LANES],
        stored: &[f32; LANES],
    ) {
        for i in 0..LANES {
            // Triangles at equal depth change ids. A depth of 1 is never kept, since it is the
            // value of a clear image.
            let may_be_kept = z[i] <= stored[i] && z[i] < 1.0;
            if may_be_kept && self.is_hole(triangle, first[0] as u32 + i as u32, first[1] as u32) {
                z[i] = 1.0;
            }
        }
    }
}
