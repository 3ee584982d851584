//! The page of a report and the documented format: complete, small, and with existing images.

use super::{
    tests::{NASTY, plan, row, scene, write},
    *,
};
use crate::{
    compare::{
        CompareRow, Comparison, CostBasis, Preparation, Ranks, RowOutcome, RowTimes, SCHEMA,
        TimingStats, setting_groups,
    },
    output::slug,
};
use serde_json::Value;
use std::{collections::BTreeSet, fs};
use umbrage_core::metrics::Agreement;

/// Returns the data in a page.
fn data_of(page: &str) -> Value {
    let (_, rest) = page.split_once("id=\"data\">").expect("there");
    let (json, _) = rest.split_once("</script>").expect("there");
    serde_json::from_str(json).expect("valid")
}

/// Returns the column of a row in a page's data; resolves texts.
fn cell(data: &Value, row: usize, name: &str) -> Value {
    let columns = data["columns"].as_array().expect("names");
    let column = columns.iter().position(|c| c == name).expect("there");
    let value = &data["rows"][0][row][column];
    let texts = data["text_columns"].as_array().expect("names");
    match value.as_u64() {
        Some(place) if texts.iter().any(|t| t == name) => data["texts"][place as usize].clone(),
        _ => value.clone(),
    }
}

#[test]
fn the_page_has_all_rows_and_names_pictures_that_are_there() {
    let (dir, _) = write(false);
    let out = dir.path().join("out");
    let data = data_of(&fs::read_to_string(out.join("index.html")).expect("there"));
    let rows: Vec<usize> = data["rows"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|scene| scene.as_array().map_or(0, Vec::len))
        .collect();
    assert_eq!(rows, [4, 4]);
    assert_eq!(
        (cell(&data, 1, "rmse"), cell(&data, 1, "front")),
        (0.2.into(), 1.into())
    );
    assert_eq!(
        (cell(&data, 2, "front"), cell(&data, 3, "reason")),
        (0.into(), NASTY.into())
    );
    let folder = out.join(data["scenes"][1]["folder"].as_str().expect("a name"));
    for row in 0..3 {
        let stem = cell(&data, row, "stem");
        let stem = stem.as_str().expect("a name");
        assert!(folder.join(format!("{stem}.png")).is_file(), "{stem}");
        assert!(folder.join(format!("{stem}.error.png")).is_file(), "{stem}");
    }
    assert_eq!(cell(&data, 3, "stem"), Value::Null);
}

/// The built-in suite has 44 scenes; their images are separate files.
#[test]
fn pages_of_suites_stay_below_five_megabytes() {
    let (mut result, _) = scene();
    let first = result.rows[0].clone();
    result.rows.clear();
    for i in 0..200 {
        let mut row = row("pcf", "cpu", 1.0 / f64::from(i + 3), f64::from(i).sqrt());
        row.settings = format!("3x3, 2048, bias: adaptive, {i}");
        row.slug = slug(&row.settings);
        result.rows.push(row);
    }
    result.rows.push(CompareRow {
        technique: "hard".to_owned(),
        ..first
    });
    let comparison = Comparison {
        scenes: vec![result; 44],
        ..Comparison::default()
    };
    let mut stored = Vec::new();
    for scene in &comparison.scenes {
        stored.push(Stored {
            plan: plan(),
            place: 0,
            program: String::new(),
            environment: Environment::default(),
            notices: Vec::new(),
            result: scene.clone(),
        });
    }
    let dir = tempfile::tempdir().expect("a temporary folder");
    let folder = Folder::create(dir.path()).expect("writable");
    let (_, page) = assemble::write(dir.path(), &folder, &stored, None).expect("writable");
    let size = fs::metadata(page).expect("there").len();
    assert!((500_000..5_000_000).contains(&size), "{size} bytes");
}

#[test]
fn groups_of_the_page_lead_to_rows_and_leave_out_nothing() {
    let mut scenes = Vec::new();
    for is_ideal in [true, false] {
        let rows = vec![
            row("hard", "cpu", 0.1, 1.0),
            row("pcf", "cpu", 0.05, 1.2),
            row("none", "cpu", 0.5, 0.1),
        ];
        scenes.push(SceneResult {
            is_ideal,
            rows,
            rmse_of_none: [0.5, 0.8],
            ..SceneResult::default()
        });
    }
    let comparison = Comparison {
        scenes,
        ..Comparison::default()
    };
    let groups = setting_groups(&comparison);
    assert_eq!(groups.len(), 2);
    let dots = chart::dots(&groups[0], CostBasis::Wall);
    let named: Vec<(&str, bool)> = dots.iter().map(|d| (&*d.technique, d.on_front)).collect();
    assert_eq!(named, [("hard", true), ("pcf", true)]);
    let group = assemble::page_group(&groups[1], &comparison);
    assert_eq!((group.light, group.scene), ("soft", 1));
    let rows: Vec<Option<usize>> = group.settings.iter().map(|s| s.row).collect();
    assert_eq!(rows, [0, 1, 2].map(Some));
    assert!(group.advice.is_some_and(|words| words.starts_with("pcf")));
    assert_eq!(group.strip, [0, 1]);
}

/// Adds the names of all fields in a value, at any depth.
fn add_fields(value: &Value, names: &mut BTreeSet<String>) {
    match value {
        Value::Object(fields) => {
            for (name, inner) in fields {
                names.insert(name.clone());
                add_fields(inner, names);
            }
        }
        Value::Array(all) => all.iter().for_each(|inner| add_fields(inner, names)),
        _ => {}
    }
}

/// Returns a scene with an entry in every field.
fn whole_scene() -> SceneResult {
    let (mut result, _) = scene();
    let ratio = Ranks::default();
    let stats = TimingStats::default();
    let RowOutcome::Measured(m) = &mut result.rows[0].outcome else {
        panic!("measured")
    };
    m.times = Some(RowTimes {
        cast: Some(stats),
        ratio: Some(ratio),
        ..RowTimes::default()
    });
    m.preparation = Some(Preparation::default());
    m.agreement = Some(Agreement::default());
    result.hint = Some(String::new());
    result
}

#[test]
fn the_documented_format_has_every_field() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/schemas.md");
    let document = fs::read_to_string(path).expect("there");
    let stored = Stored {
        plan: plan(),
        place: 0,
        program: String::new(),
        environment: Environment::default(),
        notices: Vec::new(),
        result: whole_scene(),
    };
    let comparison = Comparison {
        scenes: vec![stored.result.clone()],
        ..Comparison::default()
    };
    let mut names = BTreeSet::new();
    let to_value = |text: String| serde_json::from_str(&text).expect("valid");
    add_fields(
        &to_value(serde_json::to_string(&stored).expect("plain")),
        &mut names,
    );
    add_fields(
        &to_value(serde_json::to_string(&comparison).expect("plain")),
        &mut names,
    );
    assert!(names.contains("wrong_without") && names.contains("rmse_error"));
    // Names that only appear in the examples of an outcome count, too.
    let in_example = |name: &str| document.contains(&format!("\"{name}\":"));
    let missing: Vec<&String> = names
        .iter()
        .filter(|name| !document.contains(&format!("`{name}`")) && !in_example(name))
        .collect();
    assert!(missing.is_empty(), "{missing:?}");
    let version = format!("**version {}**", SCHEMA);
    assert!(document.contains(&version), "{version}");
}
