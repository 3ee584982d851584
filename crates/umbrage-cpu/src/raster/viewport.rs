//! Transforms from clip space to the window, and from there to the grid of 1/256 pixels that
//! decides coverage.

use glam::{UVec2, Vec3, Vec4};
use umbrage_core::Snapping;

/// Sub-pixel steps per pixel.
pub(crate) const SUBPIXELS: i32 = 256;

/// Map from clip x and y to window x and y: pixels from the top left corner, centres at .5. Depth
/// is unchanged.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Viewport {
    scale_x: f32,
    offset_x: f32,
    scale_y: f32,
    offset_y: f32,
}

impl Viewport {
    /// Returns the viewport that covers a whole image.
    pub(crate) fn new(size: UVec2) -> Self {
        let (x, y) = (0.5 * size.x as f32, 0.5 * size.y as f32);
        Self {
            scale_x: x,
            offset_x: x,
            scale_y: -y,
            offset_y: y,
        }
    }

    /// Returns the window position of a vertex, with the fused multiplication of the drivers'
    /// vertex stage.
    #[inline(always)]
    pub(crate) fn project(&self, clip: Vec4) -> Vec3 {
        let r = 1.0 / clip.w;
        let x = (clip.x * r).mul_add(self.scale_x, self.offset_x);
        let y = (clip.y * r).mul_add(self.scale_y, self.offset_y);
        Vec3::new(x, y, clip.z * r)
    }

    /// Returns the window position of a vertex created by clipping. This (rare) stage fuses
    /// nothing.
    pub(crate) fn project_clipped(&self, clip: Vec4) -> Vec3 {
        let r = 1.0 / clip.w;
        Vec3::new(
            clip.x * r * self.scale_x + self.offset_x,
            clip.y * r * self.scale_y + self.offset_y,
            clip.z * r,
        )
    }
}

/// Largest snapped coordinate: the right edge of the widest image. Only faulty vertices that
/// clipping created from nearly equal numbers exceed it. Clamping them keeps later integers within
/// 32 bits.
const SNAP_LIMIT: f32 = (umbrage_core::MAX_SIDE as i32 * SUBPIXELS) as f32;

/// Snaps a window coordinate to the sub-pixel grid, ties to even. Pixel centres become multiples of
/// 256.
#[inline(always)]
pub(crate) fn snap(v: f32) -> i32 {
    // Adding 1.5 * 2^23 leaves an integer in the low bits, rounded by the processor: to nearest,
    // ties to even.
    const MAGIC: f32 = 12_582_912.0;
    let v = (v - 0.5) * SUBPIXELS as f32;
    let v = if v < SNAP_LIMIT { v } else { SNAP_LIMIT };
    let v = if v > -SNAP_LIMIT { v } else { -SNAP_LIMIT };
    (v + MAGIC).to_bits().wrapping_sub(MAGIC.to_bits()) as i32
}

/// Moves a window coordinate to a grid, ties to even. Pixel centres are points of all grids. The
/// result is exact for all coordinates within an image: it needs 15 bits before the point and 8
/// after it.
pub(crate) fn on_grid(v: f32, snapping: Snapping) -> f32 {
    let steps = (1_u32 << snapping.sub_pixel_bits) as f32;
    ((v - 0.5) * steps).round_ties_even() / steps + 0.5
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage_core::DepthPlanes;

    #[test]
    fn every_grid_lies_on_the_finest() {
        for sub_pixel_bits in Snapping::BITS {
            let grid = Snapping {
                sub_pixel_bits,
                planes: DepthPlanes::Snapped,
                ..Snapping::default()
            };
            for i in 0..4860 {
                // Test from the left edge of an image to the right edge of the widest.
                let v = i as f32 * 3.37;
                let moved = on_grid(v, grid);
                assert!((moved - v).abs() <= 0.5 * grid.step(), "{v}: {moved}");
                assert_eq!(
                    snap(moved) as f32 / 256.0,
                    moved - 0.5,
                    "{v}: not on the finest grid"
                );
                assert_eq!(
                    snap(moved) % (256 >> sub_pixel_bits),
                    0,
                    "{v}: not on its own grid"
                );
            }
        }
    }

    #[test]
    fn snapping_rounds_ties_to_even() {
        for i in -5000..5000 {
            let v = i as f32 * 0.37 + 0.5;
            assert_eq!(snap(v), ((v - 0.5) * 256.0).round_ties_even() as i32, "{v}");
            let tie = i as f32 / 512.0 + 0.5;
            assert_eq!(
                snap(tie),
                ((tie - 0.5) * 256.0).round_ties_even() as i32,
                "{tie}"
            );
        }
    }

    #[test]
    fn snapping_never_leaves_the_limit() {
        for v in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30, -1e30] {
            assert!(snap(v).abs() <= 1 << 22, "{v}");
        }
    }

    #[test]
    fn corners_of_clip_space_are_corners_of_the_window() {
        let viewport = Viewport::new(UVec2::new(300, 200));
        assert_eq!(
            viewport.project(Vec4::new(-2.0, 2.0, 1.0, 2.0)),
            Vec3::new(0.0, 0.0, 0.5)
        );
        assert_eq!(
            viewport.project_clipped(Vec4::new(1.0, -1.0, 1.0, 1.0)),
            Vec3::new(300.0, 200.0, 1.0)
        );
    }
}
