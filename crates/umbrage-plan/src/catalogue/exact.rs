//! What is measured and planned of `exact`.

use super::{CataloguedTechnique, ClosedFormDemand};
use umbrage_core::Recipe;
use umbrage_techniques::{Exact, ShadowMap};

impl CataloguedTechnique for Exact {
    fn why_chosen(&self, _: f64, _: &Recipe) -> Option<String> {
        Some("its answer is that of rays, without a map or a bias".to_owned())
    }

    fn closed_form(_: ShadowMap) -> Option<ClosedFormDemand<Self>> {
        Some(ClosedFormDemand::new(Self {}, 0.0))
    }
}
