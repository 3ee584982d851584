//! Kinds of vertices that can be drawn.

use glam::{Mat4, Vec3, Vec4};
use umbrage_core::math::transform;

/// A vertex in world space.
pub(crate) trait Position: Copy + Send + Sync {
    /// The vertex in clip space: columns times components, added from left to right.
    fn to_clip(self, clip_from_world: Mat4) -> Vec4;

    /// The same with each product and the sum that it goes into rounded once.
    fn to_clip_fused(self, clip_from_world: Mat4) -> Vec4;
}

/// A point.
impl Position for Vec3 {
    #[inline(always)]
    fn to_clip(self, clip_from_world: Mat4) -> Vec4 {
        transform(clip_from_world, self)
    }

    fn to_clip_fused(self, clip_from_world: Mat4) -> Vec4 {
        self.extend(1.0).to_clip_fused(clip_from_world)
    }
}

/// A homogeneous point; w = 0 is the point infinitely far along a direction.
impl Position for Vec4 {
    #[inline(always)]
    fn to_clip(self, m: Mat4) -> Vec4 {
        m.x_axis * self.x + m.y_axis * self.y + m.z_axis * self.z + m.w_axis * self.w
    }

    fn to_clip_fused(self, m: Mat4) -> Vec4 {
        let add = |axis: Vec4, by: f32, sum: Vec4| axis.mul_add(Vec4::splat(by), sum);
        let last = m.w_axis * self.w;
        let sum = add(m.z_axis, self.z, last);
        add(m.x_axis, self.x, add(m.y_axis, self.y, sum))
    }
}
