//! The trait that a shadow technique implements.

use crate::{
    geometry::cut_out::CutOuts, recipe::Recipe, recipe_error::RecipeError, scene::light::Light,
    view::View,
};
use std::fmt::Debug;

/// A shadow technique: a pure function from a view to a recipe. Its parameters are its public
/// fields.
pub trait ShadowTechnique: Debug + Send + Sync {
    /// Returns the technique's name, in lower case: `pcf`.
    fn name(&self) -> &'static str;

    /// Returns the recipe for a view. The result is deterministic.
    ///
    /// # Errors
    /// Errors with `Unsupported` and a reason if the technique can't handle this light or scene.
    /// Errors with `Invalid` for bad parameters.
    fn recipe(&self, view: &View<'_>) -> Result<Recipe, RecipeError>;

    /// Returns the recipe for a renderer that builds a hierarchy of the casters from its own vertices
    /// ([`Recipe::hierarchy`]). `cut_outs` are the records of alpha-tested casters, if there are
    /// any. `None` for techniques that need no hierarchy, or can't use one of a device.
    fn device_recipe(
        &self,
        view: &View<'_>,
        cut_outs: Option<&CutOuts>,
    ) -> Option<Result<Recipe, RecipeError>> {
        let _ = (view, cut_outs);
        None
    }

    /// Returns whether recipes for `light` depend on the camera when the receivers are unknown. If
    /// true, code that caches recipes across frames requests a new one whenever the camera moves.
    /// The default is true.
    fn follows_camera(&self, light: &Light) -> bool {
        let _ = light;
        true
    }
}
