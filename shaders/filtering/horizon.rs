//! Light horizon: the part of an area light above a receiver's tangent plane. A light point below
//! the plane is not visible ([`light_sample`](umbrage_core::light_sample)), whatever a map holds.
//!
//! The light's point at (x, y) of -1..1 along its half axes has the height `h.x + h.y x + h.z y`
//! over the receiver's plane. Heights are metres, or sines for directional lights. So the horizon
//! is a straight line across the square or the disc, and the fraction above it has a closed form.

use crate::filtering::light_extent::{HalfAxes, half_axes};
use glam::{DMat4, Mat4, Vec2, Vec3, Vec4};
use umbrage_core::{Light, LightSpaces, Module, math::dot3, module, uniforms};

/// The WGSL half.
pub(crate) const HORIZON: Module = module!("horizon");

uniforms! {
    /// Half axes of a light in world space.
    pub struct Horizon {
        /// Metres, or tangents for directional lights; w: radius of a ball (the other components
        /// are then 0), else 0.
        pub half_u: Vec4,
        /// Second half axis. w: 0.
        pub half_v: Vec4,
    }
}

impl Horizon {
    /// Returns the half axes of `light`, whose maps have the light spaces `spaces`.
    ///
    /// Panics if there are no spaces.
    pub fn new(light: &Light, spaces: &LightSpaces) -> Self {
        let world_from_view: DMat4 = spaces.spaces[0].view_from_world.as_dmat4().inverse();
        match half_axes(light, &world_from_view) {
            HalfAxes::Flat(u, v) => Self {
                half_u: u.as_vec3().extend(0.0),
                half_v: v.as_vec3().extend(0.0),
            },
            HalfAxes::Ball(radius) => Self {
                half_u: Vec4::new(0.0, 0.0, 0.0, radius as f32),
                half_v: Vec4::ZERO,
            },
        }
    }

    /// Returns the fraction of the light, 0..=1, above the plane with unit normal `n` through `p`.
    /// `light` is its centre, homogeneous; `square`: see [`share_above`].
    #[inline(always)]
    pub(crate) fn share(&self, square: u32, light: Vec4, p: Vec3, n: Vec3) -> f32 {
        let middle = height_over_plane(light, p, n);
        if self.half_u.w > 0.0 {
            let to_light = Vec3::new(light.x - p.x, light.y - p.y, light.z - p.z);
            let rim = ball_rim(self.half_u.w, middle, dot3(to_light, to_light));
            return disc_share(Vec3::new(middle, rim, 0.0));
        }
        let along_u = dot3(n, self.half_u.truncate());
        let along_v = dot3(n, self.half_v.truncate());
        share_above(square, Vec3::new(middle, along_u, along_v))
    }

    /// Returns heights over that plane: of the light's centre, and their growth along the half axes
    /// that [`light_axes`](crate::filtering::light_extent::light_axes) returns. `face` is the
    /// transform of the layer that contains `p`. `t` are the receiver's tangents right and down
    /// there. `half_tangent` is the tangent of half the layer's angle.
    #[inline(always)]
    pub(crate) fn heights(
        &self,
        light: Vec4,
        face: &Mat4,
        p: Vec3,
        n: Vec3,
        t: Vec2,
        half_tangent: f32,
    ) -> Vec3 {
        let middle = height_over_plane(light, p, n);
        if self.half_u.w > 0.0 {
            // Compute the normal's components along the layer's x and y, in the scale of its
            // transform's rows: units of the tangent.
            let right = face.x_axis.x * n.x + face.y_axis.x * n.y + face.z_axis.x * n.z;
            let up = face.x_axis.y * n.x + face.y_axis.y * n.y + face.z_axis.y * n.z;
            let right_down = Vec2::new(right * half_tangent, -up * half_tangent);
            let growth = ball_heights(self.half_u.w, right_down, t);
            return Vec3::new(middle, growth.x, growth.y);
        }
        let along_u = dot3(n, self.half_u.truncate());
        let along_v = dot3(n, self.half_v.truncate());
        Vec3::new(middle, along_u, along_v)
    }
}

/// Returns the height of a light's centre ([`homogeneous`](crate::shading::facing::homogeneous))
/// over the plane with unit normal `n` through `p`.
#[inline(always)]
pub(crate) fn height_over_plane(light: Vec4, p: Vec3, n: Vec3) -> f32 {
    let to_light = Vec3::new(
        light.x - light.w * p.x,
        light.y - light.w * p.y,
        light.z - light.w * p.z,
    );
    dot3(n, to_light)
}

/// Returns the growth of heights along a ball's half axes, those of
/// [`light_axes`](crate::filtering::light_extent::light_axes). `n` are the normal's components
/// right and down on the map, `t` the receiver's tangents.
#[inline(always)]
pub(crate) fn ball_heights(radius: f32, n: Vec2, t: Vec2) -> Vec2 {
    let a = (1.0 + t.x * t.x).sqrt();
    let d = (1.0 + t.x * t.x + t.y * t.y).sqrt();
    Vec2::new(
        radius * (n.x * a + n.y * (t.x * t.y / a)),
        radius * (n.y * (d / a)),
    )
}

/// Returns how much higher than its centre a ball is at the edge of the disc that faces the
/// receiver. The centre is `height` over the receiver's plane; its squared distance from the
/// receiver is `distance_squared`.
#[inline(always)]
pub(crate) fn ball_rim(radius: f32, height: f32, distance_squared: f32) -> f32 {
    radius * (1.0 - height * height / distance_squared).max(0.0).sqrt()
}

/// Returns the fraction of the square -1..1 above the horizon `h.x + h.y x + h.z y = 0`. The part
/// below is a trapezium, or a triangle at a corner.
#[inline(always)]
pub(crate) fn square_share(h: Vec3) -> f32 {
    let a = h.y.abs().max(h.z.abs());
    let b = h.y.abs().min(h.z.abs());
    // Start from the result without a crossing: the side of the centre has everything.
    let whole = if h.x >= 0.0 { 1.0 } else { 0.0 };
    if h.x.abs() >= a + b {
        return whole;
    }
    let height = h.x.abs() / a;
    let slant = b / a;
    // Subtract the area beyond the horizon, on the side without the centre.
    let mut cut_off = 0.5 - height * 0.5;
    if height > 1.0 - slant {
        let corner = 1.0 + slant - height;
        cut_off = corner * corner / (8.0 * slant);
    }
    (whole - cut_off).abs()
}

/// Returns the fraction of the unit disc above the horizon. The part below is a segment of area
/// acos t - t sqrt(1 - t^2). The arc cosine is Hastings' polynomial (Abramowitz and Stegun 1964,
/// 4.4.45), with an error of at most 7e-5.
#[inline(always)]
pub(crate) fn disc_share(h: Vec3) -> f32 {
    let radius = (h.y * h.y + h.z * h.z).sqrt();
    let whole = if h.x >= 0.0 { 1.0 } else { 0.0 };
    if h.x.abs() >= radius {
        return whole;
    }
    let t = h.x.abs() / radius;
    let arc =
        (1.0 - t).sqrt() * (1.570_728_8 + t * (-0.212_114_4 + t * (0.074_261_0 - t * 0.018_729_3)));
    let cut_off = (arc - t * (1.0 - t * t).sqrt()) * std::f32::consts::FRAC_1_PI;
    (whole - cut_off).abs()
}

/// Returns the fraction of a square (`square` is 1) or a disc (0) above the horizon.
#[inline(always)]
pub(crate) fn share_above(square: u32, h: Vec3) -> f32 {
    if square != 0 {
        square_share(h)
    } else {
        disc_share(h)
    }
}

/// Returns the heights along half axes that are
/// [`turned`](crate::filtering::sample_pattern::turned) by (cos, sin).
#[inline(always)]
pub(crate) fn turned_heights(h: Vec3, turn: Vec2) -> Vec3 {
    Vec3::new(
        h.x,
        h.y * turn.x + h.z * turn.y,
        h.z * turn.x - h.y * turn.y,
    )
}

/// All twins of this module, for the tests that compare them.
#[cfg(feature = "testing")]
pub(crate) const TWINS: &[umbrage_core::Twin] = &[
    umbrage_core::twin!(HORIZON, height_over_plane(light: Vec4, p: Vec3, n: Vec3) -> f32, needs [umbrage_core::MATH]),
    umbrage_core::twin!(HORIZON, ball_heights(radius: f32, n: Vec2, t: Vec2) -> Vec2, needs [umbrage_core::MATH]),
    umbrage_core::twin!(HORIZON, ball_rim(radius: f32, height: f32, distance_squared: f32) -> f32, needs [umbrage_core::MATH]),
    umbrage_core::twin!(HORIZON, square_share(h: Vec3) -> f32, needs [umbrage_core::MATH]),
    umbrage_core::twin!(HORIZON, disc_share(h: Vec3) -> f32, needs [umbrage_core::MATH]),
    umbrage_core::twin!(HORIZON, share_above(square: u32, h: Vec3) -> f32, needs [umbrage_core::MATH]),
    umbrage_core::twin!(HORIZON, turned_heights(h: Vec3, turn: Vec2) -> Vec3, needs [umbrage_core::MATH]),
];

#[cfg(test)]
#[path = "horizon_tests.rs"]
mod tests;
