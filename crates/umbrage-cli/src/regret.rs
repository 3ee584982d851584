//! `plan --regret`: plans against exhaustive sweeps.

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

/// One row a scene, light and bound; fails if too many bounds are broken, or a choice costs too much.
pub(crate) fn regret(program: &Program, arguments: &PlanArguments) -> Result<()> {
    let scenes = scenes(program, &arguments.scenes)?;
    let progress = Progress::new();
    let mut all = Vec::new();
    for (i, scene) in scenes.iter().enumerate() {
        progress.prefix(format!("{} ({} of {}): ", scene.name, i + 1, scenes.len()));
        // The library says what a scene without lights lacks.
        for light in 0..scene.lights.len().max(1) {
            let options = PlanOptions {
                light,
                ..options_of(program, arguments)
            };
            let found = measure(scene, &arguments.errors, &options, &|step| {
                progress.note(step)
            });
            let found = found.inspect_err(|_| progress.finish())?;
            found.iter().for_each(|r| progress.say(&line(r)));
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

fn cells(r: &Regret) -> Vec<String> {
    let dash = || "-".to_owned();
    let verdict = match (r.keeps(), r.misses()) {
        (false, _) => "bound broken",
        (true, true) => "dear",
        _ => "",
    };
    vec![
        r.scene.clone(),
        format!("{}: {}", r.light_number, r.light),
        format!("{}", r.bound),
        r.chosen
            .as_ref()
            .map_or_else(|| "nothing".to_owned(), |c| c.label()),
        r.chosen.as_ref().map_or_else(dash, |c| {
            format!("{:.4} ({:.4})", c.estimate.error, c.estimate.high)
        }),
        r.chosen
            .as_ref()
            .map_or_else(dash, |_| format!("{:.4}", r.error)),
        r.chosen
            .as_ref()
            .map_or_else(dash, |c| format!("{:.3}", c.milliseconds)),
        r.cheapest.clone().unwrap_or_else(|| "nothing".to_owned()),
        r.ratio().map_or_else(dash, |ratio| format!("{ratio:.2}")),
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
    [2, 4, 5, 6, 8, 9].iter().for_each(|&i| {
        if let Some(column) = table.column_mut(i) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    });
    table
}

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
    let at = |share: f64| ratios.nearest(share).unwrap_or(1.0);
    let summary = format!(
        "{kept} of {} plans keep their bound on the whole image ({:.1} %); cost over the least: median {:.2}, \
         9 in 10 within {:.2}, greatest {:.2}; {dear} cost more than {MAX_REGRET} times the least",
        all.len(),
        100.0 * kept as f64 / count,
        at(0.5),
        at(0.9),
        at(1.0)
    );
    println!("{summary}");
    if (kept as f64) < MIN_KEPT * count || dear > 0 {
        bail!(
            "plans miss their targets: {:.0} % kept, at most {MAX_REGRET} times the least cost",
            100.0 * MIN_KEPT
        );
    }
    Ok(())
}
