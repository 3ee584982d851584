//! Moving rows: shadows that crawl, shadows that follow, and cases that can't be measured.

use super::*;
use std::sync::Arc;

/// A tight fit crawls under a panning camera. Stable fits remove the crawl exactly. Rays have no
/// map that could crawl.
#[test]
fn panning_shimmers_on_a_tight_fit_and_not_on_a_stable_one() {
    let rendered = small_run(&["fence-pan", "fence-pan-stable"], &["hard", "traced"]);
    let [tight, stable] = &rendered.cases[..] else {
        panic!("both fits: {:?}", rendered.cases);
    };
    let shimmer_of = |case: &CaseResult, technique: &str| -> Vec<Judgement> {
        let cells = case.cells.iter().filter(|c| c.technique == technique);
        cells.map(|cell| cell.judgements()[0].clone()).collect()
    };
    let crawling = shimmer_of(tight, "hard");
    assert!(
        crawling.len() == 3 && crawling.iter().all(|j| j.verdict == Verdict::Fails),
        "{crawling:?}"
    );
    assert!(tight.cells.iter().any(|cell| cell.picture.is_some()));
    let resting = shimmer_of(stable, "hard");
    assert!(
        resting.len() == 3 && resting.iter().all(|j| j.figure == Some(0.0)),
        "{resting:?}"
    );
    let of_rays = shimmer_of(tight, "traced");
    assert!(
        !of_rays.is_empty() && of_rays.iter().all(|j| j.verdict == Verdict::NotMeasured),
        "{of_rays:?}"
    );
    assert!(shimmer_of(stable, "traced").is_empty());
    assert!(rendered.faults.is_empty());
}

/// Patterns that follow the pixel change at fixed points while the camera moves, with any fit. A
/// figure that could not have changed is not a pass.
#[test]
fn patterns_shimmer_and_what_cannot_change_is_not_measured() {
    let techniques = ["none", "hard", "pcf_dithered", "volumes", "traced"];
    let rendered = small_run(&["hills-pan", "hills-pan-stable"], &techniques);
    let [tight, stable] = &rendered.cases[..] else {
        panic!("both fits: {:?}", rendered.cases);
    };
    for cell in &tight.cells {
        let [shimmer, error] = cell.judgements() else {
            panic!("two measures: {cell:?}");
        };
        let is_held = ["none", "volumes", "traced"].contains(&cell.technique.as_str());
        let is_not_measured = shimmer.verdict == Verdict::NotMeasured;
        assert_eq!(is_not_measured, is_held, "{}: {shimmer:?}", cell.technique);
        assert_eq!(shimmer.reason.is_some(), is_held);
        // Its error is measured anyway.
        assert!(error.figure.is_some());
    }
    for cell in &stable.cells {
        let shimmer = cell.figure().expect("measured");
        let is_dithered = cell.technique == "pcf_dithered";
        assert_eq!(shimmer > 0.0, is_dithered, "{}: {shimmer}", cell.technique);
    }
}

/// While light and casters stand still, truth at fixed points doesn't change, so every change of a
/// mask is an error. While either moves, truth changes, so a shadow that stands still differs from
/// one that follows.
#[test]
fn truth_moves_with_light_and_casters_alone() {
    let options = small();
    for (_, case) in cases().filter(|(_, c)| c.motion != Motion::Still) {
        let case_truth = Arc::new(case_truth_of(case, &options));
        let moving = Moving::new(&case_truth, case.motion, options.frames, &options.truth)
            .expect("a built-in scene");
        let change = measures::shimmer::change(&moving.truth, &moving.marked);
        assert!(
            moving.points() > 50,
            "{}: {} points",
            case.name,
            moving.points()
        );
        assert_eq!(
            change > 0.0,
            case.motion.moves_shadows(),
            "{}: {change}",
            case.name
        );
        assert_eq!(
            case.measure == Measure::ChangeError,
            case.motion.moves_shadows(),
            "{}",
            case.name
        );
    }
}

/// A missing shadow doesn't crawl, but it doesn't follow the sun either.
#[test]
fn what_stands_still_under_a_turning_sun_fails() {
    let names = ["none", "traced"].map(str::to_owned).to_vec();
    let options = StabilityOptions {
        rows: vec!["13".to_owned()],
        techniques: names,
        ..small()
    };
    let mut backends = Backends::from_backends(vec![Box::new(Cpu::new())]);
    let result = run(&options, &mut backends, &mut |_| {})
        .expect("runs")
        .cases
        .remove(0);
    for (name, expected) in [("none", Verdict::Fails), ("traced", Verdict::Pass)] {
        let of_name = result.cells.iter().filter(|c| c.technique == name);
        let verdicts: Vec<Option<Verdict>> = of_name.map(Cell::verdict).collect();
        assert!(
            !verdicts.is_empty() && verdicts.iter().all(|v| *v == Some(expected)),
            "{name}: {verdicts:?}"
        );
    }
}

/// However slow the movement, standing still is worse than the passing limit.
#[test]
fn limits_of_slow_movement_are_below_standing_still() {
    let options = small();
    let case = case("hills-sun");
    let case_truth = Arc::new(case_truth_of(case, &options));
    let mut moving = Moving::new(&case_truth, case.motion, options.frames, &options.truth)
        .expect("a built-in scene");
    // Slow truth's movement down by a factor of a hundred.
    let first = moving.truth[0].clone();
    for frame in &mut moving.truth {
        for (visibility, at_first) in frame.iter_mut().zip(&first) {
            *visibility = at_first + (*visibility - at_first) / 100.0;
        }
    }
    let still = moving.figure(case.measure, &vec![first.clone(); moving.truth.len()]);
    let limits = moving.limits(case.measure, case.measure.limits(&case_truth));
    assert!(
        still > 0.0 && still < case.measure.limits(&case_truth).pass,
        "{still}: too fast for this test"
    );
    assert_eq!(
        limits.judge(still),
        Verdict::Fails,
        "{still} against {limits:?}"
    );
    assert_eq!(
        limits.judge(moving.figure(case.measure, &moving.truth)),
        Verdict::Pass
    );
}
