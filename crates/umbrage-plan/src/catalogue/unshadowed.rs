//! Catalogue entry of `none`.

use super::{
    CataloguedTechnique,
    kernel::{self, CataloguedKernel, KernelCost},
};
use umbrage_core::{ReceiveKernel, Recipe};
use umbrage_techniques::{Unshadowed, UnshadowedKernel};

impl CataloguedTechnique for Unshadowed {
    fn kernel(kernel: &dyn ReceiveKernel) -> Option<&dyn CataloguedKernel> {
        kernel::downcast::<UnshadowedKernel>(kernel)
    }

    fn why_chosen(&self, error: f64, _: &Recipe) -> Option<String> {
        (error > 0.0).then(|| format!("the error without shadows is only {error:.4}"))
    }
}

impl CataloguedKernel for UnshadowedKernel {
    fn cost_per_receiver(&self) -> KernelCost {
        KernelCost::taps(0)
    }
}
