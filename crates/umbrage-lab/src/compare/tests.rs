//! Comparisons on the CPU, and faulty backends.

use super::*;
use crate::{
    compare::settings::with_fit,
    faulty_backend::{FaultyBackend, darken_one, lighten_one},
};
use std::collections::BTreeSet;
use umbrage_core::{
    Fit, Geometry, Receivers, ShadowTechnique as _, Shadows, Snapping, View, glam::UVec2,
    metrics::Pixel,
};
use umbrage_cpu::Cpu;
use umbrage_plan::{footprint::measure, truth::TruthOptions};

fn quick(techniques: &[&str]) -> CompareOptions {
    CompareOptions {
        catalogue: umbrage_plan::catalogue::Catalogue::built_in(),
        color: false,
        techniques: techniques.iter().map(|t| (*t).to_owned()).collect(),
        map_sizes: vec![256],
        max_settings: None,
        size: Some(UVec2::new(96, 64)),
        truth: TruthOptions {
            samples: 16,
            probe_samples: 8,
            ..TruthOptions::default()
        },
        runs: Some(Runs::exactly(2)),
        ..CompareOptions::default()
    }
}

fn input(name: &str) -> SceneInput {
    let entry = umbrage_scenes::find(name).expect("built in");
    SceneInput::new((entry.build)(), entry.summary)
}

fn run(
    scene: &str,
    options: &CompareOptions,
    backends: &mut Backends,
) -> Result<Comparison, LabError> {
    compare(
        &[input(scene)],
        options,
        backends,
        &mut |_, _| Ok(()),
        &|_| (),
    )
}

fn with_faulty_backend(spoil: fn(&mut Shadows)) -> Backends {
    Backends::from_backends(vec![
        Box::new(Cpu::new()),
        Box::new(FaultyBackend::new(spoil)),
    ])
}

#[test]
fn rows_tell_errors_times_and_agreement() {
    let comparison = run(
        "cubes",
        &quick(&["hard", "traced"]),
        &mut with_faulty_backend(|_| ()),
    )
    .expect("valid");
    let scene = &comparison.scenes[0];
    assert_eq!((scene.size, scene.rows.len() % 2), ([96, 64], 0));
    for pair in scene.rows.chunks(2) {
        let cpu = pair[0].measured_figures().expect("supported");
        let other = pair[1].measured_figures().expect("supported");
        assert_eq!((&*pair[0].backend, &*pair[1].backend), ("cpu", "wgpu"));
        assert_eq!(cpu.errors, other.errors);
        assert!(
            cpu.agreement.is_none()
                && other
                    .agreement
                    .is_some_and(|a| a.holds() && a.differing == 0)
        );
        let times = cpu.times.expect("asked for");
        assert_eq!(times.total.runs, 2);
        assert!(cpu.cost_ms > 0.0 && cpu.work.receivers > 0);
        assert_eq!(times.cast.is_some(), pair[0].technique == "hard");
    }
    let traced = scene
        .rows
        .iter()
        .find(|r| r.technique == "traced")
        .and_then(CompareRow::measured_figures)
        .expect("there");
    let rmse = traced.rmse().expect("compared");
    assert!(rmse < 0.02, "one ray a receiver is the truth: {rmse}");
    assert!(
        scene
            .controls
            .iter()
            .all(|c| c.holds && c.shadowed > 0 && c.changed > 0),
        "{:?}",
        scene.controls
    );
    assert!(comparison.faults().is_empty());
}

/// Rows report the map use that `measure` returns, on every backend. Techniques without lookups
/// report none.
#[test]
fn rows_tell_how_maps_are_used() {
    /// Technique, start of its settings, and reach of its lookups beyond the point, texels. `None`
    /// without a map. A kernel as wide as its penumbra has its minimum here, and reports the reach
    /// of each receiver itself.
    const REACHES: [(&str, &str, Option<f32>); 7] = [
        ("hard", "", Some(0.0)),
        ("pcf", "3x3", Some(1.0)),
        ("pcf", "5x5", Some(2.0)),
        ("pcf", "7x7", Some(3.0)),
        ("pcss", "", Some(0.0)),
        ("traced", "", None),
        ("volumes", "", None),
    ];
    let options = quick(&["hard", "pcf", "pcss", "traced", "volumes"]);
    // With a manual fit, kernels of any reach share one light space.
    let input = SceneInput {
        fit: Some(umbrage_scenes::TEXTBOOK_FIT),
        ..input("cubes")
    };
    let comparison = compare(
        std::slice::from_ref(&input),
        &options,
        &mut with_faulty_backend(|_| ()),
        &mut |_, _| Ok(()),
        &|_| (),
    )
    .expect("valid");
    let camera = options.camera(&input.scene.cameras[0]);
    let geometry = Geometry::bake(&input.scene).expect("valid");
    let receivers = Cpu::new().receivers(&camera, &geometry).expect("valid");
    let view = View::new(&camera, &input.scene.lights[0], &geometry).with_receivers(&receivers);
    let mut spoilt = receivers.clone();
    for receives in spoilt.receives.iter_mut().step_by(2) {
        *receives = false;
    }
    let mut seen = std::collections::HashSet::new();
    let tight = options.settings(Fit::Tight).expect("known");
    for technique in with_fit(&tight, input.fit, &options).expect("known") {
        let settings = technique.settings();
        let known = REACHES
            .iter()
            .find(|(name, begins, _)| *name == technique.name() && settings.starts_with(begins));
        let reach = known
            .unwrap_or_else(|| panic!("{}, {settings}: no known reach", technique.name()))
            .2;
        let recipe = technique.recipe(&view).expect("supported");
        let kernel = options.catalogue.kernel(&recipe);
        let used =
            |by: &Receivers| reach.map(|reach| measure(&view, &recipe, by, reach, kernel).total);
        let right = used(&receivers);
        let wrong = used(&spoilt);
        let rows: Vec<_> = comparison.scenes[0]
            .rows
            .iter()
            .filter(|r| r.settings == settings)
            .collect();
        assert!(rows.len() >= 2, "{settings}");
        for row in rows.into_iter().filter(|r| r.technique == technique.name()) {
            let maps = row.measured_figures().expect("supported").maps;
            assert_eq!(maps, right, "{}", row.label());
            assert!(
                maps.is_none() || maps != wrong,
                "{}: other receivers, other figures",
                row.label()
            );
            seen.insert((technique.name(), maps.is_some()));
        }
    }
    let expected_reasons = [
        ("hard", true),
        ("pcf", true),
        ("pcss", true),
        ("traced", false),
        ("volumes", false),
    ];
    assert_eq!(seen, expected_reasons.into_iter().collect());
}

#[test]
fn a_fit_by_hand_adds_rows_for_maps_alone() {
    let options = quick(&["hard", "traced"]);
    let count = |fit: Option<Fit>| {
        let input = SceneInput {
            fit,
            ..input("cubes")
        };
        let sink = &mut |_: &SceneResult, _: &SceneImages| Ok(());
        let comparison = compare(
            &[input],
            &options,
            &mut Backends::from_backends(vec![Box::new(Cpu::new())]),
            sink,
            &|_| (),
        );
        let rows = comparison.expect("valid").scenes.remove(0).rows;
        let by_hand = rows
            .iter()
            .filter(|r| r.settings.contains("manual fit"))
            .count();
        (
            by_hand,
            rows.iter().filter(|r| r.technique == "hard").count(),
            rows.len(),
        )
    };
    let (none, hard, all) = count(None);
    assert_eq!(none, 0);
    // Cascades follow the camera: one row has no manual fit.
    let fitted = hard - 1;
    assert_eq!(
        count(Some(umbrage_scenes::TEXTBOOK_FIT)),
        (fitted, hard + fitted, all + fitted)
    );
}

#[test]
fn one_wrong_pixel_is_a_fault() {
    let comparison = run(
        "cubes",
        &quick(&["traced"]),
        &mut with_faulty_backend(darken_one),
    )
    .expect("valid");
    let faults = comparison.faults();
    assert!(
        faults.iter().any(|f| f.contains("decided pixels differ")),
        "{faults:?}"
    );
}

/// Rounding changes the last bits of a penumbra's pixel, and excuses nothing else.
#[test]
fn one_wrong_penumbra_pixel_is_a_fault() {
    let faulty = &mut with_faulty_backend(lighten_one);
    let comparison = run("cubes", &quick(&["pcf_hardware"]), faulty).expect("valid");
    let faults = comparison.faults();
    assert!(
        faults.iter().any(|f| f.contains("decided pixels differ")),
        "{faults:?}"
    );
}

fn rounding(does: Snapping, says: Snapping, spoil: fn(&mut Shadows)) -> Backends {
    Backends::from_backends(vec![
        Box::new(Cpu::new()),
        Box::new(FaultyBackend::rounding(does, says, spoil)),
    ])
}

/// On a coarse grid other pixels are dark and other triangles are visible than on the CPU's. All of
/// that is correct, and reported.
#[test]
fn a_backend_is_compared_by_its_own_rounding() {
    let options = quick(&["volumes", "traced", "planar"]);
    let coarse = Snapping::COARSEST;
    let comparison =
        run("cubes", &options, &mut rounding(coarse, coarse, |_| ())).expect("comparable");
    let rows: Vec<_> = comparison.scenes[0]
        .rows
        .iter()
        .filter(|r| r.backend == "wgpu")
        .collect();
    let volumes = rows
        .iter()
        .find(|r| r.technique == "volumes")
        .and_then(|r| r.measured_figures())
        .expect("measured");
    let agreed = volumes.agreement.expect("compared");
    assert!(
        agreed.by_grid > 0 && agreed.differing > 0 && agreed.undecided == 0,
        "{agreed:?}"
    );
    let errors = volumes.errors.expect("pixels count");
    assert!(errors.elsewhere > 0 && errors.rmse == 0.0, "{errors:?}");
    assert!(comparison.faults().is_empty(), "{:?}", comparison.faults());
    let snapping = comparison.environment.snapping.expect("told");
    assert!(snapping.starts_with("4 sub-pixel bits"), "{snapping}");
    // A wrong pixel is detected as on the CPU's grid.
    let faults = run("cubes", &options, &mut rounding(coarse, coarse, darken_one))
        .expect("comparable")
        .faults();
    assert!(
        faults.iter().any(|f| f.contains("decided pixels differ")),
        "{faults:?}"
    );
    // Backends that round differently than they report are detected.
    let lies = run(
        "cubes",
        &options,
        &mut rounding(coarse, Snapping::default(), |_| ()),
    )
    .expect("comparable")
    .faults();
    assert!(
        lies.iter().any(|f| f.contains("decided pixels differ")),
        "{lies:?}"
    );
}

/// Rounding changes many pixels of maps without bias. This is reported and is not a fault, except
/// with a bias or at nearly all pixels.
#[test]
fn only_maps_without_bias_may_be_sensitive_to_rounding() {
    let mut comparison =
        run("cubes", &quick(&["hard"]), &mut with_faulty_backend(|_| ())).expect("valid");
    let rows = &mut comparison.scenes[0].rows;
    rows.retain(|row| row.backend == "wgpu");
    let set_undecided = |comparison: &mut Comparison, share: f64| {
        for row in &mut comparison.scenes[0].rows {
            let RowOutcome::Measured(m) = &mut row.outcome else {
                panic!("measured")
            };
            let agreement = m.agreement.as_mut().expect("compared");
            agreement.undecided = (share * agreement.compared as f64) as u64;
        }
    };
    set_undecided(&mut comparison, 0.2);
    let (without_bias, with_bias): (Vec<_>, Vec<_>) = comparison.scenes[0]
        .rows
        .iter()
        .map(CompareRow::label)
        .partition(|label| label.contains("bias: none"));
    let reported = comparison.rows_sensitive_to_rounding();
    let faults = comparison.faults();
    assert!(!without_bias.is_empty() && !with_bias.is_empty());
    assert_eq!(
        (reported.len(), faults.len()),
        (without_bias.len(), with_bias.len())
    );
    assert!(reported[0].contains(&without_bias[0]), "{reported:?}");
    assert!(faults[0].contains(&with_bias[0]), "{faults:?}");
    set_undecided(&mut comparison, 0.4);
    assert!(comparison.rows_sensitive_to_rounding().is_empty());
    assert_eq!(comparison.faults().len(), comparison.scenes[0].rows.len());
}

/// A backend may agree with the CPU on its own grid and still be wrong: a bias too small for this
/// grid makes surfaces dark.
#[test]
fn masks_much_farther_from_truth_than_the_cpu_s_are_faults() {
    let measured = |excess: f64| {
        let mut comparison = run(
            "cubes",
            &quick(&["traced"]),
            &mut with_faulty_backend(|_| ()),
        )
        .expect("valid");
        let row = comparison.scenes[0].rows.last_mut().expect("rows");
        let RowOutcome::Measured(m) = &mut row.outcome else {
            panic!("measured")
        };
        m.agreement.as_mut().expect("compared").excess = excess;
        comparison.faults()
    };
    assert!(measured(0.005).is_empty());
    let faults = measured(0.0051);
    assert!(faults[0].contains("RMSE is 0.0051 above"), "{faults:?}");
}

#[test]
fn a_mask_that_ignores_casters_fails_the_control() {
    let all_lit = |s: &mut Shadows| s.mask.fill(1.0);
    let comparison = run(
        "cubes",
        &quick(&["traced"]),
        &mut with_faulty_backend(all_lit),
    )
    .expect("valid");
    assert!(comparison.scenes[0].controls[0].holds && !comparison.scenes[0].controls[1].holds);
    let all_dark = |s: &mut Shadows| s.mask.fill(0.0);
    let comparison = run(
        "cubes",
        &quick(&["traced"]),
        &mut with_faulty_backend(all_dark),
    )
    .expect("valid");
    assert!(!comparison.scenes[0].controls[1].holds);
}

#[test]
fn other_triangles_cannot_be_compared() {
    // Timed runs reuse the receivers of the first run.
    let shifted = |s: &mut Shadows| {
        s.receivers
            .iter_mut()
            .for_each(|seen| seen.triangle.rotate_left(40))
    };
    let e = run(
        "cubes",
        &quick(&["traced"]),
        &mut with_faulty_backend(shifted),
    )
    .expect_err("different triangles");
    assert!(matches!(e, LabError::NotComparable { .. }), "{e}");
    let elsewhere = |s: &mut Shadows| {
        let Some(seen) = &mut s.receivers else { return };
        for i in 0..seen.len() / 50 {
            (seen.triangle[i], seen.distance[i]) = (seen.triangle[i] ^ 1, seen.distance[i] + 9.0);
        }
    };
    assert!(
        run(
            "cubes",
            &quick(&["traced"]),
            &mut with_faulty_backend(elsewhere)
        )
        .is_err()
    );
    let silent = |s: &mut Shadows| s.receivers = None;
    assert!(
        run(
            "cubes",
            &quick(&["traced"]),
            &mut with_faulty_backend(silent)
        )
        .is_err()
    );
}

#[test]
fn spoilt_masks_stop_the_comparison() {
    let nan = |s: &mut Shadows| s.mask[3] = f32::NAN;
    assert!(matches!(
        run("cubes", &quick(&["traced"]), &mut with_faulty_backend(nan)),
        Err(LabError::Invalid(_))
    ));
}

#[test]
fn what_is_not_supported_is_reported_with_its_reason() {
    let mut cpu = Backends::from_backends(vec![Box::new(Cpu::new())]);
    let comparison = run("c4-edge-square", &quick(&["hard"]), &mut cpu).expect("valid");
    for row in &comparison.scenes[0].rows {
        if let RowOutcome::Unsupported { reason } = &row.outcome {
            assert!(reason.len() > 10, "{reason}");
        }
    }
    // Scenes with nothing to render must not stop the comparison, either.
    for scene in ["no-casters", "no-receivers", "only-sky"] {
        let comparison = run(scene, &quick(&[]), &mut cpu).expect("empty scenes are fine");
        let rows: Vec<_> = comparison.scenes[0]
            .rows
            .iter()
            .filter_map(|row| Some((row.technique.as_str(), row.measured_figures()?)))
            .collect();
        let nothing = comparison.scenes[0].nothing_compared.as_deref();
        assert!(
            !rows.is_empty() && comparison.faults().is_empty(),
            "{scene}"
        );
        for (technique, measured) in rows {
            match measured.rmse() {
                // Everything that is compared is correct.
                Some(rmse) => {
                    assert!(nothing.is_none(), "{scene}, {technique}");
                    assert_eq!(rmse, 0.0, "{scene}, {technique}");
                }
                // If nothing is compared, this is reported, and not as an error of 0.
                None => assert!(nothing.is_some(), "{scene}, {technique}"),
            }
        }
        assert_eq!(nothing.is_some(), scene != "no-casters", "{scene}");
    }
}

/// Previews skip moment maps unless one is named.
#[test]
fn dear_techniques_are_previewed_by_name_alone() {
    let names = |options: &CompareOptions| {
        let settings = options.settings(Fit::Tight).expect("all are known");
        let names: BTreeSet<&str> = settings.iter().map(|technique| technique.name()).collect();
        names
    };
    let all = names(&CompareOptions::default());
    let previewed = names(&CompareOptions::quick());
    let left_out: Vec<&str> = all.difference(&previewed).copied().collect();
    assert_eq!(left_out, ["evsm", "msm", "vsm"]);
    let named = CompareOptions {
        techniques: vec!["vsm".to_owned()],
        ..CompareOptions::quick()
    };
    assert_eq!(names(&named), BTreeSet::from(["vsm"]));
}

#[test]
fn unknown_techniques_are_named_and_listed() {
    let mut cpu = Backends::from_backends(vec![Box::new(Cpu::new())]);
    let e = run("cubes", &quick(&["magic"]), &mut cpu)
        .expect_err("unknown")
        .to_string();
    assert!(e.contains("magic") && e.contains("pcf"), "{e}");
    let no_maps = CompareOptions {
        map_sizes: Vec::new(),
        ..quick(&[])
    };
    assert!(run("cubes", &no_maps, &mut cpu).is_err());
}

#[test]
fn scenes_that_cannot_be_compared_are_refused_before_any_is() {
    let mut long = input("figure");
    long.scene.name = "x".repeat(5000);
    let mut cpu = Backends::from_backends(vec![Box::new(Cpu::new())]);
    let mut seen = 0;
    let sink = &mut |_: &SceneResult, _: &SceneImages| {
        seen += 1;
        Ok(())
    };
    let e = compare(
        &[input("cubes"), long],
        &quick(&["hard"]),
        &mut cpu,
        sink,
        &|_| (),
    )
    .expect_err("too long");
    let e = e.to_string();
    assert!(
        seen == 0 && e.contains("5000 bytes") && e.contains("at most 200") && e.len() < 200,
        "{e}"
    );
}

#[test]
fn another_size_keeps_the_vertical_field_of_view() {
    let camera = input("cubes").scene.cameras[0];
    let wider = quick(&[]).camera(&camera);
    assert_eq!(wider.size, UVec2::new(96, 64));
    assert_eq!(wider.clip_from_view.y_axis, camera.clip_from_view.y_axis);
    // Pixels are square: a step to the right has the same length as a step down.
    let rays = wider.rays();
    let right = rays.dir_dx.length();
    let down = rays.dir_dy.length();
    assert!((right / down - 1.0).abs() < 1e-4, "{right} {down}");
}

#[test]
fn images_come_with_every_row() {
    let mut cpu = Backends::from_backends(vec![Box::new(Cpu::new())]);
    let mut seen = 0;
    let sink = &mut |r: &SceneResult, images: &SceneImages| {
        assert_eq!(r.rows.len(), images.rows.len());
        for (row, images) in r.rows.iter().zip(&images.rows) {
            // Cascades are next to each other, three in a row.
            let is_one_map = !row.settings.contains("cascades");
            let heat = images.lookups.as_ref();
            assert!(heat.is_none_or(|heat| (heat.size == [256; 2]) == is_one_map));
        }
        let mut masks = images.rows.iter().filter_map(|row| row.mask.as_ref());
        assert!(masks.all(|m| m.len() == 96 * 64));
        assert!(images.truth.pixels.contains(&Pixel::Counted));
        seen += 1;
        Ok(())
    };
    compare(
        &[input("cubes"), input("figure")],
        &quick(&["pcf"]),
        &mut cpu,
        sink,
        &|_| (),
    )
    .expect("valid");
    assert_eq!(seen, 2);
}

/// Images that no report shows are not kept.
#[test]
fn only_few_scenes_keep_where_maps_are_looked_up() {
    let kept = |scenes: usize| {
        let mut cpu = Backends::from_backends(vec![Box::new(Cpu::new())]);
        let mut kept = 0;
        let sink = &mut |r: &SceneResult, images: &SceneImages| {
            assert!(
                r.rows
                    .iter()
                    .all(|row| row.measured_figures().is_some_and(|m| m.maps.is_some())),
                "figures are for all"
            );
            kept += images
                .rows
                .iter()
                .filter(|row| row.lookups.is_some())
                .count();
            Ok(())
        };
        compare(
            &vec![input("cubes"); scenes],
            &quick(&["hard"]),
            &mut cpu,
            sink,
            &|_| (),
        )
        .expect("valid");
        kept
    };
    assert!(kept(3) >= 3);
    assert_eq!(kept(4), 0);
}

#[test]
fn medians_and_extremes() {
    assert_eq!(TimingStats::from_times(Vec::new()), None);
    assert_eq!(
        TimingStats::from_times(vec![3.0, 1.0, 8.0]),
        Some(TimingStats {
            median: 3.0,
            min: 1.0,
            max: 8.0,
            runs: 3
        })
    );
    assert_eq!(
        TimingStats::from_times(vec![4.0, 1.0]).map(|s| s.median),
        Some(2.5)
    );
}

/// Full-size scenes are too slow for this test.
#[test]
fn small_built_in_scenes_leave_out_no_more_than_their_limits() {
    let scenes = umbrage_scenes::all().iter();
    let inputs: Vec<SceneInput> = scenes
        .filter(|entry| !entry.kind.is_full_size())
        .map(|entry| input(entry.name))
        .collect();
    let options = quick(&["none"]);
    let mut backends = Backends::cpu();
    let comparison = compare(
        &inputs,
        &options,
        &mut backends,
        &mut |_, _| Ok(()),
        &|_| (),
    );
    let mut over = Vec::new();
    for scene in comparison.expect("valid").scenes {
        let entry = umbrage_scenes::find(&scene.name).expect("built in");
        let share = scene.truth.share_left_out();
        let limit = entry.max_left_out.unwrap_or(0.05);
        assert!(share <= limit, "{}: {share}", scene.name);
        if share > 0.05 {
            over.push(entry.name);
        }
    }
    // Negative control: these need a limit of their own.
    assert!(
        over.contains(&"hills-1e6") && over.contains(&"foliage"),
        "{over:?}"
    );
}
