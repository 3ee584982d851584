//! Integer-valued floats: conversions that compilers vectorise in loops over many receivers.

/// Constant whose addition moves an integer value into the mantissa's low bits.
const TWO_POW_23: f32 = 8_388_608.0;

/// Returns the greatest integer at or below `x`, exact for |x| < 2^22. Maps are far smaller.
///
/// Adding 1.5 * 2^23 leaves no bits for a fraction, so the sum is rounded to the nearest integer.
/// `f32::floor` is a call on processors without such an instruction, and calls do not vectorise.
#[inline(always)]
pub(crate) fn floor(x: f32) -> f32 {
    let nearest = (x + 1.5 * TWO_POW_23) - 1.5 * TWO_POW_23;
    if nearest > x { nearest - 1.0 } else { nearest }
}

/// Converts an integer value from 0 to [`TWO_POW_23`] to an integer.
///
/// This avoids `as`, which saturates and does not vectorise.
#[inline(always)]
pub(crate) fn whole_to_u32(x: f32) -> u32 {
    (x + TWO_POW_23)
        .to_bits()
        .wrapping_sub(TWO_POW_23.to_bits())
}
