//! Kinds of vertices that can be drawn.

use glam::{Mat4, Vec3, Vec4};
use umbrage_core::math::transform;

/// A vertex in world space.
pub(crate) trait Position: Copy + Send + Sync {
    /// The vertex in clip space: columns times components, added from left to right.
    fn to_clip(self, clip_from_world: Mat4) -> Vec4;
}

/// A point.
impl Position for Vec3 {
    #[inline(always)]
    fn to_clip(self, clip_from_world: Mat4) -> Vec4 {
        transform(clip_from_world, self)
    }
}

/// A homogeneous point; w = 0 is the point infinitely far along a direction.
impl Position for Vec4 {
    #[inline(always)]
    fn to_clip(self, m: Mat4) -> Vec4 {
        m.x_axis * self.x + m.y_axis * self.y + m.z_axis * self.z + m.w_axis * self.w
    }
}
