//! Power of two, with the same bits in both halves and on every driver that rounds sums and
//! products according to IEEE 754. Shading languages allow drivers an error of several units in the
//! last place for `exp` and `exp2`.

use umbrage_core::{Module, module};

/// The WGSL half.
pub(crate) const EXP2: Module = module!("exp2");

/// Greatest absolute exponent; powers beyond are not normal numbers.
const GREATEST_POWER: f32 = 126.0;

/// Returns 2 to the power `exponent`, with a relative error below 1.3e-7. The exponent is clamped
/// to -126..=126.
///
/// The integer part becomes the exponent bits of the result. The remainder, -0.5 to 0.5, is the
/// argument of a polynomial of degree 6 with the least maximum relative error (2e-9 before
/// rounding).
#[inline(always)]
#[expect(
    clippy::manual_clamp,
    reason = "WGSL's min and max, in this order, also for NaN"
)]
pub(crate) fn power_of_two(exponent: f32) -> f32 {
    let t = exponent.max(-GREATEST_POWER).min(GREATEST_POWER);
    let whole = (t + 0.5).floor();
    let rest = t - whole;
    // Use Horner's scheme; each product is rounded before the sum.
    let mut sum = 1.535_336_2e-4;
    sum = sum * rest + 1.339_887_5e-3;
    sum = sum * rest + 9.618_437e-3;
    sum = sum * rest + 5.550_332_4e-2;
    sum = sum * rest + 2.402_264_8e-1;
    sum = sum * rest + 6.931_472e-1;
    sum = sum * rest + 1.0;
    let exponent_bits = (whole as i32) << 23;
    f32::from_bits((sum.to_bits().cast_signed() + exponent_bits).cast_unsigned())
}

/// All twins of this module, for the tests that compare them.
#[cfg(feature = "testing")]
pub(crate) const TWINS: &[umbrage_core::Twin] =
    &[umbrage_core::twin!(EXP2, power_of_two(exponent: f32) -> f32, needs [])];

#[cfg(test)]
mod tests {
    use super::power_of_two;

    #[test]
    fn powers_are_those_of_the_standard_library() {
        for i in -125_999..126_000 {
            let exponent = i as f32 * 1e-3;
            let exact = f64::from(exponent).exp2();
            let off = f64::from(power_of_two(exponent)) / exact - 1.0;
            assert!(off.abs() < 1.3e-7, "2^{exponent}: off by {off:e}");
        }
        assert_eq!([-3.0, 0.0, 10.0].map(power_of_two), [0.125, 1.0, 1024.0]);
        for beyond in [126.5, 1e30, f32::INFINITY] {
            assert_eq!(power_of_two(beyond), power_of_two(126.0));
            assert_eq!(power_of_two(-beyond), power_of_two(-126.0));
        }
    }
}
