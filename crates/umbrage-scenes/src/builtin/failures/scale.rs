//! The textbook's cubes at a thousandth and at ten thousand times their size.

use crate::builtin::textbook::{cubes_at, textbook_fit};
use umbrage_core::{Fit, Scene};

const TINY: f32 = 1e-3;
const HUGE: f32 = 1e4;

/// The textbook's fit for the tiny cubes.
pub(crate) const TINY_FIT: Fit = textbook_fit(TINY);
/// The textbook's fit for the huge cubes.
pub(crate) const HUGE_FIT: Fit = textbook_fit(HUGE);

pub(crate) fn tiny() -> Scene {
    cubes_at("cubes-tiny", TINY)
}

pub(crate) fn huge() -> Scene {
    cubes_at("cubes-huge", HUGE)
}
