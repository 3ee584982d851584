//! Tests of the redraws of a set while its camera turns.

use glam::{UVec2, Vec3};
use std::sync::Arc;
use umbrage_core::{Camera, Cascades, Fit, Layout, Light};
use umbrage_techniques::{MapFilter as _, Pcf, ShadowMap};
use umbrage_tests::light_stage::Stage;
use umbrage_wgpu::{LightId, SetBudget, ShadowedLight};

fn camera(yaw: f32) -> Camera {
    let size = UVec2::new(64, 48);
    let eye = Vec3::new(1.3, 4.0, 9.7);
    let ahead = Vec3::new(yaw.sin(), -0.3, -yaw.cos());
    Camera::perspective(eye, eye + ahead, Vec3::Y, 0.9, [0.1, 100.0], size).expect("valid")
}

/// A sun with three cascades of this fit over a row of triangles that is too long for one map.
fn stage(fit: Fit) -> (Stage, LightId) {
    let places: Vec<f32> = (-20..=20).map(|i| 4.0 * i as f32).collect();
    let mut stage = Stage::new(SetBudget::default(), &places);
    let map = ShadowMap {
        size: 64,
        fit,
        layout: Layout::Cascades(Cascades {
            count: 3,
            ..Cascades::default()
        }),
        ..ShadowMap::default()
    };
    let sun = ShadowedLight {
        light: Light::Directional {
            direction: Vec3::new(0.3, -1.0, 0.1),
            angular_diameter: 0.0,
        },
        technique: Arc::new(Pcf::new(1).on(map)),
        priority: 1.0,
    };
    let sun = stage.set.add_light(sun).expect("valid");
    (stage, sun)
}

/// Returns the number of drawn layers and written bytes in one full turn of the camera.
fn turn_around(fit: Fit) -> [u64; 2] {
    let (mut stage, sun) = stage(fit);
    stage.camera = camera(0.0);
    assert_eq!(stage.frame().redrawn, 3);
    let before = stage.shadowed_pixels(sun);
    let mut total = [0, 0];
    for step in 1..=24 {
        stage.camera = camera(step as f32 * std::f32::consts::TAU / 24.0);
        let report = stage.frame();
        assert_eq!(report.planned, 1);
        total[0] += u64::from(report.redrawn);
        total[1] += report.uploaded;
    }
    assert!(before > 20 && before == stage.shadowed_pixels(sun));
    total
}

#[test]
fn a_camera_that_turns_draws_nothing_again_with_maps_around_it() {
    assert_eq!(turn_around(Fit::AroundCamera { range: 30.0 }), [0, 0]);
    // Most turns move all stable maps that are in front of the camera.
    let [layers, bytes] = turn_around(Fit::Stable { range: 30.0 });
    assert!(
        layers > 40 && bytes > 0,
        "only {layers} layers, {bytes} bytes"
    );
}
