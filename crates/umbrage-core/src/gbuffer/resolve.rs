//! Computation of a receiver from a pixel's triangle id: the intersection of the pixel's ray with
//! the triangle's plane.
//!
//! Both backends rasterise triangle ids and then resolve them with these formulas. Receivers are
//! therefore equal wherever the ids are, however a driver rounds interpolated values.

use crate::{
    math::{cross3, dot3, unit3},
    recipe::shader::Module,
    scene::camera::CameraRays,
};
use glam::{Vec3, Vec4};

/// The WGSL half.
pub const RESOLVE: Module = crate::module!("resolve");

/// Normal of the plane through three points; its length is twice the triangle's area
/// (right-handed).
#[inline(always)]
pub fn plane_normal(a: Vec3, b: Vec3, c: Vec3) -> Vec3 {
    cross3(b - a, c - a)
}

/// Parameter `t` at which the ray `o + t d` meets the plane through `a` with normal `n`; not finite
/// if they are parallel.
#[inline(always)]
pub fn plane_distance(o: Vec3, d: Vec3, a: Vec3, n: Vec3) -> f32 {
    dot3(n, a - o) / dot3(n, d)
}

/// Unit normal, turned against the ray.
#[inline(always)]
pub fn facing_normal(n: Vec3, d: Vec3) -> Vec3 {
    let unit = unit3(n);
    if dot3(n, d) > 0.0 { -unit } else { unit }
}

/// Origin or direction of the ray through a pixel's centre.
#[inline(always)]
pub fn at_pixel(base: Vec4, dx: Vec4, dy: Vec4, x: u32, y: u32) -> Vec3 {
    let fx = x as f32 + 0.5;
    let fy = y as f32 + 0.5;
    Vec3::new(
        base.x + dx.x * fx + dy.x * fy,
        base.y + dx.y * fx + dy.y * fy,
        base.z + dx.z * fx + dy.z * fy,
    )
}

/// A resolved receiver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resolved {
    /// World position, metres.
    pub position: Vec3,
    /// Geometric unit normal, turned to the camera.
    pub normal: Vec3,
    /// Position along the pixel's ray, in multiples of its direction, which is not a unit vector.
    pub t: f32,
}

/// Returns the receiver at pixel (x, y) on the triangle with these corners (world space). `None` if
/// the ray is parallel to its plane.
#[inline(always)]
pub fn resolve(rays: &CameraRays, x: u32, y: u32, corners: [Vec3; 3]) -> Option<Resolved> {
    let [a, b, c] = corners;
    let o = at_pixel(rays.origin, rays.origin_dx, rays.origin_dy, x, y);
    let d = at_pixel(rays.dir, rays.dir_dx, rays.dir_dy, x, y);
    let n = plane_normal(a, b, c);
    let t = plane_distance(o, d, a, n);
    let normal = facing_normal(n, d);
    let position = Vec3::new(o.x + d.x * t, o.y + d.y * t, o.z + d.z * t);
    (t.abs() < 3.0e38).then_some(Resolved {
        position,
        normal,
        t,
    })
}

/// The twins, for the lockstep tests.
#[cfg(feature = "testing")]
pub const TWINS: &[crate::recipe::twin::Twin] = &[
    crate::twin!(RESOLVE, plane_normal(a: Vec3, b: Vec3, c: Vec3) -> Vec3, needs [crate::math::MATH]),
    crate::twin!(RESOLVE, plane_distance(o: Vec3, d: Vec3, a: Vec3, n: Vec3) -> f32, needs [crate::math::MATH]),
    crate::twin!(RESOLVE, facing_normal(n: Vec3, d: Vec3) -> Vec3, needs [crate::math::MATH]),
    crate::twin!(RESOLVE, at_pixel(base: Vec4, dx: Vec4, dy: Vec4, x: u32, y: u32) -> Vec3, needs [crate::math::MATH]),
];
