//! Moments of depth, which a map stores and averages before it is looked up.

use crate::filtering::moments::{
    exp2::power_of_two,
    stored::{Encoding, MomentPrecision},
};
use glam::{Vec2, Vec4};
use umbrage_core::{Format, Module, SimdTask, module};

/// WGSL half of the functions that read no image.
pub(crate) const MOMENTS_OF_DEPTH: Module = module!("of_depth");

/// Maps clip depth to centred depth, -1 at the near plane to 1 at the far plane. The squares of
/// floats are finest around 0, and variances are small differences of large squares.
#[inline(always)]
#[expect(
    clippy::manual_clamp,
    reason = "WGSL's min and max, in this order, also for NaN"
)]
pub(crate) fn centre_depth(depth: f32) -> f32 {
    2.0 * depth.max(0.0).min(1.0) - 1.0
}

/// Returns depth and its square (Donnelly and Lauritzen 2006, "Variance shadow maps").
#[inline(always)]
pub(crate) fn variance_moments(depth: f32) -> Vec2 {
    let z = centre_depth(depth);
    Vec2::new(z, z * z)
}

/// Returns a rising exponential of depth and its square, then a falling one and its square
/// (Lauritzen and McCool 2008, "Layered variance shadow maps", where the falling one is negative).
/// `rising` and `falling` are powers of two per unit of centred depth.
#[inline(always)]
pub(crate) fn exponential_moments(depth: f32, rising: f32, falling: f32) -> Vec4 {
    let z = centre_depth(depth);
    let up = power_of_two(rising * z);
    let down = power_of_two(-(falling * z));
    Vec4::new(up, up * up, down, down * down)
}

/// Returns depth and its second, third and fourth power (Peters and Klein 2015, "Moment shadow
/// mapping").
#[inline(always)]
pub(crate) fn power_moments(depth: f32) -> Vec4 {
    let z = centre_depth(depth);
    let square = z * z;
    Vec4::new(z, square, square * z, square * square)
}

/// Kind of the moments of depth in a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum MomentKind {
    /// Depth and its square.
    Variance,
    /// Rising exponential of depth, and its square: powers of two per unit of centred depth.
    OneExponential {
        /// Exponent of the rising exponential.
        rising: f32,
    },
    /// Rising and falling exponential of depth, each with its square.
    TwoExponentials {
        /// Exponent of the rising exponential.
        rising: f32,
        /// Exponent of the falling exponential.
        falling: f32,
    },
    /// The first four powers of depth.
    Powers,
}

impl MomentKind {
    /// Returns the image format of these moments.
    pub(crate) fn format(self, precision: MomentPrecision) -> Format {
        match (self, precision) {
            (Self::Variance | Self::OneExponential { .. }, MomentPrecision::Bits32) => Format::Rg32,
            (Self::Variance | Self::OneExponential { .. }, MomentPrecision::Bits16) => Format::Rg16,
            (Self::TwoExponentials { .. } | Self::Powers, MomentPrecision::Bits32) => {
                Format::Rgba32
            }
            (Self::TwoExponentials { .. } | Self::Powers, MomentPrecision::Bits16) => {
                Format::Rgba16
            }
        }
    }

    /// Returns the encoding of the channels.
    pub(crate) fn encoding(self, precision: MomentPrecision) -> Encoding {
        match (self, precision) {
            (_, MomentPrecision::Bits32) => Encoding::Floats,
            (Self::Variance, MomentPrecision::Bits16) => Encoding::Variance16,
            (Self::Powers, MomentPrecision::Bits16) => Encoding::Powers16,
            (
                Self::OneExponential { .. } | Self::TwoExponentials { .. },
                MomentPrecision::Bits16,
            ) => Encoding::Exponentials16,
        }
    }
}

/// Moments of a row of depths, which may be longer than the row of moments.
pub(super) struct MomentsOfRow<'a> {
    pub(super) kind: MomentKind,
    pub(super) depths: &'a [f32],
    pub(super) out: &'a mut [f32],
}

impl SimdTask for MomentsOfRow<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (pairs, _) = self.out.as_chunks_mut::<2>();
        match self.kind {
            MomentKind::Variance => {
                for (pair, &depth) in pairs.iter_mut().zip(self.depths) {
                    *pair = variance_moments(depth).to_array();
                }
            }
            MomentKind::OneExponential { rising } => {
                for (pair, &depth) in pairs.iter_mut().zip(self.depths) {
                    let up = power_of_two(rising * centre_depth(depth));
                    *pair = [up, up * up];
                }
            }
            MomentKind::TwoExponentials { rising, falling } => {
                let (texels, _) = self.out.as_chunks_mut::<4>();
                for (texel, &depth) in texels.iter_mut().zip(self.depths) {
                    *texel = exponential_moments(depth, rising, falling).to_array();
                }
            }
            MomentKind::Powers => {
                let (texels, _) = self.out.as_chunks_mut::<4>();
                for (texel, &depth) in texels.iter_mut().zip(self.depths) {
                    *texel = power_moments(depth).to_array();
                }
            }
        }
    }
}

/// All twins of this module, for the tests that compare them.
#[cfg(feature = "testing")]
pub(crate) const TWINS: &[umbrage_core::Twin] = &[
    umbrage_core::twin!(MOMENTS_OF_DEPTH, variance_moments(depth: f32) -> Vec2, needs [crate::filtering::moments::exp2::EXP2]),
    umbrage_core::twin!(MOMENTS_OF_DEPTH, exponential_moments(depth: f32, rising: f32, falling: f32) -> Vec4, needs [crate::filtering::moments::exp2::EXP2]),
    umbrage_core::twin!(MOMENTS_OF_DEPTH, power_moments(depth: f32) -> Vec4, needs [crate::filtering::moments::exp2::EXP2]),
];
