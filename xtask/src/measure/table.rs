//! A comparison's figures on the terminal.

use comfy_table::{CellAlignment, ContentArrangement, Table, presets::UTF8_FULL_CONDENSED};
use umbrage_lab::compare::{Measured, Outcome, Row, SceneResult};

/// With more rows than this, only those are printed that no other beats in both time and error.
const ALL_ROWS: usize = 120;

const HEADER: [&str; 11] = [
    "technique",
    "settings",
    "backend",
    "RMSE",
    "false shadow %",
    "false light %",
    "acne %",
    "ms",
    "lookup ms",
    "MiB",
    "differing",
];

/// One table a scene.
pub(super) fn print(scenes: &[SceneResult]) {
    let whole = scenes.iter().map(|s| s.rows.len()).sum::<usize>() <= ALL_ROWS;
    for scene in scenes {
        let mut table = Table::new();
        table.load_style(UTF8_FULL_CONDENSED).set_content_arrangement(ContentArrangement::Dynamic).set_header(HEADER);
        for row in scene.rows.iter().filter(|row| whole || is_best(row, &scene.rows)) {
            table.add_row(cells(row));
        }
        (3..HEADER.len()).filter_map(|i| table.column_mut(i)).for_each(|c| c.set_cell_alignment(CellAlignment::Right));
        let [w, h] = scene.size;
        println!("\n{}: {} light, {w} x {h}, {} triangles\n{table}", scene.name, scene.light, scene.triangles);
    }
    if !whole {
        println!(
            "\nOnly rows that no other row of their scene and backend beats in both time and error; the report has all."
        );
    }
}

fn cells(row: &Row) -> Vec<String> {
    let named = [&row.technique, &row.settings, &row.backend].map(String::clone);
    let figures = match &row.outcome {
        Outcome::Unsupported { reason } => vec!["-".to_owned(), reason.clone()],
        Outcome::Measured(m) => figures(m),
    };
    named.into_iter().chain(figures).collect()
}

fn figures(m: &Measured) -> Vec<String> {
    let e = &m.errors;
    vec![
        format!("{:.4}", e.rmse),
        format!("{:.2}", e.false_shadow),
        format!("{:.2}", e.false_light),
        format!("{:.2}", e.acne),
        format!("{:.2}", m.times.total.median),
        m.times.receive.map_or_else(|| "-".to_owned(), |s| format!("{:.2}", s.median)),
        format!("{:.1}", m.bytes as f64 / f64::from(1 << 20)),
        m.agreement.map_or_else(String::new, |a| a.differing.to_string()),
    ]
}

/// Whether no row of the same backend is both faster and nearer to truth.
fn is_best(row: &Row, rows: &[Row]) -> bool {
    let point = |row: &Row| row.measured().map(|m| (m.times.total.median, m.errors.rmse));
    let Some((time, error)) = point(row) else { return false };
    let mut others = rows.iter().filter(|r| r.backend == row.backend).filter_map(point);
    !others.any(|(t, e)| t <= time && e <= error && (t, e) != (time, error))
}
