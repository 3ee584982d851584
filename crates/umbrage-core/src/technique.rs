//! The trait that a shadow technique implements.

use crate::{
    recipe::{Recipe, device_lists::DeviceRecipe},
    recipe_error::RecipeError,
    scene::light::Light,
    view::View,
};
use std::fmt::Debug;

/// A way to make shadows: a pure function from what is seen to a recipe. Its parameters are its
/// public fields.
pub trait ShadowTechnique: Debug + Send + Sync {
    /// Returns the technique's name, in lower case: `pcf`.
    fn name(&self) -> &'static str;

    /// Returns the recipe for a view. The same view gives the same recipe.
    ///
    /// # Errors
    /// Errors with `Unsupported` if it can't serve this light or scene, with the reason; with
    /// `Invalid` for bad parameters.
    fn recipe(&self, view: &View<'_>) -> Result<Recipe, RecipeError>;

    /// Returns the recipe for a renderer that has the casters' vertices on the device alone, for
    /// techniques that ask lists of casters, which the device then makes itself. None for all
    /// others, which need no list or can't do with such ones.
    fn device_recipe(&self, view: &View<'_>) -> Option<Result<DeviceRecipe, RecipeError>> {
        let _ = view;
        None
    }

    /// Returns whether recipes for `light` depend on the camera, where it isn't known what the
    /// camera sees. Yes, unless a technique knows better: whoever keeps recipes from frame to frame
    /// then asks for a new one whenever the camera moves.
    fn follows_camera(&self, light: &Light) -> bool {
        let _ = light;
        true
    }
}
