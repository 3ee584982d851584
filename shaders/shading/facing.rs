//! Direction to the light, for directional lights and lights with a position alike.

use glam::{Vec3, Vec4};
use umbrage_core::{Light, Module, math::dot3, module};

/// The WGSL half.
pub const FACING: Module = module!("facing");

/// Returns a light's centre in homogeneous coordinates (x, y, z, 1). Directional lights return the
/// unit direction to the light (w = 0). The vector from a point `p` to the light is `xyz - w p`.
pub fn homogeneous(light: &Light) -> Vec4 {
    match light.position() {
        Some(p) => p.extend(1.0),
        None => light.direction_from(Vec3::ZERO).extend(0.0),
    }
}

/// Returns 1 if a surface at the point `p` with the normal `n` faces away from a [`homogeneous`]
/// light or is parallel to its rays, else 0.
#[inline(always)]
pub fn turned_away(light: Vec4, p: Vec3, n: Vec3) -> u32 {
    let to_light = Vec3::new(
        light.x - p.x * light.w,
        light.y - p.y * light.w,
        light.z - p.z * light.w,
    );
    u32::from(dot3(n, to_light) <= 0.0)
}

/// All twins of this module, for the tests that compare them.
#[cfg(feature = "testing")]
pub const TWINS: &[umbrage_core::Twin] = &[
    umbrage_core::twin!(FACING, turned_away(light: Vec4, p: Vec3, n: Vec3) -> u32, needs [umbrage_core::MATH]),
];
