//! Tests of truth against formulas, at every scale, with checks that the tests detect errors.

use super::*;
use glam::{Affine3A, Vec3};
use umbrage_core::{Instance, Mesh, NO_TRIANGLE, Scene};
use umbrage_scenes::{ClosedForm, SceneEntry};

/// Checks a scene's closed form under a given light. Returns the number of samples outside the
/// tolerance.
fn samples_off(entry: &SceneEntry, closed_form: &ClosedForm, light: &Light) -> usize {
    let geometry = Geometry::bake(&(entry.build)()).expect("built in");
    let unknown = closed_form
        .samples
        .iter()
        .map(|s| ReceiverPoint::new(s.point, s.normal, &geometry));
    let known = closed_form.samples.iter().map(|s| ReceiverPoint {
        triangle: s.triangle(&geometry).unwrap_or(NO_TRIANGLE),
        ..ReceiverPoint::new(s.point, s.normal, &geometry)
    });
    let points: Vec<ReceiverPoint> = unknown.chain(known).collect();
    let seen = trace_points(&geometry, light, &points, &TruthOptions::default()).expect("valid");
    let expected = closed_form.samples.iter().chain(&closed_form.samples);
    seen.iter()
        .zip(expected)
        .filter(|(s, e)| (s.visibility - e.visibility).abs() > closed_form.tolerance)
        .count()
}

/// Checks every closed form, with the point's triangle known and unknown.
#[test]
fn closed_forms_hold() {
    let mut checked = 0;
    for entry in umbrage_scenes::all() {
        let Some(closed_form) = entry.closed_form.map(|f| f()) else {
            continue;
        };
        let light = (entry.build)().lights[0];
        assert_eq!(
            samples_off(entry, &closed_form, &light),
            0,
            "{}",
            entry.name
        );
        // Stratified samples of an area light must meet this limit; ideal lights must be exact.
        assert!(
            closed_form.tolerance <= if light.is_ideal() { 0.0 } else { 0.005 },
            "{}",
            entry.name
        );
        checked += closed_form.samples.len();
    }
    assert!(
        checked > 100,
        "only {checked} samples: where are the scenes?"
    );
}

/// The closed forms detect errors: an area light that is 5 % too large, or another light that is
/// slightly moved.
#[test]
fn spoilt_lights_break_closed_forms() {
    for name in [
        "c4-edge-square",
        "c4d-edge-disc",
        "c1-box-sun",
        "c3-sphere-bulb",
    ] {
        let entry = umbrage_scenes::find(name).expect("built in");
        let closed_form = entry.closed_form.expect("has one")();
        let spoilt = match (entry.build)().lights[0] {
            Light::Rect {
                center,
                half_u,
                half_v,
            } => Light::Rect {
                center,
                half_u: half_u * 1.05,
                half_v: half_v * 1.05,
            },
            Light::Disc {
                center,
                normal,
                radius,
            } => Light::Disc {
                center,
                normal,
                radius: radius * 1.05,
            },
            Light::Directional {
                direction,
                angular_diameter,
            } => Light::Directional {
                direction: direction + Vec3::X * 0.03,
                angular_diameter,
            },
            Light::Point { position, radius } => Light::Point {
                position: position + Vec3::X * 0.05,
                radius,
            },
            spot @ Light::Spot { .. } => spot,
        };
        assert!(
            samples_off(entry, &closed_form, &spoilt) > 0,
            "{name} doesn't detect it"
        );
    }
}

fn scene_truth(name: &str, options: &TruthOptions) -> Truth {
    let scene = (umbrage_scenes::find(name).expect("built in").build)();
    let geometry = Geometry::bake(&scene).expect("built in");
    let camera = Camera {
        size: glam::UVec2::new(120, 68),
        ..scene.cameras[0]
    };
    let mut cpu = umbrage_cpu::Cpu::new();
    let find = &mut |c: &Camera, g: &Geometry| cpu.receivers(c, g);
    trace(
        &camera,
        &scene.lights[0],
        &geometry,
        options,
        find,
        &|_, _| (),
    )
    .expect("valid")
}

/// Masks of one scene at scales 1e-3, 1 and 1e4 are equal, except for pixels on outlines. Scaling
/// by a factor that is not a power of two rounds them differently; those are ambiguous.
#[test]
fn truth_is_the_same_at_every_scale() {
    let options = TruthOptions::default();
    let truth = scene_truth("cubes", &options);
    assert!(truth.has_shadow());
    for name in ["cubes-tiny", "cubes-huge"] {
        let scaled = scene_truth(name, &options);
        for i in 0..truth.visibility.len() {
            let decided = !truth.ambiguous[i] && !scaled.ambiguous[i];
            assert!(
                !decided || truth.visibility[i] == scaled.visibility[i],
                "{name}: pixel {i}"
            );
            assert!(
                !decided || truth.pixels[i] == scaled.pixels[i],
                "{name}: pixel {i}"
            );
        }
        let share = scaled.ambiguous.iter().filter(|a| **a).count();
        // .04 px to each side of outlines that are some hundreds of pixels long.
        assert!(
            share * 100 < truth.visibility.len(),
            "{name}: {share} pixels are ambiguous"
        );
    }
}

/// Checks a closed room without thickness and a bare floor at grazing light: no leak and no acne on
/// any pixel.
#[test]
fn nothing_leaks_and_nothing_shadows_itself() {
    let options = TruthOptions::default();
    let room = scene_truth("c7-closed-room", &options);
    let lit = room
        .visibility
        .iter()
        .zip(&room.pixels)
        .filter(|(v, p)| **v > 0.0 && **p != Pixel::Empty)
        .count();
    assert_eq!(lit, 0, "light in a closed room");
    for name in ["c9-bare-floor", "c8-faceted-sphere"] {
        let truth = scene_truth(name, &options);
        let dark = truth
            .visibility
            .iter()
            .zip(&truth.pixels)
            .filter(|(v, p)| **v < 1.0 && **p == Pixel::Counted)
            .count();
        assert_eq!(dark, 0, "{name}: acne");
    }
}

#[test]
fn area_lights_tell_their_error_and_ambiguity_is_rare() {
    let options = TruthOptions {
        samples: 256,
        penumbra_factor: 4,
        ..TruthOptions::default()
    };
    let truth = scene_truth("teapot-lamp", &options);
    let [mean, largest] = truth.standard_error();
    assert!(
        mean > 0.0 && mean < 0.002 && largest < 0.02,
        "{mean} {largest}"
    );
    let penumbra = truth
        .visibility
        .iter()
        .filter(|v| **v > 0.0 && **v < 1.0)
        .count();
    assert!(penumbra > 300, "{penumbra} pixels of penumbra");
    let ambiguous = truth
        .pixels
        .iter()
        .filter(|p| **p == Pixel::Ambiguous)
        .count();
    assert!(
        ambiguous * 100 < truth.visibility.len(),
        "{ambiguous} pixels are ambiguous"
    );
}

/// Checks a floor under lights from below, from the side and past it.
#[test]
fn unlit_points_are_reported() {
    let mesh =
        Mesh::new("floor", vec![Vec3::ZERO, Vec3::Z, Vec3::X], vec![[0, 1, 2]]).expect("valid");
    let instances = vec![Instance::new(0, Affine3A::IDENTITY)];
    let geometry = Geometry::bake(&Scene {
        meshes: vec![mesh],
        instances,
        ..Scene::default()
    })
    .expect("valid");
    let point = ReceiverPoint::new(Vec3::new(0.2, 0.0, 0.2), Vec3::Y, &geometry);
    let query = |light: Light| {
        trace_points(&geometry, &light, &[point], &TruthOptions::default()).expect("valid")[0]
    };
    let sun = |direction: Vec3, angular_diameter: f32| {
        query(Light::Directional {
            direction,
            angular_diameter,
        })
    };
    assert_eq!(
        sun(Vec3::NEG_Y, 0.0),
        PointTruth {
            visibility: 1.0,
            error: 0.0,
            unlit: false
        }
    );
    assert_eq!(
        sun(Vec3::Y, 0.0),
        PointTruth {
            visibility: 0.0,
            error: 0.0,
            unlit: true
        }
    );
    // Half of a sun on the horizon is above it.
    let half = sun(Vec3::X, 0.1);
    assert!(
        (half.visibility - 0.5).abs() < 0.005 && !half.unlit,
        "{half:?}"
    );
    let spot = |outer: f32| Light::Spot {
        position: Vec3::new(2.0, 1.0, 0.2),
        direction: Vec3::NEG_Y,
        inner: 0.1,
        outer,
        radius: 0.0,
    };
    assert_eq!(
        query(spot(1.2)),
        PointTruth {
            visibility: 1.0,
            error: 0.0,
            unlit: false
        }
    );
    // Outside the cone, occlusion is traced anyway.
    assert_eq!(
        query(spot(0.8)),
        PointTruth {
            visibility: 1.0,
            error: 0.0,
            unlit: true
        }
    );
}

/// Unlit pixels are found without rays, with the same result as with rays. This holds for lights
/// with and without an extent, and for cones.
#[test]
fn unlit_pixels_are_reported_without_rays() {
    for (name, light) in [
        ("cubes", 0),
        ("rising-boxes-disc", 0),
        ("lamp-in-room", 0),
        ("night-room", 1),
        ("night-room-soft", 1),
    ] {
        let scene = umbrage_scenes::by_argument(name).expect("built in");
        let geometry = Geometry::bake(&scene).expect("valid");
        let camera = scene.cameras[0].with_size(UVec2::new(64, 36));
        let light = &scene.lights[light];
        let options = TruthOptions {
            samples: 32,
            probe_samples: 16,
            ..TruthOptions::default()
        };
        let find = &mut |camera: &Camera, geometry: &Geometry| {
            umbrage_cpu::Cpu::new().receivers(camera, geometry)
        };
        let truth = trace(&camera, light, &geometry, &options, find, &|_, _| {}).expect("valid");
        let all: Vec<u32> = (0..truth.pixels.len() as u32).collect();
        let request = TruthRequest {
            camera: &camera,
            geometry: &geometry,
            receivers: &truth.receivers,
            pixels: &all,
        };
        let found = unlit_pixels(&request, light, &options).expect("valid");
        let expected: Vec<bool> = (truth.pixels.iter())
            .map(|pixel| *pixel == Pixel::Unlit)
            .collect();
        assert!(found == expected, "{name}");
        assert!(found.contains(&true) && found.contains(&false), "{name}");
    }
}

#[test]
fn points_that_are_not_finite_are_refused() {
    let geometry = Geometry::default();
    let light = Light::Point {
        position: Vec3::Y,
        radius: 0.0,
    };
    let point = ReceiverPoint::new(Vec3::new(f32::NAN, 0.0, 0.0), Vec3::Y, &geometry);
    assert!(trace_points(&geometry, &light, &[point], &TruthOptions::default()).is_err());
    let light = Light::Point {
        position: Vec3::Y,
        radius: -1.0,
    };
    assert!(trace_points(&geometry, &light, &[], &TruthOptions::default()).is_err());
}

/// At the drawn pixels, truth has the bits of the whole image. The others are previews that do not
/// count.
#[test]
fn a_sample_of_truth_is_truth() {
    for name in ["cubes", "teapot-lamp"] {
        let scene = umbrage_scenes::by_argument(name).expect("built in");
        let geometry = Geometry::bake(&scene).expect("valid");
        let camera = scene.cameras[0].with_size(UVec2::new(60, 44));
        let light = &scene.lights[0];
        let trace = |block_side| {
            let options = TruthOptions {
                samples: 32,
                probe_samples: 16,
                block_side,
                ..TruthOptions::default()
            };
            let find = &mut |camera: &Camera, geometry: &Geometry| {
                umbrage_cpu::Cpu::new().receivers(camera, geometry)
            };
            super::trace(&camera, light, &geometry, &options, find, &|_, _| {}).expect("valid")
        };
        let whole = trace(1);
        let sample = trace(4);
        let mut judged = 0;
        let mut farthest: f32 = 0.0;
        for i in 0..whole.pixels.len() {
            if sample.pixels[i] == Pixel::Unsampled {
                assert_ne!(whole.pixels[i], Pixel::Empty);
                assert!(!sample.ambiguous[i]);
                farthest = farthest.max((whole.visibility[i] - sample.visibility[i]).abs());
                continue;
            }
            let is_counted = sample.pixels[i] == Pixel::Counted;
            judged += usize::from(is_counted);
            if is_counted {
                assert_eq!(
                    whole.visibility[i].to_bits(),
                    sample.visibility[i].to_bits()
                );
                assert_eq!(whole.pixels[i], Pixel::Counted);
            }
        }
        let counted = whole
            .pixels
            .iter()
            .filter(|p| **p == Pixel::Counted)
            .count();
        assert!(
            judged * 20 > counted && judged * 12 < counted,
            "{judged} of {counted}"
        );
        // 16 stratified rays are off by at most a few sixteenths.
        let limit = if light.is_ideal() { 0.0 } else { 0.35 };
        assert!(farthest <= limit, "{name}: {farthest}");
        assert!(
            light.is_ideal() || farthest > 0.0,
            "the preview must have few rays"
        );
    }
}
