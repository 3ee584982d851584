//! The camera, and the rays through its pixels.

use crate::{
    invalid::{self, Invalid},
    light_space::{Extents, LightSpace, look_along, orthographic, perspective},
};
use glam::{Affine3A, DAffine3, DMat4, DVec2, DVec3, Mat4, UVec2, Vec2, Vec3, Vec4};

/// Greatest supported image side.
pub const MAX_SIDE: u32 = 16_384;

/// A pinhole or orthographic camera. Row 0 is the top row; pixel centres are at 0.5.
///
/// The constructors return cameras that look along their own -z, with depth 0 at near and 1 at far.
/// Matrices of other conventions may be used unchanged: reversed depth, no far plane, or
/// left-handed views. The library converts them with [`Camera::standard`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Camera {
    /// Position and orientation. The camera looks along its own -z, or along +z if its projection
    /// is that of a left-handed view.
    pub world_from_view: Affine3A,
    /// Projection, depth in 0..1: 0 at near, or 1 at near if reversed.
    pub clip_from_view: Mat4,
    /// Image size, pixels.
    pub size: UVec2,
}

crate::uniforms! {
    /// Rays through pixel centres. The ray of pixel (x, y) starts at
    /// `origin + fx origin_dx + fy origin_dy` and runs along `dir + fx dir_dx + fy dir_dy`, with fx
    /// = x + 0.5 and fy = y + 0.5. Directions are not unit vectors. The fourth components are
    /// unused.
    pub struct CameraRays {
        /// Start of the ray at the image's top left corner.
        pub origin: Vec4,
        /// Change of the start per pixel to the right.
        pub origin_dx: Vec4,
        /// Change of the start per pixel down.
        pub origin_dy: Vec4,
        /// Direction at the image's top left corner.
        pub dir: Vec4,
        /// Change of the direction per pixel to the right.
        pub dir_dx: Vec4,
        /// Change of the direction per pixel down.
        pub dir_dy: Vec4,
    }
}

impl Camera {
    /// Returns a pinhole camera. `fov_y` is the full vertical angle in radians, `near_far` are the
    /// distances of the near and the far plane in metres. `up` may be parallel to the view.
    ///
    /// # Errors
    /// Errors if a number is not finite or out of range, or `eye` and `target` coincide.
    pub fn perspective(
        eye: Vec3,
        target: Vec3,
        up: Vec3,
        fov_y: f32,
        near_far: [f32; 2],
        size: UVec2,
    ) -> Result<Self, Invalid> {
        check_size(size)?;
        let aspect = size.x as f32 / size.y as f32;
        let projection = perspective(fov_y, aspect, near_far[0], near_far[1]);
        Self::new(eye, target, up, projection, size)
    }

    /// Returns an orthographic camera.
    ///
    /// # Errors
    /// Errors if [`Camera::perspective`] does.
    pub fn orthographic(
        eye: Vec3,
        target: Vec3,
        up: Vec3,
        extents: Extents,
        size: UVec2,
    ) -> Result<Self, Invalid> {
        Self::new(eye, target, up, orthographic(extents), size)
    }

    fn new(
        eye: Vec3,
        target: Vec3,
        up: Vec3,
        clip_from_view: Result<Mat4, Invalid>,
        size: UVec2,
    ) -> Result<Self, Invalid> {
        let in_camera = |e: Invalid| e.within_context("camera");
        check_size(size).map_err(in_camera)?;
        let view_from_world = look_along(eye, target - eye, up).map_err(in_camera)?;
        let clip_from_view = clip_from_view.map_err(in_camera)?;
        let world_from_view = view_from_world.as_dmat4().inverse().as_mat4();
        Ok(Self {
            world_from_view: Affine3A::from_mat4(world_from_view),
            clip_from_view,
            size,
        })
    }

    /// Checks that the camera can be used.
    ///
    /// # Errors
    /// Errors with the first fault found: a size of zero or beyond [`MAX_SIDE`], a matrix that is
    /// not finite or singular.
    pub fn validate(&self) -> Result<(), Invalid> {
        check_size(self.size).map_err(|e| e.within_context("camera"))?;
        invalid::finite("camera matrix", &self.world_from_view.to_cols_array())?;
        invalid::finite("camera projection", &self.clip_from_view.to_cols_array())?;
        if self.clip_from_view.as_dmat4().determinant() == 0.0 {
            return Err(Invalid::new(
                "camera projection",
                "is singular",
                "use a perspective or orthographic matrix",
            ));
        }
        if Mat4::from(self.world_from_view).as_dmat4().determinant() == 0.0 {
            return Err(Invalid::new(
                "camera matrix",
                "is singular",
                "use a rotation and a translation",
            ));
        }
        Ok(())
    }

    /// Returns the world position of the eye.
    pub fn eye(&self) -> Vec3 {
        self.world_from_view.translation.into()
    }

    /// Returns an equivalent camera that looks along its own -z, with depth that grows from 0 at
    /// near. It is bit-equal if this camera already does.
    ///
    /// The view is left-handed if clip w grows along +z. An orthographic projection has constant w.
    /// It counts as left-handed if depth grows along +z and the whole view volume is at positive z,
    /// so orthographic left-handed views must not use reversed depth.
    #[must_use]
    pub fn standard(&self) -> Self {
        let mut out = *self;
        if looks_along_plus_z(&self.clip_from_view) {
            // Mirror both matrices, so that clip from world stays the same.
            out.world_from_view.matrix3.z_axis = -out.world_from_view.matrix3.z_axis;
            out.clip_from_view.z_axis = -out.clip_from_view.z_axis;
        }
        if is_reversed(&out.clip_from_view) {
            // Replace depth by 1 - z / w = (w - z) / w. The transpose's columns are the matrix'
            // rows.
            let mut rows = out.clip_from_view.transpose();
            rows.z_axis = rows.w_axis - rows.z_axis;
            out.clip_from_view = rows.transpose();
        }
        out
    }

    /// Returns the view and projection of [`Camera::standard`].
    pub fn space(&self) -> LightSpace {
        let camera = self.standard();
        let world_from_view = Mat4::from(camera.world_from_view).as_dmat4();
        LightSpace {
            view_from_world: world_from_view.inverse().as_mat4(),
            clip_from_view: camera.clip_from_view,
        }
    }

    /// Returns the same camera with another image size; the vertical field of view is kept.
    #[must_use]
    pub fn with_size(&self, size: UVec2) -> Self {
        let old_aspect = f64::from(self.size.x) / f64::from(self.size.y);
        let new_aspect = f64::from(size.x) / f64::from(size.y);
        let widen = DMat4::from_scale(DVec3::new(old_aspect / new_aspect, 1.0, 1.0));
        Self {
            clip_from_view: (widen * self.clip_from_view.as_dmat4()).as_mat4(),
            size,
            ..*self
        }
    }

    /// Returns the same camera with its image moved by `pixels` right and down.
    #[must_use]
    pub fn nudged_by(&self, pixels: Vec2) -> Self {
        let camera = self.standard();
        Self {
            clip_from_view: camera
                .space()
                .nudge_by(pixels, 0.0, self.size)
                .clip_from_view,
            ..camera
        }
    }

    /// Returns the rays through the pixels' centres.
    pub fn rays(&self) -> CameraRays {
        let unprojection = Unprojection::new(&self.standard());
        // Interpolate from three rays: both ends of a ray are linear in the image position.
        let corner = unprojection.ray(0.0, 0.0);
        let right = unprojection.ray(1.0, 0.0);
        let down = unprojection.ray(0.0, 1.0);
        CameraRays {
            origin: round_to_single(corner.origin),
            origin_dx: round_to_single(right.origin - corner.origin),
            origin_dy: round_to_single(down.origin - corner.origin),
            dir: round_to_single(corner.direction),
            dir_dx: round_to_single(right.direction - corner.direction),
            dir_dy: round_to_single(down.direction - corner.direction),
        }
    }
}

/// A ray in world space.
struct ImageRay {
    origin: DVec3,
    direction: DVec3,
}

/// The transform from a standard camera's image to world space.
struct Unprojection {
    world_from_view: DAffine3,
    view_from_clip: DMat4,
    is_orthographic: bool,
    /// Image size, pixels.
    size: DVec2,
}

impl Unprojection {
    fn new(camera: &Camera) -> Self {
        let world_from_view = Mat4::from(camera.world_from_view).as_dmat4();
        Self {
            world_from_view: DAffine3::from_mat4(world_from_view),
            view_from_clip: camera.clip_from_view.as_dmat4().inverse(),
            is_orthographic: camera.clip_from_view.row(3) == Vec4::W,
            size: camera.size.as_dvec2(),
        }
    }

    /// Returns the ray through a position on the image, pixels from its top left corner.
    fn ray(&self, x: f64, y: f64) -> ImageRay {
        let on_near_plane = DVec3::new(
            2.0 * x / self.size.x - 1.0,
            1.0 - 2.0 * y / self.size.y,
            0.0,
        );
        let near = self.view_from_clip.project_point3(on_near_plane);
        if self.is_orthographic {
            ImageRay {
                origin: self.world_from_view.transform_point3(near),
                direction: self.world_from_view.transform_vector3(-DVec3::Z),
            }
        } else {
            ImageRay {
                origin: self.world_from_view.translation,
                direction: self.world_from_view.transform_vector3(near / -near.z),
            }
        }
    }
}

/// Returns a vector for a uniform: 32 bits, with an unused fourth component.
fn round_to_single(v: DVec3) -> Vec4 {
    v.as_vec3().extend(0.0)
}

/// Returns whether a projection is for a left-handed view, see [`Camera::standard`].
fn looks_along_plus_z(clip_from_view: &Mat4) -> bool {
    let depth = clip_from_view.row(2);
    let w = clip_from_view.row(3);
    if w.z != 0.0 {
        return w.z > 0.0;
    }
    // Depth is depth.z z + depth.w. At the plane z = 0 it is depth.w; if that is not positive,
    // nothing visible is in front of that plane.
    depth.z > 0.0 && depth.w <= 0.0
}

/// Returns whether depth decreases along -z. Depth is (a z + b) / (c z + d), whose derivative has
/// the sign of a d - b c.
fn is_reversed(clip_from_view: &Mat4) -> bool {
    let depth = clip_from_view.row(2).as_dvec4();
    let w = clip_from_view.row(3).as_dvec4();
    depth.z * w.w - depth.w * w.z > 0.0
}

fn check_size(size: UVec2) -> Result<(), Invalid> {
    if size.min_element() == 0 || size.max_element() > MAX_SIDE {
        let why = format!("is {} x {} pixels", size.x, size.y);
        return Err(Invalid::new(
            "image size",
            why,
            format!("use 1 to {MAX_SIDE} on each side"),
        ));
    }
    Ok(())
}
