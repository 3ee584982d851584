//! Automatic choice of the cheapest technique that a scene needs.

use crate::{Scene, techniques::TechniquePreset};
use umbrage_plan::{MeasureError, Miss, PlanOptions, plan};

/// Limits on error and cost, and the data that the renderer has for executing recipes
/// ([`Budget::renderer`](umbrage_plan::Bounds::renderer)).
pub type Budget = umbrage_plan::Bounds;

/// Finds the cheapest built-in technique and setting within a budget, for a scene's first camera
/// and light.
///
/// Without an error bound, it finds the most accurate one. It measures on the CPU and takes
/// seconds. Call it when a scene is built, not every frame, and store the result
/// ([`TechniquePreset::to_toml`]). [`mod@crate::plan`] also reports the reasons and the
/// alternatives.
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
/// All returned presets can be executed by the caller's renderer. By default the renderer is
/// assumed to have the triangles on the CPU, as above. If they are on the GPU only, set
/// [`Budget::renderer`](umbrage_plan::Bounds::renderer). This excludes planar shadows, volumes and
/// rays, which need triangles. Maps are then fitted to the bounding box of the casters, as they
/// will be in the program. A light set can also execute `exact`, whose hierarchy its device builds:
/// `RendererData::LightSet`.
///
#[cfg_attr(feature = "scenes", doc = "```")]
#[cfg_attr(not(feature = "scenes"), doc = "```ignore")]
/// use umbrage::{Budget, Geometry, RendererData, ShadowTechnique, View};
///
/// let scene = umbrage::scenes::by_argument("cubes")?;
/// let budget = Budget { renderer: RendererData::CasterBox, ..Budget::error(0.1) };
/// let technique = umbrage::auto(&scene, &budget)?.technique();
///
/// let geometry = Geometry::bake(&scene)?;
/// let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
/// let without_triangles = View { geometry: None, ..view };
/// assert!(technique.recipe(&without_triangles).is_ok());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// Errors if the scene or the budget is not valid, or if nothing is within the budget.
pub fn auto(scene: &Scene, budget: &Budget) -> Result<TechniquePreset, AutoError> {
    auto_with(scene, budget, &PlanOptions::default())
}

/// Finds a preset like [`auto`], with options.
///
/// Options cover the cameras of a path, what moves from frame to frame, another light or image
/// size, and custom techniques. They also accept the prices of another machine:
/// [`PlanOptions::cost`], from a [`PriceList`](umbrage_plan::cost::PriceList) that
/// `bench --costs --write` writes.
///
/// # Errors
/// Errors in the same cases as [`auto`].
pub fn auto_with(
    scene: &Scene,
    budget: &Budget,
    options: &PlanOptions,
) -> Result<TechniquePreset, AutoError> {
    Ok(plan(scene, budget, options, &|_| {})?.preset()?)
}

/// Reason why there is no preset.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum AutoError {
    /// The scene or the budget is not valid.
    #[error(transparent)]
    Measure(#[from] MeasureError),
    /// Nothing is within the budget. Contains the bound that fails, by how much, and the closest
    /// setting.
    #[error(transparent)]
    Miss(#[from] Box<Miss>),
}

#[cfg(all(test, feature = "scenes"))]
mod tests {
    use super::*;
    use umbrage_core::{Geometry, View, glam::UVec2};
    use umbrage_plan::{RendererData, motion::FrameMotion};

    fn picked_preset(
        scene: &Scene,
        renderer: RendererData,
        error: f64,
    ) -> Result<TechniquePreset, AutoError> {
        let budget = Budget {
            renderer,
            ..Budget::error(error)
        };
        let options = PlanOptions {
            samples: 1024,
            size: Some(UVec2::new(160, 120)),
            // If maps are drawn every frame, exact shadows of triangles are cheaper than the finest
            // map.
            motion: FrameMotion::AllMoves,
            ..PlanOptions::default()
        };
        auto_with(scene, &budget, &options)
    }

    /// A renderer without triangles gets a technique that it can execute, or an error.
    #[test]
    fn what_the_renderer_cannot_run_is_never_picked() {
        for name in ["c1-box-sun", "cubes", "lamp-in-room"] {
            let scene = umbrage_scenes::by_argument(name).expect("built in");
            let geometry = Geometry::bake(&scene).expect("valid");
            let view = View {
                geometry: None,
                ..View::new(&scene.cameras[0], &scene.lights[0], &geometry)
            };
            let supports = |preset: &TechniquePreset| preset.technique().recipe(&view).is_ok();
            let exact =
                picked_preset(&scene, RendererData::Triangles, 0.0).expect("rays are exact");
            assert!(!supports(&exact), "{name}: {exact:?}");
            // A light set's device builds the hierarchy of `exact`.
            let of_set =
                picked_preset(&scene, RendererData::LightSet, 0.0).expect("`exact` has no error");
            let built = of_set.technique().device_recipe(&view, None);
            assert!(
                supports(&of_set) || built.is_some_and(|made| made.is_ok()),
                "{name}: {of_set:?}"
            );
            if let Ok(preset) = picked_preset(&scene, RendererData::CasterBox, 0.0) {
                assert!(supports(&preset), "{name}: {preset:?}");
            }
            let rough =
                picked_preset(&scene, RendererData::CasterBox, 0.2).expect("maps are enough");
            assert!(supports(&rough), "{name}: {rough:?}");
        }
    }
}
