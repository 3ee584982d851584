//! Tests of the statement whether a technique's maps follow the camera, against maps for another
//! camera.

use umbrage_core::{Fit, Geometry, View};
use umbrage_plan::motion;
use umbrage_techniques::ShadowMap;

/// A technique that doesn't follow the camera returns the same recipe after the camera moves.
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
    assert!(staying > 50, "only {staying} report that they stay");
    assert!(
        following > 5,
        "only {following} follow, so the test proves little"
    );
}
