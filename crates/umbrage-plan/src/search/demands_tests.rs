//! Requirements on plans other than a small error: other bounds, several cameras, motion, the
//! clock.

use super::{
    tests::{plan_scene, scene, small, with_planner},
    *,
};
use crate::{
    cost::CostModel,
    estimate::{scene::RendererData, weighting::Weighting},
    motion::FrameMotion,
    truth,
};
use glam::UVec2;
use umbrage_core::{Camera, Fit, Receivers};
use umbrage_cpu::Cpu;
use umbrage_techniques::{
    Hard, MapFilter as _, MapTechnique, Pcf, ShadowMap, TechniquePreset, Traced,
};

/// The default bound rejects the grain of 4 to 6 rays a pixel. It accepts that of many rays and of
/// a smooth kernel.
#[test]
fn few_rays_are_grainy_and_smooth_kernels_are_not() {
    for name in ["rising-boxes", "rising-boxes-disc", "teapot-lamp"] {
        with_planner(name, |mut planner| {
            let bounds = Bounds::error(1.0);
            let mut grain = |preset: TechniquePreset| {
                let trials = &mut planner.trials;
                let setting = trials.try_out(&preset).expect("valid").expect("supported");
                let endured = trials
                    .with_grain_and_shimmer(setting, &bounds)
                    .expect("valid");
                endured.grain.expect("there are penumbrae")
            };
            let [four, six, many] = [4, 6, 64].map(|samples| grain(Traced { samples }.into()));
            let smooth = grain(Pcf::new(3).on(ShadowMap::default()).into());
            assert!(four > six && six > MAX_GRAIN, "{name}: {four} {six}");
            assert!(
                many < MAX_GRAIN && smooth < MAX_GRAIN,
                "{name}: {many} {smooth}"
            );
        });
    }
}

/// Shimmer comes from maps that move with the camera. It is 0 if the fit is stable or does not
/// move.
#[test]
fn only_fits_that_follow_the_camera_shimmer() {
    with_planner("cubes", |mut planner| {
        let bounds = Bounds {
            max_shimmer: Some(0.001),
            renderer: RendererData::SeenPoints,
            ..Bounds::error(1.0)
        };
        planner.trials.prepare(&bounds).expect("valid");
        let mut shimmer = |fit: Fit| {
            let map = ShadowMap {
                size: 256,
                fit,
                ..ShadowMap::default()
            };
            let trials = &mut planner.trials;
            let setting = trials
                .try_out(&Hard {}.on(map).into())
                .expect("valid")
                .expect("supported");
            let endured = trials
                .with_grain_and_shimmer(setting, &bounds)
                .expect("valid");
            endured.shimmer.expect("measured")
        };
        let [tight, stable] = [Fit::Tight, Fit::Stable { range: 30.0 }].map(&mut shimmer);
        assert!(tight > 0.001 && stable == 0.0, "{tight} {stable}");
    });
}

/// A plan for two cameras meets its bound at both. For half of them it meets the bound at the
/// easier one, at a lower cost.
#[test]
fn a_plan_holds_for_all_cameras_or_for_a_share() {
    let scene = scene("cubes");
    let near = scene.cameras[0];
    // From far above, the shadows cover a few pixels with any map.
    let far = Camera {
        world_from_view: near.world_from_view
            * glam::Affine3A::from_translation(glam::Vec3::Z * 40.0),
        ..near
    };
    let bounds = Bounds::error(0.05);
    let of = |cameras: Vec<Camera>, hold| {
        let options = PlanOptions {
            cameras,
            hold,
            ..small()
        };
        plan(&scene, &bounds, &options, &|_| {}).expect("can be planned")
    };
    let both = of(vec![near, far], Hold::Worst);
    let chosen = both.chosen.expect("possible");
    assert_eq!((both.cameras, chosen.cameras.len()), (2, 2));
    let errors: Vec<f64> = chosen.cameras.iter().map(|c| c.estimate.error).collect();
    assert_eq!(chosen.estimate.error, errors[0].max(errors[1]));
    assert!(chosen.cameras.iter().all(|c| c.estimate.high <= 0.06));
    let either = of(vec![near, far], Hold::Share(0.5));
    let easier = either.chosen.expect("possible");
    assert!(easier.milliseconds <= chosen.milliseconds);
    let alone = of(vec![near], Hold::Worst).chosen.expect("possible");
    assert!(alone.milliseconds <= chosen.milliseconds && alone.cameras.is_empty());
    // Reject an invalid share.
    let options = PlanOptions {
        hold: Hold::Share(2.0),
        ..small()
    };
    assert!(plan(&scene, &bounds, &options, &|_| {}).is_err());
}

/// A relative bound is that share of the error of no shadow.
#[test]
fn relative_bounds_are_shares_of_the_shadow_that_is_there() {
    let relative = plan_scene("cubes", &Bounds::relative_error(0.2));
    let none = relative.error_of_no_shadow;
    assert!(none.error > 0.1);
    let chosen = relative.chosen.expect("possible");
    assert!(chosen.estimate.high <= 0.2 * none.error, "{chosen:?}");
    let absolute = plan_scene("cubes", &Bounds::error(0.2 * none.low));
    assert_eq!(absolute.chosen.expect("possible").preset, chosen.preset);
    // A scene without shadows needs no technique.
    let empty = plan_scene("no-casters", &Bounds::relative_error(0.2));
    assert_eq!(empty.chosen.expect("possible").technique, "none");
}

/// While nothing moves, only the lookup counts, so finer maps cost nothing.
#[test]
fn what_moves_decides_what_counts() {
    let with = |motion| {
        let options = PlanOptions { motion, ..small() };
        let plan = plan(&scene("cubes"), &Bounds::error(0.05), &options, &|_| {});
        plan.expect("can be planned").chosen.expect("possible")
    };
    let [still, camera, all] = [
        FrameMotion::Still,
        FrameMotion::CameraMoves,
        FrameMotion::AllMoves,
    ]
    .map(with);
    assert!(still.milliseconds <= camera.milliseconds);
    assert!(camera.milliseconds <= all.milliseconds);
    assert!(still.milliseconds < all.milliseconds, "{still:?} {all:?}");
    assert_eq!(still.kept_as_camera_moves, None);
    assert!(camera.kept_as_camera_moves.is_some());
}

/// The classes of the image's receivers add up to the total.
#[test]
fn a_plan_says_for_how_many_pixels_it_holds() {
    let coverage = plan_scene("cubes", &Bounds::error(0.1)).coverage;
    assert_eq!(coverage.pixels, 160 * 120);
    let sum = coverage.certain + coverage.ambiguous + coverage.unlit;
    assert!(sum.abs_diff(coverage.receivers) <= 3, "{coverage:?}");
    assert!(coverage.certain > coverage.receivers / 2 && coverage.unlit > 0);
    assert!(coverage.unsampled_pixels() + coverage.traced + coverage.unlit >= coverage.receivers);
    let whole = {
        let scene = scene("cubes");
        let camera = scene.cameras[0].with_size(UVec2::new(160, 120));
        let geometry = Geometry::bake(&scene).expect("valid");
        let mut cpu = Cpu::new();
        let find = &mut |c: &Camera, g: &Geometry| -> Result<Receivers, _> { cpu.receivers(c, g) };
        let light = &scene.lights[0];
        let options = small().truth;
        truth::trace(&camera, light, &geometry, &options, find, &|_, _| {}).expect("valid")
    };
    let certain = (whole.pixels.iter())
        .filter(|p| **p == umbrage_core::metrics::Pixel::Counted)
        .count() as u64;
    // Twice the deviation that one in twenty exceeds.
    let reach = 2 * coverage.certain_margin + 1;
    assert!(
        certain.abs_diff(coverage.certain) <= reach,
        "{certain} {coverage:?}"
    );
}

/// Weighted samples estimate the weighted error of the whole image.
#[test]
fn weighted_samples_tell_of_whole_images() {
    let scene = scene("lamp-in-room");
    let camera = scene.cameras[0].with_size(UVec2::new(160, 120));
    let geometry = Geometry::bake(&scene).expect("valid");
    let options = PlanOptions {
        weighting: Weighting::Irradiance,
        ..small()
    };
    let mut planner =
        Planner::new(&camera, &scene.lights[0], &geometry, &options, &|_| {}).expect("valid");
    let preset = TechniquePreset::from(MapTechnique::<Hard>::default());
    let trials = &mut planner.trials;
    let first = trials.try_out(&preset).expect("valid").expect("supported");
    let verified = trials.verify(&first, None, &|_| {}).expect("valid");
    let view = &mut trials.views[0].scene;
    let all: Vec<u32> = (0..view.receivers.len() as u32).collect();
    let truth = view
        .truth_at(&all, &small().truth, &|_, _| {})
        .expect("valid");
    let mask = view.preset_mask(&preset).expect("valid");
    let mut sums = [0.0; 2];
    for (i, truth) in truth.iter().enumerate() {
        if truth.pixel == umbrage_core::metrics::Pixel::Counted {
            let difference = f64::from(mask[i]) - f64::from(truth.visibility);
            sums[0] += view.weights[i] * difference.powi(2);
            sums[1] += view.weights[i];
        }
    }
    let whole = sums[0] / sums[1];
    for e in [first.estimate, verified.estimate] {
        let reach = 3.0 * (e.high.powi(2) - e.error.powi(2)) + 1e-9;
        assert!(
            (whole - e.error.powi(2)).abs() <= reach,
            "{e:?} for {}",
            whole.sqrt()
        );
    }
}

/// Measured times choose the fastest setting, and all finalists are listed.
#[test]
fn the_clock_decides_between_finalists() {
    let scene = scene("cubes");
    let bounds = Bounds::error(0.1);
    let mut cpu = Cpu::new();
    let plan =
        plan_by_clock(&scene, &bounds, &small(), Some(&mut cpu), &|_| {}).expect("can be planned");
    let chosen = plan.chosen.expect("possible");
    let times: Vec<f64> = plan.timed.iter().filter_map(|s| s.measured_ms).collect();
    assert!(times.len() > 1 && times.is_sorted(), "{times:?}");
    assert_eq!(chosen.measured_ms, Some(times[0]));
    assert!(plan.timed.iter().all(|s| s.estimate.is_surely_within(0.1)));
    // A measured time over the bound is a miss, whatever the price list predicts.
    let slow = Bounds {
        max_ms: Some(1e6),
        ..bounds
    };
    assert!(
        plan_by_clock(&scene, &slow, &small(), Some(&mut cpu), &|_| {})
            .expect("plans")
            .miss
            .is_none()
    );
    let quick = Bounds {
        max_ms: Some(1e-6),
        ..Bounds::milliseconds(1e-6)
    };
    let options = PlanOptions {
        cost: CostModel {
            nanoseconds: [0.0; crate::cost::KINDS],
        },
        ..small()
    };
    let miss = plan_by_clock(&scene, &quick, &options, Some(&mut cpu), &|_| {})
        .expect("plans")
        .miss;
    assert!(miss.is_some_and(|miss| miss.reason.contains("when timed")));
}
