//! What techniques say of their maps and the camera, against maps that were made for another
//! camera.

use umbrage_core::{Fit, Geometry, View};
use umbrage_plan::motion;
use umbrage_techniques::ShadowMap;

/// A technique that says it doesn't follow the camera makes the same recipe for a camera that
/// moved.
#[test]
fn what_does_not_follow_the_camera_stays() {
    let fits = [Fit::Tight, Fit::Whole, Fit::Stable { range: 10.0 }];
    let mut staying = 0;
    let mut following = 0;
    for name in ["cubes", "teapot-lamp", "lamp-in-room"] {
        let scene = (umbrage_scenes::find(name).expect("a built-in scene").build)();
        let geometry = Geometry::bake(&scene).expect("valid");
        let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
        for entry in umbrage_techniques::all() {
            for fit in fits {
                let preset = (entry.preset)();
                let map = preset.map().map(|map| ShadowMap {
                    fit,
                    size: 128,
                    ..*map
                });
                let preset = map.map_or(preset.clone(), |map| preset.with_map(map));
                let technique = preset.technique();
                let Ok(recipe) = technique.recipe(&view) else {
                    continue;
                };
                let says = technique.follows_camera(view.light);
                let does = motion::follows_camera(&*technique, &recipe, &view);
                assert!(says || !does, "{} in {name}, {fit:?}", entry.name);
                staying += u32::from(!says);
                following += u32::from(does);
            }
        }
    }
    assert!(staying > 50, "only {staying} say that they stay");
    assert!(
        following > 5,
        "only {following} do follow, and could be missed"
    );
}
