//! Whole numbers in floats: conversions that loops over many receivers can do in vector lanes.

/// Adding 2^23 moves a whole number into the mantissa's low bits.
const TWO_POW_23: f32 = 8_388_608.0;

/// Returns the whole number at or below `x`: exact for |x| < 2^22; maps are far smaller.
///
/// Adding 1.5 * 2^23 leaves no bits for a fraction, so the sum is rounded to the nearest whole
/// number. `f32::floor` is a call on processors without such an instruction, and calls do not
/// vectorise.
#[inline(always)]
pub(crate) fn floor(x: f32) -> f32 {
    let nearest = (x + 1.5 * TWO_POW_23) - 1.5 * TWO_POW_23;
    if nearest > x { nearest - 1.0 } else { nearest }
}

/// Converts a whole number from 0 to [`TWO_POW_23`] to an integer.
///
/// Not by `as`, which saturates and does not vectorise.
#[inline(always)]
pub(crate) fn whole_to_u32(x: f32) -> u32 {
    (x + TWO_POW_23)
        .to_bits()
        .wrapping_sub(TWO_POW_23.to_bits())
}
