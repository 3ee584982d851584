//! Holes of triangles, cut out by alpha textures: pixels in them are as if outside the triangle.

use crate::raster::tile::LANES;
use umbrage_core::{CameraRays, CutOuts, Geometry};

/// What tells which pixels of which triangles are holes. Triangles are those of the geometry, under
/// its ids.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Holes<'a> {
    /// The holes.
    pub(crate) cut_outs: &'a CutOuts,
    /// The triangles.
    pub(crate) geometry: &'a Geometry,
    /// The rays through the image's pixels.
    pub(crate) rays: &'a CameraRays,
}

impl Holes<'_> {
    /// Returns whether the ray through a pixel's centre meets a hole of a triangle's, by the rule
    /// of its material.
    pub(crate) fn is_hole(&self, triangle: u32, x: u32, y: u32) -> bool {
        let corners = self.geometry.corners(triangle);
        self.cut_outs
            .is_hole_at_pixel(triangle, corners, self.rays, x, y)
    }
}

/// What a fill does about holes. One type for triangles that have none, so that their loops have no
/// trace of it.
pub(crate) trait HoleTest {
    /// Whether there may be holes.
    const HAS_HOLES: bool;

    /// Takes the pixels of a row that lie in holes out of it: their depth `z` becomes 1. Pixels
    /// that are not nearer than `stored` aren't asked, as none of the modes that know ids keeps
    /// what is farther.
    fn take_holes(
        &self,
        triangle: u32,
        first: [i32; 2],
        z: &mut [f32; LANES],
        stored: &[f32; LANES],
    );
}

/// No triangle has holes.
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
            // Equally near triangles change ids. A depth of 1 is never kept: it is what a clear
            // image holds.
            let may_be_kept = z[i] <= stored[i] && z[i] < 1.0;
            if may_be_kept && self.is_hole(triangle, first[0] as u32 + i as u32, first[1] as u32) {
                z[i] = 1.0;
            }
        }
    }
}
