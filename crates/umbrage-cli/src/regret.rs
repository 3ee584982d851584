//! `plan --regret`: compares plans with exhaustive sweeps.

use crate::args::PlanArguments;
use crate::program::Program;
use crate::{inputs::scene, plan::options_of, planning::Progress};
use anyhow::{Result, bail};
use comfy_table::{CellAlignment, ContentArrangement, Table, presets::UTF8_FULL_CONDENSED};
use umbrage_core::Scene;
use umbrage_lab::plan_files::write_regret;
use umbrage_plan::{
    MAX_REGRET, MIN_KEPT, PlanOptions, Regret, regret as measure, statistics::Sorted,
};

/// Prints a row for each scene, light and bound; errors if too many bounds are broken, or a choice costs too much.
pub(crate) fn regret(program: &Program, arguments: &PlanArguments) -> Result<()> {
    let scenes = scenes(program, &arguments.scenes)?;
    let progress = Progress::new();
    let mut all = Vec::new();
    for (i, scene) in scenes.iter().enumerate() {
        progress.prefix(format!("{} ({} of {}): ", scene.name, i + 1, scenes.len()));
        // Once also without lights: then the library returns the error that says so.
        for light in 0..scene.lights.len().max(1) {
            let options = PlanOptions {
                light,
                ..options_of(program, arguments)?
            };
            let found = measure(scene, &arguments.errors, &options, &|step| {
                progress.note(step)
            });
            let found = found.inspect_err(|_| progress.finish())?;
            for regret in &found {
                progress.say(&line(regret));
            }
            all.extend(found);
        }
    }
    progress.finish();
    println!("{}", table(&all));
    let path = write_regret(&all, &program.folder(arguments.out.as_deref(), "plan"))?;
    println!("\ntable: {}", path.display());
    verdict(&all)
}

fn scenes(program: &Program, names: &[String]) -> Result<Vec<Scene>> {
    if names.is_empty() {
        return Ok(umbrage_scenes::all()
            .iter()
            .filter(|e| e.suite)
            .map(|e| (e.build)())
            .collect());
    }
    names.iter().map(|name| scene(program, name)).collect()
}

/// Returns the cells of a row, in the order of [`HEADER`].
fn cells(r: &Regret) -> Vec<String> {
    let verdict = if !r.keeps() {
        "bound broken"
    } else if r.misses() {
        "dear"
    } else {
        ""
    };
    let mut planned = "nothing".to_owned();
    let mut predicted = "-".to_owned();
    let mut error = "-".to_owned();
    let mut cost = "-".to_owned();
    if let Some(chosen) = &r.chosen {
        let estimate = chosen.estimate;
        planned = chosen.label();
        predicted = format!("{:.4} ({:.4})", estimate.error, estimate.high);
        error = format!("{:.4}", r.error);
        cost = format!("{:.3}", chosen.milliseconds);
    }
    let cheapest = r.cheapest.clone();
    let ratio = r.ratio().map(|ratio| format!("{ratio:.2}"));
    vec![
        r.scene.clone(),
        format!("{}: {}", r.light_number, r.light),
        r.bound.to_string(),
        planned,
        predicted,
        error,
        cost,
        cheapest.unwrap_or_else(|| "nothing".to_owned()),
        ratio.unwrap_or_else(|| "-".to_owned()),
        format!("{:.1}", r.seconds),
        verdict.to_owned(),
    ]
}

const HEADER: [&str; 11] = [
    "scene",
    "light",
    "bound",
    "planned",
    "predicted (most)",
    "error",
    "ms",
    "cheapest by sweep",
    "times the least",
    "seconds",
    "",
];

/// The columns of [`HEADER`] that hold numbers.
const NUMBERS: [usize; 6] = [2, 4, 5, 6, 8, 9];

/// Returns a row as a line for logs.
fn line(r: &Regret) -> String {
    cells(r).join(" | ")
}

fn table(all: &[Regret]) -> Table {
    let mut table = Table::new();
    table
        .load_style(UTF8_FULL_CONDENSED)
        .set_content_arrangement(ContentArrangement::Dynamic)
        .set_header(HEADER);
    for r in all {
        table.add_row(cells(r));
    }
    for i in NUMBERS {
        if let Some(column) = table.column_mut(i) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    table
}

/// Prints a summary; errors if plans miss their targets.
fn verdict(all: &[Regret]) -> Result<()> {
    let count = all.len().max(1) as f64;
    let kept = all.iter().filter(|r| r.keeps()).count();
    let ratios: Vec<f64> = all
        .iter()
        .filter(|r| r.keeps())
        .filter_map(Regret::ratio)
        .collect();
    let dear = ratios.iter().filter(|r| **r > MAX_REGRET).count();
    let ratios = Sorted::new(ratios);
    let median = ratios.nearest(0.5).unwrap_or(1.0);
    let nine_in_ten = ratios.nearest(0.9).unwrap_or(1.0);
    let greatest = ratios.nearest(1.0).unwrap_or(1.0);
    let percent = 100.0 * kept as f64 / count;
    println!(
        "{kept} of {} plans keep their bound on the whole image ({percent:.1} %); cost over the least: median {median:.2}, \
         9 in 10 within {nine_in_ten:.2}, greatest {greatest:.2}; {dear} cost more than {MAX_REGRET} times the least",
        all.len()
    );
    if (kept as f64) < MIN_KEPT * count || dear > 0 {
        bail!(
            "plans miss their targets: {:.0} % kept, at most {MAX_REGRET} times the least cost",
            100.0 * MIN_KEPT
        );
    }
    Ok(())
}
