use super::*;
use crate::{
    compare::Backends,
    stability::{
        bias_window::BiasWindow,
        cell::{CaseResult, Cell, CriterionResult},
        sweeps::curve::{Curve, Sweep},
        verdict::{Judgement, Verdict, VerdictLimits},
    },
};

/// Returns a matrix of three cases: the second has one cell, which isn't measured; the last is a
/// sanity case. Names contain characters with a meaning in markup and CSV.
fn sample() -> Stability {
    let cell = |settings: &str, outcome| Cell {
        technique: "pcf".to_owned(),
        settings: settings.to_owned(),
        outcome,
        disagreeing: Some(0),
        picture: Some(vec![1, 2, 3]),
    };
    let criterion = |measure: &str, limits: VerdictLimits| CriterionResult {
        measure: measure.to_owned(),
        unit: "mm".to_owned(),
        limits,
        reason: "because".to_owned(),
        ideal: 0.25,
    };
    let limits = [VerdictLimits::new(1.0, 4.0), VerdictLimits::new(10.0, 40.0)];
    let measured = |gap: f64, acne: f64| {
        CellOutcome::from_judgements(vec![limits[0].judgement(gap), limits[1].judgement(acne)])
    };
    let case = CaseResult {
        row: 3,
        title: "thin </script> contact".to_owned(),
        weakness: "gap & leak".to_owned(),
        not_yet: None,
        case: "thin-plate".to_owned(),
        scene: "thin-plate".to_owned(),
        motion: "still".to_owned(),
        fit: String::new(),
        is_sanity: false,
        criteria: vec![criterion("gap", limits[0]), criterion("acne", limits[1])],
        cells: vec![
            cell("3x3, bias: <none>", measured(0.5, 0.25)),
            cell("7x7, bias: slope", measured(0.75, 90.0)),
            cell(
                "cube",
                CellOutcome::Unsupported {
                    reason: "no, \"never\"".to_owned(),
                },
            ),
        ],
    };
    let mut stable = case.clone();
    stable.case = "plate-pan".to_owned();
    stable.fit = "stable fit to 8 m".to_owned();
    stable.cells = vec![cell(
        "7x7, stable fit to 8 m, bias: slope",
        CellOutcome::from_judgements(vec![
            Judgement::not_measured("rendered <once>"),
            limits[1].judgement(2.0),
        ]),
    )];
    let sanity = CaseResult {
        case: "no-casters".to_owned(),
        is_sanity: true,
        ..case.clone()
    };
    Stability {
        backends: vec!["cpu".to_owned()],
        map_size: 64,
        size: [8, 6],
        frames: 2,
        cases: vec![case, stable, sanity],
        windows: vec![BiasWindow {
            technique: "pcf".to_owned(),
            settings: "3x3, <own>".to_owned(),
            base: Base::Own,
            passes_without: true,
            passes: Some([0.0, 1.5]),
            disagreeing: None,
        }],
        faults: vec![],
    }
}

/// Returns the sample as results of this program.
fn results() -> StabilityResults {
    StabilityResults::new(sample(), vec![sweep()], &Backends::cpu())
}

fn sweep() -> Sweep {
    let curve = Curve {
        label: "acne".to_owned(),
        points: vec![[1.0, 2.0], [2.0, 1.0]],
    };
    Sweep {
        name: "too-little".to_owned(),
        title: "Too <little>".to_owned(),
        x: "bias".to_owned(),
        y: "acne".to_owned(),
        curves: vec![curve],
        best: None,
        limit: None,
        disagreeing: None,
    }
}

/// Returns the files in a folder, sorted.
fn files(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("there").flatten();
    let mut names: Vec<String> = entries
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

#[test]
fn pictures_and_charts_are_files_next_to_the_page() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    // Files of an older run are removed.
    std::fs::create_dir(dir.path().join("pictures")).expect("writable");
    std::fs::write(dir.path().join("pictures/old.png"), b"old").expect("writable");
    let results = results();
    let page = write(dir.path(), &results).expect("writable");
    let names = files(&dir.path().join("pictures"));
    let expected = [
        "no-casters.pcf-3x3-bias-none.png",
        "no-casters.pcf-7x7-bias-slope.png",
        "no-casters.pcf-cube.png",
        "plate-pan.pcf-7x7-bias-slope.png",
        "thin-plate.pcf-3x3-bias-none.png",
        "thin-plate.pcf-7x7-bias-slope.png",
        "thin-plate.pcf-cube.png",
    ];
    assert_eq!(names, expected);
    let html = std::fs::read_to_string(page).expect("there");
    for name in results.pictures.iter().flatten().flatten() {
        assert!(html.contains(name), "{name}");
        let png = std::fs::read(dir.path().join(name)).expect("where the results say");
        assert_eq!(png, [1, 2, 3]);
    }
    assert_eq!(
        files(&dir.path().join("sweeps")),
        ["too-little.csv", "too-little.svg"]
    );
    assert!(html.contains("sweeps/too-little.svg") && !html.contains("data:image"));
}

/// Settings with equal file names still have separate image files.
#[test]
fn no_two_pictures_share_a_file() {
    let mut stability = sample();
    stability.cases[0].cells[1].settings = "3x3; bias: NONE".to_owned();
    stability.cases[0].cells[2].picture = None;
    let names = super::pictures::names(&stability);
    let of_first: Vec<&str> = names[0].iter().flatten().map(String::as_str).collect();
    let expected = [
        "pictures/thin-plate.pcf-3x3-bias-none.png",
        "pictures/thin-plate.pcf-3x3-bias-none-2.png",
    ];
    assert_eq!(of_first, expected);
    assert_eq!(names[0][2], None);
}

#[test]
fn results_of_other_versions_and_other_files_are_refused() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    write(dir.path(), &results()).expect("writable");
    let file = dir.path().join("results.json");
    // The folder and the file are both accepted.
    for path in [dir.path(), &file] {
        let read = StabilityResults::read(path).expect("as written");
        assert_eq!(read.stability.cases.len(), 3);
        assert_eq!(read.program, results().program);
    }
    let refused = |text: &str| {
        std::fs::write(&file, text).expect("writable");
        let error = StabilityResults::read(&file).expect_err("refused");
        error.to_string()
    };
    let newer = refused(&format!("{{\"schema\": {}}}", STABILITY_SCHEMA + 1));
    assert!(newer.contains("schema 2, this program's is 1"), "{newer}");
    assert!(refused("[1, 2]").contains("no results of `stability`"));
    assert!(refused("{\"schema\": 1}").contains("is not what `stability` writes"));
    let missing = StabilityResults::read(&dir.path().join("none")).expect_err("not there");
    assert!(missing.to_string().contains("cannot be read"), "{missing}");
}

/// Adds the names of all fields in some data.
fn add_fields(data: &serde_json::Value, names: &mut Vec<String>) {
    match data {
        serde_json::Value::Object(fields) => {
            for (name, value) in fields {
                names.push(name.clone());
                add_fields(value, names);
            }
        }
        serde_json::Value::Array(values) => values.iter().for_each(|v| add_fields(v, names)),
        _ => {}
    }
}

#[test]
fn the_documented_format_has_every_field() {
    let document = include_str!("../../../../../docs/schemas.md");
    let (_, document) = document
        .split_once("## results.json of stability")
        .expect("a part of its own");
    let version = format!("**version {STABILITY_SCHEMA}** of `stability`");
    assert!(document.contains(&version), "{version}");
    let mut data = serde_json::to_value(results()).expect("plain data");
    // Its fields are documented with those of `compare`.
    data["environment"] = serde_json::Value::Null;
    let mut names = Vec::new();
    add_fields(&data, &mut names);
    assert!(names.iter().any(|name| name == "passes_without"));
    let is_reported = |name: &&String| {
        document.contains(&format!("`{name}`")) || document.contains(&format!("\"{name}\":"))
    };
    let missing: Vec<&String> = names.iter().filter(|name| !is_reported(name)).collect();
    assert!(missing.is_empty(), "{missing:?}");
}

#[test]
fn everything_is_written_and_reads_back() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let page = write(dir.path(), &results()).expect("writable");
    let html = std::fs::read_to_string(page).expect("there");
    // The data, and the four scripts.
    assert_eq!(
        html.matches("</script>").count(),
        5,
        "names can't end a script"
    );
    assert!(
        !html.contains("src=\"http") && !html.contains("href=\"http"),
        "needs nothing from elsewhere"
    );
    let read = StabilityResults::read(dir.path()).expect("as written");
    let back = read.stability;
    let failing = &back.cases[0].cells[1];
    assert_eq!(failing.figure(), Some(0.75));
    assert_eq!(failing.decisive(), Some(1), "the other criterion fails");
    assert_eq!(back.windows, sample().windows);
    assert!(html.contains("0 to 1.5 texels"));
    let windows = std::fs::read_to_string(dir.path().join("windows.csv")).expect("there");
    assert!(windows.contains("own,1.5,0,1.5"), "{windows}");
    let svg = std::fs::read_to_string(dir.path().join("matrix.svg")).expect("there");
    assert!(
        ["✓", "✗", "–", "&lt;none&gt;"]
            .iter()
            .all(|s| svg.contains(s)),
        "{svg}"
    );
    let csv = std::fs::read_to_string(dir.path().join("matrix.csv")).expect("there");
    // A header, and two lines for each of 3 + 1 + 3 cells.
    assert_eq!(csv.lines().count(), 15);
    let not_measured = &back.cases[1].cells[0];
    assert_eq!(not_measured.verdict(), Some(Verdict::NotMeasured));
    assert_eq!(not_measured.figure(), None);
    assert!(
        csv.contains("not measured") && csv.contains("rendered <once>"),
        "{csv}"
    );
    assert!(
        svg.contains("stable fit to 8 m, bias: slope); gap: not measured; acne: 2.000"),
        "{svg}"
    );
    assert!(html.contains("1 sanity case") && svg.contains("1 sanity case"));
    assert_eq!(svg.matches("thin-plate").count(), 1);
    assert_eq!(
        svg.matches("no-casters").count(),
        1,
        "in the line of sanity cases alone"
    );
    assert!(
        csv.contains("thin-plate") && csv.contains("unsupported,\"no, \"\"never\"\"\""),
        "{csv}"
    );
}

#[test]
fn sanity_cases_are_one_line_that_names_what_fails() {
    let mut stability = sample();
    let line = stability.sanity_line().expect("one sanity case");
    assert!(
        line.contains("do not pass: no-casters: pcf (7x7, bias: slope)"),
        "{line}"
    );
    assert!(!line.contains("3x3") && !line.contains("cube"), "{line}");
    let sanity = stability.cases.last_mut().expect("the sanity case");
    sanity.cells.retain(|cell| !cell.settings.contains("7x7"));
    assert_eq!(
        stability.sanity_line().as_deref(),
        Some("1 sanity case: all pass")
    );
    stability.cases.retain(|case| !case.is_sanity);
    assert_eq!(stability.sanity_line(), None);
}
