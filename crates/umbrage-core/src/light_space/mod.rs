//! Spaces, and the matrices between them.
//!
//! * **world**: right-handed, y up, metres.
//! * **clip**: y up; after division by w: x and y in -1..1 from left to right and bottom to top, z
//!   in 0..1 from near to far, as in WebGPU.
//! * **texture**: u and v in 0..1, origin top left. **texel**: u and v times the size; texel
//!   centres at 0.5.
//!
//! Matrices are named `destination_from_source` and multiply column vectors. They are built in
//! `f64` and rounded once.

pub(crate) mod cascades;
pub(crate) mod caster_set;
pub mod depth_range;
pub(crate) mod fit;
pub mod footprint;
pub(crate) mod layers;
pub(crate) mod view_box;

use crate::{
    invalid::{self, Invalid},
    scene::camera::{Camera, CameraRays},
};
use glam::{
    Affine3A, DMat4, DVec3, Mat4, Vec3,
    dcamera::rh::{proj::directx, view::look_to_mat4},
};

/// View and projection of a light or a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSpace {
    /// The view: a rigid motion.
    pub view_from_world: Mat4,
    /// The projection: orthographic or perspective, depth 0 at the near plane and 1 at the far
    /// plane.
    pub clip_from_view: Mat4,
}

impl LightSpace {
    /// Returns the product of both matrices, computed in `f64`.
    pub fn clip_from_world(&self) -> Mat4 {
        (self.clip_from_view.as_dmat4() * self.view_from_world.as_dmat4()).as_mat4()
    }

    /// Returns the transform from world positions to texture coordinates (u, v) and depth: the
    /// usual bias matrix times `clip_from_world`.
    pub fn texture_from_world(&self) -> Mat4 {
        (TEXTURE_FROM_CLIP.as_dmat4()
            * self.clip_from_view.as_dmat4()
            * self.view_from_world.as_dmat4())
        .as_mat4()
    }

    /// Returns the rays through the centres of the texels of a map of this size. Their lengths are
    /// proportional to the distance from the light (or, without perspective, from the near plane).
    pub fn rays(&self, size: glam::UVec2) -> CameraRays {
        let world_from_view = self.view_from_world.as_dmat4().inverse();
        let camera = Camera {
            world_from_view: Affine3A::from_mat4(world_from_view.as_mat4()),
            clip_from_view: self.clip_from_view,
            size,
        };
        camera.rays()
    }

    /// Returns the space with its image moved by `texels` right and down, and depth increased by
    /// `depth`. `size` is the map's, in texels.
    #[must_use]
    pub fn nudge_by(&self, texels: glam::Vec2, depth: f32, size: glam::UVec2) -> Self {
        let ndc = texels.as_dvec2() * 2.0 / size.as_dvec2();
        // Multiply from the left of the projection, so that w scales the shift.
        let shift = DMat4::from_translation(DVec3::new(ndc.x, -ndc.y, f64::from(depth)));
        Self {
            clip_from_view: (shift * self.clip_from_view.as_dmat4()).as_mat4(),
            ..*self
        }
    }
}

/// Transform of clip x and y from -1..1 to 0..1 with v pointing down; depth is unchanged.
pub const TEXTURE_FROM_CLIP: Mat4 = Mat4::from_cols_array(&[
    0.5, 0.0, 0.0, 0.0, //
    0.0, -0.5, 0.0, 0.0, //
    0.0, 0.0, 1.0, 0.0, //
    0.5, 0.5, 0.0, 1.0,
]);

/// Returns the view from `eye` along `direction` (any length). If `up` is parallel to it, another
/// axis is used: z for views up and down.
///
/// No rule is continuous at such views: the image's roll has a limit from each azimuth, and no two
/// are equal. A view that turns down from the horizontal direction h has the limit h, one that
/// turns up has -h. With `up` along y, the axis z is the limit of views that turn down from +z and
/// of those that turn up from -z. A view that passes y from the opposite side turns its image by
/// 180 degrees there, and from any other side by the angle between h and z. Pass another `up` to
/// keep the roll. Maps of lights have the same extents after a turn by 180 degrees.
///
/// # Errors
/// Errors if a number is not finite, or `direction` is zero.
pub fn look_along(eye: Vec3, direction: Vec3, up: Vec3) -> Result<Mat4, Invalid> {
    invalid::finite("eye", &eye.to_array())?;
    invalid::finite("up", &up.to_array())?;
    invalid::direction("viewing direction", direction)?;
    let forward = direction.as_dvec3().normalize();
    Ok(look_to_mat4(eye.as_dvec3(), forward, stable_up(forward, up.as_dvec3())).as_mat4())
}

/// Returns `up`, unless `forward` (unit) is parallel to it within rounding of 32-bit directions.
/// Then returns an axis that only depends on the axis of `forward`, so that rounding doesn't roll
/// the view: z for views up and down. That is the limit of views that turn down from +z, and of
/// those that turn up from -z.
fn stable_up(forward: DVec3, up: DVec3) -> DVec3 {
    const PARALLEL: f64 = 1e-6;
    let up = up.normalize_or_zero();
    if forward.cross(up).length() > PARALLEL {
        return up;
    }
    let a = forward.abs();
    if a.z >= a.x && a.z >= a.y {
        DVec3::X
    } else {
        DVec3::Z
    }
}

/// Extents of an orthographic projection, in view-space metres; `near` and `far` are distances
/// along the view.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields)
)]
pub struct Extents {
    /// Least x.
    pub left: f32,
    /// Greatest x.
    pub right: f32,
    /// Least y.
    pub bottom: f32,
    /// Greatest y.
    pub top: f32,
    /// Distance to the plane of depth 0; may be negative.
    pub near: f32,
    /// Distance to the plane of depth 1.
    pub far: f32,
}

/// Returns an orthographic projection.
///
/// # Errors
/// Errors if a number is not finite, or an extent is empty or reversed.
pub fn orthographic(e: Extents) -> Result<Mat4, Invalid> {
    invalid::finite(
        "orthographic extents",
        &[e.left, e.right, e.bottom, e.top, e.near, e.far],
    )?;
    for (lo, hi, names) in [
        (e.left, e.right, "left and right"),
        (e.bottom, e.top, "bottom and top"),
        (e.near, e.far, "near and far"),
    ] {
        if lo >= hi {
            return Err(Invalid::new(
                format!("orthographic {names}"),
                format!("are {lo} and {hi}"),
                "make the first less than the second",
            ));
        }
    }
    let matrix = directx::orthographic(
        f64::from(e.left),
        f64::from(e.right),
        f64::from(e.bottom),
        f64::from(e.top),
        f64::from(e.near),
        f64::from(e.far),
    );
    Ok(matrix.as_mat4())
}

/// Returns a perspective projection with a full vertical angle in radians; `aspect` is width over
/// height.
///
/// # Errors
/// Errors if a number is not finite, the angle is not within 0..pi, or not `0 < near < far`.
pub fn perspective(fov_y: f32, aspect: f32, near: f32, far: f32) -> Result<Mat4, Invalid> {
    invalid::finite("perspective", &[fov_y, aspect, near, far])?;
    invalid::positive("aspect ratio", aspect)?;
    if !(fov_y > 0.0 && fov_y < std::f32::consts::PI) {
        let why = format!("is {} degrees", fov_y.to_degrees());
        return Err(Invalid::new(
            "field of view",
            why,
            "use more than 0 and less than 180",
        ));
    }
    if !(near > 0.0 && near < far) {
        let why = format!("are {near} and {far}");
        return Err(Invalid::new("near and far", why, "use 0 < near < far"));
    }
    Ok(directx::perspective(
        f64::from(fov_y),
        f64::from(aspect),
        f64::from(near),
        f64::from(far),
    )
    .as_mat4())
}

#[cfg(test)]
mod tests {
    use super::look_along;
    use glam::{Vec2, Vec3};

    /// Returns the world's direction that is up in the view along `direction`.
    fn up_of(direction: Vec3) -> Vec3 {
        let view_from_world = look_along(Vec3::ZERO, direction, Vec3::Y).unwrap();
        view_from_world.inverse().y_axis.truncate()
    }

    #[test]
    fn rounding_does_not_roll_views_up_and_down() {
        for y in [-3.0, -1.0, 1.0, 250.0] {
            for i in 0..64 {
                let tilt = Vec2::from_angle(0.1 * i as f32) * (3e-7 * y);
                let up = up_of(Vec3::new(tilt.x, y, tilt.y));
                assert!(up.distance(Vec3::Z) < 1e-5, "{y}, {tilt}: {up}");
            }
        }
    }

    /// Views that turn from the horizon to the zenith, and from the other side to the nadir, don't
    /// jump. Next to them, any other view has the roll of `up`.
    #[test]
    fn straight_views_are_the_limit_of_tilted_ones() {
        for y in [-1.0_f32, 1.0] {
            let towards = -Vec3::Z * y;
            let mut last = up_of(Vec3::Y * y);
            for exponent in -90..=0 {
                let tilt = 10.0_f32.powf(0.1 * exponent as f32);
                let direction = Vec3::Y * y + towards * tilt;
                let up = up_of(direction);
                assert!(
                    up.distance(last) < 0.3 * tilt + 1e-5,
                    "{y}, {tilt}: {last}, {up}"
                );
                last = up;
            }
            for i in 0..64 {
                let tilt = Vec2::from_angle(0.1 * i as f32) * 1e-5;
                let direction = Vec3::new(tilt.x, y, tilt.y).normalize();
                let right = direction.cross(Vec3::Y).normalize();
                let expected = right.cross(direction);
                let up = up_of(direction);
                assert!(
                    up.distance(expected) < 1e-5,
                    "{direction}: {expected}, {up}"
                );
            }
        }
    }

    #[test]
    fn any_up_that_is_parallel_to_the_view_has_a_replacement() {
        for axis in [
            Vec3::X,
            Vec3::Y,
            Vec3::Z,
            Vec3::ONE,
            Vec3::new(-1.0, 2.0, -3.0),
        ] {
            for up in [axis, -axis, Vec3::ZERO] {
                let view = look_along(Vec3::ZERO, axis, up).unwrap();
                assert!(
                    (view.determinant() - 1.0).abs() < 1e-5,
                    "{axis}, {up}: {view}"
                );
            }
        }
    }
}
