//! Tests that planning reads few triangles, since fits use the boxes around them.

use umbrage_core::{Fit, Geometry, Recipe, ShadowTechnique, View};
use umbrage_techniques::{Hard, MapFilter as _, Pcss, ShadowMap};

/// Greatest number of triangles that planning may read for each drawn one.
const MOST_OF_DRAWN: f64 = 0.25;

/// Returns the number of triangles that a recipe's casts draw.
fn drawn_triangles(recipe: &Recipe, geometry: &Geometry) -> usize {
    let casts = recipe.casts.iter();
    casts
        .flat_map(|cast| cast.source.runs(geometry))
        .map(|run| run.len())
        .sum()
}

/// Point lights are excluded: the axis of the cone around all casters is a sum over all of them.
#[test]
fn plans_look_at_a_quarter_of_what_is_drawn_at_most() {
    for name in ["street-soft", "dancer-soft"] {
        let scene = (umbrage_scenes::find(name).expect("built in").build)();
        let geometry = Geometry::bake(&scene).expect("valid");
        let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
        for fit in [Fit::Tight, Fit::Stable { range: 50.0 }, Fit::Whole] {
            let map = ShadowMap {
                size: 2048,
                fit,
                ..ShadowMap::default()
            };
            let hard = Hard {}.on(map);
            let soft = Pcss::default().on(map);
            let techniques: [&dyn ShadowTechnique; 2] = [&hard, &soft];
            for technique in techniques {
                let before = geometry.triangles_looked_at();
                let recipe = technique.recipe(&view).expect("supported");
                let looked_at = (geometry.triangles_looked_at() - before) as f64;
                let drawn = drawn_triangles(&recipe, &geometry) as f64;
                assert!(drawn > 100_000.0, "{name} is a scene of real size");
                assert!(
                    looked_at > 0.0 && looked_at <= drawn * MOST_OF_DRAWN,
                    "{name}, {}, {fit:?}: {looked_at} triangles were looked at for {drawn} drawn",
                    technique.name()
                );
            }
        }
    }
}
