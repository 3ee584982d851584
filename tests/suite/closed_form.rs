//! Tests of shadows with analytic visibility: the reference and the traced technique must reproduce
//! them, through the lab's own entry point.

use umbrage_core::{Geometry, Light};
use umbrage_plan::truth::{ReceiverPoint, TruthOptions, trace_points};
use umbrage_scenes::{ClosedForm, Sample, SceneEntry, all};

fn cases() -> impl Iterator<Item = (&'static SceneEntry, ClosedForm)> {
    all()
        .iter()
        .filter_map(|entry| entry.closed_form.map(|make| (entry, make())))
}

#[test]
fn truth_reproduces_every_closed_form() {
    let mut points = 0;
    for (entry, form) in cases() {
        let scene = (entry.build)();
        let geometry = Geometry::bake(&scene).expect("built-in scenes are valid");
        let traced = trace_form(&scene.lights[0], &geometry, &form);
        for (sample, seen) in form.samples.iter().zip(&traced) {
            let off = (seen - sample.visibility).abs();
            assert!(
                off <= form.tolerance,
                "{} at {}: {seen} instead of {}, off by {off}",
                entry.name,
                sample.point,
                sample.visibility
            );
        }
        points += form.samples.len();
    }
    assert!(
        cases().count() >= 15 && points > 100,
        "{points} points are too few"
    );
}

fn trace_form(light: &Light, geometry: &Geometry, form: &ClosedForm) -> Vec<f32> {
    let point = |s: &Sample| {
        let triangle = s.triangle(geometry).expect("samples lie on receivers");
        ReceiverPoint {
            triangle,
            ..ReceiverPoint::new(s.point, s.normal, geometry)
        }
    };
    let points: Vec<ReceiverPoint> = form.samples.iter().map(point).collect();
    let seen = trace_points(geometry, light, &points, &TruthOptions::default()).expect("valid");
    seen.iter().map(|s| s.visibility).collect()
}

/// Negative control: a reference with a displaced light must fail.
#[test]
fn a_moved_light_fails_the_forms() {
    let (entry, form) = cases().next().expect("there are closed forms");
    let mut scene = (entry.build)();
    scene.lights[0] = Light::Directional {
        direction: glam::Vec3::NEG_Y,
        angular_diameter: 0.0,
    };
    let geometry = Geometry::bake(&scene).expect("valid");
    let traced = trace_form(&scene.lights[0], &geometry, &form);
    assert!(
        form.samples
            .iter()
            .zip(&traced)
            .any(|(s, seen)| (seen - s.visibility).abs() > form.tolerance)
    );
}
