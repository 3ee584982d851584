//! `bench`: prints speeds as ratios.

use crate::bench::{BenchOptions, Pair, lists, plans, run, soft};
use crate::cli::args::BenchArguments;
use anyhow::{Result, bail};
use comfy_table::{CellAlignment, ContentArrangement, Table, presets::UTF8_FULL_CONDENSED};
use umbrage_wgpu::{AdapterChoice, Gpu};

/// Prints each ratio as it comes, then the table of all.
pub(crate) fn bench(arguments: &BenchArguments) -> Result<()> {
    let mut pairs = Vec::new();
    let tell = |pair: Pair| {
        println!("{}: {:.2} x", pair.work, pair.ratio);
        if let Some(fault) = &pair.fault {
            println!("  FAULT: {fault}");
        }
        pairs.push(pair);
    };
    if arguments.plans {
        check_scenes(&arguments.scenes)?;
        plans(arguments.runs as usize, &arguments.scenes, tell)?;
    } else if arguments.lists {
        check_scenes(&arguments.scenes)?;
        let mut gpu = adapter();
        lists(
            arguments.runs as usize,
            &arguments.scenes,
            gpu.as_mut(),
            tell,
        )?;
    } else if arguments.soft {
        check_scenes(&arguments.scenes)?;
        let mut gpu = adapter();
        soft(
            arguments.runs as usize,
            &arguments.scenes,
            gpu.as_mut(),
            tell,
        )?;
    } else {
        run_suite(arguments, tell)?;
    }
    println!("\n{}", table(&pairs));
    let missed = pairs.iter().filter(|p| !p.met()).count();
    let wrong = pairs.iter().filter(|p| p.fault.is_some()).count();
    match (wrong, missed) {
        (0, 0) => Ok(()),
        (0, _) => bail!("{missed} of {} ratios miss their bar", pairs.len()),
        _ => bail!(
            "{wrong} of {} rows have wrong answers: see FAULT",
            pairs.len()
        ),
    }
}

/// Errors if one of the names is no built-in scene's.
fn check_scenes(names: &[String]) -> Result<()> {
    match names
        .iter()
        .find(|name| umbrage_scenes::find(name).is_none())
    {
        Some(name) => bail!("no built-in scene is called `{name}`; `compare --list` names them"),
        None => Ok(()),
    }
}

/// Returns the graphics adapter, or says why there is none.
fn adapter() -> Option<Gpu> {
    match Gpu::new(&AdapterChoice::from_env()) {
        Ok(gpu) => Some(gpu),
        Err(why) => {
            println!("nothing is timed on a graphics adapter: {why}");
            None
        }
    }
}

fn run_suite(arguments: &BenchArguments, tell: impl FnMut(Pair)) -> Result<()> {
    let mut gpu = adapter();
    let options = BenchOptions {
        runs: arguments.runs as usize,
        ..BenchOptions::default()
    };
    run(options, gpu.as_mut(), tell)?;
    Ok(())
}

fn table(pairs: &[Pair]) -> Table {
    let mut table = Table::new();
    table
        .load_style(UTF8_FULL_CONDENSED)
        .set_content_arrangement(ContentArrangement::Dynamic);
    table.set_header([
        "work",
        "ours",
        "theirs",
        "ours ms",
        "theirs ms",
        "times as fast",
        "bar",
        "runs",
    ]);
    for pair in pairs {
        let [ours, theirs] = pair.who.clone();
        let verdict = if pair.fault.is_some() {
            " FAULT"
        } else if pair.met() {
            ""
        } else {
            " missed"
        };
        let bar = pair
            .bar
            .map_or_else(|| format!("-{verdict}"), |bar| format!("{bar:.2}{verdict}"));
        table.add_row([
            pair.work.clone(),
            ours,
            theirs,
            format!("{:.2}", pair.ours.median),
            format!("{:.2}", pair.theirs.median),
            format!("{:.2}", pair.ratio),
            bar,
            pair.runs.to_string(),
        ]);
    }
    for column in table.column_iter_mut().skip(3) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}
