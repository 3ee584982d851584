//! What frames cost besides what backends play: making recipes, and what is made once for a scene.

use super::TimingStats;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::time::Instant;
use umbrage_core::{Geometry, Recipe, RecipeError, ShadowTechnique, View};
use umbrage_plan::motion::draw_alike;

/// The times of what comes before a backend plays, for one setting on one scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Preparation {
    /// Once a scene: hierarchies over its triangles, welded edges and the like, milliseconds. It is the time by which the first
    /// recipe of fresh triangles takes longer than later ones.
    pub scene_ms: f64,
    /// Making the recipe: once a change of what it depends on.
    pub recipe: TimingStats,
}

/// How often a recipe is made to be timed.
const RECIPES: u32 = 3;
/// Seconds after which no further recipe is made to be timed.
const MAX_SECONDS: f64 = 0.5;
/// Makes a recipe and times that.
///
/// # Errors
/// Errors if the technique can't make it.
pub(super) fn time_recipe(
    technique: &dyn ShadowTechnique,
    view: &View<'_>,
) -> Result<(Recipe, TimingStats), RecipeError> {
    let recipe = technique.recipe(view)?;
    recipe.make_tables();
    let start = Instant::now();
    let mut times = Vec::new();
    for _ in 0..RECIPES {
        let one = Instant::now();
        technique.recipe(view)?.make_tables();
        times.push(one.elapsed().as_secs_f64() * 1e3);
        if start.elapsed().as_secs_f64() > MAX_SECONDS {
            break;
        }
    }
    Ok((recipe, TimingStats::of(times).unwrap_or_default()))
}

/// Returns by how many milliseconds a first recipe for the triangles of a scene takes longer than `later_ms`; 0 if the technique
/// doesn't serve it.
pub(super) fn time_of_scene(
    technique: &dyn ShadowTechnique,
    view: &View<'_>,
    later_ms: f64,
) -> f64 {
    let fresh = view.geometry.map(Geometry::without_hierarchies);
    let view = View {
        geometry: fresh.as_ref(),
        ..*view
    };
    let start = Instant::now();
    match technique.recipe(&view) {
        Ok(recipe) => recipe.make_tables(),
        Err(_) => return 0.0,
    }
    let first_ms = start.elapsed().as_secs_f64() * 1e3;
    (first_ms - later_ms).max(0.0)
}

/// Whether two recipes are the same, so that their masks are.
pub(super) fn play_alike(a: &Recipe, b: &Recipe) -> bool {
    let of_lookup = |recipe: &Recipe| {
        let receive = &recipe.receive;
        format!(
            "{:?} {:?} {:?}",
            receive.kernel, receive.inputs, receive.tables
        )
    };
    let same_tables = a.tables.len() == b.tables.len()
        && a.tables
            .iter()
            .zip(&b.tables)
            .all(|(a, b)| Arc::ptr_eq(a.rows(), b.rows()) || a.rows() == b.rows());
    draw_alike(a, b) && same_tables && of_lookup(a) == of_lookup(b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage_core::Light;
    use umbrage_techniques::{Bias, Hard, MapFilter as _, Pcss, ShadowMap, Traced};

    #[test]
    fn the_same_recipe_is_known_under_another_name() {
        let scene = umbrage_scenes::by_argument("cubes").expect("built in");
        let geometry = Geometry::bake(&scene).expect("valid");
        let recipe = |technique: &dyn ShadowTechnique, light: &Light| {
            let view = View::new(&scene.cameras[0], light, &geometry);
            technique.recipe(&view).expect("served")
        };
        let sun = scene.lights[0];
        let map = ShadowMap::default();
        let hard = Hard {}.on(map);
        let pcss = Pcss::default().on(map);
        assert!(play_alike(&recipe(&hard, &sun), &recipe(&pcss, &sun)));
        // Under a wide light, with another bias or on another map they differ.
        let lamp = umbrage_scenes::by_argument("teapot-lamp")
            .expect("built in")
            .lights[0];
        assert!(!play_alike(&recipe(&hard, &lamp), &recipe(&pcss, &lamp)));
        for other in [
            ShadowMap {
                bias: Bias::SLOPE,
                ..map
            },
            ShadowMap { size: 512, ..map },
        ] {
            let other = Hard {}.on(other);
            assert!(!play_alike(&recipe(&hard, &sun), &recipe(&other, &sun)));
        }
        let few = Traced { samples: 1 };
        let many = Traced { samples: 4 };
        assert!(play_alike(&recipe(&few, &sun), &recipe(&many, &sun)));
        assert!(!play_alike(&recipe(&few, &lamp), &recipe(&many, &lamp)));
    }
}
