//! Storage of moments: 32-bit floats, or channels of 16 bits, which use half of the memory.

use crate::shadow_map::variants::constant;
use glam::{Vec2, Vec4};
use umbrage_core::{Module, SimdTask, module};

/// The WGSL half.
const STORED: Module = module!("stored");

/// Bits per moment in a map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum MomentPrecision {
    /// 32-bit floats.
    #[default]
    Bits32,
    /// 16 bits. Rounding hides receivers that are nearer to their blocker than some thousandths of
    /// the map's depth.
    Bits16,
}

/// Encoding of the channels of a texel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Encoding {
    /// Moments without an encoding.
    Floats,
    /// Depth and its square in 65536 steps each.
    Variance16,
    /// Four powers of depth, rotated so that each channel uses its full range, in 65536 steps each.
    Powers16,
    /// Floats without a sign: eight bits of exponent, eight of fraction.
    Exponentials16,
}

/// Returns the channels, 0..=1, of centred depth and its square.
///
/// The square has half the range of a depth from -1 to 1, so the same steps resolve it twice as
/// finely. The channels of depth z equal those of Peters and Klein 2015 for depths from 0 to 1
/// ("Moment shadow mapping", section 3.4).
#[inline(always)]
pub(crate) fn store_variance(moments: Vec2) -> Vec2 {
    Vec2::new(moments.x * 0.5 + 0.5, moments.y)
}

/// Inverts [`store_variance`]. The bounds have no effect, but keep drivers from factoring the 1 out
/// of differences of such depths.
#[inline(always)]
#[expect(
    clippy::manual_clamp,
    reason = "WGSL's min and max, in this order, also for NaN"
)]
pub(crate) fn load_variance(channels: Vec2) -> Vec2 {
    let depth = channels.x * 2.0 - 1.0;
    Vec2::new(depth.max(-1.0).min(1.0), channels.y)
}

/// Half of the square root of 3.
const HALF_ROOT_3: f32 = 0.866_025_4;
/// Two ninths of the square root of 3.
const ROOT_3_BY_4_5: f32 = 0.384_900_18;

/// Returns the channels, 0..=1, of four powers of centred depth.
///
/// Moments of depth are close to each other, so most of the range of four channels would be unused.
/// An affine map gives each channel its full range over all depths, with odd and even powers
/// separated (Peters, Münstermann, Wetzstein, Klein 2017, "Improved moment shadow maps for
/// translucent occluders, soft shadows and single scattering").
///
/// The bounds have no effect, but keep drivers from adding the half to one of the two products
/// first.
#[inline(always)]
#[expect(
    clippy::manual_clamp,
    reason = "WGSL's min and max, in this order, also for NaN"
)]
pub(crate) fn store_powers(b: Vec4) -> Vec4 {
    let first = (1.5 * b.x - 2.0 * b.z).max(-0.5).min(0.5);
    let third = (HALF_ROOT_3 * b.x - ROOT_3_BY_4_5 * b.z).max(-0.5).min(0.5);
    Vec4::new(
        first + 0.5,
        4.0 * b.y - 4.0 * b.w,
        third + 0.5,
        0.5 * b.y + 0.5 * b.w,
    )
}

/// Square root of 3.
const ROOT_3: f32 = 1.732_050_8;
/// Three quarters of the square root of 3.
const ROOT_3_BY_4_THIRDS: f32 = 1.299_038;
const THIRD: f32 = 0.333_333_34;

/// Inverts [`store_powers`], bounded likewise.
#[inline(always)]
pub(crate) fn load_powers(channels: Vec4) -> Vec4 {
    let first = channels.x - 0.5;
    let third = channels.z - 0.5;
    let moments = Vec4::new(
        ROOT_3 * third - THIRD * first,
        0.125 * channels.y + channels.w,
        ROOT_3_BY_4_THIRDS * third - 0.75 * first,
        channels.w - 0.125 * channels.y,
    );
    moments.max(Vec4::NEG_ONE).min(Vec4::ONE)
}

/// Returns the channel, 0..=1, of a positive number. It holds the exponent and the first eight bits
/// of the fraction, rounded to nearest, halves upwards, as an integer out of 65535.
///
/// Hardware half floats end at 65504, so that exponents would end at 5.5 (Lauritzen and McCool
/// 2008). The error of a depth is the relative error over the exponent. With an exponent of 40,
/// that error is smaller despite three bits of fraction less.
#[inline(always)]
pub(crate) fn store_exponential(value: f32) -> f32 {
    let rounded = value.to_bits().wrapping_add(0x4000) >> 15;
    rounded as f32 * (1.0 / 65_535.0)
}

/// Greatest channel, times 65535, of a finite number.
const GREATEST_FINITE: u32 = 0xfeff;

/// Inverts [`store_exponential`].
#[inline(always)]
pub(crate) fn load_exponential(channel: f32) -> f32 {
    let rounded = (channel.max(0.0) * 65_535.0 + 0.5) as u32;
    f32::from_bits(rounded.min(GREATEST_FINITE) << 15)
}

/// WGSL of `stored_moments` and `loaded_moments`.
const ENCODING: Module = module!("encoding");
const FLOATS: Module = constant!("ENCODING = FLOATS");
const VARIANCE_16: Module = constant!("ENCODING = VARIANCE_16");
const POWERS_16: Module = constant!("ENCODING = POWERS_16");
const EXPONENTIALS_16: Module = constant!("ENCODING = EXPONENTIALS_16");

impl Encoding {
    /// Returns the modules of two functions: `fn stored_moments(moments: vec4f) -> vec4f` returns
    /// the channels, `fn loaded_moments(channels: vec4f) -> vec4f` the moments.
    pub(crate) fn modules(self) -> Vec<Module> {
        let encoding = match self {
            Self::Floats => FLOATS,
            Self::Variance16 => VARIANCE_16,
            Self::Powers16 => POWERS_16,
            Self::Exponentials16 => EXPONENTIALS_16,
        };
        vec![encoding, STORED, ENCODING]
    }

    /// Returns the encoding for averaging channels. Affine maps commute with means, so their
    /// channels are averaged without decoding.
    pub(crate) fn of_means(self) -> Self {
        match self {
            Self::Floats | Self::Variance16 | Self::Powers16 => Self::Floats,
            Self::Exponentials16 => Self::Exponentials16,
        }
    }

    /// Converts the moments of some texels to channels, in place.
    #[inline(always)]
    pub(crate) fn store(self, texels: &mut [f32]) {
        match self {
            Self::Floats => {}
            Self::Variance16 => {
                for pair in texels.as_chunks_mut::<2>().0 {
                    *pair = store_variance(Vec2::from_array(*pair)).to_array();
                }
            }
            Self::Powers16 => {
                for texel in texels.as_chunks_mut::<4>().0 {
                    *texel = store_powers(Vec4::from_array(*texel)).to_array();
                }
            }
            Self::Exponentials16 => {
                for value in texels {
                    *value = store_exponential(*value);
                }
            }
        }
    }

    /// Converts the channels of some texels to moments, in place.
    #[inline(always)]
    pub(crate) fn load(self, texels: &mut [f32]) {
        match self {
            Self::Floats => {}
            Self::Variance16 => {
                for pair in texels.as_chunks_mut::<2>().0 {
                    *pair = load_variance(Vec2::from_array(*pair)).to_array();
                }
            }
            Self::Powers16 => {
                for texel in texels.as_chunks_mut::<4>().0 {
                    *texel = load_powers(Vec4::from_array(*texel)).to_array();
                }
            }
            Self::Exponentials16 => {
                for channel in texels {
                    *channel = load_exponential(*channel);
                }
            }
        }
    }
}

/// Conversion of moments to channels, in vector lanes.
pub(crate) struct Store<'a> {
    pub(crate) encoding: Encoding,
    pub(crate) texels: &'a mut [f32],
}

impl SimdTask for Store<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.encoding.store(self.texels);
    }
}

/// Conversion of channels to moments, in vector lanes.
pub(crate) struct Load<'a> {
    pub(crate) encoding: Encoding,
    pub(crate) texels: &'a mut [f32],
}

impl SimdTask for Load<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.encoding.load(self.texels);
    }
}

/// All twins of this module, for the tests that compare them.
#[cfg(feature = "testing")]
pub(crate) const TWINS: &[umbrage_core::Twin] = &[
    umbrage_core::twin!(STORED, store_variance(moments: Vec2) -> Vec2, needs []),
    umbrage_core::twin!(STORED, load_variance(channels: Vec2) -> Vec2, needs []),
    umbrage_core::twin!(STORED, store_powers(b: Vec4) -> Vec4, needs []),
    umbrage_core::twin!(STORED, load_powers(channels: Vec4) -> Vec4, needs []),
    umbrage_core::twin!(STORED, store_exponential(value: f32) -> f32, needs []),
    umbrage_core::twin!(STORED, load_exponential(channel: f32) -> f32, needs []),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filtering::moments::of_depth::{
        exponential_moments, power_moments, variance_moments,
    };

    /// Returns the nearest step of a 16-bit image.
    fn nearest_step(channel: f32) -> f32 {
        assert!((-1e-6..=1.000_001).contains(&channel), "{channel}");
        (channel.clamp(0.0, 1.0) * 65_535.0 + 0.5).floor() * (1.0 / 65_535.0)
    }

    fn through_encoding(encoding: Encoding, moments: &[f32]) -> Vec<f32> {
        let mut texels = moments.to_vec();
        encoding.store(&mut texels);
        texels
            .iter_mut()
            .for_each(|channel| *channel = nearest_step(*channel));
        encoding.load(&mut texels);
        texels
    }

    /// Channels of all depths are within 0 to 1 and reach both ends. Moments survive a round trip
    /// except for the effect of half a step.
    #[test]
    fn moments_come_back_but_for_half_a_step() {
        let half = 0.5 / 65_535.0;
        let depths = (0..=10_000).map(|i| i as f32 * 1e-4);
        let mut least = Vec4::ONE;
        let mut most = Vec4::ZERO;
        for depth in depths {
            let pair = variance_moments(depth).to_array();
            let got = through_encoding(Encoding::Variance16, &pair);
            assert!((got[0] - pair[0]).abs() <= 2.1 * half, "{depth}");
            assert!((got[1] - pair[1]).abs() <= 1.1 * half, "{depth}");

            let powers = power_moments(depth);
            let channels = store_powers(powers);
            least = least.min(channels);
            most = most.max(channels);
            let got = through_encoding(Encoding::Powers16, &powers.to_array());
            // The factors are the row sums of `load_powers`.
            for (i, factors) in [2.07, 1.13, 2.05, 1.13].into_iter().enumerate() {
                let off = (got[i] - powers[i]).abs();
                assert!(off <= factors * half + 4e-7, "{depth}: {off}");
            }

            let exponentials = exponential_moments(depth, 60.0, 60.0).to_array();
            let got = through_encoding(Encoding::Exponentials16, &exponentials);
            for (got, value) in got.iter().zip(exponentials) {
                let relative = got / value - 1.0;
                assert!(relative.abs() <= 1.0 / 512.0, "{depth}: {relative}");
            }
        }
        assert!(least.max_element() < 1e-6, "{least}");
        assert!(most.min_element() > 0.999_999, "{most}");
    }

    /// Every 16-bit number survives decoding and encoding.
    #[test]
    fn numbers_of_16_bits_are_kept() {
        for bits in 0..=GREATEST_FINITE {
            let value = f32::from_bits(bits << 15);
            let got = load_exponential(nearest_step(store_exponential(value)));
            assert_eq!(got, value, "{bits:x}");
        }
    }
}
