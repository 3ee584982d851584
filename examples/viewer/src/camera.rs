//! The camera that the user controls.

use crate::lights::LookedAt;
use serde::{Deserialize, Serialize};
use umbrage::{
    Aabb, Camera,
    glam::{Affine3A, EulerRot, Quat, UVec2, Vec2, Vec3, camera::rh::proj::directx},
};

/// Turn for each point of mouse movement, radians.
const TURN: f32 = 0.0035;
/// Greatest pitch, radians.
const STEEPEST: f32 = 1.55;
/// Near plane, as a fraction of the scene's diagonal.
const NEAR: f32 = 2e-4;

/// Effect of rotation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Mode {
    /// The camera keeps its position and looks around.
    Fly,
    /// The camera orbits a point.
    Orbit,
}

/// Pose and motion of the camera.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct ViewCamera {
    pub mode: Mode,
    /// Speed, metres a second.
    pub speed: f32,
    /// `true` if the projection is orthographic.
    pub orthographic: bool,
    /// Position in world space, metres.
    eye: Vec3,
    /// Turn around the y axis, radians; 0 looks along -z.
    yaw: f32,
    /// Turn upwards, radians.
    pitch: f32,
    /// Distance from the eye to the orbited point, metres.
    distance: f32,
    /// Full vertical angle, radians.
    fov_y: f32,
    /// Diagonal of the scene's box, metres.
    diagonal: f32,
}

impl ViewCamera {
    /// Returns a camera with the view of a scene's camera.
    pub(crate) fn new(camera: &Camera, bounds: &Aabb) -> Self {
        let camera = camera.standard();
        let eye = camera.eye();
        let ahead = camera
            .world_from_view
            .transform_vector3(Vec3::NEG_Z)
            .normalize();
        let has_perspective = camera.clip_from_view.w_axis.w == 0.0;
        let fov_y = if has_perspective {
            2.0 * (1.0 / camera.clip_from_view.y_axis.y).atan()
        } else {
            0.8
        };
        let diagonal = bounds.diagonal().max(1e-3);
        // Approximately the distance of the scene's centre.
        let distance = (bounds.center() - eye).dot(ahead).max(0.05 * diagonal);
        Self {
            mode: Mode::Fly,
            speed: 0.08 * diagonal.min(200.0),
            orthographic: !has_perspective,
            eye,
            yaw: (-ahead.x).atan2(-ahead.z),
            pitch: ahead.y.clamp(-1.0, 1.0).asin().clamp(-STEEPEST, STEEPEST),
            distance,
            fov_y,
            diagonal,
        }
    }

    /// Returns the view with the pose and angle of another camera.
    pub(crate) fn seen_as(&self, camera: &Camera, bounds: &Aabb) -> Self {
        let seen = Self::new(camera, bounds);
        Self {
            mode: self.mode,
            speed: self.speed,
            orthographic: self.orthographic,
            distance: self.distance,
            fov_y: if self.orthographic {
                self.fov_y
            } else {
                seen.fov_y
            },
            ..seen
        }
    }

    /// Reports whether position and direction equal those of another camera, regardless of the
    /// modes.
    pub(crate) fn has_pose_of(&self, other: &Self) -> bool {
        let place = |view: &Self| (view.eye, view.yaw, view.pitch, view.distance);
        place(self) == place(other)
    }

    /// Switches between flying and orbiting.
    pub(crate) fn switch_mode(&mut self) {
        self.mode = match self.mode {
            Mode::Fly => Mode::Orbit,
            Mode::Orbit => Mode::Fly,
        };
    }

    /// Turns by a mouse movement, points.
    pub(crate) fn turn(&mut self, moved: Vec2) {
        let pivot = self.pivot();
        self.yaw -= TURN * moved.x;
        self.pitch = (self.pitch - TURN * moved.y).clamp(-STEEPEST, STEEPEST);
        if self.mode == Mode::Orbit {
            self.eye = pivot - self.forward_direction() * self.distance;
        }
    }

    /// Moves sideways and up, so that the pivot follows the mouse. `moved` and the image's height
    /// are in points.
    pub(crate) fn pan(&mut self, moved: Vec2, height: f32) {
        let metres = 2.0 * self.distance * (0.5 * self.fov_y).tan() / height.max(1.0);
        self.eye += self.rotation() * Vec3::new(-moved.x * metres, moved.y * metres, 0.0);
    }

    /// Moves ahead by steps of the wheel.
    pub(crate) fn step(&mut self, steps: f32) {
        match self.mode {
            Mode::Fly => self.eye += self.forward_direction() * (0.5 * self.speed * steps),
            Mode::Orbit => {
                let pivot = self.pivot();
                let nearest = 1e-3 * self.diagonal;
                self.distance = (self.distance * 0.85_f32.powf(steps)).max(nearest);
                self.eye = pivot - self.forward_direction() * self.distance;
            }
        }
    }

    /// Flies for some seconds. `way` is to the right, up (in the world) and forward, each -1 to 1.
    pub(crate) fn fly(&mut self, way: Vec3, seconds: f32) {
        let along = self.rotation() * Vec3::new(way.x, 0.0, -way.z);
        self.eye += (along + Vec3::Y * way.y) * (self.speed * seconds);
    }

    /// Returns the camera for an image of this size. Its depth is reversed: 1 at the near plane.
    pub(crate) fn camera(&self, size: UVec2) -> Camera {
        let aspect = size.x as f32 / size.y as f32;
        let near = NEAR * self.diagonal;
        let clip_from_view = if self.orthographic {
            let half = self.distance * (0.5 * self.fov_y).tan();
            let far = 2.0 * self.diagonal + self.distance;
            // Near and far are swapped.
            directx::orthographic(-half * aspect, half * aspect, -half, half, far, -far)
        } else {
            directx::perspective_infinite_reverse(self.fov_y, aspect, near)
        };
        Camera {
            world_from_view: Affine3A::from_rotation_translation(self.rotation(), self.eye),
            clip_from_view,
            size,
        }
    }

    /// Returns the direction of view.
    pub(crate) fn forward_direction(&self) -> Vec3 {
        self.rotation() * Vec3::NEG_Z
    }

    /// Returns the point that the camera orbits, and the visible extent at that point.
    pub(crate) fn looked_at(&self) -> LookedAt {
        LookedAt {
            point: self.pivot(),
            reach: 0.6 * self.distance * (0.5 * self.fov_y).tan(),
        }
    }

    fn pivot(&self) -> Vec3 {
        self.eye + self.forward_direction() * self.distance
    }

    fn rotation(&self) -> Quat {
        Quat::from_euler(EulerRot::YXZ, self.yaw, self.pitch, 0.0)
    }
}
