//! A report of made-up results: complete, self-contained, and safe whatever the names.

use super::*;
use crate::{
    compare::{Control, Measured, Outcome, Row, Spread, Times},
    truth::Truth,
};
use glam::UVec2;
use std::{fs, time::Duration};
use umbrage_core::{
    Receivers,
    metrics::{Errors, Pixel},
};

const NASTY: &str = "</script><img src=x onerror=alert(1)> & \"co\"";

fn row(technique: &str, backend: &str, rmse: f64, median: f64) -> Row {
    let total = Spread { median, least: median, greatest: median, runs: 1 };
    let times = Times { receive: Some(total), total, ..Times::default() };
    let errors = Errors { rmse, counted: 12, ..Errors::default() };
    let outcome = Outcome::Measured(Box::new(Measured {
        errors,
        causes: umbrage_core::metrics::Causes::default(),
        times,
        bytes: 100,
        agreement: None,
        color_differing: None,
    }));
    let (technique, settings) = (technique.to_owned(), NASTY.to_owned());
    Row { slug: slug(&technique), technique, settings, backend: backend.to_owned(), outcome }
}

fn scene() -> (SceneResult, SceneImages) {
    let unsupported = Outcome::Unsupported { reason: NASTY.to_owned() };
    let rows = vec![
        row("good", "cpu", 0.0, 3.0),
        row("quick", "cpu", 0.2, 1.0),
        row("beaten", "cpu", 0.3, 2.0),
        Row { outcome: unsupported, ..row("dash", "cpu", 0.0, 0.0) },
    ];
    let size = UVec2::new(4, 3);
    let mut receivers = Receivers::empty(size);
    (receivers.triangle[5], receivers.distance[5], receivers.receives[5]) = (0, 2.5, true);
    let truth = Truth {
        size,
        visibility: vec![1.0; 12],
        error: vec![0.0; 12],
        pixels: vec![Pixel::Counted; 12],
        ambiguous: vec![false; 12],
        blocker: vec![f32::INFINITY; 12],
        contact: 0.0,
        receivers,
        fingerprint: 1,
        elapsed: Duration::ZERO,
    };
    let masks = vec![Some(vec![1.0; 12]), Some(vec![0.5; 12]), Some(vec![0.0; 12]), None];
    let controls = vec![Control { backend: "cpu".into(), ..Control::default() }];
    let result = SceneResult { name: NASTY.to_owned(), size: [4, 3], rows, controls, ..SceneResult::default() };
    let colors = vec![None; masks.len()];
    (result, SceneImages { truth, masks, colors })
}

fn write(arrays: bool) -> (tempfile::TempDir, Comparison) {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let mut report = Report::create(&dir.path().join("out"), arrays).expect("writable");
    let (result, images) = scene();
    report.scene(&result, &images).expect("writable");
    report.scene(&result, &images).expect("writable");
    let comparison = Comparison {
        schema: 1,
        notices: vec![NASTY.into()],
        scenes: vec![result.clone(), result],
        ..Comparison::default()
    };
    let page = report.finish(&comparison).expect("writable");
    assert_eq!(page, dir.path().join("out/index.html"));
    (dir, comparison)
}

#[test]
fn names_cannot_smuggle_in_markup() {
    let (dir, _) = write(false);
    let page = fs::read_to_string(dir.path().join("out/index.html")).expect("there");
    assert!(!page.contains("<img src=x"), "a name became an element");
    // The page's three scripts, and not one more end of a script than starts.
    assert_eq!(page.matches("</script").count(), 3);
    assert!(page.contains("onerror=alert"), "the name must still be told, as text");
}

#[test]
fn the_page_asks_for_nothing_from_elsewhere() {
    let (dir, _) = write(false);
    let page = fs::read_to_string(dir.path().join("out/index.html")).expect("there");
    for loader in ["<script src", "<link", "@import", "url(http"] {
        assert!(!page[..page.find("plotly.js v").expect("plotly")].contains(loader), "{loader}");
    }
}

#[test]
fn results_come_back_from_json() {
    let (dir, comparison) = write(false);
    let json = fs::read(dir.path().join("out/results.json")).expect("there");
    assert_eq!(serde_json::from_slice::<Comparison>(&json).expect("valid"), comparison);
    let mut spoilt = comparison.clone();
    spoilt.scenes[0].rows[0].backend = "wgpu".into();
    assert_ne!(serde_json::from_slice::<Comparison>(&json).expect("valid"), spoilt);
}

#[test]
fn scenes_of_one_name_get_folders_of_their_own() {
    let (dir, _) = write(true);
    let stem = slug(NASTY);
    for folder in [stem.clone(), format!("{stem}-2")] {
        let folder = dir.path().join("out").join(folder);
        for file in
            ["truth.png", "good.cpu.png", "good.cpu.error.png", "truth.npy", "t.npy", "ambiguous.npy", "good.cpu.npy"]
        {
            assert!(folder.join(file).is_file(), "{file} in {}", folder.display());
        }
        assert!(!folder.join("dash.cpu.png").exists());
    }
    assert!(!write(false).0.path().join("out").join(stem).join("truth.npy").exists());
}

#[test]
fn arrays_hold_minus_one_where_nothing_is_seen() {
    let (dir, _) = write(true);
    let bytes = fs::read(dir.path().join("out").join(slug(NASTY)).join("t.npy")).expect("there");
    let file = npyz::NpyFile::new(&bytes[..]).expect("valid");
    assert_eq!(file.shape(), [3, 4]);
    let values = file.into_vec::<f32>().expect("floats");
    assert_eq!(values[5], 2.5);
    assert!(values.iter().enumerate().all(|(i, &v)| i == 5 || v == -1.0));
}

#[test]
fn fronts_and_failed_controls_are_told() {
    let (result, _) = scene();
    let (front, traces) = chart::of(&result);
    assert_eq!(front, [1, 0]);
    assert!(!traces.to_string().contains("<img"), "hover texts are markup to plotly");
    let comparison = Comparison { scenes: vec![result], ..Comparison::default() };
    assert_eq!(comparison.faults().len(), 1, "the control doesn't hold");
}
