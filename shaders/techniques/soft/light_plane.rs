//! A light as seen from a receiver: the plane in which its points lie, so that what hides them is a
//! linear function of two coordinates.

use super::lattice::Domain;
use umbrage_core::{
    Module,
    glam::Vec3,
    light_sample::{LightSampler, SHORT, bitangent, kind, tangent},
    math::dot3,
    module,
};

/// The WGSL half.
pub(super) const LIGHT_PLANE: Module = module!("soft_light_plane", "light_plane.wgsl");

/// Vectors from a receiver: the light's point (x, y) of the unit disc, or from -1 to 1 both ways,
/// is at `center + u * x + v * y`. Those to suns have no length that means anything.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LightPlane {
    pub(super) center: Vec3,
    pub(super) u: Vec3,
    pub(super) v: Vec3,
}

impl LightPlane {
    /// That of nobody.
    pub(super) const NOWHERE: Self = Self {
        center: Vec3::ZERO,
        u: Vec3::ZERO,
        v: Vec3::ZERO,
    };

    /// Returns the plane as seen from `o`. `slope` is the tangent of half a sun's angular diameter.
    ///
    /// Points of lamps are at [`SHORT`] of the way, as those of rays are.
    #[inline(always)]
    pub(super) fn seen_from(s: &LightSampler, slope: f32, o: Vec3) -> Self {
        let center = s.center.truncate();
        let u = s.half_u.truncate();
        let v = s.half_v.truncate();
        let kind = s.shape.x;
        if kind == kind::DIRECTION || kind == kind::CAP {
            return Self {
                center,
                u: u * slope,
                v: v * slope,
            };
        }
        let to_center = center - o;
        if kind != kind::BALL {
            return Self {
                center: to_center * SHORT,
                u: u * SHORT,
                v: v * SHORT,
            };
        }
        let n = to_center / dot3(to_center, to_center).sqrt();
        let radius = s.half_u.w * SHORT;
        Self {
            center: to_center * SHORT,
            u: tangent(n) * radius,
            v: bitangent(n) * radius,
        }
    }
}

/// Returns whether a light has a position, so that casters may lie beyond it.
pub(super) fn is_lamp(s: &LightSampler) -> bool {
    s.shape.x != kind::DIRECTION && s.shape.x != kind::CAP
}

/// Returns over what a light's points are spread.
pub(super) fn domain_of(s: &LightSampler) -> Domain {
    if s.shape.x == kind::RECT {
        Domain::Square
    } else {
        Domain::Disc
    }
}

/// Returns how far the light reaches from its middle along each axis: metres, or for suns as a part
/// of the way.
pub(super) fn spread_of(s: &LightSampler, slope: f32) -> Vec3 {
    let u = s.half_u.truncate().abs();
    let v = s.half_v.truncate().abs();
    // The least box around an ellipse.
    let around_ellipse = (u * u + v * v).map(f32::sqrt);
    match s.shape.x {
        kind::CAP => around_ellipse * slope,
        kind::RECT => u + v,
        kind::DISC => around_ellipse,
        kind::BALL => Vec3::splat(s.half_u.w),
        _ => Vec3::ZERO,
    }
}
