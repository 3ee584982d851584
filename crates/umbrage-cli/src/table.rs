//! A comparison's figures on the terminal.

use comfy_table::{CellAlignment, ContentArrangement, Table, presets::UTF8_FULL_CONDENSED};
use umbrage_core::metrics::Errors;
use umbrage_lab::compare::{CompareRow, Measured, RowOutcome, SceneResult};
use umbrage_plan::{footprint, pareto::front};

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
pub(crate) fn print(scenes: &[SceneResult]) {
    let whole = scenes.iter().map(|s| s.rows.len()).sum::<usize>() <= ALL_ROWS;
    for scene in scenes {
        let mut table = Table::new();
        table
            .load_style(UTF8_FULL_CONDENSED)
            .set_content_arrangement(ContentArrangement::Dynamic)
            .set_header(HEADER);
        for row in chosen(&scene.rows, whole) {
            table.add_row(cells(row));
        }
        table
            .column_iter_mut()
            .skip(3)
            .for_each(|c| c.set_cell_alignment(CellAlignment::Right));
        let [w, h] = scene.size;
        println!(
            "\n{}: {} light, {w} x {h}, {} triangles\n{table}",
            scene.name, scene.light, scene.triangles
        );
        scene
            .nothing_compared
            .iter()
            .for_each(|why| println!("-: {why}"));
        maps(&scene.rows)
            .iter()
            .chain(&left_out(&scene.rows))
            .for_each(|line| println!("{line}"));
    }
    if !whole {
        println!(
            "\nOnly rows that no other row of their scene and backend beats in both time and error; the report has all."
        );
    }
}

/// How the maps of all rows are used, in a line; none without maps.
fn maps(rows: &[CompareRow]) -> Option<String> {
    let used: Vec<_> = rows.iter().filter_map(|r| r.measured()?.maps).collect();
    Some(format!("maps: {}", footprint::words(&used)?))
}

/// How many pixels were left out of the errors, in a line; none if none were.
fn left_out(rows: &[CompareRow]) -> Option<String> {
    let left_out = |row: &CompareRow| {
        row.measured()?
            .errors
            .map(|e| e.elsewhere)
            .filter(|pixels| *pixels > 0)
    };
    let (row, pixels) = rows.iter().find_map(|row| Some((row, left_out(row)?)))?;
    Some(format!(
        "left out: {pixels} pixels at which {} sees other triangles than truth",
        row.backend
    ))
}

fn cells(row: &CompareRow) -> Vec<String> {
    let named = [&row.technique, &row.settings, &row.backend].map(String::clone);
    let figures = match &row.outcome {
        RowOutcome::Unsupported { reason } => vec!["-".to_owned(), reason.clone()],
        RowOutcome::Measured(m) => figures(m),
    };
    named.into_iter().chain(figures).collect()
}

fn figures(m: &Measured) -> Vec<String> {
    // Where no pixel counts, no error is no merit.
    let error = |digits: usize, of: fn(&Errors) -> f64| {
        m.errors
            .as_ref()
            .map_or_else(|| "-".to_owned(), |e| format!("{:.digits$}", of(e)))
    };
    vec![
        error(4, |e| e.rmse),
        error(2, |e| e.false_shadow),
        error(2, |e| e.false_light),
        error(2, |e| e.acne),
        format!("{:.2}", m.times.map_or(m.cost_ms, |t| t.total.median)),
        m.times
            .and_then(|t| t.receive)
            .map_or_else(|| "-".to_owned(), |s| format!("{:.2}", s.median)),
        format!("{:.1}", m.bytes as f64 / f64::from(1 << 20)),
        m.agreement
            .map_or_else(String::new, |a| a.differing.to_string()),
    ]
}

/// The rows to print: all, or each backend's Pareto front of time against error.
fn chosen(rows: &[CompareRow], whole: bool) -> Vec<&CompareRow> {
    if whole {
        return rows.iter().collect();
    }
    let mut backends: Vec<&str> = rows.iter().map(|r| r.backend.as_str()).collect();
    backends.sort_unstable();
    backends.dedup();
    backends
        .into_iter()
        .flat_map(|backend| best(rows.iter().filter(|r| r.backend == backend).collect()))
        .collect()
}

fn best(rows: Vec<&CompareRow>) -> Vec<&CompareRow> {
    let point = |row: &&CompareRow| {
        row.measured().map_or([f64::NAN; 2], |m| {
            [
                m.times.map_or(m.cost_ms, |t| t.total.median),
                m.rmse().unwrap_or_default(),
            ]
        })
    };
    let points: Vec<_> = rows.iter().map(point).collect();
    front(&points).into_iter().map(|i| rows[i]).collect()
}
