//! Tables printed by `stability`: the matrix of single rows, the bias windows, and the list of
//! rows.

use crate::stability::{
    Base, BiasWindow, CaseResult, Cell, CriterionResult, Stability, Verdict, rows,
};
use comfy_table::{CellAlignment, ContentArrangement, Table, presets::UTF8_FULL_CONDENSED};

/// Returns a table with one line per technique: the normal offsets with neither acne nor a gap.
pub(crate) fn windows_table(windows: &[BiasWindow]) -> Table {
    let mut table = Table::new();
    table
        .load_style(UTF8_FULL_CONDENSED)
        .set_content_arrangement(ContentArrangement::Disabled)
        .set_header([
            "technique",
            "normal offsets without acne and gap, added to the default bias",
            "width, texels",
            "as the only bias",
            "width, texels",
        ]);
    for own in windows.iter().filter(|window| window.base == Base::Own) {
        let bare = windows
            .iter()
            .find(|window| window.base == Base::Bare && window.technique == own.technique);
        let tuning = if own.needs_no_tuning() {
            ": no tuning"
        } else {
            ""
        };
        table.add_row([
            own.technique.clone(),
            format!("{}{tuning}", own.words()),
            number(own.width()),
            bare.map_or_else(String::new, BiasWindow::words),
            bare.map_or_else(String::new, |window| number(window.width())),
        ]);
    }
    table
}

/// Returns the number of cells with each verdict, next to its sign.
pub(crate) fn legend(stability: &Stability) -> String {
    let verdicts = [
        (Verdict::Pass, "pass"),
        (Verdict::Degraded, "degraded"),
        (Verdict::Fails, "fail"),
        (Verdict::NotMeasured, "not measured (could not fail)"),
    ];
    let mut parts = Vec::new();
    for (verdict, what) in verdicts {
        let count = stability.count(verdict);
        parts.push(format!("{} {count} {what}", verdict.sign()));
    }
    let counts = parts.join("   ");
    format!("{counts}   – not supported   ! invalid")
}

/// Formats each of a case's criteria with `text`. All but the first are in brackets.
pub(crate) fn measures(
    result: &CaseResult,
    text: impl Fn(&CriterionResult) -> String,
) -> Vec<String> {
    let mut out = Vec::new();
    for (k, criterion) in result.criteria.iter().enumerate() {
        out.push(bracket_text(k, text(criterion)));
    }
    out
}

/// Returns the text of the first criterion as it is, and that of others in brackets.
fn bracket_text(criterion: usize, text: String) -> String {
    if criterion == 0 {
        text
    } else {
        format!("({text})")
    }
}

/// Returns the name and unit of a measure.
fn with_unit(criterion: &CriterionResult) -> String {
    if criterion.unit.is_empty() {
        criterion.measure.clone()
    } else {
        format!("{}, {}", criterion.measure, criterion.unit)
    }
}

/// Returns the matrix: a line for each case but the sanity cases, and a column for each
/// technique. Each setting has a sign and its decisive figure.
pub(crate) fn matrix(stability: &Stability) -> Table {
    let techniques = stability.techniques();
    let mut table = Table::new();
    table
        .load_style(UTF8_FULL_CONDENSED)
        .set_content_arrangement(ContentArrangement::Disabled);
    let mut head = vec!["#", "case", "measure", "pass", "fail"];
    head.extend(&techniques);
    table.set_header(head);
    for result in stability.separating_cases() {
        let mut line = vec![
            result.row.to_string(),
            result.case.clone(),
            measures(result, with_unit).join("\n"),
            measures(result, |c| number(c.limits.pass)).join("\n"),
            measures(result, |c| number(c.limits.fails)).join("\n"),
        ];
        for technique in &techniques {
            line.push(signs_and_figures(result, technique));
        }
        table.add_row(line);
    }
    for column in table.column_iter_mut().skip(3).take(2) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

/// Returns a line for each setting of a technique.
fn signs_and_figures(result: &CaseResult, technique: &str) -> String {
    let mut lines = Vec::new();
    for cell in result.cells.iter().filter(|c| c.technique == technique) {
        let sign = cell.sign();
        lines.push(match decisive_figure(cell) {
            Some(figure) => format!("{sign} {figure}"),
            None => sign.to_string(),
        });
    }
    lines.join("\n")
}

/// Returns the figure that decides a cell's verdict. `None` if there is none.
fn decisive_figure(cell: &Cell) -> Option<String> {
    let criterion = cell.decisive()?;
    let figure = cell.judgements()[criterion].figure?;
    Some(bracket_text(criterion, number(figure)))
}

/// Formats a number with three significant digits, or fewer below 0.1.
pub(crate) fn number(v: f64) -> String {
    match v.abs() {
        0.0 => "0".to_owned(),
        a if a < 0.001 => format!("{v:.0e}"),
        a if a < 1.0 => format!("{v:.3}"),
        a if a < 10.0 => format!("{v:.2}"),
        a if a < 100.0 => format!("{v:.1}"),
        _ => format!("{v:.0}"),
    }
}

/// Returns the table of all rows with their cases and measures.
pub(crate) fn list() -> Table {
    let mut table = Table::new();
    table.load_style(comfy_table::presets::NOTHING).set_header([
        "row",
        "what fails",
        "case",
        "motion",
        "measure",
        "limits",
    ]);
    for row in rows() {
        for case in row.cases {
            let criteria = [Some(case.measure), case.measure.opposite()];
            let names: Vec<&str> = criteria.iter().flatten().map(|m| m.name()).collect();
            let reasons: Vec<&str> = criteria.iter().flatten().map(|m| m.reason()).collect();
            table.add_row([
                format!("{} {}", row.number, row.title),
                row.weakness.to_owned(),
                case.name.to_owned(),
                case.motion.label().to_owned(),
                names.join("; "),
                reasons.join("; "),
            ]);
        }
    }
    table.set_content_arrangement(ContentArrangement::Dynamic);
    table
}
