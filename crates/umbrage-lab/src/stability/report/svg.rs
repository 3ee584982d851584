//! The matrix as one picture for a README: a line a case, a column a setting, signs that read without colour.

use crate::{
    output::html::escape,
    stability::{CaseResult, Cell, Stability, Verdict},
};
use std::fmt::Write as _;

const CELL: [usize; 2] = [26, 19];
/// Beside the cells: names of cases; above them: names of techniques.
const LEFT: usize = 335;
const TOP: usize = 178;
const BOTTOM: usize = 34;

/// Background and ink of a cell. Blue to orange, as all kinds of colour vision tell them apart (Okabe, Ito 2008).
fn colors(cell: &Cell) -> [&'static str; 2] {
    match cell.verdict() {
        Some(Verdict::Pass) => ["#cfe3f5", "#134a7c"],
        Some(Verdict::Degraded) => ["#fbe6b8", "#7a5200"],
        Some(Verdict::Fails) => ["#e58a4a", "#3d1600"],
        None if cell.sign() == '!' => ["#b3261e", "#ffffff"],
        None => ["#eef0f3", "#8a94a3"],
    }
}

/// The whole picture; empty without cases.
pub(super) fn matrix(stability: &Stability) -> String {
    // Settings that only single rows try are the page's: the picture has those that all rows try.
    let Some(least) = stability.cases.iter().min_by_key(|c| c.cells.len()) else {
        return String::new();
    };
    let columns: Vec<String> = least.cells.iter().map(head).collect();
    let (w, h) = (
        LEFT + columns.len() * CELL[0] + 90,
        TOP + stability.cases.len() * CELL[1] + BOTTOM,
    );
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w} {h}\" width=\"{w}\" height=\"{h}\" \
         font-family=\"system-ui, 'Segoe UI', 'DejaVu Sans', sans-serif\" font-size=\"11.5\">\n\
         <rect width=\"{w}\" height=\"{h}\" fill=\"#ffffff\"/>\n"
    );
    for (i, column) in columns.iter().enumerate() {
        let (x, y) = (LEFT + i * CELL[0] + CELL[0] / 2 + 4, TOP - 8);
        let _ = writeln!(
            out,
            "<text transform=\"translate({x} {y}) rotate(-50)\" fill=\"#1b2330\">{}</text>",
            escape(column)
        );
    }
    for (k, case) in stability.cases.iter().enumerate() {
        let is_first_of_row = stability.cases[..k].iter().all(|c| c.row != case.row);
        line(&mut out, case, k, columns.len(), is_first_of_row);
    }
    let legend = "✓ passes   ~ degraded   ✗ fails   – not made for it; limits and figures: cargo xtask stability";
    let _ = writeln!(
        out,
        "<text x=\"12\" y=\"{}\" fill=\"#5b6675\">{legend}</text>\n</svg>",
        h - 12
    );
    out
}

/// A technique, and in what its settings differ from its others: its bias, or its rays.
fn head(cell: &Cell) -> String {
    let settings = cell.settings.rsplit("bias: ").next().unwrap_or_default();
    format!("{}, {settings}", cell.technique)
}

/// Line `k`: as many cells as there are columns, and the row's number before its first case.
fn line(out: &mut String, case: &CaseResult, k: usize, columns: usize, is_first_of_row: bool) {
    let y = TOP + k * CELL[1];
    let base = y + 14;
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
        escape(&case.measure)
    );
    for (i, cell) in case.cells.iter().take(columns).enumerate() {
        let (x, [background, ink]) = (LEFT + i * CELL[0], colors(cell));
        let figure = cell
            .figure()
            .map_or_else(String::new, |f| format!(": {f:.3} {}", case.unit));
        let _ = writeln!(
            out,
            "<g><title>{} ({}){figure}</title><rect x=\"{x}\" y=\"{y}\" width=\"{}\" height=\"{}\" rx=\"3\" fill=\"{background}\"/>\
             <text x=\"{}\" y=\"{base}\" text-anchor=\"middle\" fill=\"{ink}\">{}</text></g>",
            escape(&cell.technique),
            escape(&cell.settings),
            CELL[0] - 2,
            CELL[1] - 2,
            x + CELL[0] / 2 - 1,
            cell.sign()
        );
    }
}
