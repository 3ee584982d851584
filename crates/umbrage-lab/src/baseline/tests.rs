//! Baselines spoilt in every way that must be noticed, and in those that must not.

use super::*;
use crate::compare::{SCHEMA, Times};
use umbrage_core::{
    Work,
    metrics::{Causes, Errors},
};

fn row(backend: &str) -> Row {
    let total = Spread { median: 2.0, least: 1.9, greatest: 2.2, runs: 5 };
    let measured = Measured {
        errors: Errors { rmse: 0.1, false_shadow: 1.0, false_light: 2.0, acne: 0.5, ..Errors::default() },
        causes: Causes::default(),
        times: Some(Times { total, ..Times::default() }),
        work: Work { taps: 1000, ..Work::default() },
        cost_ms: 0.1,
        bytes: 4096,
        agreement: None,
        color_differing: None,
        maps: None,
    };
    let outcome = Outcome::Measured(Box::new(measured));
    let (technique, settings) = ("pcf".to_owned(), "3x3".to_owned());
    Row { slug: technique.clone(), technique, settings, backend: backend.to_owned(), outcome }
}

fn comparison() -> Comparison {
    let scene = SceneResult { name: "cubes".into(), rows: vec![row("cpu"), row("wgpu")], ..SceneResult::default() };
    Comparison { schema: SCHEMA, scenes: vec![scene], ..Comparison::default() }
}

/// What changed when row `index` is changed so.
fn after(index: usize, change: impl Fn(&mut Measured)) -> Changes {
    let mut new = comparison();
    let Outcome::Measured(m) = &mut new.scenes[0].rows[index].outcome else { unreachable!("made so") };
    change(m);
    changes(&comparison(), &new)
}

fn total(m: &mut Measured) -> &mut Spread {
    &mut m.times.as_mut().expect("made so").total
}

/// Both rows were compared, and nothing has changed.
fn unchanged() -> Changes {
    Changes { compared: 2, ..Changes::default() }
}

#[test]
fn another_light_or_camera_is_not_compared() {
    let mut moved = comparison();
    moved.scenes[0].rmse_of_none[0] += 0.01;
    let found = changes(&comparison(), &moved);
    assert_eq!((found.compared, found.notes.len()), (0, 1), "{found:?}");
}

#[test]
fn the_same_is_no_change() {
    assert_eq!(changes(&comparison(), &comparison()), unchanged());
}

#[test]
fn less_accurate_is_worse_and_more_accurate_better() {
    let worse: [fn(&mut Measured); 6] = [
        |m| m.errors.rmse += 1e-6,
        |m| m.errors.false_shadow += 1e-3,
        |m| m.errors.false_light += 1e-3,
        |m| m.errors.acne += 1e-3,
        |m| m.work.taps += 1,
        |m| m.bytes += 1,
    ];
    for spoil in worse {
        let found = after(0, spoil);
        assert_eq!((found.worse.len(), found.better.len()), (1, 0), "{found:?}");
        assert!(found.worse[0].starts_with("cubes: pcf (3x3) on cpu: "), "{found:?}");
    }
    let found = after(0, |m| m.errors.rmse -= 1e-6);
    assert_eq!((found.worse.len(), found.better.len()), (0, 1));
    assert_eq!(after(0, |m| m.errors.rmse *= 1.0 + 1e-12), unchanged(), "rounding");
}

#[test]
fn slower_counts_beyond_both_spreads_and_the_noise() {
    let to = |median: f64, least: f64| after(0, move |m| *total(m) = Spread { median, least, ..*total(m) });
    assert_eq!(to(3.0, 2.9).worse.len(), 1);
    assert_eq!(to(1.0, 0.9).better.len(), 0, "its greatest run is as slow as before");
    assert_eq!(to(3.0, 1.9), unchanged(), "its quickest run is as quick as before");
    assert_eq!(to(2.5, 2.4), unchanged(), "a quarter is noise");
    let quick = after(0, |m| *total(m) = Spread { median: 1.0, least: 0.9, greatest: 1.1, runs: 5 });
    assert_eq!((quick.worse.len(), quick.better.len()), (0, 1));
}

#[test]
fn on_another_machine_costs_count_and_times_do_not() {
    let mut new = comparison();
    new.environment.cpu = "another".into();
    let Outcome::Measured(m) = &mut new.scenes[0].rows[0].outcome else { unreachable!("made so") };
    *total(m) = Spread { median: 99.0, least: 98.0, greatest: 100.0, runs: 5 };
    let found = changes(&comparison(), &new);
    assert!(found.worse.is_empty() && found.notes.len() == 1 && found.notes[0].contains("another"), "{found:?}");
    let Outcome::Measured(m) = &mut new.scenes[0].rows[0].outcome else { unreachable!("made so") };
    m.work.rays += 100;
    m.work.casters = 10;
    assert_eq!(changes(&comparison(), &new).worse.len(), 1);
}

#[test]
fn another_adapter_may_round_otherwise() {
    let with = |growth: f64| {
        let mut new = comparison();
        new.environment.adapter = Some("another".into());
        for row in &mut new.scenes[0].rows {
            let Outcome::Measured(m) = &mut row.outcome else { unreachable!("made so") };
            m.errors.false_light += growth;
        }
        changes(&comparison(), &new).worse
    };
    assert_eq!(with(0.05).len(), 1, "the CPU has no excuse");
    assert_eq!(with(0.2).len(), 2);
}

#[test]
fn new_missing_and_refused_rows_are_told() {
    let mut new = comparison();
    new.scenes[0].rows[0].settings = "5x5".into();
    let found = changes(&comparison(), &new);
    assert_eq!((found.new.len(), found.missing.len(), found.worse.len()), (1, 1, 0), "{found:?}");
    let mut new = comparison();
    new.scenes[0].rows[0].outcome = Outcome::Unsupported { reason: "no more".into() };
    assert_eq!(changes(&comparison(), &new).worse.len(), 1);
    assert_eq!(changes(&new, &comparison()).better.len(), 1);
    let none = Comparison { scenes: Vec::new(), ..comparison() };
    assert_eq!(changes(&comparison(), &none).missing.len(), 1);
    assert_eq!(changes(&none, &comparison()).new.len(), 1);
}

#[test]
fn other_scenes_are_not_compared() {
    let mut new = comparison();
    new.scenes[0].fingerprint = "other".into();
    let Outcome::Measured(m) = &mut new.scenes[0].rows[0].outcome else { unreachable!("made so") };
    m.errors.rmse = 1.0;
    let found = changes(&comparison(), &new);
    assert!(found.worse.is_empty() && found.notes[0].contains("triangles"), "{found:?}");
}

/// Schema 3 lacked how maps are used, which no guard asks for.
#[test]
fn older_baselines_are_still_read() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let path = dir.path().join("results.json");
    let old = Comparison { schema: 3, ..comparison() };
    let text = serde_json::to_string(&old).expect("memory");
    let without = text.replace(",\"maps\":null", "");
    assert_ne!(text, without);
    std::fs::write(&path, without).expect("writable");
    assert_eq!(read(&path).expect("old, but known"), old);
    assert_eq!(changes(&old, &comparison()), unchanged());
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
