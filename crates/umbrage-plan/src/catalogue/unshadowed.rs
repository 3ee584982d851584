//! What is measured and planned of `none`.

use super::CataloguedTechnique;
use umbrage_core::Recipe;
use umbrage_techniques::Unshadowed;

impl CataloguedTechnique for Unshadowed {
    // It begins with the light, but nothing is compiled anew for that.
    const BRANCHES_ON_UNIFORMS: bool = false;

    fn why_chosen(&self, error: f64, _: &Recipe) -> Option<String> {
        (error > 0.0).then(|| format!("leaving all shadows out errs by only {error:.4}"))
    }
}
