//! [`plane_gradient`](crate::lookup::plane_gradient) in scalars, so that the compiler finds its lanes.

use glam::{Mat4, Vec2, Vec3};
use umbrage_core::math::cross3;

/// Depth change per texel right and down along the plane with normal `n` through the point whose clip coordinates over w
/// are `point`.
#[inline(always)]
pub(crate) fn gradient(m: &Mat4, point: [f32; 3], n: Vec3, size: f32, limit: f32) -> Vec2 {
    let along_x = n.x.abs() < 0.6;
    let axis = Vec3::new(if along_x { 1.0 } else { 0.0 }, if along_x { 0.0 } else { 1.0 }, 0.0);
    let t = cross3(n, axis);
    let (a, b) = (slide(m, point, t, size), slide(m, point, cross3(n, t), size));
    let det = a[0] * b[1] - b[0] * a[1];
    let (gx, gy) = ((a[2] * b[1] - b[2] * a[1]) / det, (a[0] * b[2] - b[0] * a[2]) / det);
    let bounded = |g: f32| if det == 0.0 { 0.0 } else { g.min(limit).max(-limit) };
    Vec2::new(bounded(gx), bounded(gy))
}

/// [`slide`](crate::lookup::slide).
#[inline(always)]
fn slide(m: &Mat4, [x, y, z]: [f32; 3], t: Vec3, size: f32) -> [f32; 3] {
    let row = |i: usize| m.x_axis[i] * t.x + m.y_axis[i] * t.y + m.z_axis[i] * t.z;
    let (half, w) = (size * 0.5, row(3));
    [(row(0) - x * w) * half, (y * w - row(1)) * half, row(2) - z * w]
}
