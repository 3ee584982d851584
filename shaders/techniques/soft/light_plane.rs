//! Plane of a light's points relative to a receiver. In it, hidden points are given by linear
//! functions of two coordinates.

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

/// Vectors from a receiver to the light. The light's point (x, y) of the unit disc, or of -1 to 1
/// in both coordinates, is at `center + u * x + v * y`. The length of vectors to directional lights
/// is meaningless.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LightPlane {
    pub(super) center: Vec3,
    pub(super) u: Vec3,
    pub(super) v: Vec3,
}

impl LightPlane {
    /// Plane without a receiver.
    pub(super) const NOWHERE: Self = Self {
        center: Vec3::ZERO,
        u: Vec3::ZERO,
        v: Vec3::ZERO,
    };

    /// Returns the plane relative to `o`. `slope` is the tangent of half a directional light's
    /// angular diameter.
    ///
    /// Points of lights with a position are at [`SHORT`] of the distance, like the ends of rays.
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

/// Returns whether a light has a position, so that casters may be beyond it.
pub(super) fn is_lamp(s: &LightSampler) -> bool {
    s.shape.x != kind::DIRECTION && s.shape.x != kind::CAP
}

/// Returns the domain of a light's points.
pub(super) fn domain_of(s: &LightSampler) -> Domain {
    if s.shape.x == kind::RECT {
        Domain::Square
    } else {
        Domain::Disc
    }
}

/// Returns the extent of the light from its centre along each axis: metres, or a fraction of the
/// distance for directional lights.
pub(super) fn spread_of(s: &LightSampler, slope: f32) -> Vec3 {
    let u = s.half_u.truncate().abs();
    let v = s.half_v.truncate().abs();
    // Compute the bounding box of an ellipse.
    let around_ellipse = (u * u + v * v).map(f32::sqrt);
    match s.shape.x {
        kind::CAP => around_ellipse * slope,
        kind::RECT => u + v,
        kind::DISC => around_ellipse,
        kind::BALL => Vec3::splat(s.half_u.w),
        _ => Vec3::ZERO,
    }
}
