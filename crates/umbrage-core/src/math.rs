//! Arithmetic in a fixed order. Each function has a twin in `math.wgsl`, bit-equal on every device
//! that rounds sums and products to nearest and does not reorder them.
//!
//! Kernels use these functions because shading languages leave the order of `dot`, `normalize` and
//! matrix products to the driver. Drivers may also fuse `a * b + c`, and round quotients and roots
//! inexactly.

use crate::recipe::shader::Module;
use glam::{Mat4, Vec3, Vec4};

/// The WGSL half.
pub const MATH: Module = crate::module!("math");

/// Matrix-vector product, added from left to right.
#[inline(always)]
pub fn transform(m: Mat4, p: Vec3) -> Vec4 {
    m.x_axis * p.x + m.y_axis * p.y + m.z_axis * p.z + m.w_axis
}

/// Dot product, added from left to right.
#[inline(always)]
pub fn dot3(a: Vec3, b: Vec3) -> f32 {
    a.x * b.x + a.y * b.y + a.z * b.z
}

/// Cross product.
#[inline(always)]
pub fn cross3(a: Vec3, b: Vec3) -> Vec3 {
    Vec3::new(
        a.y * b.z - a.z * b.y,
        a.z * b.x - a.x * b.z,
        a.x * b.y - a.y * b.x,
    )
}

/// Returns the greater of two numbers, or `b` if one is NaN. This is the rule of the vector
/// instructions, so loops compile to one instruction each; `f32::max` has another rule and takes
/// several.
#[inline(always)]
pub fn greater(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Returns the lesser of two numbers, or `b` if one is NaN.
#[inline(always)]
pub fn lesser(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// Returns `a / b`, rounded to nearest.
#[inline(always)]
pub fn quotient(a: f32, b: f32) -> f32 {
    a / b
}

/// Returns the square root of a number, rounded to nearest.
#[inline(always)]
pub fn root(x: f32) -> f32 {
    x.sqrt()
}

/// Normalizes `v`; not finite for the zero vector.
#[inline(always)]
pub fn unit3(v: Vec3) -> Vec3 {
    let length = root(dot3(v, v));
    Vec3::new(
        quotient(v.x, length),
        quotient(v.y, length),
        quotient(v.z, length),
    )
}

/// The twins, for the lockstep tests.
#[cfg(feature = "testing")]
pub const TWINS: &[crate::recipe::twin::Twin] = &[
    crate::twin!(MATH, quotient(a: f32, b: f32) -> f32),
    crate::twin!(MATH, root(x: f32) -> f32),
    crate::twin!(MATH, transform(m: Mat4, p: Vec3) -> Vec4),
    crate::twin!(MATH, dot3(a: Vec3, b: Vec3) -> f32),
    crate::twin!(MATH, cross3(a: Vec3, b: Vec3) -> Vec3),
    crate::twin!(MATH, unit3(v: Vec3) -> Vec3),
];
