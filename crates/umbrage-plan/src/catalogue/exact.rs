//! What is measured and planned of `exact`.

use super::{Candidate, CataloguedTechnique, ClosedFormDemand};
use umbrage_core::{Fit, Light, Recipe};
use umbrage_techniques::{Exact, ShadowMap};

impl CataloguedTechnique for Exact {
    fn candidates(_: ShadowMap, _: &Light) -> Vec<Candidate<Self>> {
        vec![Candidate::One(Self {})]
    }

    fn compared(_: &[u32], _: Fit) -> Vec<Self> {
        vec![Self {}]
    }

    fn why_chosen(&self, _: f64, _: &Recipe) -> Option<String> {
        Some("its answer is that of rays, without a map or a bias".to_owned())
    }

    fn closed_form(_: ShadowMap) -> Option<ClosedFormDemand<Self>> {
        Some(ClosedFormDemand::new(Self {}, 0.0))
    }
}
