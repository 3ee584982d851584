//! Page of synthetic results: answers follow the figures, and missing figures are reported.

use super::*;
use crate::{
    card::{Card, CardTime},
    compare::{
        CompareOptions, CompareRow, Environment, Measured, RowImages, RowOutcome, RowTimes,
        SceneImages, SceneInput, SceneResult, Section, TimingStats,
    },
    report::{ComparisonPlan, Report},
    stability::{
        CaseResult, Cell, CellOutcome, Judgement, Stability, Verdict,
        report::{STABILITY_SCHEMA, StabilityResults},
    },
};
use glam::UVec2;
use std::{fs, time::Duration};
use umbrage_core::{
    Receivers,
    metrics::{Errors, Pixel},
};
use umbrage_plan::truth::Truth;

fn row(technique: &str, rmse: f64, ms: f64) -> CompareRow {
    let total = TimingStats {
        median: ms,
        min: ms,
        max: ms,
        runs: 1,
    };
    let errors = Errors {
        rmse,
        counted: 12,
        ..Errors::default()
    };
    let times = RowTimes {
        receive: Some(total),
        total,
        ..RowTimes::default()
    };
    let measured = Measured {
        errors: Some(errors),
        times: Some(times),
        ..Measured::default()
    };
    CompareRow {
        technique: technique.to_owned(),
        settings: "1024, bias: adaptive".to_owned(),
        slug: technique.to_owned(),
        backend: "cpu".to_owned(),
        same_as: None,
        outcome: RowOutcome::Measured(Box::new(measured)),
    }
}

/// Returns a frame under the sun with 451,942 triangles; `hard` and `better` have these errors.
fn scene(hard: f64, better: f64) -> (SceneResult, SceneImages) {
    let rows = vec![
        row("none", 0.5, 0.1),
        row("hard", hard, 10.0),
        row("better", better, 18.0),
    ];
    let truth = Truth {
        size: UVec2::new(4, 3),
        visibility: vec![1.0; 12],
        error: vec![0.0; 12],
        pixels: vec![Pixel::Counted; 12],
        ambiguous: vec![false; 12],
        blocker: vec![f32::INFINITY; 12],
        contact: 0.0,
        receivers: Receivers::empty(UVec2::new(4, 3)),
        fingerprint: 1,
        elapsed: Duration::ZERO,
    };
    let images = SceneImages {
        rows: vec![
            RowImages {
                mask: Some(vec![0.5; 12]),
                ..RowImages::default()
            };
            rows.len()
        ],
        truth,
    };
    let result = SceneResult {
        name: "street".to_owned(),
        section: Section::Content,
        light: "directional".to_owned(),
        is_ideal: true,
        size: [4, 3],
        triangles: 451_942,
        rmse_of_none: [0.5, 0.8],
        rows,
        ..SceneResult::default()
    };
    (result, images)
}

/// Returns results in which `hard` fails the second of two rows and `better` was not run.
fn stability() -> StabilityResults {
    let case = |row: u8, verdict| CaseResult {
        row,
        title: format!("weakness {row}"),
        weakness: String::new(),
        not_yet: None,
        case: format!("case-{row}"),
        scene: String::new(),
        motion: "still".to_owned(),
        fit: String::new(),
        is_sanity: false,
        criteria: Vec::new(),
        cells: vec![Cell {
            technique: "hard".to_owned(),
            settings: "512, bias: adaptive".to_owned(),
            outcome: CellOutcome::from_judgements(vec![Judgement {
                figure: Some(1.0),
                verdict,
                reason: None,
            }]),
            disagreeing: None,
            picture: None,
        }],
    };
    StabilityResults {
        schema: STABILITY_SCHEMA,
        stability: Stability {
            cases: vec![case(1, Verdict::Pass), case(2, Verdict::Fails)],
            ..Stability::default()
        },
        ..StabilityResults::default()
    }
}

/// Writes results in which `better` has this error and `hard` has 0.2; returns the folder.
fn measured_folder(better: f64, section: Section) -> tempfile::TempDir {
    measured_errors(0.2, better, section)
}

/// Writes a comparison with these errors of `hard` and `better`, and `stability`'s results; returns
/// the folder.
fn measured_errors(hard: f64, better: f64, section: Section) -> tempfile::TempDir {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let named = umbrage_core::Scene {
        name: "street".to_owned(),
        ..Default::default()
    };
    let plan = ComparisonPlan::new(&[SceneInput::new(named, "")], &CompareOptions::default());
    let compared = dir.path().join("compared");
    let report = Report::create(&compared, plan, &[0], false).expect("writable");
    let (mut result, images) = scene(hard, better);
    result.section = section;
    let environment = Environment::default();
    report
        .scene(0, &environment, &[], &result, &images)
        .expect("writable");
    report.finish(None).expect("writable");
    let folder = dir.path().join("stability");
    fs::create_dir(&folder).expect("writable");
    let json = serde_json::to_vec(&stability()).expect("plain data");
    fs::write(folder.join("results.json"), json).expect("writable");
    dir
}

/// Returns the page as Markdown.
fn page(dir: &Path) -> String {
    page_with_card(dir, None)
}

/// Returns the page with a card's times as Markdown.
fn page_with_card(dir: &Path, card: Option<&Card>) -> String {
    let out = dir.join("out");
    let [markdown, html] = write(
        &dir.join("compared"),
        &dir.join("stability"),
        card,
        &out,
        "make it",
    )
    .expect("writable");
    let html = fs::read_to_string(html).expect("there");
    let markdown = fs::read_to_string(markdown).expect("there");
    // Each image file is named on both pages and is small.
    let files = fs::read_dir(out.join("which")).expect("there").flatten();
    for file in files {
        let name = file.file_name().to_string_lossy().into_owned();
        assert!(markdown.contains(&name) && html.contains(&name), "{name}");
        let picture = image::open(file.path()).expect("a picture");
        assert_eq!((picture.width(), picture.height()), (3 * 168 + 8, 126));
    }
    assert!(html.contains("<h1") && !html.contains("http"));
    markdown
}

/// Returns the first table line that begins with a cell.
fn line<'a>(markdown: &'a str, cell: &str) -> &'a str {
    let begins = format!("| {cell} |");
    let found = markdown.lines().find(|line| line.starts_with(&begins));
    found.unwrap_or_else(|| panic!("{cell}: {markdown}"))
}

#[test]
fn answers_follow_the_figures() {
    let better = page(measured_folder(0.1, Section::Content).path());
    assert!(line(&better, "1.25 times hard").contains("**hard** 1024: 40 %, 1.0 times"));
    assert!(line(&better, "2 times hard").contains("**better** 1024: 20 %, 1.8 times"));
    let mut lines = better.lines();
    let is_there = lines.any(|line| line.starts_with("| 5 times hard |"));
    assert!(!is_there, "it changes nothing");
    assert!(better.contains("(451,942 triangles, 4x3)"));
    assert!(
        better.contains("all moves): 18.0, 18.0, 18.0 ms (1.8, 1.8, 1.8 times hard)"),
        "{better}"
    );
    // Once it is worse, no answer names it.
    let worse = page(measured_folder(0.3, Section::Content).path());
    assert!(!worse.contains("better"), "{worse}");
}

#[test]
fn what_is_not_known_is_said() {
    let markdown = page(measured_folder(0.1, Section::Content).path());
    let missing = markdown
        .lines()
        .find(|line| line.starts_with("**Not measured**"));
    let missing = missing.expect("a line");
    assert!(
        missing.contains("Spot with extent, over 1 million triangles"),
        "{missing}"
    );
    assert!(!missing.contains("Sun without extent, 300,"), "{missing}");
    // Seventeen of 3 lights x 2 extents x 3 sizes.
    assert_eq!(missing.matches(" triangles").count(), 17);
    assert!(
        markdown.contains("fails 1 of 2 rows: weakness 2 |"),
        "{markdown}"
    );
    assert!(
        markdown.contains("| not measured |"),
        "of `better`: {markdown}"
    );
    assert!(
        markdown.contains("**Note:**"),
        "measured by another program"
    );
}

#[test]
fn folders_without_such_results_are_refused() {
    let dir = measured_folder(0.1, Section::Check);
    let refused = |compared: &str, stability: &str| {
        let at = |name: &str| dir.path().join(name);
        let error =
            write(&at(compared), &at(stability), None, &at("out"), "").expect_err("refused");
        error.to_string()
    };
    assert!(refused("compared", "stability").contains("no full-size scenes"));
    let no_scenes = refused("none", "stability");
    assert!(
        no_scenes.contains("contains no scenes") && no_scenes.contains("`compare` wrote"),
        "{no_scenes}"
    );
    assert!(refused("compared", "none").contains("cannot be read"));
}

#[test]
fn a_poor_answer_is_called_that_and_a_good_one_is_named() {
    // `hard` has 40 % of the error of no shadow, then 80 %.
    let good = page(measured_folder(0.3, Section::Content).path());
    assert!(!good.contains("**none is good**"), "{good}");
    let dir = measured_errors(0.4, 0.1, Section::Content);
    let poor = page(dir.path());
    let least = line(&poor, "1.25 times hard");
    assert!(
        least.contains("**none is good**: **hard** 1024: 80 %, 1.0 times; take **better** 1024: 20 %, 1.8 times"),
        "{least}"
    );
}

/// Returns a card on which `better` takes half of the time of `hard`.
fn card() -> Card {
    let time = |technique: &str, milliseconds| CardTime {
        frame: "street 4x3".to_owned(),
        technique: technique.to_owned(),
        settings: "1024, bias: adaptive".to_owned(),
        milliseconds,
        measured_milliseconds: 1.0,
    };
    Card {
        adapter: "A card".to_owned(),
        times: Some(vec![time("hard", Some(2.0)), time("better", Some(1.0))]),
        ..Card::default()
    }
}

#[test]
fn a_card_decides_by_its_own_times() {
    let dir = measured_folder(0.1, Section::Content);
    let with_card = page_with_card(dir.path(), Some(&card()));
    let first = line(&with_card, "1.25 times hard");
    assert!(
        first.contains("**better** 1024: 20 %, 0.5 times"),
        "{first}"
    );
    assert!(
        with_card.contains("A card (maps and lookup of a frame): 1.00 ms (0.5 times hard)"),
        "{with_card}"
    );
    // A time without a steady clock is no time.
    let mut unsteady = card();
    for time in unsteady.times.iter_mut().flatten() {
        time.milliseconds = None;
    }
    let without = page_with_card(dir.path(), Some(&unsteady));
    assert!(!without.contains("A card ("), "{without}");
}

#[test]
fn the_chart_has_a_label_for_each_setting_and_says_if_no_card_was_measured() {
    let dir = measured_folder(0.1, Section::Content);
    page(dir.path());
    let chart = dir.path().join("out/which.svg");
    let of_cpu = fs::read_to_string(&chart).expect("there");
    for part in ["hard 1024", "better 1024", "not yet measured on hardware"] {
        assert!(of_cpu.contains(part), "{part}: {of_cpu}");
    }
    page_with_card(dir.path(), Some(&card()));
    let of_card = fs::read_to_string(&chart).expect("there");
    assert!(
        of_card.contains("A card") && !of_card.contains("not yet measured"),
        "{of_card}"
    );
}
