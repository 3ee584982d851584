//! Every row's measure can pass and can fail, its scene has the failure's cause, and known
//! weaknesses are detected.

mod backends;
mod bleeding;
mod moving;

use super::*;
use crate::{
    compare::Backends,
    faulty_backend::{FaultyBackend, darken_one},
};
use glam::UVec2;
use std::{
    collections::HashSet,
    sync::{
        Arc,
        atomic::{AtomicU32, Ordering},
    },
};
use umbrage_core::{Backend, BackendError, Fit, Invalid, Recipe, ShadowTechnique, Shadows, View};
use umbrage_cpu::Cpu;
use umbrage_plan::catalogue::Catalogue;
use umbrage_plan::truth::{self, TruthOptions};
use umbrage_techniques::{
    Bias, Hard, MapFilter as _, Pcss, Planar, SecondDepth, ShadowMap, ShadowVolumes,
    TechniquePreset, Traced,
};

/// Returns options small enough to run all cases in seconds.
fn small() -> StabilityOptions {
    let truth = TruthOptions {
        samples: 64,
        penumbra_factor: 1,
        probe_samples: 16,
        ..TruthOptions::default()
    };
    StabilityOptions {
        size: UVec2::new(96, 72),
        map_size: 512,
        frames: 4,
        truth,
        ..StabilityOptions::quick()
    }
}

fn case(name: &str) -> &'static StabilityCase {
    cases()
        .find(|(_, case)| case.name == name)
        .map(|(_, case)| case)
        .expect("in the list")
}

fn case_truth_of(case: &StabilityCase, options: &StabilityOptions) -> CaseTruth {
    case_truth(case, case.scene, options).expect("a built-in scene")
}

/// Returns the mean mask over the case's lights on the CPU.
fn mask(case_truth: &CaseTruth, technique: &dyn ShadowTechnique) -> Vec<f32> {
    let mut sum = vec![0.0; case_truth.truth.visibility.len()];
    for light in &case_truth.lights {
        let view: View<'_> = case_truth
            .view(light)
            .with_receivers(&case_truth.truth.receivers);
        let recipe = technique.recipe(&view).expect("supported");
        let shadows = Cpu::new().render(&view, &recipe).expect("renders");
        sum.iter_mut()
            .zip(&shadows.mask)
            .for_each(|(s, v)| *s += v / case_truth.lights.len() as f32);
    }
    sum
}

/// Returns the criteria of a still case.
fn criteria(case: &StabilityCase, case_truth: &CaseTruth) -> Vec<Criterion> {
    Criterion::of_case(case.measure, case_truth, |measure| {
        measure.limits(case_truth)
    })
}

/// Returns the worst verdict of a still case's criteria.
fn verdict(case: &StabilityCase, case_truth: &CaseTruth, mask: &[f32]) -> Verdict {
    let verdicts = criteria(case, case_truth).into_iter().map(|criterion| {
        let figure = criterion.measure.figure(case_truth, mask);
        criterion.limits.judge(figure)
    });
    verdicts.max().expect("each case has a measure")
}

#[test]
fn the_list_holds_every_row_once_and_every_scene_exists() {
    let numbers: Vec<u8> = rows().iter().map(|row| row.number).collect();
    assert_eq!(numbers, (1..=40).collect::<Vec<u8>>());
    let mut names = HashSet::new();
    for (_, case) in cases() {
        assert!(names.insert(case.name), "{} twice", case.name);
        assert!(
            case.entry().is_some(),
            "{}: no scene {}",
            case.name,
            case.scene
        );
    }
}

/// Each failure scene of the scene catalogue is run by a row.
#[test]
fn scenes_of_failures_are_rendered() {
    let rendered: HashSet<&str> = cases().map(|(_, case)| case.scene).collect();
    let left_out: Vec<&str> = umbrage_scenes::all()
        .iter()
        .filter(|e| {
            matches!(e.kind, umbrage_scenes::Kind::Failure(_)) && !rendered.contains(e.name)
        })
        .map(|e| e.name)
        .collect();
    // The light with an extent is only there for its penumbra.
    assert_eq!(left_out, ["glowing-lamp-in-room"]);
}

/// Every measure can pass and can fail. Truth's own technique passes every still row. Each
/// criterion fails with a fully lit or a fully dark mask. Without casters no shadow is left to
/// measure.
#[test]
fn every_still_row_can_pass_and_can_fail() {
    let options = small();
    // A single mask doesn't determine these; and 10,000 boxes are only for the command.
    let by_mask = |m: Measure| {
        !matches!(
            m,
            Measure::Fill | Measure::Shimmer | Measure::ChangeError | Measure::CascadeSeams
        )
    };
    for (_, case) in cases().filter(|(_, c)| by_mask(c.measure)) {
        let case_truth = case_truth_of(case, &options);
        let traced = mask(&case_truth, &Traced { samples: 256 });
        assert_eq!(
            verdict(case, &case_truth, &traced),
            Verdict::Pass,
            "{}: traced",
            case.name
        );
        if case.measure == Measure::AllLit && case_truth.counted_pixels().count() == 0 {
            continue;
        }
        for criterion in criteria(case, &case_truth) {
            assert!(
                criterion.can_fail(&case_truth),
                "{}: neither all light nor all shadow fails {criterion:?}",
                case.name
            );
        }
    }
}

#[test]
fn without_casters_no_shadow_is_left() {
    let options = small();
    for name in [
        "thin-plate",
        "stacked-slices",
        "hovering-feet",
        "fence",
        "hills",
        "long-plane",
        "into-light",
        "two-lights",
    ] {
        let case = case(name);
        let case_truth = case_truth_of(case, &options);
        assert!(case_truth.truth.has_shadow(), "{name}: no shadow");
        let bare = case_truth.geometry.without_casters();
        for light in &case_truth.lights {
            let truth = truth::trace(
                &case_truth.camera,
                light,
                &bare,
                &options.truth,
                &mut |camera, geometry| Cpu::new().receivers(camera, geometry),
                &|_, _| {},
            )
            .expect("valid");
            assert!(!truth.has_shadow(), "{name}: shadows without casters");
        }
    }
}

fn hard(bias: Bias) -> TechniquePreset {
    TechniquePreset::from(Hard {}.on(ShadowMap {
        size: 512,
        bias,
        ..ShadowMap::default()
    }))
}

/// Known weaknesses of techniques are detected, and truth's technique has none of them.
#[test]
fn known_weaknesses_are_seen() {
    let too_much = Bias {
        constant: 0.1,
        ..Bias::NONE
    };
    let map = ShadowMap {
        size: 512,
        bias: Bias::FRONT_CULL,
        ..ShadowMap::default()
    };
    let known: [(&str, TechniquePreset); 10] = [
        ("thin-plate", hard(too_much)),
        ("thin-plate-leak", hard(too_much)),
        ("low-sun-5", hard(Bias::NONE)),
        ("long-plane", hard(Bias::NONE)),
        (
            "open-shells",
            TechniquePreset::from(SecondDepth { radius: 0 }.on(map)),
        ),
        (
            "broken-meshes",
            TechniquePreset::from(SecondDepth { radius: 0 }.on(map)),
        ),
        ("rising-boxes", hard(Bias::ADAPTIVE)),
        ("two-blockers", hard(Bias::ADAPTIVE)),
        ("rising-boxes-disc", hard(Bias::ADAPTIVE)),
        ("canopy", hard(Bias::ADAPTIVE)),
    ];
    for (name, technique) in known {
        let case = case(name);
        let case_truth = case_truth_of(case, &small());
        let figure = case
            .measure
            .figure(&case_truth, &mask(&case_truth, &technique));
        let limits = case.measure.limits(&case_truth);
        assert_ne!(
            limits.judge(figure),
            Verdict::Pass,
            "{name}: {figure} passes {limits:?}"
        );
    }
}

/// Default PCSS passes where several blockers share one penumbra, and where penumbrae have
/// different widths.
#[test]
fn soft_shadows_pass_under_lamps() {
    let technique = Pcss::default().on(ShadowMap {
        size: 512,
        ..ShadowMap::default()
    });
    for name in [
        "two-blockers",
        "rising-boxes",
        "rising-boxes-disc",
        "canopy",
    ] {
        let case = case(name);
        let case_truth = case_truth_of(case, &small());
        let figure = case
            .measure
            .figure(&case_truth, &mask(&case_truth, &technique));
        let limits = case.measure.limits(&case_truth);
        println!("{name}: {figure} of {limits:?}");
        assert_eq!(
            limits.judge(figure),
            Verdict::Pass,
            "{name}: {figure} does not pass {limits:?}"
        );
    }
}

/// Runs these techniques in all cases of `rows`, or in all cases if it is empty, on the CPU.
fn small_run(rows: &[&str], techniques: &[&str]) -> Stability {
    let owned = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect();
    let options = StabilityOptions {
        rows: owned(rows),
        techniques: owned(techniques),
        ..small()
    };
    let mut backends = Backends::from_backends(vec![Box::new(Cpu::new())]);
    run(&options, &mut backends, &mut |_| {}).expect("runs")
}

/// The fixes of false shadow lead to no shadow at all. That fails every case in which visible
/// geometry is in shadow, and passes those in which it isn't.
#[test]
fn no_shadow_fails_wherever_something_casts() {
    let rendered = small_run(&[], &["none"]);
    let mut passing = Vec::new();
    for case in &rendered.cases {
        for cell in &case.cells {
            match cell.verdict() {
                Some(Verdict::Fails) => {}
                Some(Verdict::Pass) => passing.push(case.case.as_str()),
                other => panic!("{}: {other:?}", case.case),
            }
        }
    }
    assert_eq!(passing, ["no-casters", "no-receivers", "only-sky"]);
    assert_eq!(
        rendered.sanity_line().as_deref(),
        Some("3 sanity cases: all pass")
    );
}

/// Masks that only pass a one-sided measure fail.
#[test]
fn what_a_cure_takes_away_is_charged() {
    let options = small();
    // No acne, but no shadow; or no leak and no gap, but no light.
    let one_sided = [
        ("low-sun-5", 1.0_f32),
        ("long-plane", 1.0),
        ("far-range", 1.0),
        ("displaced-wall", 1.0),
        ("relief-without-depth-pass", 1.0),
        ("thin-plate", 0.0),
        ("thin-plate-leak", 0.0),
        ("hovering-feet", 0.0),
        ("bar-at-lamp", 0.0),
    ];
    for (name, visibility) in one_sided {
        let case = case(name);
        let case_truth = case_truth_of(case, &options);
        let mask = vec![visibility; case_truth.ideal.len()];
        let own = case.measure.figure(&case_truth, &mask);
        let own_limits = case.measure.limits(&case_truth);
        assert_eq!(own_limits.judge(own), Verdict::Pass, "{name}: {own}");
        let both = verdict(case, &case_truth, &mask);
        assert_eq!(both, Verdict::Fails, "{name}");
    }
}

/// Far from the origin less of truth's shadow is certain, and truth at texel centres is unreliable.
/// The limits are those near the origin, scaled by the cost of no shadow.
#[test]
fn limits_far_away_are_in_proportion() {
    let options = small();
    let case = case("hills-1e6");
    let far = case_truth_of(case, &options);
    let near = case_truth(case, "hills", &options).expect("a built-in scene");
    let far_cost = Measure::Rmse.without_shadow(&far);
    let near_cost = Measure::Rmse.without_shadow(&near);
    assert!(far_cost < 0.5 * near_cost, "{far_cost} {near_cost}");
    let limits = Measure::Rmse.limits_from(&far, &near);
    assert_eq!(limits.judge(far_cost), Verdict::Fails);
    assert_eq!(limits.judge(0.0), Verdict::Pass);
    let near_limits = Measure::Rmse.limits(&near);
    let shares = [limits.pass / far_cost, near_limits.pass / near_cost];
    assert!((shares[0] - shares[1]).abs() < 1e-9, "{shares:?}");
    // Limits of measures that a single mask doesn't determine are equal everywhere.
    let shimmer = Measure::Shimmer.limits_from(&far, &near);
    assert_eq!(shimmer, Measure::Shimmer.limits(&far));
}

fn false_light(case_truth: &CaseTruth, mask: &[f32]) -> f64 {
    let truth = &case_truth.truth;
    umbrage_core::metrics::Errors::measure(truth.size, mask, &truth.visibility, &truth.pixels)
        .expect("valid")
        .false_light
}

/// Relief that the depth pass omits casts no shadow into its joints: they are lit, compared with
/// the relief's truth.
#[test]
fn relief_that_the_map_lacks_leaves_joints_lit() {
    let whole = case_truth_of(case("displaced-wall"), &small());
    let split = case_truth_of(case("relief-without-depth-pass"), &small());
    let technique = hard(Bias::ADAPTIVE);
    let with = false_light(&whole, &mask(&whole, &technique));
    let without = false_light(&whole, &mask(&split, &technique));
    assert!(
        without > 3.0 * with && without > 1.0,
        "{with} % with the relief, {without} % without"
    );
}

/// Shadows on a normal-mapped wall are those of a flat wall. A bias along the relief's normals
/// gives them acne.
#[test]
fn a_bias_along_shading_normals_spoils_a_flat_wall() {
    let flat = case_truth_of(case("normal-mapped-wall"), &small());
    let relief = case_truth_of(case("displaced-wall"), &small())
        .truth
        .receivers;
    let mut bent = flat.truth.receivers.clone();
    bent.nx = relief.nx;
    bent.ny = relief.ny;
    bent.nz = relief.nz;
    let technique = hard(Bias::ADAPTIVE);
    let rmse_with = |receivers: &umbrage_core::Receivers| {
        let view = flat.view(&flat.lights[0]).with_receivers(receivers);
        let recipe = technique.recipe(&view).expect("supported");
        let shadows = Cpu::new().render(&view, &recipe).expect("renders");
        Measure::Rmse.figure(&flat, &shadows.mask)
    };
    let geometric = rmse_with(&flat.truth.receivers);
    let shading = rmse_with(&bent);
    assert!(
        shading > 1.2 * geometric,
        "{geometric} along geometric normals, {shading} along shading normals"
    );
}

/// Shadow volumes count exactly, also with the eye in an umbra and with open meshes.
#[test]
fn volumes_are_exact_where_counts_start_inside() {
    for name in ["eye-in-umbra", "eye-in-umbra-lamp"] {
        let case = case(name);
        let case_truth = case_truth_of(case, &small());
        assert_eq!(
            case.measure
                .figure(&case_truth, &mask(&case_truth, &ShadowVolumes::default())),
            0.0,
            "{name}"
        );
    }
}

/// Planar shadows are exact on flat receivers, including casters beyond the light and through the
/// floor.
#[test]
fn planar_shadows_have_no_anti_shadow() {
    let case = case("flat-receivers");
    let case_truth = case_truth_of(case, &small());
    let planar = mask(&case_truth, &Planar::default());
    assert_eq!(verdict(case, &case_truth, &planar), Verdict::Pass);
}

/// Open pixels have no edge nearby, and exist; a perfect map errs only at edges.
#[test]
fn open_pixels_are_right_on_a_perfect_map() {
    let case_truth = case_truth_of(case("stairs"), &small());
    let open = case_truth.open.iter().filter(|o| **o).count();
    assert!(open * 4 > case_truth.open.len(), "{open} open pixels");
    assert_eq!(
        super::measures::open::wrong(
            &case_truth.ideal,
            &case_truth.truth.visibility,
            &case_truth.open
        ),
        0.0
    );
    assert!(
        Measure::Rmse.figure(&case_truth, &case_truth.ideal) > 0.0,
        "edges must alias"
    );
    // A map with a quarter of the side errs more.
    let coarse = case_truth_of(
        case("stairs"),
        &StabilityOptions {
            map_size: 128,
            ..small()
        },
    );
    assert!(
        Measure::Rmse.figure(&coarse, &coarse.ideal)
            > Measure::Rmse.figure(&case_truth, &case_truth.ideal)
    );
}

/// A mask of the wrong size, or with an invalid visibility, has no RMSE and passes nowhere.
#[test]
fn what_is_no_mask_has_no_rmse() {
    let case = case("stairs");
    let case_truth = case_truth_of(case, &small());
    let mut spoilt = case_truth.truth.visibility.clone();
    assert_eq!(Measure::Rmse.figure(&case_truth, &spoilt), 0.0);
    spoilt[0] = f32::NAN;
    assert!(
        Measure::Rmse.figure(&case_truth, &spoilt).is_nan()
            && Measure::Rmse.figure(&case_truth, &[]).is_nan()
    );
    assert_eq!(
        Measure::Rmse.limits(&case_truth).judge(f64::NAN),
        Verdict::Fails
    );
}

#[test]
fn without_a_backend_nothing_runs() {
    let none = || Backends::from_backends(Vec::new());
    assert!(
        run(&small(), &mut none(), &mut |_| {})
            .expect_err("no backend")
            .to_string()
            .contains("backend")
    );
    assert!(sweeps::sweeps(&small(), &mut none(), &mut |_| {}).is_err());
}

#[test]
fn unknown_names_are_refused_with_what_there_is() {
    let rows = StabilityOptions {
        rows: vec!["41".to_owned()],
        ..small()
    };
    assert!(
        rows.validate()
            .expect_err("no such row")
            .to_string()
            .contains("1 to 40")
    );
    let techniques = StabilityOptions {
        techniques: vec!["vsm2".to_owned()],
        ..small()
    };
    assert!(
        techniques
            .validate()
            .expect_err("no such technique")
            .to_string()
            .contains("pcf")
    );
    let known = StabilityOptions {
        rows: vec!["3".to_owned(), "hills-pan".to_owned(), "fence".to_owned()],
        ..small()
    };
    assert!(known.validate().is_ok());
}

/// Equal runs return equal figures, whatever the state of the backend.
#[test]
fn runs_repeat_to_the_bit() {
    let options = StabilityOptions {
        rows: vec!["3".to_owned(), "17".to_owned()],
        ..small()
    };
    let mut backends = Backends::from_backends(vec![Box::new(Cpu::new())]);
    let mut figures = || {
        let stability = run(&options, &mut backends, &mut |_| {}).expect("runs");
        stability
            .cases
            .iter()
            .flat_map(|c| &c.cells)
            .map(|c| c.figure().map(f64::to_bits))
            .collect::<Vec<_>>()
    };
    assert_eq!(figures(), figures());
}

#[test]
fn settings_serve_any_fit() {
    assert!(
        settings(&Catalogue::built_in(), &[], 64, Fit::Tight).len()
            >= umbrage_techniques::all().len()
    );
}
