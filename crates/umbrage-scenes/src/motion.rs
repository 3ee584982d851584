//! Built-in scenes in motion: which cases of the catalogue of failures move, and where camera,
//! light and casters are in each frame.

use umbrage_core::glam::{Affine3A, DQuat, Quat, Vec2};
use umbrage_core::{Camera, Fit, Layout, Light, RecipeError, Scene, View};

/// Texels that the camera pans by from a frame to the next.
const PAN_TEXELS: f64 = 0.37;
/// Texels that casters move by from a frame to the next: more than one, so that no frame may rest,
/// and no whole number.
const CASTER_TEXELS: f64 = 1.37;
/// Degrees that the camera yaws by from a frame to the next.
const YAW: f64 = 0.1;
/// Degrees that the sun turns by from a frame to the next.
const TURN: f64 = 0.25;
/// Vertical field of view of the first frame of a widening, degrees.
const FIRST_FOV: f64 = 75.0;
/// Vertical field of view of the last frame of a widening, degrees.
const LAST_FOV: f64 = 90.0;

/// How deep steady fits reach in views a few metres deep, metres.
const NEARBY: f32 = 8.0;
/// How deep they reach in landscapes.
const LANDSCAPE: f32 = 160.0;

/// A built-in scene in which something moves: a case of the catalogue of failures.
#[derive(Clone, Copy, Debug)]
pub struct MovingScene {
    /// Lower case with dashes.
    pub name: &'static str,
    /// Its row in the catalogue of failures.
    pub row: u8,
    /// The built-in scene.
    pub scene: &'static str,
    /// What moves.
    pub motion: Motion,
    /// The range of a fit that holds maps still while the camera moves, metres: [`Fit::Stable`].
    pub range: f32,
}

/// What moves from frame to frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// Nothing.
    Still,
    /// The camera moves sideways by .37 texels of the map a frame: within a few frames edges have
    /// met texels in all phases.
    Pan,
    /// The camera turns by .1 degree a frame about the vertical.
    Yaw,
    /// The camera's vertical field of view opens from 75 to 90 degrees.
    Widening,
    /// The sun turns by .25 degree a frame about the vertical.
    Sun,
    /// All that casts but the first thing of the scene, its ground, moves along x by 1.37 texels of
    /// the map a frame.
    Casters,
    /// The camera's projection is moved by parts of a pixel, another way in each frame, as temporal
    /// antialiasing does.
    Jitter,
}

/// Which frame of a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionStep {
    /// 0 for the first.
    pub index: u32,
    /// How many frames the motion has.
    pub count: u32,
    /// The width of a texel of the first frame's map, metres: see [`texel_width`].
    pub texel: f64,
}

const fn moving(
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
    pub const FENCE_PAN: Self = moving(9, "fence-pan", "fence", Motion::Pan, NEARBY);
    /// Wires cut out of one quad.
    pub const WIRE_FENCE_PAN: Self = moving(9, "wire-fence-pan", "wire-fence", Motion::Pan, NEARBY);
    /// A landscape under a low sun.
    pub const HILLS_PAN: Self = moving(10, "hills-pan", "hills", Motion::Pan, LANDSCAPE);
    /// The same 100 km from the origin.
    pub const HILLS_1E5_PAN: Self =
        moving(11, "hills-1e5-pan", "hills-1e5", Motion::Pan, LANDSCAPE);
    /// The same 1,000 km from the origin.
    pub const HILLS_1E6_PAN: Self =
        moving(11, "hills-1e6-pan", "hills-1e6", Motion::Pan, LANDSCAPE);
    /// A camera that turns.
    pub const HILLS_YAW: Self = moving(12, "hills-yaw", "hills", Motion::Yaw, LANDSCAPE);
    /// A field of view that opens.
    pub const HILLS_FOV: Self = moving(12, "hills-fov", "hills", Motion::Widening, LANDSCAPE);
    /// A sun that turns.
    pub const HILLS_SUN: Self = moving(13, "hills-sun", "hills", Motion::Sun, LANDSCAPE);
    /// A projection without a far plane.
    pub const HILLS_ENDLESS_PAN: Self = moving(
        35,
        "hills-endless-pan",
        "hills-endless",
        Motion::Pan,
        LANDSCAPE,
    );
    /// Casters that move.
    pub const HILLS_CASTERS: Self =
        moving(36, "hills-casters", "hills", Motion::Casters, LANDSCAPE);
    /// A projection that is moved within a pixel.
    pub const HILLS_JITTER: Self = moving(37, "hills-jitter", "hills", Motion::Jitter, LANDSCAPE);

    /// Leaf cards with holes, near and far.
    pub const FOLIAGE_PAN: Self = moving(39, "foliage-pan", "foliage", Motion::Pan, LANDSCAPE);

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
    /// Returns a short description for people.
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

    /// Whether true shadows move; else the camera does.
    pub const fn moves_shadows(self) -> bool {
        matches!(self, Self::Sun | Self::Casters)
    }

    /// Whether the camera's pictures show points at other pixels from frame to frame.
    pub fn moves_pixels(self) -> bool {
        matches!(self, Self::Pan | Self::Yaw | Self::Widening)
    }

    /// Returns the camera that the motion starts from.
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
            Self::Jitter => first.nudged(jitter(step.index)),
            Self::Pan => panned(first, steps * PAN_TEXELS * step.texel),
            Self::Yaw => yawed(first, steps * YAW),
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
            turned(first, f64::from(step.index) * TURN)
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
            // The first thing is the ground.
            for instance in scene.instances.iter_mut().skip(1).filter(|i| i.casts) {
                instance.world_from_local.translation.x += offset as f32;
            }
        }
        scene
    }
}

/// Returns the width of a texel of a tight map of `size` texels a side, metres: the unit of what
/// moves by texels. `view` is the first frame's, with its receivers.
///
/// # Errors
/// Errors if no map can be fitted to the view.
pub fn texel_width(view: &View<'_>, size: u32) -> Result<f64, RecipeError> {
    let spaces = Fit::Tight.light_spaces(Layout::Auto, view, size, 0.0)?;
    // Clip units, of which a map is 2 wide, for each metre.
    let scale = spaces
        .spaces
        .first()
        .map_or(1.0, |space| f64::from(space.clip_from_view.x_axis.x));
    Ok(2.0 / (scale * f64::from(size)))
}

/// Returns how a frame's projection is moved by [`Motion::Jitter`], pixels, -.5 to .5 each way: the
/// sequence of Halton (1960) in bases 2 and 3, which temporal antialiasing commonly takes. The
/// first frame has none.
pub fn jitter(index: u32) -> Vec2 {
    if index == 0 {
        return Vec2::ZERO;
    }
    Vec2::new(
        radical_inverse(index, 2) - 0.5,
        radical_inverse(index, 3) - 0.5,
    )
}

/// Returns the digits of a number in a base, mirrored at the point: 6 is 110 in base 2, and becomes
/// .011, which is .375.
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
fn panned(camera: &Camera, by: f64) -> Camera {
    let mut out = *camera;
    let right = out.world_from_view.matrix3.x_axis.as_dvec3().normalize();
    out.world_from_view.translation =
        (out.world_from_view.translation.as_dvec3() + right * by).as_vec3a();
    out
}

/// Returns the camera turned about the vertical.
fn yawed(camera: &Camera, degrees: f64) -> Camera {
    let turn = Affine3A::from_quat(Quat::from_rotation_y(degrees.to_radians() as f32));
    let mut out = *camera;
    out.world_from_view.matrix3 = turn.matrix3 * out.world_from_view.matrix3;
    out
}

/// Returns a directional light turned about the vertical; other lights stay.
fn turned(light: &Light, degrees: f64) -> Light {
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
    fn each_plays_a_built_in_scene() {
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
