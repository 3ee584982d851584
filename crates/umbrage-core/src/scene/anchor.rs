//! Large worlds: positions relative to a point near the eye.
//!
//! The rest of the library uses 32-bit positions. Scene files (their key `anchor`) and
//! `LightSet::rebase_caster` are the only users of anchors. All layers are redrawn after a change
//! of the anchor. Stable fits count their texels from the anchor, so a change moves them by part of
//! a texel.

use crate::invalid::Invalid;
use glam::{Affine3A, DAffine3, DVec3, Vec3};

/// A point of the world near the eye, relative to which positions are stored. It keeps the
/// library's 32-bit positions small.
///
/// At 1e6 m from the origin, 32-bit positions are 6 cm apart. Within 2,048 m of an anchor they are
/// at most 0.12 mm apart. A program keeps its positions in 64 bits, and converts them with the
/// anchor before passing them to the library: casters, lights, the camera, and shader inputs. The
/// library's world space is then relative to the anchor.
///
/// Anchors are whole multiples of [`Anchor::STEP`] along each axis. Positions that are multiples of
/// a power of two are therefore converted exactly. Objects at the same offset from their anchor
/// have bit-equal shadows everywhere.
///
/// ```
/// use glam::{Affine3A, DAffine3, DVec3, UVec2, Vec3};
/// use umbrage_core::{Anchor, Camera, Instance, Light};
///
/// // In world space, metres.
/// let eye = DVec3::new(1e6, 1.7, -2e6);
/// let lamp = DVec3::new(1e6 + 3.0, 4.0, -2e6);
/// let crate_place = DAffine3::from_translation(DVec3::new(1e6, 0.5, -2e6 - 6.0));
///
/// let anchor = Anchor::nearest_to(eye)?;
/// assert_eq!(anchor.point(), DVec3::new(1_000_448.0, 0.0, -1_999_872.0));
///
/// let light = Light::Point { position: anchor.position(lamp), radius: 0.1 };
/// let instance = Instance::new(0, anchor.placement(&crate_place));
/// let target = anchor.position(crate_place.translation);
/// let size = UVec2::new(640, 360);
/// let near_far = [0.1, 100.0];
/// let eye_position = anchor.position(eye);
/// let camera = Camera::perspective(eye_position, target, Vec3::Y, 0.9, near_far, size)?;
/// # assert_eq!(instance.world_from_local.translation, glam::Vec3A::new(-448.0, 0.5, -134.0));
/// # assert_eq!(light.position(), Some(Vec3::new(-445.0, 4.0, -128.0)));
/// # assert_eq!(anchor.position(eye), Vec3::new(-448.0, 1.7, -128.0));
/// # // The camera stores a matrix, whose inverse has the eye to within rounding.
/// # assert!(camera.eye().distance(anchor.position(eye)) < 1e-5);
///
/// // In the next frame, keep the anchor while the eye is near enough.
/// let walked = eye + DVec3::new(700.0, 0.0, 0.0);
/// assert_eq!(anchor.kept_for(walked)?, anchor);
/// # Ok::<(), umbrage_core::Invalid>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Anchor {
    /// World space, metres.
    point: DVec3,
}

impl Anchor {
    /// Distance between neighbouring anchors along each axis, metres.
    pub const STEP: f64 = 1024.0;
    /// Greatest distance of the eye from a held anchor, metres. It exceeds the 0.87 steps within
    /// which a new anchor is, so that small movements to and fro don't change the anchor.
    pub const REACH: f64 = 1.5 * Self::STEP;
    /// Greatest coordinate, metres. Beyond it, some multiples of the step are not exact in 64 bits.
    pub const MAX: f64 = Self::STEP * (1_u64 << f64::MANTISSA_DIGITS) as f64;
    /// The world's origin, for small worlds.
    pub const ORIGIN: Self = Self { point: DVec3::ZERO };

    /// Returns the anchor nearest to the eye (world space, metres).
    ///
    /// # Errors
    /// Errors if a coordinate is not finite or beyond [`Anchor::MAX`].
    pub fn nearest_to(eye: DVec3) -> Result<Self, Invalid> {
        check(eye)?;
        let steps = (eye / Self::STEP).round();
        Ok(Self {
            point: steps * Self::STEP,
        })
    }

    /// Returns this anchor while the eye (world space, metres) is within [`Anchor::REACH`] of it,
    /// otherwise the one nearest to the eye.
    ///
    /// # Errors
    /// Errors if [`Anchor::nearest_to`] does.
    pub fn kept_for(self, eye: DVec3) -> Result<Self, Invalid> {
        check(eye)?;
        if eye.distance(self.point) <= Self::REACH {
            return Ok(self);
        }
        Self::nearest_to(eye)
    }

    /// Returns the position of the anchor, world space, metres.
    pub const fn point(self) -> DVec3 {
        self.point
    }

    /// Returns a position (world space, metres) relative to the anchor: a difference in 64 bits,
    /// rounded once to 32. It is not finite if the position isn't or exceeds 32 bits; functions
    /// that use positions reject it.
    pub fn position(self, world: DVec3) -> Vec3 {
        (world - self.point).as_vec3()
    }

    /// Returns a placement (world from local, metres) relative to the anchor, of an instance, a
    /// caster, or a camera ([`Camera::world_from_view`](crate::Camera::world_from_view)).
    /// Differences are computed in 64 bits; each number is rounded once to 32.
    pub fn placement(self, world_from_local: &DAffine3) -> Affine3A {
        let matrix = world_from_local.matrix3.as_mat3();
        Affine3A::from_mat3_translation(matrix, self.position(world_from_local.translation))
    }
}

/// Errors unless all multiples of the step around the eye are exact in 64 bits.
fn check(eye: DVec3) -> Result<(), Invalid> {
    // Comparisons with NaN are false.
    if eye.abs().cmple(DVec3::splat(Anchor::MAX)).all() {
        return Ok(());
    }
    let why = format!("is at {eye}");
    let help = format!("use finite coordinates up to {:e} m", Anchor::MAX);
    Err(Invalid::new("eye", why, help))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn anchor_near(x: f64, y: f64, z: f64) -> Anchor {
        Anchor::nearest_to(DVec3::new(x, y, z)).expect("a good eye")
    }

    #[test]
    fn anchors_are_the_nearest_multiples() {
        let point = DVec3::new(1024.0, 0.0, -2048.0);
        assert_eq!(anchor_near(513.0, -511.0, -1537.0).point(), point);
        assert_eq!(anchor_near(0.0, 0.0, 0.0), Anchor::ORIGIN);
        assert_eq!(anchor_near(1e6, -1e6, 300.0).point().x, 977.0 * 1024.0);
    }

    #[test]
    fn an_eye_that_goes_to_and_fro_keeps_its_anchor() {
        let mut anchor = Anchor::ORIGIN;
        let mut hops = Vec::new();
        // Move out to 4 km and back, and to and fro around each position.
        let out = 0..400;
        let back = (0..400).rev();
        for metres in out.chain(back).map(|i| 10.0 * f64::from(i)) {
            for sway in [-200.0, 200.0, 0.0] {
                let held = anchor
                    .kept_for(DVec3::new(metres + sway, 0.0, 0.0))
                    .expect("a good eye");
                if held != anchor {
                    hops.push(held.point().x);
                }
                anchor = held;
            }
        }
        let [outwards, homewards] = [[2048.0, 4096.0], [2048.0, 0.0]];
        assert_eq!(hops, [outwards, homewards].concat());
    }

    #[test]
    fn eyes_that_have_no_anchor_are_refused() {
        let most = Anchor::MAX;
        assert_eq!(anchor_near(most, -most, 0.0).point().x, most);
        // Up to there every multiple is exact: it differs from the previous one.
        assert_eq!(most - (most - Anchor::STEP), Anchor::STEP);
        for x in [f64::NAN, f64::INFINITY, -f64::INFINITY, most * 1.001] {
            for eye in [DVec3::new(x, 0.0, 0.0), DVec3::new(0.0, 1.0, x)] {
                let why = Anchor::nearest_to(eye).expect_err("no anchor").to_string();
                assert!(why.contains("use finite coordinates up to 9.2"), "{why}");
                assert_eq!(Anchor::ORIGIN.kept_for(eye), Anchor::nearest_to(eye));
            }
        }
    }
}
