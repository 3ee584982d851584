use super::*;
use crate::stability::{CaseResult, Cell, Verdict, VerdictLimits};

/// A matrix of one case and three cells; names hold what markup and CSV stumble over.
fn sample() -> Stability {
    let cell = |settings: &str, outcome| Cell {
        technique: "pcf".to_owned(),
        settings: settings.to_owned(),
        outcome,
        disagreeing: Some(0),
        picture: Some(vec![1, 2, 3]),
    };
    let measured = |figure, verdict| CellOutcome::Measured { figure, verdict };
    let case = CaseResult {
        row: 3,
        title: "thin </script> contact".to_owned(),
        weakness: "gap & leak".to_owned(),
        not_yet: None,
        case: "thin-plate".to_owned(),
        scene: "thin-plate".to_owned(),
        motion: "still".to_owned(),
        measure: "gap".to_owned(),
        unit: "mm".to_owned(),
        limits: VerdictLimits::new(1.0, 4.0),
        reason: "because".to_owned(),
        ideal: 0.25,
        cells: vec![
            cell("3x3, bias: <none>", measured(0.5, Verdict::Pass)),
            cell("7x7, bias: slope", measured(9.0, Verdict::Fails)),
            cell(
                "cube",
                CellOutcome::Unsupported {
                    reason: "no, \"never\"".to_owned(),
                },
            ),
        ],
    };
    Stability {
        backends: vec!["cpu".to_owned()],
        map_size: 64,
        size: [8, 6],
        frames: 2,
        cases: vec![case],
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
    assert_eq!(back.cases[0].cells[1].figure(), Some(9.0));
    let svg = std::fs::read_to_string(dir.path().join("matrix.svg")).expect("there");
    assert!(
        ["✓", "✗", "–", "&lt;none&gt;"]
            .iter()
            .all(|s| svg.contains(s)),
        "{svg}"
    );
    let csv = std::fs::read_to_string(dir.path().join("matrix.csv")).expect("there");
    assert_eq!(csv.lines().count(), 4);
    assert!(
        csv.contains("thin-plate") && csv.contains("unsupported,\"no, \"\"never\"\"\""),
        "{csv}"
    );
}
