//! Prints a comparison's figures on the terminal.

use crate::cli::figures_table::figures_table;
use crate::compare::{CompareRow, CostBasis, FrameMotion, Measured, RowOutcome, SceneResult};
use umbrage_plan::{footprint, pareto::front};

/// Number of rows above which only Pareto-optimal rows (time and error) are printed.
const ALL_ROWS: usize = 120;

const HEADER: [&str; 12] = [
    "technique",
    "settings",
    "backend",
    "RMSE",
    "false shadow %",
    "false light %",
    "acne %",
    "frame ms",
    "recipe ms",
    "lookup ms",
    "MiB",
    "differing",
];

/// Prints a table for each scene.
pub(crate) fn print(scenes: &[SceneResult]) {
    let whole = scenes.iter().map(|s| s.rows.len()).sum::<usize>() <= ALL_ROWS;
    for scene in scenes {
        let rows = chosen_rows(scene, whole);
        let rows = rows.into_iter().map(|row| cells(row, scene.motion));
        let table = figures_table(HEADER, rows, 3);
        let [w, h] = scene.size;
        println!(
            "\n{}: {} light, {w} x {h}, {} triangles\n{table}",
            scene.name, scene.light, scene.triangles
        );
        if let Some(why) = &scene.nothing_compared {
            println!("-: {why}");
        }
        if let Some(line) = scene.truth.left_out_words() {
            println!("{line}");
        }
        if let Some(hint) = &scene.hint {
            println!("hint: {hint}");
        }
        if let Some(line) = maps(&scene.rows) {
            println!("{line}");
        }
        if let Some(line) = left_out(&scene.rows) {
            println!("{line}");
        }
    }
    if !whole {
        println!(
            "\nOnly rows that are Pareto-optimal in time and error for their scene and backend; the report has all rows."
        );
    }
}

/// Returns a line about the use of all rows' maps. `None` without maps.
fn maps(rows: &[CompareRow]) -> Option<String> {
    let used: Vec<_> = rows
        .iter()
        .filter_map(|r| r.measured_figures()?.maps)
        .collect();
    Some(format!("maps: {}", footprint::words(&used)?))
}

/// Returns a line about excluded pixels, at which the backend sees other triangles than truth.
/// `None` if there are none.
fn left_out(rows: &[CompareRow]) -> Option<String> {
    for row in rows {
        let errors = row.measured_figures().and_then(|measured| measured.errors);
        let pixels = errors.map_or(0, |errors| errors.elsewhere);
        if pixels > 0 {
            return Some(format!(
                "excluded: {pixels} pixels at which {} sees other triangles than truth",
                row.backend
            ));
        }
    }
    None
}

fn cells(row: &CompareRow, motion: FrameMotion) -> Vec<String> {
    let mut cells = vec![
        row.technique.clone(),
        row.settings.clone(),
        row.backend.clone(),
    ];
    match &row.outcome {
        RowOutcome::Unsupported { reason } => cells.extend(["-".to_owned(), reason.clone()]),
        RowOutcome::Measured(measured) => cells.extend(figures(measured, motion)),
    }
    cells
}

/// Returns the figures of a row, in the order of [`HEADER`].
fn figures(m: &Measured, motion: FrameMotion) -> [String; 9] {
    let receive = m
        .times
        .and_then(|times| Some(times.milliseconds(&times.receive?)));
    let differing = m.agreement.map(|agreement| agreement.differing);
    [
        or_dash(m.errors.map(|e| e.rmse), 4),
        or_dash(m.errors.map(|e| e.false_shadow), 2),
        or_dash(m.errors.map(|e| e.false_light), 2),
        or_dash(m.errors.map(|e| e.acne), 2),
        format!("{:.2}", milliseconds(m, motion)),
        or_dash(m.preparation.map(|p| p.recipe.median), 2),
        or_dash(receive, 2),
        format!("{:.1}", m.bytes as f64 / f64::from(1 << 20)),
        differing.map_or_else(String::new, |pixels| pixels.to_string()),
    ]
}

/// Formats a figure with this many decimals, or a dash without one.
fn or_dash(figure: Option<f64>, decimals: usize) -> String {
    figure.map_or_else(|| "-".to_owned(), |figure| format!("{figure:.decimals$}"))
}

/// Returns the time of a frame, or its cost if times weren't measured.
fn milliseconds(m: &Measured, motion: FrameMotion) -> f64 {
    let time = m.milliseconds(CostBasis::Wall, motion);
    let cost = m.milliseconds(CostBasis::Cost, motion);
    time.or(cost).unwrap_or(f64::NAN)
}

/// Returns the rows to print: all, or the Pareto front of time and error of each backend.
fn chosen_rows(scene: &SceneResult, whole: bool) -> Vec<&CompareRow> {
    let rows = &scene.rows;
    if whole {
        return rows.iter().collect();
    }
    let mut backends: Vec<&str> = rows.iter().map(|r| r.backend.as_str()).collect();
    backends.sort_unstable();
    backends.dedup();
    let mut out = Vec::new();
    for backend in backends {
        let of_backend = rows
            .iter()
            .filter(|r| r.backend == backend && r.same_as.is_none());
        out.extend(best(of_backend.collect(), scene.motion));
    }
    out
}

/// Returns the rows that no other row beats in both time and error.
fn best(rows: Vec<&CompareRow>, motion: FrameMotion) -> Vec<&CompareRow> {
    let mut points = Vec::with_capacity(rows.len());
    for row in &rows {
        points.push(match row.measured_figures() {
            Some(m) => [milliseconds(m, motion), m.rmse().unwrap_or(f64::NAN)],
            None => [f64::NAN; 2],
        });
    }
    front(&points).into_iter().map(|i| rows[i]).collect()
}
