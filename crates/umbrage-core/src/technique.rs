//! The trait that a shadow technique implements.

use crate::{
    recipe::{Recipe, device_lists::DeviceRecipe},
    recipe_error::RecipeError,
    scene::light::Light,
    view::View,
};
use std::fmt::Debug;

/// A way to make shadows: a pure function from what is seen to a recipe. Its parameters are its public fields.
pub trait ShadowTechnique: Debug + Send + Sync {
    /// Returns the technique's name, in lower case: `pcf`.
    fn name(&self) -> &'static str;

    /// Returns its settings in a few words, without the name: `3x3, 1024, slope .05/.005`.
    fn settings(&self) -> String;

    /// Returns the recipe for a view. The same view gives the same recipe.
    ///
    /// # Errors
    /// Errors with `Unsupported` if it can't serve this light or scene, with the reason; with `Invalid` for bad parameters.
    fn recipe(&self, view: &View<'_>) -> Result<Recipe, RecipeError>;

    /// Returns the recipe for a renderer that has the casters' vertices on the device alone, for techniques that ask lists of casters,
    /// which the device then makes itself. None for all others, which need no list or can't do with such ones.
    fn device_recipe(&self, view: &View<'_>) -> Option<Result<DeviceRecipe, RecipeError>> {
        let _ = view;
        None
    }

    /// Returns how far, in texels, lookups go beyond the point of a map on which a receiver falls, along each axis: 0 for one
    /// texel, 1 for the 3 x 3 around it. None where no map of what the light sees is looked up, and where that isn't known:
    /// reports then say nothing of its maps. Where it differs from one receiver to the next, this is the narrowest, and
    /// [`ReceiveKernel::reach`](crate::ReceiveKernel::reach) returns each.
    fn kernel_reach(&self) -> Option<f32> {
        None
    }

    /// Returns whether recipes for `light` depend on the camera, where it isn't known what the camera sees. Yes, unless a technique
    /// knows better: whoever keeps recipes from frame to frame then asks for a new one whenever the camera moves.
    fn follows_camera(&self, light: &Light) -> bool {
        let _ = light;
        true
    }
}
