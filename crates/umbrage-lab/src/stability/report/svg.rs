//! The matrix as one image for a README: a line per case, a column per setting, and signs that read
//! without color.

use crate::{
    output::html::escape,
    stability::{
        cell::{CaseResult, Cell, CriterionResult, Stability},
        verdict::Verdict,
    },
};
use std::fmt::Write as _;

/// Distance between the left sides of neighbouring cells, pixels; includes the gap.
const CELL_WIDTH: usize = 26;
/// Distance between the tops of neighbouring lines, pixels; includes the gap.
const CELL_HEIGHT: usize = 19;
/// Gap between cells, pixels.
const CELL_GAP: usize = 2;
/// Width left of the cells, for the names of cases, pixels.
const LEFT: usize = 400;
/// Width right of the cells, for the last slanted column head, pixels.
const RIGHT: usize = 90;
/// Height above the cells, for the column heads, pixels.
const TOP: usize = 178;
/// Height below the cells, for the legend, pixels.
const BOTTOM: usize = 34;
/// Distance from the top of a line to the baseline of its text, pixels.
const BASELINE: usize = 14;

/// Legend of the signs ([`Cell::sign`]).
const LEGEND: &str = "✓ passes   ~ degraded   ✗ fails   · not measured: could not fail   – unsupported; limits and figures: cargo xtask stability";

/// The colors of a cell, as CSS.
struct CellColors {
    background: &'static str,
    ink: &'static str,
}

/// Returns the colors of a cell: blue to orange, which all kinds of color vision distinguish
/// (Okabe, Ito 2008).
fn colors(cell: &Cell) -> CellColors {
    let (background, ink) = match cell.verdict() {
        Some(Verdict::Pass) => ("#cfe3f5", "#134a7c"),
        Some(Verdict::NotMeasured) => ("#e6ecf2", "#5b6675"),
        Some(Verdict::Degraded) => ("#fbe6b8", "#7a5200"),
        Some(Verdict::Fails) => ("#e58a4a", "#3d1600"),
        None if cell.sign() == '!' => ("#b3261e", "#ffffff"),
        None => ("#eef0f3", "#8a94a3"),
    };
    CellColors { background, ink }
}

/// Returns the whole image; empty without cases.
pub(super) fn matrix(stability: &Stability) -> String {
    let cases: Vec<&CaseResult> = stability.separating_cases().collect();
    // Some rows run more settings than others. Take the settings that all rows with the default fit
    // run as columns; the page shows the rest.
    let usual = cases.iter().filter(|case| case.fit.is_empty());
    let least = usual.min_by_key(|case| case.cells.len());
    let Some(least) = least.or(cases.first()) else {
        return String::new();
    };
    let columns: Vec<String> = least.cells.iter().map(|c| column(least, c)).collect();
    let sanity = stability.sanity_line();
    let sanity_height = if sanity.is_some() { CELL_HEIGHT } else { 0 };
    let w = LEFT + columns.len() * CELL_WIDTH + RIGHT;
    let h = TOP + cases.len() * CELL_HEIGHT + sanity_height + BOTTOM;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w} {h}\" width=\"{w}\" height=\"{h}\" \
         font-family=\"system-ui, 'Segoe UI', 'DejaVu Sans', sans-serif\" font-size=\"11.5\">\n\
         <rect width=\"{w}\" height=\"{h}\" fill=\"#ffffff\"/>\n"
    );
    for (column, cell) in least.cells.iter().enumerate() {
        write_head(&mut out, cell, column);
    }
    for (line, case) in cases.iter().enumerate() {
        let is_first_of_row = cases[..line].iter().all(|c| c.row != case.row);
        write_line(&mut out, case, line, &columns, is_first_of_row);
    }
    if let Some(text) = sanity {
        let y = TOP + cases.len() * CELL_HEIGHT + BASELINE;
        let text = escape(&text);
        let _ = writeln!(
            out,
            "<text x=\"34\" y=\"{y}\" fill=\"#1b2330\">{text}</text>"
        );
    }
    let legend_y = h - 12;
    let _ = writeln!(
        out,
        "<text x=\"12\" y=\"{legend_y}\" fill=\"#5b6675\">{LEGEND}</text>\n</svg>"
    );
    out
}

/// Returns the name of a cell's column: the technique and its settings without the fit, which is
/// the line's.
fn column(case: &CaseResult, cell: &Cell) -> String {
    let settings = case.settings_without_fit(cell);
    format!("{} ({settings})", cell.technique)
}

/// Writes a column's slanted head: the technique, and the end of its settings, which differs
/// between the settings of one technique (the bias, or the rays).
fn write_head(out: &mut String, cell: &Cell, column: usize) {
    let settings = cell.settings.rsplit("bias: ").next().unwrap_or_default();
    let head = format!("{}, {settings}", cell.technique);
    let x = LEFT + column * CELL_WIDTH + CELL_WIDTH / 2 + 4;
    let y = TOP - 8;
    let _ = writeln!(
        out,
        "<text transform=\"translate({x} {y}) rotate(-50)\" fill=\"#1b2330\">{}</text>",
        escape(&head)
    );
}

/// Writes a case's line: the row's number if it is the row's first case, the case's name, and the
/// cells of these columns.
fn write_line(
    out: &mut String,
    case: &CaseResult,
    line: usize,
    columns: &[String],
    is_first_of_row: bool,
) {
    let y = TOP + line * CELL_HEIGHT;
    let measures: Vec<&str> = case.criteria.iter().map(|c| c.measure.as_str()).collect();
    let measures = measures.join(", ");
    let base = y + BASELINE;
    if is_first_of_row {
        let _ = writeln!(
            out,
            "<text x=\"12\" y=\"{base}\" fill=\"#5b6675\">{}</text>",
            case.row
        );
    }
    let _ = writeln!(
        out,
        "<text x=\"34\" y=\"{base}\" fill=\"#1b2330\">{} <tspan fill=\"#5b6675\">{}</tspan></text>",
        escape(&case.case),
        escape(&measures)
    );
    for (k, name) in columns.iter().enumerate() {
        let x = LEFT + k * CELL_WIDTH;
        if let Some(cell) = case.cells.iter().find(|cell| column(case, cell) == *name) {
            write_cell(out, cell, &case.criteria, x, y);
        }
    }
}

/// Writes a cell whose top left corner is at (`x`, `y`). Its tooltip lists the setting and the
/// figures.
fn write_cell(out: &mut String, cell: &Cell, criteria: &[CriterionResult], x: usize, y: usize) {
    let CellColors { background, ink } = colors(cell);
    let technique = escape(&cell.technique);
    let settings = escape(&cell.settings);
    let mut figures = String::new();
    for (criterion, judgement) in criteria.iter().zip(cell.judgements()) {
        let measure = escape(&criterion.measure);
        let _ = match judgement.figure {
            Some(figure) => write!(figures, "; {measure}: {figure:.3} {}", criterion.unit),
            None => write!(figures, "; {measure}: not measured"),
        };
    }
    let w = CELL_WIDTH - CELL_GAP;
    let h = CELL_HEIGHT - CELL_GAP;
    let center = x + CELL_WIDTH / 2 - 1;
    let base = y + BASELINE;
    let sign = cell.sign();
    let _ = writeln!(
        out,
        "<g><title>{technique} ({settings}){figures}</title>\
         <rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" rx=\"3\" fill=\"{background}\"/>\
         <text x=\"{center}\" y=\"{base}\" text-anchor=\"middle\" fill=\"{ink}\">{sign}</text></g>"
    );
}
