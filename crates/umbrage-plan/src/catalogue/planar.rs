//! What is measured and planned of `planar`.

use super::CataloguedTechnique;
use umbrage_core::Recipe;
use umbrage_techniques::{Planar, ShadowMap};

impl CataloguedTechnique for Planar {
    fn exhaustive(_: u32) -> Vec<Self> {
        vec![Self { planes: 64 }]
    }

    fn why_chosen(&self, _: f64, recipe: &Recipe) -> Option<String> {
        let layers = recipe.images.first().map_or(0, |image| image.layers);
        Some(format!(
            "all that is seen lit is flat, in {layers} planes: flattened casters have exact edges there"
        ))
    }

    fn random(_: ShadowMap, _: &[f32]) -> Self {
        Self { planes: 40 }
    }
}
