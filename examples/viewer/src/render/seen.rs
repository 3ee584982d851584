//! Culling of geometry outside the camera's view.

use umbrage::{
    Aabb,
    glam::{Mat4, Vec3},
};

/// A part of the image, and the camera.
pub(crate) struct SeenPart {
    pub clip_from_world: Mat4,
    /// Start and end of the part, as fractions of the width, 0..=1.
    pub part: [f32; 2],
    /// Position of the camera. `None` if its projection is orthographic.
    pub eye: Option<Vec3>,
    /// Distance from the eye within which the near plane may clip, metres.
    pub near: f32,
    /// Width of a pixel, metres, if smaller details may be culled. In perspective, at a distance of
    /// one metre.
    pub coarse_pixel: Option<f32>,
}

impl SeenPart {
    /// Reports whether the camera is outside a box, and the near plane doesn't clip it.
    pub(super) fn is_outside(&self, bounds: &Aabb) -> bool {
        let Some(eye) = self.eye else {
            return false;
        };
        let nearest = eye.clamp(bounds.min, bounds.max);
        nearest.distance(eye) > self.near
    }

    /// Returns the width of a pixel at the nearest point of a box, metres. `None` if details must
    /// not be culled.
    pub(super) fn pixel_at(&self, bounds: &Aabb) -> Option<f32> {
        let pixel = self.coarse_pixel?;
        let nearest = |eye: Vec3| eye.clamp(bounds.min, bounds.max).distance(eye);
        Some(pixel * self.eye.map_or(1.0, nearest))
    }

    /// Reports whether a box may be visible. It is not if all of its corners are beyond one side.
    pub(super) fn may_show(&self, bounds: &Aabb) -> bool {
        let [left, right] = self.part.map(|share| 2.0 * share - 1.0);
        let mut outside = [true; 5];
        for corner in bounds.corners() {
            let clip = self.clip_from_world * corner.extend(1.0);
            // Depth is reversed: points behind the eye are nearer than the near plane.
            let beyond = [
                clip.x < left * clip.w,
                clip.x > right * clip.w,
                clip.y < -clip.w,
                clip.y > clip.w,
                clip.z > clip.w,
            ];
            for (outside, beyond) in outside.iter_mut().zip(beyond) {
                *outside &= beyond;
            }
        }
        !outside.contains(&true)
    }
}
