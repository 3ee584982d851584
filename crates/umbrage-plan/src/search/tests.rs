//! Plans of scenes whose best technique is known, and comparisons of samples with whole images.

use super::{
    bias_search::best_bias,
    families::{Family, families},
    *,
};
use crate::{
    catalogue::{self, Catalogue},
    cost::{CostModel, KIND_NAMES, KINDS},
    estimate::error::Estimate,
    motion::FrameMotion,
    progress::Step,
    truth::{self, TruthOptions},
};
use glam::UVec2;
use std::sync::atomic::{AtomicUsize, Ordering};
use umbrage_core::{
    Camera, Fit, Light, Receivers, RecipeError, ShadowTechnique as _, View,
    metrics::{Errors, Pixel},
};
use umbrage_cpu::Cpu;
use umbrage_techniques::TechniquePreset;

pub(super) fn scene(name: &str) -> Scene {
    umbrage_scenes::by_argument(name).expect("built in")
}

/// Small images: fast, and as hard to plan for.
pub(super) fn small() -> PlanOptions {
    PlanOptions {
        samples: 1024,
        size: Some(UVec2::new(160, 120)),
        motion: FrameMotion::AllMoves,
        ..PlanOptions::default()
    }
}

pub(super) fn plan_scene(name: &str, bounds: &Bounds) -> Plan {
    plan(&scene(name), bounds, &small(), &|_| {}).expect("can be planned")
}

/// Runs `f` with a planner of a scene.
pub(super) fn with_planner<R>(name: &str, f: impl FnOnce(Planner<'_>) -> R) -> R {
    let scene = scene(name);
    let camera = scene.cameras[0].with_size(UVec2::new(160, 120));
    let geometry = Geometry::bake(&scene).expect("built in");
    f(
        Planner::new(&camera, &scene.lights[0], &geometry, &small(), &|_| {})
            .expect("can be planned"),
    )
}

#[test]
fn where_nothing_casts_there_is_no_shadow_to_make() {
    for name in ["no-casters", "only-sky", "no-receivers"] {
        let plan = plan_scene(name, &Bounds::error(0.01));
        assert_eq!(
            plan.chosen.as_ref().map(|c| c.technique.as_str()),
            Some("none"),
            "{name}"
        );
    }
}

/// On flat receivers under an ideal light several techniques are exact, and the cheapest one wins.
#[test]
fn exact_techniques_are_distinguished_by_cost() {
    let exact = |plan: Plan| plan.chosen.expect("rays are exact");
    let chosen = exact(plan_scene("c1-box-sun", &Bounds::error(0.0)));
    assert_eq!(
        (chosen.technique.as_str(), chosen.estimate.high),
        ("planar", 0.0)
    );
    // If images are expensive, techniques without images win: rays, lists or a device's hierarchy,
    // whichever costs less.
    let [tap, ray, walk] = [
        "tap",
        "ray, per level of the hierarchy",
        "walk through it, per level",
    ];
    for (dear, winner) in [
        ([tap, walk], "traced 1 rays"),
        ([ray, walk], "exact lists"),
        ([tap, ray], "exact hierarchy"),
    ] {
        let mut cost = CostModel {
            nanoseconds: [1e-3; KINDS],
        };
        for name in ["texel cleared"].into_iter().chain(dear) {
            let kind = KIND_NAMES.iter().position(|k| *k == name);
            cost.nanoseconds[kind.expect("a kind of work")] = 1e6;
        }
        let options = PlanOptions { cost, ..small() };
        let other = exact(
            plan(&scene("c1-box-sun"), &Bounds::error(0.0), &options, &|_| {})
                .expect("can be planned"),
        );
        let found = format!("{} {}", other.technique, other.settings);
        assert_eq!(found, winner, "if {dear:?} are expensive");
    }
}

/// With penumbrae of many widths, the kernel of variable width has a smaller error than fixed ones.
#[test]
fn a_soft_lamp_needs_soft_shadows() {
    with_planner("rising-boxes", |mut planner| {
        let all = families(
            &planner.trials.counting.catalogue,
            planner.trials.views[0].scene.light,
            false,
        );
        let mut best = |name: &str| {
            let mine: Vec<&Family> = all
                .iter()
                .filter(|f| f.preset().technique().name() == name)
                .collect();
            let best_of = |f: &&Family| {
                best_bias(&mut planner.trials, f, 4, None)
                    .expect("valid")
                    .map(|s| s.estimate.error)
            };
            mine.iter()
                .filter_map(best_of)
                .fold(f64::INFINITY, f64::min)
        };
        let [pcss, pcf, hard] = ["pcss", "pcf", "hard"].map(&mut best);
        assert!(pcss < 0.9 * pcf && pcf < hard, "{pcss} {pcf} {hard}");
    });
}

/// Estimates from a sample hold for the whole image, within twice the 90 % bounds, on every scene
/// and setting.
#[test]
fn samples_tell_of_whole_images() {
    for name in ["cubes", "c4-edge-square", "low-sun-5", "lamp-in-room"] {
        with_planner(name, |mut planner| {
            let scene = &mut planner.trials.views[0].scene;
            let all: Vec<u32> = (0..scene.receivers.len() as u32).collect();
            let truth = scene
                .truth_at(&all, &small().truth, &|_, _| {})
                .expect("can be traced");
            let (visibility, pixels): (Vec<f32>, Vec<_>) =
                truth.iter().map(|t| (t.visibility, t.pixel)).unzip();
            for preset in [64, 512].into_iter().flat_map(presets_of_size) {
                let Some(setting) = planner.trials.try_out(&preset).expect("valid") else {
                    continue;
                };
                let mask = planner.trials.views[0]
                    .scene
                    .preset_mask(&preset)
                    .expect("valid");
                let whole = Errors::measure(UVec2::new(160, 120), &mask, &visibility, &pixels)
                    .expect("fits")
                    .rmse;
                let e = setting.estimate;
                let reach = 2.0 * (e.high.powi(2) - e.error.powi(2)) + 1e-9;
                let off = (whole.powi(2) - e.error.powi(2)).abs();
                assert!(
                    off <= reach,
                    "{name}: {}: {} for {whole}",
                    setting.label(),
                    e.error
                );
            }
        });
    }
}

/// Returns every technique with its defaults except for the size of its map.
fn presets_of_size(size: u32) -> Vec<TechniquePreset> {
    let at = |p: TechniquePreset| match p.map() {
        Some(&map) => p.with_map(umbrage_techniques::ShadowMap { size, ..map }),
        None => p,
    };
    TechniquePreset::defaults().into_iter().map(at).collect()
}

/// A shadow between the samples may be missed by all sampled receivers. The pilot finds it, since
/// it traces rays at all receivers.
#[test]
fn what_no_sample_shows_a_second_look_does() {
    for name in ["cubes", "rising-boxes"] {
        with_planner(name, |mut planner| {
            // Use a sample that contains only lit receivers.
            let sampled = &mut planner.trials.views[0].sampled;
            let lit: Vec<usize> = (0..sampled.truth.len())
                .filter(|&k| sampled.truth[k].visibility == 1.0)
                .collect();
            sampled.sample.chances = lit.iter().map(|&k| sampled.sample.chances[k]).collect();
            sampled.sample.pixels = lit.iter().map(|&k| sampled.sample.pixels[k]).collect();
            sampled.truth = lit.iter().map(|&k| sampled.truth[k]).collect();
            let none = TechniquePreset::from(umbrage_techniques::Unshadowed::default());
            let blind = planner
                .trials
                .try_out(&none)
                .expect("valid")
                .expect("supported");
            assert_eq!(blind.estimate.high, 0.0, "{name}");
            let seen = planner
                .trials
                .verify(&blind, None, &|_| {})
                .expect("valid")
                .estimate;
            assert!(seen.error > 0.1, "{name}: {seen:?}");
        });
    }
}

/// Verified estimates are more precise than those of the first sample. Their bounds hold as often
/// as stated. Under ideal lights, the only uncertainty is the number of pixels that count.
#[test]
fn second_looks_tell_of_whole_images() {
    let (mut compared, mut within) = (0, 0);
    for name in [
        "c7-closed-room",
        "low-sun-5",
        "cubes",
        "rising-boxes",
        "canopy",
    ] {
        with_planner(name, |mut planner| {
            let scene = &mut planner.trials.views[0].scene;
            let all: Vec<u32> = (0..scene.receivers.len() as u32).collect();
            let truth = scene
                .truth_at(&all, &small().truth, &|_, _| {})
                .expect("can be traced");
            let (visibility, pixels): (Vec<f32>, Vec<_>) =
                truth.iter().map(|t| (t.visibility, t.pixel)).unzip();
            for preset in presets_of_size(64) {
                let Some(setting) = planner.trials.try_out(&preset).expect("valid") else {
                    continue;
                };
                let mask = planner.trials.views[0]
                    .scene
                    .preset_mask(&preset)
                    .expect("valid");
                let whole = Errors::measure(UVec2::new(160, 120), &mask, &visibility, &pixels)
                    .expect("fits")
                    .rmse;
                let e = planner
                    .trials
                    .verify(&setting, None, &|_| {})
                    .expect("valid")
                    .estimate;
                // Three times the error that one in twenty exceeds: five standard errors.
                let reach = 3.0 * (e.high.powi(2) - e.error.powi(2)) + 1e-9;
                let off = (whole.powi(2) - e.error.powi(2)).abs();
                assert!(
                    off <= reach,
                    "{name}: {}: {e:?} for {whole}",
                    setting.label()
                );
                compared += 1;
                within += u32::from(e.low - 1e-6 <= whole && whole <= e.high + 1e-6);
            }
        });
    }
    // Nine in ten are expected. Settings of one scene share a sample and their errors are
    // correlated, so up to a fifth may be outside.
    assert!(
        compared > 40 && within * 5 >= compared * 4,
        "{within} of {compared}"
    );
}

/// A repeated verification returns the same estimate, even with the greatest seed. It keeps
/// everything from the first sample.
#[test]
fn second_looks_can_be_repeated() {
    with_planner("rising-boxes", |mut planner| {
        planner.trials.views[0].verifier.sampling.seed = u32::MAX;
        // Set the error to 0, as in a sample that misses rare artefacts.
        let hard = planner
            .trials
            .try_out(&TechniquePreset::defaults()[1])
            .expect("valid")
            .expect("supported");
        let blind = Setting {
            estimate: Estimate::default(),
            ..hard
        };
        let once = planner
            .trials
            .verify(&blind, Some(1e-3), &|_| {})
            .expect("valid");
        assert!(once.estimate.error > 0.0);
        let twice = planner
            .trials
            .verify(&once, Some(1e-3), &|_| {})
            .expect("valid");
        assert_eq!(twice, once);
    });
}

/// Without rays, only the first sample is available, and its estimates are kept.
#[test]
fn without_a_pilot_the_first_sample_must_do() {
    with_planner("rising-boxes", |mut planner| {
        let [none, hard] = [0, 1].map(|i| TechniquePreset::defaults()[i].clone());
        planner.trials.views[0].verifier.pilot = None;
        for preset in [none.clone(), hard] {
            let first = planner
                .trials
                .try_out(&preset)
                .expect("valid")
                .expect("supported");
            let again = planner
                .trials
                .verify(&first, Some(0.1), &|_| {})
                .expect("valid");
            assert!(first.estimate.error > 0.0);
            assert_eq!(again.estimate, first.estimate);
        }
        // A verified setting keeps its first estimate.
        planner.trials.forget();
        let blind = Setting {
            estimate: Estimate::default(),
            ..planner
                .trials
                .try_out(&none)
                .expect("valid")
                .expect("supported")
        };
        let again = planner
            .trials
            .verify(&blind, None, &|_| {})
            .expect("valid")
            .estimate;
        assert!(again.error == 0.0 && again.high > 0.01, "{again:?}");
    });
}

/// Without casters, few rays can't prove that nothing casts. All rays of a pilot prove it within 3
/// divided by their number.
#[test]
fn none_of_n_rays_is_not_never() {
    let lamp = Light::Disc {
        center: glam::Vec3::Y * 5.0,
        normal: -glam::Vec3::Y,
        radius: 0.5,
    };
    let high = |light: Light| {
        let scene = Scene {
            lights: vec![light],
            ..scene("no-casters")
        };
        let plan = plan(&scene, &Bounds::error(0.1), &small(), &|_| {}).expect("can be planned");
        let estimate = plan.chosen.expect("possible").estimate;
        assert_eq!(estimate.error, 0.0);
        estimate.high
    };
    assert_eq!(high(scene("no-casters").lights[0]), 0.0);
    // Rule of three: 3 / n, with 2 rays at each of at most 160 x 120 receivers, and at least a
    // third of them.
    let least = (3.0 / 38_400.0_f64).sqrt();
    let high = high(lamp);
    assert!(least <= high && high <= 3.0_f64.sqrt() * least, "{high}");
}

/// Truth decides the choice. If truth is set to almost lit everywhere, including for verification,
/// no shadow is needed.
#[test]
fn spoilt_truth_changes_the_choice() {
    with_planner("cubes", |mut planner| {
        let bounds = Bounds::error(0.05);
        let right = planner
            .plan(&bounds)
            .expect("can be planned")
            .chosen
            .expect("possible");
        assert_ne!(right.technique, "none");
        let all: Vec<u32> = (0..planner.trials.views[0].scene.receivers.len() as u32).collect();
        planner.trials.views[0]
            .scene
            .truth_at(&all, &small().truth, &|_, _| {})
            .expect("can be traced");
        let view = &mut planner.trials.views[0];
        let remembered = view.scene.truth.values_mut();
        view.sampled
            .truth
            .iter_mut()
            .chain(remembered)
            .for_each(|t| t.visibility = 0.999);
        planner.trials.forget();
        let wrong = planner
            .plan(&bounds)
            .expect("can be planned")
            .chosen
            .expect("possible");
        assert_eq!(wrong.technique, "none");
    });
}

#[test]
fn the_same_seed_gives_the_same_plan() {
    let untimed = |mut plan: Plan| {
        (plan.sampled.looking, plan.sampled.trying) = (0.0, 0.0);
        plan
    };
    let [a, b] = [(); 2].map(|()| untimed(plan_scene("open-shells", &Bounds::error(0.1))));
    assert_eq!(a, b);
    assert!(!a.reasons.is_empty() && a.curve.iter().filter(|p| p.chosen).count() == 1);
}

#[test]
fn what_cannot_be_is_reported_with_the_bound_that_fails() {
    // Few samples are enough, since the bounds are missed by far.
    let options = PlanOptions {
        samples: 128,
        ..small()
    };
    let scene = scene("c4-edge-square");
    let miss = |bounds: &Bounds| {
        let plan = plan(&scene, bounds, &options, &|_| {}).expect("can be planned");
        plan.preset().expect_err("impossible")
    };
    let error = miss(&Bounds::error(0.0));
    assert!(
        error.reason.contains("no technique meets an error of 0"),
        "{error}"
    );
    assert!(error.best.is_some_and(|best| best.estimate.error < 0.05));
    let time = miss(&Bounds::milliseconds(0.0));
    assert!(time.reason.contains("ms"), "{time}");
    let both = miss(&Bounds {
        max_error: Some(0.1),
        max_ms: Some(1e-3),
        ..Bounds::default()
    });
    assert!(both.reason.contains("an error of 0.1 needs"), "{both}");
}

#[test]
fn within_a_time_the_most_accurate_is_chosen() {
    let within = |ms| {
        plan_scene("cubes", &Bounds::milliseconds(ms))
            .chosen
            .expect("possible")
    };
    let much = within(5.0);
    let less = 0.75 * much.milliseconds;
    let little = within(less);
    assert!(much.milliseconds <= 5.0 && little.milliseconds <= less);
    assert!(
        much.estimate.error < little.estimate.error,
        "{} {}",
        much.label(),
        little.label()
    );
}

/// A receiver evaluated alone returns the same bits as in the whole image, also with patterns that
/// depend on its position.
#[test]
fn receivers_queried_alone_answer_the_same() {
    for name in ["cubes", "rising-boxes-disc", "lamp-in-room"] {
        let scene = scene(name);
        let camera = scene.cameras[0].with_size(UVec2::new(96, 54));
        let geometry = Geometry::bake(&scene).expect("built in");
        let mut cpu = Cpu::new();
        let receivers = cpu.receivers(&camera, &geometry).expect("valid");
        let view = View::new(&camera, &scene.lights[0], &geometry).with_receivers(&receivers);
        let pixels: Vec<u32> = (0..receivers.len() as u32).filter(|i| i % 7 != 3).collect();
        for technique in catalogue::all()
            .iter()
            .flat_map(|e| (e.settings)(&[128], Fit::Tight))
        {
            let recipe = match technique.recipe(&view) {
                Ok(recipe) => recipe,
                Err(RecipeError::Unsupported(_)) => continue,
                Err(e) => panic!("{name}: {}: {e}", technique.name()),
            };
            let whole = cpu.render(&view, &recipe).expect("valid").mask;
            let alone = cpu.render_pixels(&view, &recipe, &pixels).expect("valid");
            let same = pixels
                .iter()
                .zip(&alone)
                .all(|(&i, v)| whole[i as usize].to_bits() == v.to_bits());
            assert!(
                same,
                "{name}: {} ({})",
                technique.name(),
                technique.settings()
            );
        }
    }
}

/// The truth of some pixels is that of the whole image.
#[test]
fn some_pixels_have_the_truth_of_all() {
    let scene = scene("rising-boxes");
    let camera = scene.cameras[0].with_size(UVec2::new(64, 36));
    let geometry = Geometry::bake(&scene).expect("built in");
    let options = TruthOptions {
        samples: 16,
        probe_samples: 16,
        ..TruthOptions::default()
    };
    let mut cpu = Cpu::new();
    let find = &mut |c: &Camera, g: &Geometry| -> Result<Receivers, _> { cpu.receivers(c, g) };
    let light: &Light = &scene.lights[0];
    let whole = truth::trace(&camera, light, &geometry, &options, find, &|_, _| {}).expect("valid");
    let pixels: Vec<u32> = (0..64 * 36).filter(|i| i % 5 == 2).rev().collect();
    let request = truth::TruthRequest {
        camera: &camera,
        geometry: &geometry,
        receivers: &whole.receivers,
        pixels: &pixels,
    };
    let some = truth::trace_pixels(&request, light, &options, find, &|_, _| {}).expect("valid");
    for (&i, t) in pixels.iter().zip(&some) {
        let i = i as usize;
        assert_eq!(
            (t.visibility, t.error, t.pixel),
            (whole.visibility[i], whole.error[i], whole.pixels[i]),
            "{i}"
        );
    }
    assert!(
        some.iter()
            .any(|t| t.visibility > 0.0 && t.visibility < 1.0),
        "no penumbra was compared"
    );
}

/// The search skips candidates and stops early. On this scene an exhaustive sweep finds nothing
/// cheaper.
#[test]
fn a_sweep_finds_nothing_much_cheaper() {
    let found = regret(&scene("cubes"), &[0.08], &small(), None, &|_| {}).expect("can be planned");
    assert!(found.iter().all(|r| !r.misses()), "{found:?}");
    let spoilt = Regret {
        error: 0.2,
        ..found[0].clone()
    };
    assert!(spoilt.misses());
    let dear = Regret {
        min_milliseconds: found[0].min_milliseconds / 2.0,
        ..found[0].clone()
    };
    assert!(dear.misses());
}

/// Each kind of bias applies the bias that it names.
#[test]
fn biases_are_those_of_their_kinds() {
    for family in families(
        &Catalogue::built_in(),
        &Light::Point {
            position: glam::Vec3::Y,
            radius: 0.1,
        },
        true,
    ) {
        for biases in family.bias_amounts() {
            let preset = family.preset_at(0, biases.kind, biases.first());
            let own = family
                .preset()
                .map()
                .map(|map| biases.kind.bias(biases.first(), map.bias));
            assert_eq!(preset.map().map(|map| map.bias), own);
        }
    }
}

/// Unlit receivers are not part of a sample. Under a spot that lights a tenth of the image,
/// techniques differ from rays outside the cone. Verification measures the errors within it.
#[test]
fn second_looks_under_a_spot_see_what_it_lights() {
    let scene = scene("night-room");
    let camera = scene.cameras[0].with_size(UVec2::new(320, 180));
    let geometry = Geometry::bake(&scene).expect("built in");
    let options = PlanOptions {
        samples: 64,
        ..small()
    };
    let mut planner = Planner::new(&camera, &scene.lights[1], &geometry, &options, &|_| {})
        .expect("can be planned");
    let view = &mut planner.trials.views[0];
    let all: Vec<u32> = (0..view.scene.receivers.len() as u32).collect();
    let truth = (view.scene)
        .trace_at(&all, &options.truth, &|_, _| {})
        .expect("can be traced");
    let lit = view.scene.lit_pixels(&options.truth).expect("valid");
    let is_lit = |pixel| matches!(pixel, Pixel::Counted | Pixel::Ambiguous);
    assert!((0..lit.len()).all(|i| lit[i] == is_lit(truth[i].pixel)));
    let (visibility, pixels): (Vec<f32>, Vec<_>) =
        truth.iter().map(|t| (t.visibility, t.pixel)).unzip();
    let hard = TechniquePreset::defaults()[1].clone();
    let map = hard.map().copied().expect("has a map");
    for size in [64, 128, 256] {
        let preset = hard.with_map(umbrage_techniques::ShadowMap { size, ..map });
        let setting = planner.trials.try_out(&preset).expect("valid");
        let mask = (planner.trials.views[0].scene)
            .preset_mask(&preset)
            .expect("valid");
        let whole = Errors::measure(camera.size, &mask, &visibility, &pixels)
            .expect("fits")
            .rmse;
        assert!(whole > 0.02, "{size}: {whole}");
        let e = planner
            .trials
            .verify(&setting.expect("supported"), None, &|_| {})
            .expect("valid")
            .estimate;
        // All differing pixels are sampled. Only the number of counted pixels is uncertain.
        assert!(
            (e.error / whole - 1.0).abs() < 0.05 && e.high < 1.1 * whole,
            "{size}: {e:?} for {whole}"
        );
    }
}

#[test]
fn a_plan_that_is_called_off_tries_nothing_more() {
    let options = small();
    let tried = AtomicUsize::new(0);
    let call_off = |step: Step<'_>| {
        if matches!(step, Step::Trying(..)) && tried.fetch_add(1, Ordering::Relaxed) == 2 {
            options.cancel.cancel();
        }
    };
    let outcome = plan(&scene("cubes"), &Bounds::error(0.0), &options, &call_off);
    assert!(matches!(outcome, Err(MeasureError::Cancelled)));
    assert_eq!(tried.into_inner(), 3);
}
