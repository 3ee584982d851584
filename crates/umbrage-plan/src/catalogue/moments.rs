//! What `vsm`, `evsm` and `msm` have in common.

use super::ClosedFormDemand;
use umbrage_core::ShadowTechnique;
use umbrage_techniques::{MomentPrecision, ShadowMap};

/// How far from light or darkness a bound may be where a formula knows either: what is mixed into moments, the least variance, and the
/// variance of curved surfaces leave a little of both.
const CLOSED_FORM_TOLERANCE: f32 = 0.05;

/// The precisions and counts of mipmaps that differ in code path, besides the default ones.
pub(super) const STORAGES: [(MomentPrecision, u32); 3] = [
    (MomentPrecision::Bits16, 0),
    (MomentPrecision::Bits32, 3),
    (MomentPrecision::Bits16, 2),
];

/// Returns the map for closed forms: of half the side, as each of its texels is averaged with 48
/// others, on software drivers, too.
pub(super) fn closed_form_map(map: ShadowMap) -> ShadowMap {
    ShadowMap {
        size: map.size / 2,
        ..map
    }
}

/// Returns what closed forms demand of a technique that looks up moments.
pub(super) fn closed_form_demand<T: ShadowTechnique>(technique: T) -> Option<ClosedFormDemand<T>> {
    let reach = technique.kernel_reach()?;
    Some(ClosedFormDemand {
        tolerance: CLOSED_FORM_TOLERANCE,
        ..ClosedFormDemand::new(technique, reach)
    })
}

/// Returns what a random switch ([`RandomParameter::Switch`](super::RandomParameter::Switch))
/// chooses.
pub(super) fn precision_of_switch(number: f32) -> MomentPrecision {
    if number > 0.0 {
        MomentPrecision::Bits16
    } else {
        MomentPrecision::Bits32
    }
}
