//! The least technique that a scene needs.

use crate::{Scene, techniques::TechniquePreset};
use umbrage_plan::{MeasureError, Miss, PlanOptions, plan};

/// What shadows may err and cost: a greatest error, time, number of bytes, or several of them.
pub type Budget = umbrage_plan::Bounds;

/// Finds the cheapest built-in technique and setting within a budget (without a bound of the error, the most accurate) for a
/// scene's first camera and light. It measures on the CPU, in seconds: call it where scenes are made rather than every frame,
/// and keep the answer ([`TechniquePreset::to_toml`]). Why it was chosen, and what else there is: [`mod@crate::plan`].
///
#[cfg_attr(feature = "scenes", doc = "```")]
#[cfg_attr(not(feature = "scenes"), doc = "```ignore")]
/// use umbrage::{Budget, Geometry, ShadowTechnique, View, techniques::TechniquePreset};
///
/// let scene = umbrage::scenes::by_argument("cubes")?;
/// let preset = umbrage::auto(&scene, &Budget::error(0.1))?;
/// let file = preset.to_toml()?;
///
/// // In the program that draws the scene:
/// let technique = TechniquePreset::from_toml(&file)?.technique();
/// let geometry = Geometry::bake(&scene)?;
/// let recipe = technique.recipe(&View::new(&scene.cameras[0], &scene.lights[0], &geometry))?;
/// # assert!(recipe.images.len() < 3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// When the scene or the budget is not valid, and when nothing is within the budget.
pub fn auto(scene: &Scene, budget: &Budget) -> Result<TechniquePreset, AutoError> {
    auto_with(scene, budget, &PlanOptions::default())
}

/// As [`auto`], with options: another light or image size, techniques of your own, or the prices of your machine
/// ([`PlanOptions::cost`], from a [`PriceList`](umbrage_plan::cost::PriceList) that `bench --costs --write` writes).
///
/// # Errors
/// As those of [`auto`].
pub fn auto_with(
    scene: &Scene,
    budget: &Budget,
    options: &PlanOptions,
) -> Result<TechniquePreset, AutoError> {
    Ok(plan(scene, budget, options, &|_| {})?.preset()?)
}

/// Why there is no preset.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum AutoError {
    /// The scene or the budget can't be used.
    #[error(transparent)]
    Measure(#[from] MeasureError),
    /// Nothing is within the budget: which bound fails, by how much, and what comes nearest.
    #[error(transparent)]
    Miss(#[from] Box<Miss>),
}
