//! Models of hardware clipping that differs from the planes of the view volume, for testing
//! techniques.
//!
//! Software drivers clip at all six planes. Hardware clips at the near plane first, and at the
//! sides only at a guard band far outside the image. Corners created by the near plane keep their
//! clip w, which is 0 if both ends of their edge are infinitely far away.

use crate::raster::{
    clip::{Corner, PLANES, Polygon, project},
    viewport::Viewport,
};
use glam::{UVec2, Vec3, Vec4};

/// Clipping of triangles in the rasteriser.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Clipping {
    /// Clips at the six planes of the view volume, as Mesa's software drivers do.
    #[default]
    Exact,
    /// Clips at the near and the far plane, and at the sides at a guard band of 8192 pixels around
    /// the image. All variants below do the same.
    GuardBand,
    /// Also rounds half of the vertices on the far plane to beyond it.
    FarRounding,
    /// Also drops triangles that have a corner near clip w = 0 after clipping at the near plane.
    ZeroWDropped,
    /// Also moves triangles with such a corner, if rounding made its w positive, behind all others.
    /// An NVIDIA H200 does so.
    ZeroWBehind,
}

/// Distance of the guard band from the image, pixels. Hardware has two to four times as much. Here,
/// window coordinates on the finest grid must fit the rasteriser's integers.
const GUARD_BAND: f32 = 8192.0;

/// Share of a corner's clip x or y below which its clip w counts as nearly 0: it is outside of any
/// guard band.
const NEARLY_ZERO_W: f32 = 1e-5;

impl Clipping {
    /// All variants except the exact one.
    pub const INEXACT: [Self; 4] = [
        Self::GuardBand,
        Self::FarRounding,
        Self::ZeroWDropped,
        Self::ZeroWBehind,
    ];

    /// Clips a triangle (clip space) for an image of this size. Calls `emit` with the window
    /// corners of each resulting triangle.
    #[cold]
    pub(crate) fn clip(
        self,
        corners: [Vec4; 3],
        size: UVec2,
        viewport: &Viewport,
        mut emit: impl FnMut([Vec3; 3]),
    ) {
        let corners = corners.map(|corner| self.round_clip(corner));
        let guard_band = guard_band(size);
        clip_at_near(corners).for_each_triangle(|piece| {
            let piece = piece.map(|corner| corner.position);
            if self == Self::ZeroWDropped && piece.iter().any(has_nearly_zero_w) {
                return;
            }
            let is_lost = |corner: &Vec4| has_nearly_zero_w(corner) && corner.w > 0.0;
            let is_behind_all = self == Self::ZeroWBehind && piece.iter().any(is_lost);
            let mut polygon = Polygon::new(piece).clip_by_plane(&FAR);
            for plane in &guard_band {
                polygon = polygon.clip_by_plane(plane);
            }
            polygon.for_each_triangle(|corners| {
                let mut window = corners.map(|corner| project(corner, viewport));
                if is_behind_all {
                    window = window.map(|corner| corner.with_z(1.0));
                }
                emit(window);
            });
        });
    }

    /// Returns a vertex (clip space) as this variant rounds it.
    fn round_clip(self, mut clip: Vec4) -> Vec4 {
        // Use any bit that neighbours don't share to select the half that is rounded.
        let is_odd = (clip.x.to_bits() ^ clip.y.to_bits()) & 1 == 1;
        if self == Self::FarRounding && is_odd && clip.z == clip.w {
            clip.z = clip.z.next_up();
        }
        clip
    }
}

/// Far plane.
const FAR: [f32; 4] = PLANES[5];

/// Returns the part of a triangle (clip space) behind the near plane, a fan around the first corner
/// created by clipping.
///
/// A crossing is computed from the end in front of the plane, so that neighbours agree, in one
/// fused operation. With these roundings, exactly those corners of `bar-at-lamp` and `two-blockers`
/// get clip w > 0 whose faces are wrong on an H200.
fn clip_at_near(triangle: [Vec4; 3]) -> Polygon {
    let mut polygon = Polygon::EMPTY;
    let mut first_new = None;
    for (i, &a) in triangle.iter().enumerate() {
        let b = triangle[(i + 1) % 3];
        if a.z >= 0.0 {
            polygon.push(Corner::from_position(a));
        }
        if (a.z >= 0.0) != (b.z >= 0.0) {
            let (before, behind) = if a.z < b.z { (a, b) } else { (b, a) };
            let part = before.z / (before.z - behind.z);
            let crossing = Vec4::splat(part).mul_add(behind - before, before);
            first_new = first_new.or(Some(polygon.len()));
            polygon.push(Corner::new(crossing));
        }
    }
    polygon.rotate_left(first_new.unwrap_or(0));
    polygon
}

/// Returns the right, left, upper and lower planes of the guard band around an image of this size.
fn guard_band(size: UVec2) -> [[f32; 4]; 4] {
    let reach = 1.0 + 2.0 * GUARD_BAND / size.as_vec2();
    [
        [-1.0, 0.0, 0.0, reach.x],
        [1.0, 0.0, 0.0, reach.x],
        [0.0, -1.0, 0.0, reach.y],
        [0.0, 1.0, 0.0, reach.y],
    ]
}

fn has_nearly_zero_w(clip: &Vec4) -> bool {
    clip.w.abs() <= NEARLY_ZERO_W * clip.x.abs().max(clip.y.abs())
}
