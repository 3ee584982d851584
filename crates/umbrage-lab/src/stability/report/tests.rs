use super::*;
use crate::stability::{
    BiasWindow, CaseResult, Cell, CriterionResult, Judgement, Verdict, VerdictLimits,
};

/// A matrix of three cases, the second with one cell, that isn't measured, the last a sanity case; names hold what markup and CSV stumble over.
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
        CellOutcome::of(vec![limits[0].judgement(gap), limits[1].judgement(acne)])
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
        CellOutcome::of(vec![
            Judgement::not_measured("asked <once>"),
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

#[test]
fn everything_is_written_and_reads_back() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let page = write(dir.path(), &sample(), &[]).expect("writable");
    let html = std::fs::read_to_string(page).expect("there");
    assert_eq!(
        html.matches("</script>").count(),
        2,
        "names can't end the script"
    );
    assert!(html.contains("data:image/png;base64,AQID") && !html.contains("{{"));
    assert!(
        !html.contains("src=\"http") && !html.contains("href=\"http"),
        "self-contained"
    );
    let json = std::fs::read(dir.path().join("results.json")).expect("there");
    let (back, _): (Stability, Vec<Sweep>) = serde_json::from_slice(&json).expect("as written");
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
    // A header, and by two criteria two cases of three cells and one of one.
    assert_eq!(csv.lines().count(), 15);
    let not_measured = &back.cases[1].cells[0];
    assert_eq!(not_measured.verdict(), Some(Verdict::NotMeasured));
    assert_eq!(not_measured.figure(), None);
    assert!(
        csv.contains("not measured") && csv.contains("asked <once>"),
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
