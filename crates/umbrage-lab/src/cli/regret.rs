//! `plan --regret`: compares plans with exhaustive sweeps.

use crate::cli::plan::PlanArguments;
use crate::cli::program::Program;
use crate::cli::{
    inputs::scene,
    plan::{clock_of, options_of},
    planning::PlanProgress,
};
use crate::plan_files::write_regret;
use anyhow::{Result, bail};
use comfy_table::{CellAlignment, ContentArrangement, Table, presets::UTF8_FULL_CONDENSED};
use umbrage_core::{Backend, Scene};
use umbrage_plan::{
    ClockRegret, MAX_REGRET, MIN_KEPT, PlanOptions, Regret, regret as measure, statistics::Sorted,
    truth::TruthOptions,
};

/// Size limit of thorough sweeps, pixels. In larger images under lights with an extent, one pixel
/// of each block is judged, and candidates have their best bias only. A full sweep would take
/// hours.
const MAX_THOROUGH: u32 = 320 * 240;
/// Side of these blocks, pixels.
const BLOCK_SIDE: u32 = 4;

/// Prints a row for each scene, light and bound. Errors if too many bounds are broken, or a choice
/// costs too much.
pub(crate) fn regret(program: &Program, arguments: &PlanArguments) -> Result<()> {
    let scenes = scenes(program, &arguments.scenes)?;
    let mut clock = clock_of(arguments)?;
    let progress = PlanProgress::new();
    let mut all = Vec::new();
    for (i, scene) in scenes.iter().enumerate() {
        progress.prefix(format!("{} ({} of {}): ", scene.name, i + 1, scenes.len()));
        // Run once for a scene without lights, too: the library then returns the error.
        for light in 0..scene.lights.len().max(1) {
            let of_all = options_of(program, arguments)?;
            let own = scene.cameras.first().map(|camera| camera.size);
            let size = of_all.size.or(own).unwrap_or_default();
            let options = PlanOptions {
                light,
                truth: TruthOptions {
                    block_side: if size.element_product() > MAX_THOROUGH {
                        BLOCK_SIDE
                    } else {
                        1
                    },
                    ..of_all.truth
                },
                ..of_all
            };
            let backend: Option<&mut dyn Backend> = match &mut clock {
                Some(clock) => Some(&mut *clock.backends[0]),
                None => None,
            };
            let found = measure(scene, &arguments.errors, &options, backend, &|step| {
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
        "expensive"
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
        clock_words(r.clock.as_ref()),
        format!("{:.1}", r.seconds),
        verdict.to_owned(),
    ]
}

/// Returns the measured times of a plan in words.
fn clock_words(clock: Option<&ClockRegret>) -> String {
    let Some(clock) = clock else {
        return "-".to_owned();
    };
    format!(
        "{:.2}: {:.1} ms; fastest of {}: {} with {:.1} ms",
        clock.ratio(),
        clock.chosen_ms,
        clock.candidates,
        clock.quickest,
        clock.least_ms
    )
}

const HEADER: [&str; 12] = [
    "scene",
    "light",
    "bound",
    "planned",
    "predicted (upper bound)",
    "error",
    "ms",
    "cheapest by sweep",
    "cost ratio",
    "measured ratio",
    "seconds",
    "",
];

/// Columns of [`HEADER`] with numbers.
const NUMBERS: [usize; 6] = [2, 4, 5, 6, 8, 10];

/// Returns a row as a log line.
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

/// Prints a summary. Errors if plans miss their targets.
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
        "{kept} of {} plans keep their bound on the whole image ({percent:.1} %); cost relative to the cheapest: median {median:.2}, \
         90 % within {nine_in_ten:.2}, maximum {greatest:.2}; {dear} cost more than {MAX_REGRET} times the cheapest",
        all.len()
    );
    let by_clock: Vec<f64> = all
        .iter()
        .filter(|r| r.keeps())
        .filter_map(|r| r.clock.as_ref().map(ClockRegret::ratio))
        .collect();
    let mut misses = (kept as f64) < MIN_KEPT * count;
    if by_clock.is_empty() {
        misses |= dear > 0;
    } else {
        let within = by_clock
            .iter()
            .filter(|ratio| **ratio <= MAX_REGRET)
            .count();
        let timed = by_clock.len();
        let ratios = Sorted::new(by_clock);
        println!(
            "measured: {within} of {timed} within {MAX_REGRET} times the fastest ({:.1} %); median {:.2}, maximum {:.2}",
            100.0 * within as f64 / timed as f64,
            ratios.nearest(0.5).unwrap_or(1.0),
            ratios.nearest(1.0).unwrap_or(1.0)
        );
        misses |= (within as f64) < MIN_KEPT * timed as f64;
    }
    if misses {
        bail!(
            "plans miss their targets: {:.0} % must keep their bound, at no more than {MAX_REGRET} times the least cost or measured time",
            100.0 * MIN_KEPT
        );
    }
    Ok(())
}
