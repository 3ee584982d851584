//! Baselines with changes that must be detected, and with changes that must not.

use super::*;
use crate::compare::{Measured, Ranks, SCHEMA, TimingStats};
use umbrage_core::metrics::{Causes, Errors};
use umbrage_plan::cost::Work;

fn row(backend: &str) -> CompareRow {
    let total = TimingStats {
        median: 2.0,
        min: 1.9,
        max: 2.2,
        runs: 9,
    };
    let ratio = Ranks::from_figures(vec![1.0; 9]);
    let measured = Measured {
        errors: Some(Errors {
            rmse: 0.1,
            false_shadow: 1.0,
            false_light: 2.0,
            acne: 0.5,
            ..Errors::default()
        }),
        causes: Some(Causes::default()),
        times: Some(RowTimes {
            total,
            ratio,
            yardstick: Some(total),
            ..RowTimes::default()
        }),
        work: Work {
            taps: 1000,
            ..Work::default()
        },
        cost_ms: 0.1,
        executed_cost_ms: None,
        bytes: 4096,
        ..Measured::default()
    };
    let outcome = RowOutcome::Measured(Box::new(measured));
    let (technique, settings) = ("pcf".to_owned(), "3x3".to_owned());
    CompareRow {
        slug: technique.clone(),
        technique,
        settings,
        backend: backend.to_owned(),
        same_as: None,
        outcome,
    }
}

fn scene(name: &str) -> SceneResult {
    SceneResult {
        name: name.into(),
        rows: vec![row("cpu"), row("wgpu")],
        ..SceneResult::default()
    }
}

fn comparison() -> Comparison {
    Comparison {
        schema: SCHEMA,
        scenes: vec![scene("cubes")],
        ..Comparison::default()
    }
}

fn exception_for(names: &[&str]) -> Except {
    Except::new(names.iter().map(|name| (*name).to_owned()))
}

fn changes(old: &Comparison, new: &Comparison) -> Changes {
    super::changes(old, new, &Except::default())
}

fn measured_row(comparison: &mut Comparison, row: usize) -> &mut Measured {
    let RowOutcome::Measured(m) = &mut comparison.scenes[0].rows[row].outcome else {
        unreachable!("made so")
    };
    m
}

fn errors(m: &mut Measured) -> &mut Errors {
    m.errors.as_mut().expect("made so")
}

/// Returns the changes after a change of row `index`.
fn changes_after(index: usize, change: impl Fn(&mut Measured)) -> Changes {
    let mut new = comparison();
    change(measured_row(&mut new, index));
    changes(&comparison(), &new)
}

/// Returns the result for two compared rows without changes.
fn no_changes() -> Changes {
    Changes {
        compared: 2,
        timed: 2,
        ..Changes::default()
    }
}

#[test]
fn another_light_or_camera_is_not_compared() {
    let mut moved = comparison();
    moved.scenes[0].rmse_of_none[0] += 0.01;
    let found = changes(&comparison(), &moved);
    assert_eq!((found.compared, found.lost.len()), (0, 1), "{found:?}");
}

#[test]
fn the_same_is_no_change() {
    assert_eq!(changes(&comparison(), &comparison()), no_changes());
}

#[test]
fn less_accurate_is_worse_and_more_accurate_better() {
    let worse: [fn(&mut Measured); 6] = [
        |m| errors(m).rmse += 1e-6,
        |m| errors(m).false_shadow += 1e-3,
        |m| errors(m).false_light += 1e-3,
        |m| errors(m).acne += 1e-3,
        |m| m.work.taps += 1,
        |m| m.bytes += 1,
    ];
    for spoil in worse {
        let found = changes_after(0, spoil);
        assert_eq!((found.worse.len(), found.better.len()), (1, 0), "{found:?}");
        assert!(
            found.worse[0].starts_with("cubes: pcf (3x3) on cpu: "),
            "{found:?}"
        );
    }
    let found = changes_after(0, |m| errors(m).rmse -= 1e-6);
    assert_eq!((found.worse.len(), found.better.len()), (0, 1));
    assert_eq!(
        changes_after(0, |m| errors(m).rmse *= 1.0 + 1e-12),
        no_changes(),
        "rounding"
    );
}

/// Sets all ratios of a row to this factor.
fn slow_down(m: &mut Measured, factor: f64) {
    m.times.as_mut().expect("made so").ratio = Ranks::from_figures(vec![factor; 9]);
}

#[test]
fn what_looks_slower_is_a_suspect_and_no_more() {
    let found = changes_after(0, |m| slow_down(m, 2.0));
    assert!(
        found.worse.is_empty() && found.suspects.len() == 1,
        "{found:?}"
    );
    assert_eq!(found.suspects[0].label, "cubes: pcf (3x3) on cpu");
    let requested = &found.suspects[0].rows[0];
    assert_eq!((requested.scene, &*requested.stem), (0, "pcf.cpu"));
    assert_eq!(
        changes_after(0, |m| slow_down(m, 1.3)),
        no_changes(),
        "less than what counts"
    );
    assert_eq!(
        changes_after(0, |m| m.times.as_mut().expect("made so").total.median =
            99.0),
        no_changes(),
        "the yardstick was slow, too"
    );
}

#[test]
fn on_another_machine_costs_count_and_times_do_not() {
    let mut new = comparison();
    new.environment.cpu = "another".into();
    slow_down(measured_row(&mut new, 0), 99.0);
    let found = changes(&comparison(), &new);
    assert!(
        found.worse.is_empty() && found.suspects.is_empty(),
        "{found:?}"
    );
    assert!(
        found.notes.len() == 1 && found.notes[0].contains("another"),
        "{found:?}"
    );
    let m = measured_row(&mut new, 0);
    m.work.rays += 100;
    m.work.casters = 10;
    assert_eq!(changes(&comparison(), &new).worse.len(), 1);
}

/// Results of schema 4 and before: accuracy is compared, and a note states that times aren't.
#[test]
fn without_yardsticks_accuracy_counts_and_times_do_not() {
    let mut old = Comparison {
        schema: 4,
        ..comparison()
    };
    for row in 0..2 {
        let times = measured_row(&mut old, row).times.as_mut().expect("made so");
        (times.yardstick, times.ratio) = (None, None);
    }
    let mut new = comparison();
    slow_down(measured_row(&mut new, 0), 99.0);
    let found = changes(&old, &new);
    assert!(
        found.suspects.is_empty() && (found.compared, found.timed) == (2, 0),
        "{found:?}"
    );
    assert!(
        found.notes.len() == 1
            && found.notes[0].contains("schema 4")
            && found.notes[0].contains("yardstick")
    );
    errors(measured_row(&mut new, 0)).rmse = 0.2;
    assert_eq!(changes(&old, &new).worse.len(), 1);
    let untimed = |c: &mut Comparison| (0..2).for_each(|row| measured_row(c, row).times = None);
    untimed(&mut new);
    assert!(changes(&comparison(), &new).notes[0].contains("this run has none"));
    untimed(&mut old);
    assert!(changes(&old, &comparison()).notes[0].contains("the baseline has none"));
}

/// Yardsticks had other lengths up to schema 6.
#[test]
fn times_of_schema_6_are_not_compared() {
    let old = Comparison {
        schema: 6,
        ..comparison()
    };
    let found = changes(&old, &comparison());
    assert_eq!((found.compared, found.timed), (2, 0));
    assert!(found.notes[0].contains("schema 6"), "{found:?}");
}

#[test]
fn times_next_to_yardsticks_of_other_lengths_are_not_compared() {
    let with_units = |units: f64| {
        let mut out = comparison();
        let times = measured_row(&mut out, 1).times.as_mut().expect("made so");
        times.device_units = Some(units);
        out
    };
    let mut new = with_units(8.0);
    slow_down(measured_row(&mut new, 1), 2.0);
    let found = changes(&with_units(4.0), &new);
    assert_eq!((found.timed, found.suspects.len()), (1, 0), "{found:?}");
    assert!(
        found.notes[0].contains("cubes: pcf (3x3) on wgpu"),
        "{found:?}"
    );
    assert_eq!(changes(&with_units(8.0), &new).suspects.len(), 1);
}

#[test]
fn another_adapter_may_round_otherwise() {
    let with = |growth: f64| {
        let mut new = comparison();
        new.environment.adapter = Some("another".into());
        for row in &mut new.scenes[0].rows {
            let RowOutcome::Measured(m) = &mut row.outcome else {
                unreachable!("made so")
            };
            errors(m).false_light += growth;
        }
        changes(&comparison(), &new).worse
    };
    assert_eq!(with(0.05).len(), 1, "the CPU has no excuse");
    assert_eq!(with(0.2).len(), 2);
}

#[test]
fn new_and_refused_rows_are_reported() {
    let mut new = comparison();
    new.scenes[0].rows.push(CompareRow {
        settings: "5x5".into(),
        ..row("cpu")
    });
    assert_eq!(
        changes(&comparison(), &new),
        Changes {
            new: vec!["cubes: pcf (5x5) on cpu".into()],
            ..no_changes()
        }
    );
    let mut new = comparison();
    new.scenes[0].rows[0].outcome = RowOutcome::Unsupported {
        reason: "no more".into(),
    };
    assert_eq!(changes(&comparison(), &new).worse.len(), 1);
    assert_eq!(changes(&new, &comparison()).better.len(), 1);
    let none = Comparison {
        scenes: Vec::new(),
        ..comparison()
    };
    assert_eq!(changes(&none, &comparison()).new.len(), 1);
}

/// Returns two scenes, each with two techniques of two settings on two backends.
fn wide() -> Comparison {
    let mut out = comparison();
    out.scenes = ["cubes", "figure"].map(scene).to_vec();
    for scene in &mut out.scenes {
        let make = |technique: &str, settings: &str, backend: &str| CompareRow {
            technique: technique.into(),
            settings: settings.into(),
            ..row(backend)
        };
        let settings = |t, s| ["cpu", "wgpu"].map(|b| make(t, s, b));
        scene.rows = [("pcf", "3x3"), ("pcf", "5x5"), ("hard", "a"), ("hard", "b")]
            .map(|(t, s)| settings(t, s))
            .concat();
    }
    out
}

/// Each loss is reported once, by the most general name, and excepted by the suggested name.
#[test]
fn what_vanished_is_lost_unless_it_is_named() {
    let lose = |keep: &dyn Fn(&str, &CompareRow) -> bool| {
        let mut new = wide();
        for scene in &mut new.scenes {
            let name = scene.name.clone();
            scene.rows.retain(|row| keep(&name, row));
        }
        new
    };
    let without_figure = Comparison {
        scenes: wide().scenes[..1].to_vec(),
        ..wide()
    };
    let cases: [(Comparison, &str, &str); 6] = [
        (
            without_figure,
            "scene figure is missing with its 8 rows",
            "figure",
        ),
        (
            lose(&|_, r| r.technique != "pcf"),
            "pcf is missing: 8 rows",
            "pcf",
        ),
        (
            lose(&|_, r| r.backend != "wgpu"),
            "wgpu is missing: 8 rows",
            "wgpu",
        ),
        (
            lose(&|_, r| r.settings != "5x5"),
            "pcf (5x5) is missing: 4 rows",
            "pcf (5x5)",
        ),
        (
            lose(&|s, r| s != "figure" || r.settings != "a"),
            "figure: hard (a) on cpu is missing",
            "hard (a)",
        ),
        (
            lose(&|s, r| s != "figure" || r.settings != "b" || r.backend == "cpu"),
            "figure: hard (b) on wgpu is missing",
            "hard (b)",
        ),
    ];
    for (new, line, name) in cases {
        let found = changes(&wide(), &new);
        assert_eq!(
            (&*found.lost[0], &found.except[..]),
            (line, &[name.to_owned()][..]),
            "{found:?}"
        );
        let excepted = super::changes(&wide(), &new, &exception_for(&[name]));
        assert!(
            excepted.lost.is_empty() && excepted.except.is_empty() && excepted.notes.len() == 1,
            "{excepted:?}"
        );
        assert!(
            !super::changes(&wide(), &new, &exception_for(&["cube", "none"]))
                .lost
                .is_empty(),
            "other names"
        );
    }
    assert!(changes(&wide(), &wide()).lost.is_empty());
}

#[test]
fn exceptions_that_mean_nothing_are_refused() {
    for name in ["cubes", "pcf", "wgpu", "pcf (5x5)"] {
        exception_for(&[name]).check(&wide()).expect("known");
    }
    let refused = exception_for(&["cubes", "pcff"])
        .check(&wide())
        .expect_err("unknown")
        .to_string();
    assert!(
        refused.contains("pcff") && refused.contains("name a scene"),
        "{refused}"
    );
}

#[test]
fn scenes_that_changed_are_lost_unless_they_are_named() {
    let mut new = comparison();
    new.scenes[0].fingerprint = "other".into();
    errors(measured_row(&mut new, 0)).rmse = 1.0;
    let found = changes(&comparison(), &new);
    assert!(
        found.worse.is_empty() && found.lost.len() == 1 && found.lost[0].contains("triangles"),
        "{found:?}"
    );
    let found = super::changes(&comparison(), &new, &exception_for(&["cubes"]));
    assert!(
        found.lost.is_empty() && found.notes[0].contains("triangles"),
        "{found:?}"
    );
}

/// Two scenes with the same name are paired in their order.
#[test]
fn scenes_of_one_name_are_compared_one_by_one() {
    let twice = Comparison {
        scenes: ["cubes", "cubes"].map(scene).to_vec(),
        ..comparison()
    };
    assert_eq!(changes(&twice, &twice).compared, 4);
    let found = changes(&twice, &comparison());
    assert_eq!((found.compared, found.lost.len()), (2, 1), "{found:?}");
    let mut new = twice.clone();
    new.scenes[1].fingerprint = "other".into();
    assert_eq!(changes(&twice, &new).lost.len(), 1);
}

/// Schema 3 had no map use, and 4 no yardstick. Both reported controls in another way.
#[test]
fn older_baselines_are_still_read() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let path = dir.path().join("results.json");
    let mut old = Comparison {
        schema: 3,
        ..comparison()
    };
    (0..2).for_each(|row| {
        let times = measured_row(&mut old, row).times.as_mut().expect("made so");
        (times.ratio, times.yardstick) = (None, None);
    });
    old.scenes[0].controls.push(crate::compare::Control {
        wrong_without: 7,
        ..Default::default()
    });
    let text = serde_json::to_string(&old).expect("memory");
    let without = [
        (",\"maps\":null", ""),
        (",\"yardstick\":null", ""),
        (",\"ratio\":null", ""),
        (",\"device_units\":null", ""),
        (",\"nothing_compared\":null", ""),
        ("wrong_without", "dark_without"),
    ];
    let without = without.iter().fold(text, |text, (new, old)| {
        assert!(text.contains(new), "{new}");
        text.replace(new, old)
    });
    std::fs::write(&path, without).expect("writable");
    assert_eq!(read(&path).expect("old, but known"), old);
    let found = changes(&old, &comparison());
    assert_eq!(
        (
            found.compared,
            found.timed,
            found.worse.len(),
            found.lost.len()
        ),
        (2, 0, 0, 0)
    );
}

#[test]
fn files_that_are_no_baseline_are_refused_with_their_name() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let path = dir.path().join("results.json");
    let refused = |text: &str| {
        std::fs::write(&path, text).expect("writable");
        let e = read(&path).expect_err("no baseline").to_string();
        assert!(e.contains("results.json"), "{e}");
        e
    };
    refused("");
    refused("{\"schema\": 3");
    refused("[]");
    assert!(refused("{\"schema\": 2}").contains("schema"));
    assert!(refused(&format!("{{\"schema\": {}}}", SCHEMA + 1)).contains("schema"));
    refused(&format!("{{\"schema\": {SCHEMA}, \"scenes\": 7}}"));
    let text = serde_json::to_string(&comparison()).expect("memory");
    std::fs::write(&path, &text).expect("writable");
    assert_eq!(read(&path).expect("valid"), comparison());
    std::fs::write(&path, &text[..text.len() / 2]).expect("writable");
    assert!(read(&path).is_err());
    assert!(read(&dir.path().join("none.json")).is_err());
}
