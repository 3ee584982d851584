//! A report of synthetic results: it is complete, loads nothing from elsewhere, and is safe with
//! any names.

use super::*;
use crate::{
    compare::{
        CompareOptions, CompareRow, Control, CostBasis, Measured, RowOutcome, RowTimes, SceneInput,
        TimingStats,
    },
    output::slug,
};
use glam::UVec2;
use std::{fs, sync::Arc, time::Duration};
use umbrage_core::{
    Receivers, Texels,
    metrics::{Causes, Errors, Pixel},
};
use umbrage_plan::{
    footprint::{Heat, MapUse},
    truth::Truth,
};

pub(super) const NASTY: &str = "</script><img src=x onerror=alert(1)> & \"co\"";

pub(super) fn row(technique: &str, backend: &str, rmse: f64, median: f64) -> CompareRow {
    let total = TimingStats {
        median,
        min: median,
        max: median,
        runs: 1,
    };
    let times = RowTimes {
        receive: Some(total),
        total,
        ..RowTimes::default()
    };
    let errors = Errors {
        rmse,
        counted: 12,
        ..Errors::default()
    };
    let outcome = RowOutcome::Measured(Box::new(Measured {
        errors: Some(errors),
        causes: Some(Causes::default()),
        times: Some(times),
        cost_ms: median,
        executed_cost_ms: None,
        bytes: 100,
        maps: Some(MapUse {
            unused: 0.84,
            texels_per_pixel: Some([0.5, 1.5, 4.5]),
            texels: Some(0.75),
            side: Some(683),
        }),
        ..Measured::default()
    }));
    let (technique, settings) = (technique.to_owned(), NASTY.to_owned());
    CompareRow {
        slug: slug(&technique),
        technique,
        settings,
        backend: backend.to_owned(),
        same_as: None,
        outcome,
    }
}

pub(super) fn scene() -> (SceneResult, SceneImages) {
    let unsupported = RowOutcome::Unsupported {
        reason: NASTY.to_owned(),
    };
    let rows = vec![
        row("good", "cpu", 0.0, 3.0),
        row("quick", "cpu", 0.2, 1.0),
        row("beaten", "cpu", 0.3, 2.0),
        CompareRow {
            outcome: unsupported,
            ..row("dash", "cpu", 0.0, 0.0)
        },
    ];
    let size = UVec2::new(4, 3);
    let mut receivers = Receivers::empty(size);
    (
        receivers.triangle[5],
        receivers.distance[5],
        receivers.receives[5],
    ) = (0, 2.5, true);
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
    let masks = vec![
        Some(vec![1.0; 12]),
        Some(vec![0.5; 12]),
        Some(vec![0.0; 12]),
        None,
    ];
    let controls = vec![Control {
        backend: "cpu".into(),
        ..Control::default()
    }];
    let result = SceneResult {
        name: NASTY.to_owned(),
        size: [4, 3],
        rows,
        controls,
        ..SceneResult::default()
    };
    let images = |mask| RowImages {
        mask,
        ..RowImages::default()
    };
    let mut rows: Vec<RowImages> = masks.into_iter().map(images).collect();
    rows[0].lookups = Some(Arc::new(Heat {
        size: [2, 1],
        lookups: vec![0, 3],
    }));
    (result, SceneImages { truth, rows })
}

/// Returns the plan of two scenes with the same name.
pub(super) fn plan() -> ComparisonPlan {
    let scene = || {
        let scene = umbrage_core::Scene {
            name: NASTY.into(),
            ..Default::default()
        };
        SceneInput::new(scene, "")
    };
    ComparisonPlan::new(&[scene(), scene()], &CompareOptions::default())
}

pub(super) fn write(arrays: bool) -> (tempfile::TempDir, Comparison) {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let report =
        Report::create(&dir.path().join("out"), plan(), &[0, 1], arrays).expect("writable");
    let (result, images) = scene();
    for place in [0, 1] {
        report
            .scene(
                place,
                &Environment::default(),
                &[NASTY.to_owned()],
                &result,
                &images,
            )
            .expect("writable");
    }
    let (comparison, page) = report.finish(None).expect("writable");
    assert_eq!(page, dir.path().join("out/index.html"));
    assert_eq!(
        (comparison.scenes.len(), &*comparison.notices),
        (2, &[NASTY.to_owned()][..])
    );
    (dir, comparison)
}

#[test]
fn names_cannot_smuggle_in_markup() {
    let (dir, _) = write(false);
    let page = fs::read_to_string(dir.path().join("out/index.html")).expect("there");
    assert!(!page.contains("<img src=x"), "a name became an element");
    // The page's data and its scripts; no script has a second end.
    let starts = page.matches("<script").count();
    assert!(starts > 1 && page.matches("</script").count() == starts);
    assert!(
        page.contains("onerror=alert"),
        "the name must be shown, as text"
    );
}

#[test]
fn the_page_needs_nothing_from_elsewhere() {
    let (dir, _) = write(false);
    let page = fs::read_to_string(dir.path().join("out/index.html")).expect("there");
    for loader in ["<script src", "<link", "@import", "url(http", "fetch("] {
        assert!(!page.contains(loader), "{loader}");
    }
    let addresses = page.matches("http").count();
    let namespaces = page.matches("http://www.w3.org/").count();
    assert_eq!(addresses, namespaces, "only names of formats");
}

#[test]
fn results_come_back_from_json() {
    let (dir, comparison) = write(false);
    let json = fs::read(dir.path().join("out/results.json")).expect("there");
    assert_eq!(
        serde_json::from_slice::<Comparison>(&json).expect("valid"),
        comparison
    );
    let mut spoilt = comparison.clone();
    spoilt.scenes[0].rows[0].backend = "wgpu".into();
    assert_ne!(
        serde_json::from_slice::<Comparison>(&json).expect("valid"),
        spoilt
    );
}

#[test]
fn scenes_of_one_name_get_folders_of_their_own() {
    let (dir, _) = write(true);
    let stem = slug(NASTY);
    for folder in [stem.clone(), format!("{stem}-2")] {
        let folder = dir.path().join("out").join(folder);
        for file in [
            "truth.png",
            "good.cpu.png",
            "good.cpu.error.png",
            "truth.npy",
            "t.npy",
            "ambiguous.npy",
            "good.cpu.npy",
        ] {
            assert!(
                folder.join(file).is_file(),
                "{file} in {}",
                folder.display()
            );
        }
        assert!(!folder.join("dash.cpu.png").exists());
    }
    assert!(
        !write(false)
            .0
            .path()
            .join("out")
            .join(stem)
            .join("truth.npy")
            .exists()
    );
}

/// The use of maps is in the table and in an image.
#[test]
fn how_maps_are_used_is_reported() {
    let (dir, comparison) = write(false);
    let folder = dir.path().join("out").join(slug(NASTY));
    assert!(
        folder.join("good.cpu.lookups.png").is_file()
            && !folder.join("quick.cpu.lookups.png").exists()
    );
    let line = &lines(&comparison)[0];
    assert_eq!(
        (line.map_unused, line.texels_median, line.map_side_needed),
        (Some(84.0), Some(1.5), Some(683))
    );
    assert_eq!(
        (
            line.texels_least,
            line.texels_greatest,
            line.texels_of_nine_in_ten
        ),
        (Some(0.5), Some(4.5), Some(0.75))
    );
    let without = MapUse {
        texels: None,
        ..MapUse::default()
    };
    assert_eq!(without.words(), "0 % of the map's texels never looked up");
}

#[test]
fn arrays_hold_minus_one_where_nothing_is_seen() {
    let (dir, _) = write(true);
    let bytes = fs::read(dir.path().join("out").join(slug(NASTY)).join("t.npy")).expect("there");
    let (rows, columns, values) = arrays::read_npy(&bytes);
    assert_eq!((rows, columns), (3, 4));
    assert_eq!(values[5], 2.5);
    assert!(values.iter().enumerate().all(|(i, &v)| i == 5 || v == -1.0));
}

#[test]
fn fronts_and_failed_controls_are_reported() {
    let (result, _) = scene();
    assert_eq!(chosen::fronts(&result, CostBasis::Wall), [1, 0]);
    let comparison = Comparison {
        scenes: vec![result],
        ..Comparison::default()
    };
    assert_eq!(comparison.faults().len(), 1, "the control doesn't hold");
}

/// Returns all files of a folder, by name.
fn files(folder: &std::path::Path) -> std::collections::BTreeMap<String, Vec<u8>> {
    let mut out = std::collections::BTreeMap::new();
    for entry in fs::read_dir(folder).expect("there") {
        let path = entry.expect("readable").path();
        let name = path
            .file_name()
            .expect("named")
            .to_string_lossy()
            .into_owned();
        if path.is_dir() {
            out.extend(
                files(&path)
                    .into_iter()
                    .map(|(inner, bytes)| (format!("{name}/{inner}"), bytes)),
            );
        } else {
            out.insert(name, fs::read(&path).expect("readable"));
        }
    }
    out
}

/// Writes the shard with this index of the comparison of `write(false)`, and returns its folder.
fn shard(dir: &std::path::Path, name: &str, place: usize) -> PathBuf {
    let report = Report::create(&dir.join(name), plan(), &[place], false).expect("writable");
    let (result, images) = scene();
    report
        .scene(
            place,
            &Environment::default(),
            &[NASTY.to_owned()],
            &result,
            &images,
        )
        .expect("writable");
    report.finish(None).expect("writable");
    dir.join(name)
}

#[test]
fn merged_shards_are_byte_for_byte_one_run() {
    let (dir, _) = write(false);
    let shards = [shard(dir.path(), "b", 1), shard(dir.path(), "a", 0)];
    merge(&shards, &dir.path().join("merged"), None).expect("all there");
    assert_eq!(
        files(&dir.path().join("merged")),
        files(&dir.path().join("out"))
    );
    fs::write(
        shards[0]
            .join(format!("{}-2", slug(NASTY)))
            .join("truth.png"),
        b"spoilt",
    )
    .expect("writable");
    merge(&shards, &dir.path().join("spoilt"), None).expect("all there");
    assert_ne!(
        files(&dir.path().join("spoilt")),
        files(&dir.path().join("out"))
    );
}

#[test]
fn shards_that_do_not_belong_together_are_refused() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let (a, b) = (shard(dir.path(), "a", 0), shard(dir.path(), "b", 1));
    let refused = |folders: &[&PathBuf]| {
        let folders: Vec<PathBuf> = folders.iter().map(|p| (*p).clone()).collect();
        merge(&folders, &dir.path().join("out"), None)
            .expect_err("refused")
            .to_string()
    };
    assert!(
        refused(&[&a]).contains(&format!("{}-2", slug(NASTY))),
        "missing scenes are named"
    );
    assert!(refused(&[&a, &b, &shard(dir.path(), "c", 1)]).contains("same scene"));
    assert!(refused(&[&dir.path().join("none")]).contains("none"));
    let other = ComparisonPlan {
        options: "others".into(),
        ..plan()
    };
    let report = Report::create(&dir.path().join("d"), other, &[1], false).expect("writable");
    let (result, images) = scene();
    report
        .scene(1, &Environment::default(), &[], &result, &images)
        .expect("writable");
    assert!(refused(&[&a, &dir.path().join("d")]).contains("another comparison"));
    let empty = dir.path().join("empty");
    fs::create_dir(&empty).expect("writable");
    assert!(refused(&[&empty]).contains("no scenes"));
    // Folders older than `run.json` have scenes, but none is known to be of the last run.
    fs::remove_file(a.join("run.json")).expect("there");
    let old = refused(&[&a, &b]);
    assert!(
        old.contains("was not written by this version") && old.contains("measure it again"),
        "{old}"
    );
}

/// Folders may have been used before, for another comparison and with another number of shards.
#[test]
fn scenes_of_earlier_runs_are_ignored() {
    let (dir, _) = write(false);
    let a = dir.path().join("a");
    let other = ComparisonPlan {
        options: "others".into(),
        scenes: vec!["stray".into(), "x".into()],
        ..plan()
    };
    let report = Report::create(&a, other, &[0], false).expect("writable");
    let (result, images) = scene();
    report
        .scene(0, &Environment::default(), &[], &result, &images)
        .expect("writable");
    shard(dir.path(), "a", 1);
    let shards = [shard(dir.path(), "a", 0), shard(dir.path(), "b", 1)];
    assert!(
        a.join("stray/scene.json").is_file(),
        "results of an earlier run are not deleted"
    );
    merge(&shards, &dir.path().join("merged"), None).expect("all there, nothing twice");
    assert_eq!(
        files(&dir.path().join("merged")),
        files(&dir.path().join("out"))
    );
    // A run that was stopped before its first scene is not mistaken for the one before it.
    Report::create(
        &a,
        ComparisonPlan {
            contents: vec![String::new(); 2],
            ..plan()
        },
        &[0],
        false,
    )
    .expect("writable");
    let refused = merge(&shards, &dir.path().join("merged"), None)
        .expect_err("refused")
        .to_string();
    assert!(refused.contains("another comparison"), "{refused}");
    Report::create(
        &a,
        ComparisonPlan {
            contents: vec![String::new(); 2],
            ..plan()
        },
        &[0],
        false,
    )
    .expect("writable");
    let stopped = merge(&[a], &dir.path().join("merged"), None)
        .expect_err("refused")
        .to_string();
    assert!(
        stopped.contains("lack 2 of 2 scenes") && stopped.contains("stopped"),
        "{stopped}"
    );
}

#[test]
fn only_whole_scenes_of_the_same_run_are_taken_up() {
    let (dir, _) = write(false);
    let (out, here) = (dir.path().join("out"), Environment::default());
    let has = |plan: ComparisonPlan, environment: &Environment, arrays| {
        let report = Report::create(&out, plan, &[0, 1], arrays).expect("writable");
        [0, 1].map(|place| report.has(place, environment).expect("whole"))
    };
    assert_eq!(has(plan(), &here, false), [true; 2]);
    assert_eq!(
        has(
            plan(),
            &Environment {
                date: Some("later".into()),
                ..here.clone()
            },
            false
        ),
        [true; 2]
    );
    assert_eq!(
        has(
            plan(),
            &Environment {
                commit: Some("other".into()),
                ..here.clone()
            },
            false
        ),
        [false; 2]
    );
    assert_eq!(
        has(
            ComparisonPlan {
                options: "others".into(),
                ..plan()
            },
            &here,
            false
        ),
        [false; 2]
    );
    assert_eq!(
        has(plan(), &here, true),
        [false; 2],
        "requested arrays are missing"
    );
    let folder = out.join(slug(NASTY));
    let stored = Stored::read(&folder).expect("whole").expect("there");
    assert!(!stored.program.is_empty());
    let other = Stored {
        program: "another".to_owned(),
        ..stored
    };
    other
        .write(&Folder::create(&folder).expect("writable"))
        .expect("writable");
    assert_eq!(
        has(plan(), &here, false),
        [false, true],
        "another program's figures"
    );
}

/// A changed digit, half a file, a file without a checksum and an empty file are rejected.
#[test]
fn figures_that_were_changed_are_not_taken_up() {
    let (dir, _) = write(false);
    let (out, here) = (dir.path().join("out"), Environment::default());
    let file = out.join(slug(NASTY)).join("scene.json");
    let text = fs::read_to_string(&file).expect("there");
    let digit = text.replacen("\"rmse\": 0.2", "\"rmse\": 0.1", 1);
    assert_ne!(digit, text);
    let half = text[..text.len() / 2].to_owned();
    let unmarked = format!("{{\n{}", text.split_once(",\n").expect("entries").1);
    let emptied = String::new();
    for spoilt in [digit, half, unmarked, emptied] {
        fs::write(&file, &spoilt).expect("writable");
        let report = Report::create(&out, plan(), &[0, 1], false).expect("writable");
        let why = report
            .has(0, &here)
            .expect_err("not as it was written")
            .to_string();
        assert!(
            why.contains("scene.json") && why.contains("checksum") && why.contains("again"),
            "{why}"
        );
        assert_eq!(report.has(1, &here), Ok(true), "the other scene is whole");
        let why = merge(std::slice::from_ref(&out), &dir.path().join("merged"), None)
            .expect_err("refused")
            .to_string();
        assert!(
            why.contains("scene.json") && why.contains("checksum"),
            "{why}"
        );
        let why = report.finish(None).expect_err("refused").to_string();
        assert!(why.contains("scene.json"), "{why}");
    }
    fs::write(&file, &text).expect("writable");
    let report = Report::create(&out, plan(), &[0, 1], false).expect("writable");
    assert_eq!(report.has(0, &here), Ok(true));
    // The checksum is an entry like any other for JSON readers.
    let json: serde_json::Value = serde_json::from_str(&text).expect("valid");
    assert!(
        json["checksum"].as_str().is_some_and(|sum| sum.len() == 16) && json["result"].is_object()
    );
}

#[test]
fn plans_differ_where_a_texel_or_the_size_of_a_texture_does() {
    let contents_of = |size: [u32; 2], texels: Texels| {
        let mut scene = umbrage_scenes::by_argument("cubes").expect("built in");
        scene.textures.push(umbrage_core::Texture {
            name: "tile".to_owned(),
            size: size.into(),
            texels,
        });
        let input = SceneInput::new(scene, "");
        ComparisonPlan::new(&[input], &CompareOptions::default()).contents
    };
    let contents = |size, blue: f32| {
        let mut texels = vec![[0.5; 4]; 4];
        texels[3][2] = blue;
        contents_of(size, texels.into())
    };
    // The same bytes have other values in another encoding.
    let bytes = vec![[128; 4]; 4];
    let linear = contents_of([2, 2], Texels::Unorm8(bytes.clone().into()));
    assert_ne!(linear, contents_of([2, 2], Texels::Srgb8(bytes.into())));
    assert_eq!(contents([2, 2], 0.5), contents([2, 2], 0.5));
    assert_ne!(contents([2, 2], 0.5), contents([2, 2], 0.5 + f32::EPSILON));
    assert_ne!(contents([2, 2], 0.5), contents([4, 1], 0.5));
}
