//! [`plane_gradient`](crate::shadow_map::lookup::plane_gradient) in scalars, so that the compiler finds its lanes.

use glam::Vec2;

/// A matrix's columns.
type Columns = [[f32; 4]; 4];

/// Depth change per texel right and down along the plane with normal `n` through the point whose clip coordinates over w
/// are `point`.
#[inline(always)]
pub(crate) fn gradient(m: &Columns, point: [f32; 3], n: [f32; 3], size: f32, limit: f32) -> Vec2 {
    let along_x = n[0].abs() < 0.6;
    let t = cross(
        n,
        [
            if along_x { 1.0 } else { 0.0 },
            if along_x { 0.0 } else { 1.0 },
            0.0,
        ],
    );
    let (a, b) = (slide(m, point, t, size), slide(m, point, cross(n, t), size));
    let det = a[0] * b[1] - b[0] * a[1];
    let (gx, gy) = (
        (a[2] * b[1] - b[2] * a[1]) / det,
        (a[0] * b[2] - b[0] * a[2]) / det,
    );
    let bounded = |g: f32| {
        let g = if g < limit { g } else { limit };
        let g = if g > -limit { g } else { -limit };
        if det == 0.0 { 0.0 } else { g }
    };
    Vec2::new(bounded(gx), bounded(gy))
}

/// [`cross3`](umbrage_core::math::cross3).
#[inline(always)]
fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// [`slide`](crate::shadow_map::lookup::slide).
#[inline(always)]
fn slide(m: &Columns, [x, y, z]: [f32; 3], t: [f32; 3], size: f32) -> [f32; 3] {
    let row = |i: usize| m[0][i] * t[0] + m[1][i] * t[1] + m[2][i] * t[2];
    let (half, w) = (size * 0.5, row(3));
    [
        (row(0) - x * w) * half,
        (y * w - row(1)) * half,
        row(2) - z * w,
    ]
}
