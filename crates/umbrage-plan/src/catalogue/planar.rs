//! Catalogue entry of `planar`.

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
            "all lit visible surfaces are in {layers} planes, where flattened casters have exact edges"
        ))
    }

    fn random(_: ShadowMap, _: &[f32]) -> Self {
        Self { planes: 40 }
    }
}
