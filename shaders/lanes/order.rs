//! The greater and the lesser of two numbers as vector instructions have them: loops with these become such instructions, where
//! `f32::max`, which has a rule for what is not a number, takes several.

/// Returns the greater of two numbers; the second where one is not a number.
#[inline(always)]
pub(crate) fn greater(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Returns the lesser of two numbers, likewise.
#[inline(always)]
pub(crate) fn lesser(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}
