//! The camera that flies through the scene.

use umbrage::{
    Camera,
    glam::{Affine3A, EulerRot, Quat, UVec2, Vec2, Vec3, camera::rh::proj::directx},
};

/// Full vertical angle of view, radians.
const FIELD_OF_VIEW: f32 = 0.95;
/// Metres. There is no far plane.
const NEAR: f32 = 0.1;
/// Radians for a pixel that the mouse moves.
const TURN: f32 = 0.0035;

/// Where the camera is and where it looks.
pub struct FlyCamera {
    eye: Vec3,
    /// Radians around the y axis; 0 looks along -z.
    yaw: f32,
    /// Radians upwards.
    pitch: f32,
    /// Metres a second.
    pub speed: f32,
}

impl Default for FlyCamera {
    fn default() -> Self {
        Self {
            eye: Vec3::new(-7.0, 4.0, 17.5),
            yaw: -0.42,
            pitch: -0.14,
            speed: 6.0,
        }
    }
}

impl FlyCamera {
    /// Turns as the mouse moves, in pixels.
    pub fn turn(&mut self, moved: Vec2) {
        self.yaw -= TURN * moved.x;
        self.pitch = (self.pitch - TURN * moved.y).clamp(-1.55, 1.55);
    }

    /// Flies for some seconds: `way` is to the right, up (in the world) and forward, each -1 to 1.
    pub fn fly(&mut self, way: Vec3, seconds: f32) {
        let ahead = self.rotation() * Vec3::new(way.x, 0.0, -way.z);
        self.eye += (ahead + Vec3::Y * way.y) * (self.speed * seconds);
    }

    /// Returns the camera for a picture of this size. Its depth is reversed: 1 at the near plane, 0 endlessly far.
    pub fn camera(&self, size: UVec2) -> Camera {
        let aspect = size.x as f32 / size.y as f32;
        Camera {
            world_from_view: Affine3A::from_rotation_translation(self.rotation(), self.eye),
            clip_from_view: directx::perspective_infinite_reverse(FIELD_OF_VIEW, aspect, NEAR),
            size,
        }
    }

    fn rotation(&self) -> Quat {
        Quat::from_euler(EulerRot::YXZ, self.yaw, self.pitch, 0.0)
    }
}
