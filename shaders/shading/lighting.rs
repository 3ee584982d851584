//! Reflected light of a surface: Lambert's diffuse and Blinn's specular reflection, the cone of a
//! spot light, and classic attenuation.

use crate::shading::interpolation::unit_or;
use glam::{Vec2, Vec3};
use umbrage_core::{MAX_SHININESS_LOG2, Module, math::dot3, module};

/// The WGSL half; it needs `interpolation`.
pub(crate) const LIGHTING: Module = module!("lighting");

/// Returns `x` to the power of 2^`log2` (at most [`MAX_SHININESS_LOG2`]), by repeated squaring.
#[inline(always)]
pub(crate) fn power(x: f32, log2: u32) -> f32 {
    let mut y = x;
    for _ in 0..log2.min(MAX_SHININESS_LOG2) {
        y = y * y;
    }
    y
}

/// Returns the diffuse (x) and specular (y) factor for light from `l` viewed from `v`, all unit
/// vectors. Diffuse is Lambert's n.l. Specular is (n.h)^(2^`shininess_log2`) with h halfway between
/// `l` and `v`: Blinn 1977, "Models of light reflection for computer synthesized pictures". Both
/// are 0 where the normal faces away from the light.
#[inline(always)]
pub(crate) fn blinn(n: Vec3, l: Vec3, v: Vec3, shininess_log2: u32) -> Vec2 {
    let diffuse = dot3(n, l).max(0.0);
    if diffuse > 0.0 {
        let h = unit_or(l + v, n);
        return Vec2::new(diffuse, power(dot3(n, h).max(0.0), shininess_log2));
    }
    Vec2::ZERO
}

/// Returns the factor of a spot's light at an angle to its axis, linear in the cosine. It is 0 at
/// the outer angle, whose cosine is `outer`. It is 1 at the inner angle, where
/// `(cos - outer) * scale` reaches 1.
#[inline(always)]
#[expect(
    clippy::manual_clamp,
    reason = "`clamp` lets NaN through, and this must bound it as the shader does"
)]
pub(crate) fn cone(cosine: f32, outer: f32, scale: f32) -> f32 {
    ((cosine - outer) * scale).max(0.0).min(1.0)
}

/// Returns the attenuation of OpenGL 1, `1 / (c + l d + q d^2)`, at the distance d, metres.
/// `factors` are (c, l, q).
#[inline(always)]
pub(crate) fn attenuation(factors: Vec3, distance: f32) -> f32 {
    1.0 / (factors.x + factors.y * distance + factors.z * distance * distance)
}

/// All twins of this module, for the tests that compare them.
#[cfg(feature = "testing")]
pub(crate) const TWINS: &[umbrage_core::Twin] = &[
    umbrage_core::twin!(LIGHTING, power(x: f32, log2: u32) -> f32, needs [crate::shading::interpolation::INTERPOLATION]),
    umbrage_core::twin!(LIGHTING, blinn(n: Vec3, l: Vec3, v: Vec3, shininess_log2: u32) -> Vec2, needs [crate::shading::interpolation::INTERPOLATION]),
    umbrage_core::twin!(LIGHTING, cone(cosine: f32, outer: f32, scale: f32) -> f32, needs [crate::shading::interpolation::INTERPOLATION]),
    umbrage_core::twin!(LIGHTING, attenuation(factors: Vec3, distance: f32) -> f32, needs [crate::shading::interpolation::INTERPOLATION]),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_by_squaring() {
        assert_eq!(
            [0, 1, 2, 5].map(|n| power(0.5, n)),
            [0.5, 0.25, 0.0625, 1.0 / 4_294_967_296.0]
        );
        assert_eq!((power(1.0, 12), power(0.0, 12)), (1.0, 0.0));
    }

    /// Incrementing the shininess squares the highlight and keeps the diffuse factor.
    #[test]
    fn a_step_of_shininess_doubles_the_power() {
        let n = Vec3::Z;
        let l = Vec3::new(0.6, 0.0, 0.8);
        let v = Vec3::new(0.0, 0.28, 0.96);
        for log2 in 0..8 {
            let once = blinn(n, l, v, log2);
            let twice = blinn(n, l, v, log2 + 1);
            assert_eq!((twice.x, twice.y), (0.8, once.y * once.y), "{log2}");
        }
    }

    #[test]
    fn highlights_by_hand() {
        // Light and eye are mirror images of each other, so h is the normal.
        let mirror = blinn(
            Vec3::Z,
            Vec3::new(0.6, 0.0, 0.8),
            Vec3::new(-0.6, 0.0, 0.8),
            5,
        );
        assert_eq!(mirror, Vec2::new(0.8, 1.0));
        // h = (1, 0, 1) / sqrt 2 between z and x: cos 45 degrees to the fourth power is a quarter.
        let corner = blinn(Vec3::Z, Vec3::Z, Vec3::X, 2);
        assert!(
            (corner - Vec2::new(1.0, 0.25)).abs().max_element() < 1e-6,
            "{corner}"
        );
        assert_eq!(
            blinn(Vec3::Z, Vec3::NEG_Z, Vec3::Z, 0),
            Vec2::ZERO,
            "from behind"
        );
    }

    #[test]
    fn cones_fall_off_between_their_angles() {
        assert_eq!(
            [0.4, 0.5, 0.625, 0.75, 0.9].map(|c| cone(c, 0.5, 4.0)),
            [0.0, 0.0, 0.5, 1.0, 1.0]
        );
        assert_eq!(attenuation(Vec3::X, 1e9), 1.0);
        assert_eq!(attenuation(Vec3::new(1.0, 0.5, 0.25), 2.0), 1.0 / 3.0);
    }
}
