//! Worlds larger than 32-bit numbers can describe: positions relative to a point near the eye.
//!
//! All else in the library is 32-bit. Scene files (their key `anchor`) and
//! `LightSet::rebase_caster` are the only users of anchors: after a hop all layers are drawn again.
//! Stable fits count their texels from the anchor, so a hop moves them by part of a texel.

use crate::invalid::Invalid;
use glam::{Affine3A, DAffine3, DVec3, Vec3};

/// A point of the world near the eye, from which positions are counted, so that the library's
/// 32-bit positions stay small.
///
/// At 1e6 m from the origin 32-bit positions are 6 cm apart; within 2,048 m of an anchor they are
/// at most .12 mm apart. A program keeps its positions in 64 bits, and hands the library what an
/// anchor makes of them: casters, lights, the camera, and what its shaders ask for. All that the
/// library calls world space is then relative to the anchor.
///
/// Anchors are whole multiples of [`Anchor::STEP`] along each axis. So a position that is a
/// multiple of a power of two is relative to all anchors without an error, and what stands at the
/// same place from its anchor has the same shadows everywhere, bit for bit.
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
/// let anchor = Anchor::near(eye)?;
/// assert_eq!(anchor.point(), DVec3::new(1_000_448.0, 0.0, -1_999_872.0));
///
/// let light = Light::Point { position: anchor.position(lamp), radius: 0.1 };
/// let instance = Instance::new(0, anchor.placement(&crate_place));
/// let target = anchor.position(crate_place.translation);
/// let camera = Camera::perspective(anchor.position(eye), target, Vec3::Y, 0.9, [0.1, 100.0], UVec2::new(640, 360))?;
/// # assert_eq!(instance.world_from_local.translation, glam::Vec3A::new(-448.0, 0.5, -134.0));
/// # assert_eq!(light.position(), Some(Vec3::new(-445.0, 4.0, -128.0)));
/// # assert_eq!(anchor.position(eye), Vec3::new(-448.0, 1.7, -128.0));
/// # // The camera keeps a matrix, whose inverse has the eye to within rounding.
/// # assert!(camera.eye().distance(anchor.position(eye)) < 1e-5);
///
/// // In the next frame, the same anchor while the eye is near enough.
/// let walked = eye + DVec3::new(700.0, 0.0, 0.0);
/// assert_eq!(anchor.held(walked)?, anchor);
/// # Ok::<(), umbrage_core::Invalid>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Anchor {
    /// World space, metres.
    point: DVec3,
}

impl Anchor {
    /// Metres between neighbouring anchors along each axis.
    pub const STEP: f64 = 1024.0;
    /// How far the eye may go from an anchor that is held, metres. More than the .87 steps within
    /// which a new one is, so that an eye that goes to and fro keeps its anchor.
    pub const REACH: f64 = 1.5 * Self::STEP;
    /// The greatest coordinate, metres: beyond it, not all multiples of the step are 64-bit
    /// numbers.
    pub const MAX: f64 = Self::STEP * (1_u64 << f64::MANTISSA_DIGITS) as f64;
    /// The world's origin, for worlds that need no other.
    pub const ORIGIN: Self = Self { point: DVec3::ZERO };

    /// Returns the anchor nearest to the eye (world space, metres).
    ///
    /// # Errors
    /// Errors if a coordinate is not finite or beyond [`Anchor::MAX`].
    pub fn near(eye: DVec3) -> Result<Self, Invalid> {
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
    /// Errors if [`Anchor::near`] does.
    pub fn held(self, eye: DVec3) -> Result<Self, Invalid> {
        check(eye)?;
        if eye.distance(self.point) <= Self::REACH {
            return Ok(self);
        }
        Self::near(eye)
    }

    /// Returns where the anchor is, world space, metres.
    pub const fn point(self) -> DVec3 {
        self.point
    }

    /// Returns a position (world space, metres) relative to the anchor: the difference, taken in 64
    /// bits, rounded once to 32. It is not finite if the position isn't or 32 bits can't hold it,
    /// which all that takes positions refuses.
    pub fn position(self, world: DVec3) -> Vec3 {
        (world - self.point).as_vec3()
    }

    /// Returns a placement (world from local, metres) relative to the anchor, of an instance, a
    /// caster, or a camera ([`Camera::world_from_view`](crate::Camera::world_from_view)).
    /// Differences are taken in 64 bits; each number is rounded once to 32.
    pub fn placement(self, world_from_local: &DAffine3) -> Affine3A {
        let matrix = world_from_local.matrix3.as_mat3();
        Affine3A::from_mat3_translation(matrix, self.position(world_from_local.translation))
    }
}

/// Errors unless all multiples of the step are 64-bit numbers around the eye.
fn check(eye: DVec3) -> Result<(), Invalid> {
    // No comparison holds for what is not a number.
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

    fn near(x: f64, y: f64, z: f64) -> Anchor {
        Anchor::near(DVec3::new(x, y, z)).expect("a good eye")
    }

    #[test]
    fn anchors_are_the_nearest_multiples() {
        let point = DVec3::new(1024.0, 0.0, -2048.0);
        assert_eq!(near(513.0, -511.0, -1537.0).point(), point);
        assert_eq!(near(0.0, 0.0, 0.0), Anchor::ORIGIN);
        assert_eq!(near(1e6, -1e6, 300.0).point().x, 977.0 * 1024.0);
    }

    #[test]
    fn an_eye_that_goes_to_and_fro_keeps_its_anchor() {
        let mut anchor = Anchor::ORIGIN;
        let mut hops = Vec::new();
        // Out to 4 km and back, and to and fro about each place.
        let out = 0..400;
        let back = (0..400).rev();
        for metres in out.chain(back).map(|i| 10.0 * f64::from(i)) {
            for sway in [-200.0, 200.0, 0.0] {
                let held = anchor
                    .held(DVec3::new(metres + sway, 0.0, 0.0))
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
        assert_eq!(near(most, -most, 0.0).point().x, most);
        // Up to there every multiple is a number: the one before differs.
        assert_eq!(most - (most - Anchor::STEP), Anchor::STEP);
        for x in [f64::NAN, f64::INFINITY, -f64::INFINITY, most * 1.001] {
            for eye in [DVec3::new(x, 0.0, 0.0), DVec3::new(0.0, 1.0, x)] {
                let why = Anchor::near(eye).expect_err("no anchor").to_string();
                assert!(why.contains("use finite coordinates up to 9.2"), "{why}");
                assert_eq!(Anchor::ORIGIN.held(eye), Anchor::near(eye));
            }
        }
    }
}
