//! Shared parts of the entries of `vsm`, `evsm` and `msm`.

use super::{CataloguedTechnique, ClosedFormDemand, kernel::KernelCost};
use std::any::Any;
use umbrage_core::FilterKernel;
use umbrage_techniques::{HalveKernel, HalveUniforms, MomentMapKernel, MomentPrecision, ShadowMap};

/// Greatest distance of a bound from light or darkness where a formula is exact. Rounding terms in
/// the moments, the least variance, and the variance of curved surfaces cause it.
const CLOSED_FORM_TOLERANCE: f32 = 0.05;

/// Precisions and numbers of mipmaps with a different code path, other than the default ones.
pub(super) const STORAGES: [(MomentPrecision, u32); 3] = [
    (MomentPrecision::Bits16, 0),
    (MomentPrecision::Bits32, 3),
    (MomentPrecision::Bits16, 2),
];

/// Returns the map for closed forms. It has half the side, since each texel is averaged with 48
/// others, also on software drivers.
pub(super) fn closed_form_map(map: ShadowMap) -> ShadowMap {
    ShadowMap {
        size: map.size / 2,
        ..map
    }
}

/// Returns the requirements of closed forms for a technique that looks up moments.
pub(super) fn closed_form_demand<T: CataloguedTechnique>(
    technique: T,
) -> Option<ClosedFormDemand<T>> {
    let reach = technique.kernel_reach()?;
    Some(ClosedFormDemand {
        tolerance: CLOSED_FORM_TOLERANCE,
        ..ClosedFormDemand::new(technique, reach)
    })
}

/// Returns the reach of a lookup beyond the receiver's own texel, texels: that of the blur, plus
/// one for the blend of four texels.
pub(super) fn kernel_reach(blur: u32) -> f32 {
    blur as f32 + 1.0
}

/// Returns the cost of a lookup: four texels of one level, or of two if there are several levels.
pub(super) fn lookup_cost(levels: u32) -> KernelCost {
    KernelCost::taps(if levels > 0 { 8 } else { 4 })
}

/// Implements [`CataloguedKernel`](crate::catalogue::CataloguedKernel) for a kernel that looks up
/// moments.
macro_rules! catalogued_kernel {
    ($kernel:ty) => {
        impl crate::catalogue::kernel::CataloguedKernel for $kernel {
            fn cost_per_receiver(&self) -> crate::catalogue::kernel::KernelCost {
                crate::catalogue::moments::lookup_cost(self.uniforms.mipmaps.levels)
            }

            fn reach(&self, position: glam::Vec3, normal: glam::Vec3) -> Option<f32> {
                self.lookup_reach(position, normal)
            }

            fn layer(&self, position: glam::Vec3) -> Option<u32> {
                Some(self.uniforms.lookup.layer_of(position))
            }
        }
    };
}
pub(super) use catalogued_kernel;

/// Returns the number of texels that a filter of moments loads for each that it writes, if it is
/// one.
pub(super) fn filter_loads(filter: &dyn FilterKernel) -> Option<u32> {
    let filter: &dyn Any = filter;
    if let Some(map) = filter.downcast_ref::<MomentMapKernel>() {
        // The sums along a row and along a column.
        return Some(2 * (2 * map.uniforms.radius.unsigned_abs() + 1));
    }
    let HalveUniforms {
        levels,
        along_columns,
    } = filter.downcast_ref::<HalveKernel>()?.uniforms;
    // Along rows, each level loads the whole map. Along columns, it loads half as much as the one
    // before, for half of the texels.
    Some(if along_columns == 0 { levels as u32 } else { 2 })
}

/// Returns the precision for a random switch
/// ([`RandomParameter::Switch`](super::RandomParameter::Switch)).
pub(super) fn precision_of_switch(number: f32) -> MomentPrecision {
    if number > 0.0 {
        MomentPrecision::Bits16
    } else {
        MomentPrecision::Bits32
    }
}
