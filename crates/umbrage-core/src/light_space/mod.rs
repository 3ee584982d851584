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
/// axis is used.
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

/// Returns `up`, unless `forward` (unit) is within 0.06 degrees of it. Then returns the world axis
/// closest to perpendicular to `forward`.
fn stable_up(forward: DVec3, up: DVec3) -> DVec3 {
    const PARALLEL: f64 = 1e-3;
    let up = up.normalize_or_zero();
    if forward.cross(up).length() > PARALLEL {
        return up;
    }
    let a = forward.abs();
    if a.z <= a.x && a.z <= a.y {
        DVec3::Z
    } else if a.x <= a.y {
        DVec3::X
    } else {
        DVec3::Y
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
