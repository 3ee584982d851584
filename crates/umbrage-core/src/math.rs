//! Arithmetic in a fixed order: each function has a twin in `math.wgsl`, bit-equal on every device
//! that rounds sums and products to nearest and does not reorder them. Products of matrices and
//! vectors, `dot` and `normalize` of shading languages leave the order to the driver, `a * b + c`
//! may be fused, and quotients and roots may be off: so kernels use these.

use crate::recipe::shader::Module;
use glam::{Mat4, Vec3, Vec4};

/// The WGSL half.
pub const MATH: Module = crate::module!("math");

/// Columns times components, added from left to right.
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

/// Returns the greater of two numbers as vector instructions have it: the second where one is not a
/// number. Loops with it become such instructions, where `f32::max`, which has another rule, takes
/// several.
#[inline(always)]
pub fn greater(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Returns the lesser of two numbers, likewise.
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

/// `v` over its length; not finite for the zero vector.
#[inline(always)]
pub fn unit3(v: Vec3) -> Vec3 {
    let length = root(dot3(v, v));
    Vec3::new(
        quotient(v.x, length),
        quotient(v.y, length),
        quotient(v.z, length),
    )
}

/// The pairs, for the lockstep tests.
#[cfg(feature = "testing")]
pub const TWINS: &[crate::recipe::twin::Twin] = &[
    crate::twin!(MATH, quotient(a: f32, b: f32) -> f32),
    crate::twin!(MATH, root(x: f32) -> f32),
    crate::twin!(MATH, transform(m: Mat4, p: Vec3) -> Vec4),
    crate::twin!(MATH, dot3(a: Vec3, b: Vec3) -> f32),
    crate::twin!(MATH, cross3(a: Vec3, b: Vec3) -> Vec3),
    crate::twin!(MATH, unit3(v: Vec3) -> Vec3),
];
