//! Built-in scenes in motion: the moving cases of the catalogue of failures, and the camera, the
//! light and the casters in each frame.

use umbrage_core::glam::{Affine3A, DQuat, Quat, Vec2};
use umbrage_core::{Camera, Fit, Layout, Light, RecipeError, Scene, View};

/// Distance by which the camera pans each frame, texels.
const PAN_TEXELS: f64 = 0.37;
/// Distance by which casters move each frame, texels. It exceeds one, so that every frame differs,
/// and is not an integer.
const CASTER_TEXELS: f64 = 1.37;
/// Angle by which the camera yaws each frame, degrees.
const YAW: f64 = 0.1;
/// Angle by which the sun turns each frame, degrees.
const TURN: f64 = 0.25;
/// Vertical field of view of the first frame of a widening, degrees.
const FIRST_FOV: f64 = 75.0;
/// Vertical field of view of the last frame of a widening, degrees.
const LAST_FOV: f64 = 90.0;

/// Depth range of stable fits in views a few metres deep, metres.
const NEARBY: f32 = 8.0;
/// Depth range of stable fits in landscapes, metres.
const LANDSCAPE: f32 = 160.0;

/// A built-in scene in motion: a case of the catalogue of failures.
#[derive(Clone, Copy, Debug)]
pub struct MovingScene {
    /// Name, in lower case with dashes.
    pub name: &'static str,
    /// Row in the catalogue of failures.
    pub row: u8,
    /// The built-in scene.
    pub scene: &'static str,
    /// The motion.
    pub motion: Motion,
    /// The range of a fit that keeps maps stable while the camera moves, metres: [`Fit::Stable`].
    pub range: f32,
}

/// A change from frame to frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// No motion.
    Still,
    /// The camera moves sideways by .37 texels of the map a frame. Within a few frames, edges cover
    /// all phases of texels.
    Pan,
    /// The camera turns by .1 degree a frame about the vertical.
    Yaw,
    /// The camera's vertical field of view widens from 75 to 90 degrees.
    Widening,
    /// The sun turns by .25 degree a frame about the vertical.
    Sun,
    /// All casters except the first object of the scene, its ground, move along x by 1.37 texels of
    /// the map a frame.
    Casters,
    /// The camera's projection is offset by a different fraction of a pixel in each frame, as in
    /// temporal antialiasing.
    Jitter,
}

/// A frame of a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionStep {
    /// Index of the frame, 0 for the first.
    pub index: u32,
    /// Number of frames in the motion.
    pub count: u32,
    /// The width of a texel of the first frame's map, metres: see [`texel_width`].
    pub texel: f64,
}

const fn moving_scene(
    row: u8,
    name: &'static str,
    scene: &'static str,
    motion: Motion,
    range: f32,
) -> MovingScene {
    MovingScene {
        name,
        row,
        scene,
        motion,
        range,
    }
}

impl MovingScene {
    /// Wires as thin as a texel.
    pub const FENCE_PAN: Self = moving_scene(9, "fence-pan", "fence", Motion::Pan, NEARBY);
    /// Alpha-tested wires on one quad.
    pub const WIRE_FENCE_PAN: Self =
        moving_scene(9, "wire-fence-pan", "wire-fence", Motion::Pan, NEARBY);
    /// A landscape under a low sun.
    pub const HILLS_PAN: Self = moving_scene(10, "hills-pan", "hills", Motion::Pan, LANDSCAPE);
    /// A landscape 100 km from the origin.
    pub const HILLS_1E5_PAN: Self =
        moving_scene(11, "hills-1e5-pan", "hills-1e5", Motion::Pan, LANDSCAPE);
    /// A landscape 1,000 km from the origin.
    pub const HILLS_1E6_PAN: Self =
        moving_scene(11, "hills-1e6-pan", "hills-1e6", Motion::Pan, LANDSCAPE);
    /// A camera that turns.
    pub const HILLS_YAW: Self = moving_scene(12, "hills-yaw", "hills", Motion::Yaw, LANDSCAPE);
    /// A field of view that widens.
    pub const HILLS_FOV: Self = moving_scene(12, "hills-fov", "hills", Motion::Widening, LANDSCAPE);
    /// A sun that turns.
    pub const HILLS_SUN: Self = moving_scene(13, "hills-sun", "hills", Motion::Sun, LANDSCAPE);
    /// A projection without a far plane.
    pub const HILLS_ENDLESS_PAN: Self = moving_scene(
        35,
        "hills-endless-pan",
        "hills-endless",
        Motion::Pan,
        LANDSCAPE,
    );
    /// Casters that move.
    pub const HILLS_CASTERS: Self =
        moving_scene(36, "hills-casters", "hills", Motion::Casters, LANDSCAPE);
    /// A projection with offsets within a pixel.
    pub const HILLS_JITTER: Self =
        moving_scene(37, "hills-jitter", "hills", Motion::Jitter, LANDSCAPE);

    /// Leaf cards with alpha tests, near and far.
    pub const FOLIAGE_PAN: Self =
        moving_scene(39, "foliage-pan", "foliage", Motion::Pan, LANDSCAPE);

    /// All of them, by rows.
    pub const ALL: [Self; 12] = [
        Self::FENCE_PAN,
        Self::WIRE_FENCE_PAN,
        Self::HILLS_PAN,
        Self::HILLS_1E5_PAN,
        Self::HILLS_1E6_PAN,
        Self::HILLS_YAW,
        Self::HILLS_FOV,
        Self::HILLS_SUN,
        Self::HILLS_ENDLESS_PAN,
        Self::HILLS_CASTERS,
        Self::HILLS_JITTER,
        Self::FOLIAGE_PAN,
    ];
}

impl Motion {
    /// Returns a short description for readers.
    pub fn label(self) -> &'static str {
        match self {
            Self::Still => "still",
            Self::Pan => "camera pans by .37 texels a frame",
            Self::Yaw => "camera yaws by .1 degree a frame",
            Self::Widening => "field of view opens from 75 to 90 degrees",
            Self::Sun => "sun turns by .25 degree a frame",
            Self::Casters => "casters move by 1.37 texels a frame",
            Self::Jitter => "projection jitters within a pixel",
        }
    }

    /// Reports whether true shadows move. Otherwise, the camera does.
    pub const fn moves_shadows(self) -> bool {
        matches!(self, Self::Sun | Self::Casters)
    }

    /// Reports whether points move to other pixels of the camera's images.
    pub fn moves_pixels(self) -> bool {
        matches!(self, Self::Pan | Self::Yaw | Self::Widening)
    }

    /// Returns the camera at the start of the motion.
    #[must_use]
    pub fn first_camera(self, camera: &Camera) -> Camera {
        if self == Self::Widening {
            with_fov(camera, FIRST_FOV)
        } else {
            *camera
        }
    }

    /// Returns a frame's camera; `first` is that of the first frame.
    #[must_use]
    pub fn camera(self, first: &Camera, step: &MotionStep) -> Camera {
        let steps = f64::from(step.index);
        match self {
            Self::Still | Self::Sun | Self::Casters => *first,
            Self::Jitter => first.nudged_by(jitter(step.index)),
            Self::Pan => pan_camera(first, steps * PAN_TEXELS * step.texel),
            Self::Yaw => yaw_camera(first, steps * YAW),
            Self::Widening => {
                // 0 at the first frame, 1 at the last.
                let part = steps / f64::from(step.count.max(2) - 1);
                with_fov(first, FIRST_FOV + part * (LAST_FOV - FIRST_FOV))
            }
        }
    }

    /// Returns a frame's light; `first` is that of the first frame.
    #[must_use]
    pub fn light(self, first: &Light, step: &MotionStep) -> Light {
        if self == Self::Sun {
            turn_light(first, f64::from(step.index) * TURN)
        } else {
            *first
        }
    }

    /// Returns a frame's scene; `first` is that of the first frame.
    #[must_use]
    pub fn scene(self, first: &Scene, step: &MotionStep) -> Scene {
        let mut scene = first.clone();
        if self == Self::Casters {
            let offset = f64::from(step.index) * CASTER_TEXELS * step.texel;
            // The first object is the ground.
            for instance in scene.instances.iter_mut().skip(1).filter(|i| i.casts) {
                instance.world_from_local.translation.x += offset as f32;
            }
        }
        scene
    }
}

/// Returns the width of a texel of a tight map of `size` texels a side, metres. Motions in texels
/// use this unit. `view` is that of the first frame, with its receivers.
///
/// # Errors
/// Returns an error if no map can be fitted to the view.
pub fn texel_width(view: &View<'_>, size: u32) -> Result<f64, RecipeError> {
    let spaces = Fit::Tight.light_spaces(Layout::Auto, view, size, 0.0)?;
    // Clip units per metre. A map is 2 clip units wide.
    let scale = spaces
        .spaces
        .first()
        .map_or(1.0, |space| f64::from(space.clip_from_view.x_axis.x));
    Ok(2.0 / (scale * f64::from(size)))
}

/// Returns the offset of a frame's projection for [`Motion::Jitter`], pixels, -.5 to .5 in each
/// direction: the sequence of Halton (1960) in bases 2 and 3, common in temporal antialiasing. The
/// first frame has no offset.
pub fn jitter(index: u32) -> Vec2 {
    if index == 0 {
        return Vec2::ZERO;
    }
    Vec2::new(
        radical_inverse(index, 2) - 0.5,
        radical_inverse(index, 3) - 0.5,
    )
}

/// Returns the digits of a number in a base, mirrored at the radix point: 6 is 110 in base 2, which
/// becomes .011 or .375.
fn radical_inverse(number: u32, base: u32) -> f32 {
    let mut rest = number;
    let mut place = 1.0_f32;
    let mut out = 0.0;
    while rest > 0 {
        place /= base as f32;
        out += (rest % base) as f32 * place;
        rest /= base;
    }
    out
}

/// Returns the camera with another vertical field of view, degrees, and the same aspect ratio.
fn with_fov(camera: &Camera, degrees: f64) -> Camera {
    let mut out = *camera;
    // A perspective matrix scales y by the cotangent of half the angle.
    let scale = (1.0 / (0.5 * degrees.to_radians()).tan()) as f32;
    out.clip_from_view.x_axis.x *= scale / out.clip_from_view.y_axis.y;
    out.clip_from_view.y_axis.y = scale;
    out
}

/// Returns the camera moved to its right by this many metres.
fn pan_camera(camera: &Camera, by: f64) -> Camera {
    let mut out = *camera;
    let right = out.world_from_view.matrix3.x_axis.as_dvec3().normalize();
    out.world_from_view.translation =
        (out.world_from_view.translation.as_dvec3() + right * by).as_vec3a();
    out
}

/// Returns the camera turned about the vertical.
fn yaw_camera(camera: &Camera, degrees: f64) -> Camera {
    let turn = Affine3A::from_quat(Quat::from_rotation_y(degrees.to_radians() as f32));
    let mut out = *camera;
    out.world_from_view.matrix3 = turn.matrix3 * out.world_from_view.matrix3;
    out
}

/// Returns a directional light turned about the vertical. Other lights don't change.
fn turn_light(light: &Light, degrees: f64) -> Light {
    match *light {
        Light::Directional {
            direction,
            angular_diameter,
        } => {
            let turn = DQuat::from_rotation_y(degrees.to_radians());
            Light::Directional {
                direction: (turn * direction.as_dvec3()).as_vec3(),
                angular_diameter,
            }
        }
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_runs_a_built_in_scene() {
        for (i, moving) in MovingScene::ALL.iter().enumerate() {
            let scene = crate::find(moving.scene).expect(moving.scene);
            assert!(moving.name.starts_with(scene.name), "{}", moving.name);
            assert_ne!(moving.motion, Motion::Still, "{}", moving.name);
            let before = &MovingScene::ALL[..i];
            assert!(
                before
                    .iter()
                    .all(|b| b.name != moving.name && b.row <= moving.row)
            );
        }
    }

    #[test]
    fn jitter_is_haltons() {
        let expected = [
            Vec2::ZERO,
            Vec2::new(0.5, 1.0 / 3.0) - 0.5,
            Vec2::new(0.25, 2.0 / 3.0) - 0.5,
            Vec2::new(0.75, 1.0 / 9.0) - 0.5,
        ];
        for (index, place) in (0..4).zip(expected) {
            assert!(jitter(index).distance(place) < 1e-6, "{index}");
        }
        assert_eq!(radical_inverse(6, 2), 0.375);
    }
}
