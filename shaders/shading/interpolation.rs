//! Vertex attributes over a triangle, and normals perturbed by a normal map. These are the
//! functions of [`surface`](crate::shading::surface) that read no table.
//!
//! Normal maps: Cohen, Olano and Manocha 1998, "Appearance-Preserving Simplification". The tangent
//! frame is that of Mikkelsen 2008, "Simulation of wrinkled surfaces revisited". Normal and tangent
//! are interpolated and *not* normalised. The bitangent is their cross product times the
//! handedness. So maps baked by other tools look as intended.

use glam::{Vec3, Vec4};
use umbrage_core::{
    Module,
    math::{cross3, dot3},
    module,
};

/// The WGSL half.
pub(crate) const INTERPOLATION: Module = module!("interpolation");

/// Returns the barycentric weights of a point in the plane of a triangle. They are signed areas
/// divided by the triangle's area.
#[inline(always)]
pub(crate) fn barycentric(p: Vec3, a: Vec3, b: Vec3, c: Vec3) -> Vec3 {
    let n = cross3(b - a, c - a);
    let u = dot3(n, cross3(b - p, c - p));
    let v = dot3(n, cross3(c - p, a - p));
    let w = dot3(n, cross3(a - p, b - p));
    let sum = u + v + w;
    Vec3::new(u / sum, v / sum, w / sum)
}

/// Returns the weighted sum of the corners' values.
#[inline(always)]
pub(crate) fn weighted(weights: Vec3, a: Vec4, b: Vec4, c: Vec4) -> Vec4 {
    a * weights.x + b * weights.y + c * weights.z
}

/// Returns `v` divided by its length, or `otherwise` if the length is zero.
#[inline(always)]
pub(crate) fn unit_or(v: Vec3, otherwise: Vec3) -> Vec3 {
    let square = dot3(v, v);
    if square > 0.0 {
        let length = square.sqrt();
        return Vec3::new(v.x / length, v.y / length, v.z / length);
    }
    otherwise
}

/// Transforms a normal map's normal `m` from tangent space to the space of the tangent `t` (w:
/// handedness) and the normal `n`. The result is not of unit length.
#[inline(always)]
pub(crate) fn bent(n: Vec3, t: Vec4, m: Vec3) -> Vec3 {
    let handedness = if t.w >= 0.0 { 1.0 } else { -1.0 };
    let bitangent = cross3(n, t.truncate()) * handedness;
    t.truncate() * m.x + bitangent * m.y + n * m.z
}

/// Returns `v`, negated if `n` is on the opposite side of `facing`.
#[inline(always)]
pub(crate) fn on_side_of(n: Vec3, v: Vec3, facing: Vec3) -> Vec3 {
    if dot3(n, facing) < 0.0 { -v } else { v }
}

/// All twins of this module, for the tests that compare them.
#[cfg(feature = "testing")]
pub(crate) const TWINS: &[umbrage_core::Twin] = &[
    umbrage_core::twin!(INTERPOLATION, barycentric(p: Vec3, a: Vec3, b: Vec3, c: Vec3) -> Vec3),
    umbrage_core::twin!(INTERPOLATION, weighted(weights: Vec3, a: Vec4, b: Vec4, c: Vec4) -> Vec4),
    umbrage_core::twin!(INTERPOLATION, unit_or(v: Vec3, otherwise: Vec3) -> Vec3),
    umbrage_core::twin!(INTERPOLATION, bent(n: Vec3, t: Vec4, m: Vec3) -> Vec3),
    umbrage_core::twin!(INTERPOLATION, on_side_of(n: Vec3, v: Vec3, facing: Vec3) -> Vec3),
];

#[cfg(test)]
mod tests {
    use super::*;

    const A: Vec3 = Vec3::new(1.0, 2.0, 0.0);
    const B: Vec3 = Vec3::new(5.0, 2.0, 0.0);
    const C: Vec3 = Vec3::new(1.0, 6.0, 0.0);

    #[test]
    fn corners_and_centre_have_their_weights() {
        assert_eq!(
            [A, B, C].map(|p| barycentric(p, A, B, C)),
            [Vec3::X, Vec3::Y, Vec3::Z]
        );
        assert_eq!(
            barycentric(Vec3::new(2.0, 4.0, 0.0), A, B, C),
            Vec3::new(0.25, 0.25, 0.5)
        );
        // The orientation does not matter.
        assert_eq!(
            barycentric(Vec3::new(2.0, 4.0, 0.0), A, C, B),
            Vec3::new(0.25, 0.5, 0.25)
        );
    }

    #[test]
    fn maps_bend_along_tangent_and_bitangent() {
        let n = Vec3::Z;
        let t = Vec4::new(1.0, 0.0, 0.0, 1.0);
        assert_eq!(
            bent(n, t, Vec3::new(0.25, 0.5, 0.75)),
            Vec3::new(0.25, 0.5, 0.75)
        );
        let mirrored = Vec4::new(1.0, 0.0, 0.0, -1.0);
        assert_eq!(
            bent(n, mirrored, Vec3::new(0.25, 0.5, 0.75)),
            Vec3::new(0.25, -0.5, 0.75)
        );
        // A flat map returns the normal itself in any frame.
        let n = Vec3::new(0.1, -0.7, 0.3);
        let t = Vec4::new(0.3, 0.9, 0.2, -1.0);
        assert_eq!(bent(n, t, Vec3::Z), n);
    }

    #[test]
    fn vectors_without_length_fall_back() {
        assert_eq!(
            unit_or(Vec3::new(0.0, 3.0, 4.0), Vec3::X),
            Vec3::new(0.0, 0.6, 0.8)
        );
        assert_eq!(unit_or(Vec3::ZERO, Vec3::X), Vec3::X);
    }
}
