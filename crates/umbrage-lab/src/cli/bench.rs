//! `bench`: measures speed as ratios to a reference.

use crate::{
    bench::{BenchOptions, Pair, lists, run, soft},
    cli::{args::shared::BackendName, figures_table::figures_table},
};
use anyhow::{Result, bail};
use clap::Args;
use comfy_table::Table;
use umbrage_wgpu::{AdapterChoice, Gpu};

#[derive(Args, Clone, Debug, PartialEq)]
#[command(after_help = "Examples:
  cargo xtask bench                                every ratio, median of 20 paired runs
  cargo xtask bench --runs 100                     the same with less noise
  cargo xtask bench --lists nave                   `exact` against hard maps and rays, one scene
  cargo xtask bench --soft --runs 2 nave-soft      `soft` against rays at equal error
  cargo xtask bench --costs                        prices of work here, for predicted costs
  cargo xtask bench --costs --backend wgpu         graphics adapter only; a minute on a card
  cargo xtask bench --costs --write prices.toml    prices for `compare` and `plan --prices`")]
pub(crate) struct BenchArguments {
    /// Measure the prices of work on this machine, instead of ratios
    #[arg(long)]
    pub(crate) costs: bool,
    /// With --costs: backends whose prices are measured; the others keep the built-in prices
    #[arg(
        long,
        value_name = "NAME",
        default_value = "available",
        requires = "costs"
    )]
    pub(crate) backend: BackendName,
    /// Write the prices to this file, for --prices of `compare` and `plan`
    #[arg(long, value_name = "FILE", requires = "costs")]
    pub(crate) write: Option<std::path::PathBuf>,
    /// Compare `exact` (per-cell triangle lists) with hard maps and rays, instead
    #[arg(long, conflicts_with = "costs", group = "of_scenes")]
    pub(crate) lists: bool,
    /// Compare `soft` with rays that have the same error, instead
    #[arg(long, conflicts_with = "costs", group = "of_scenes")]
    pub(crate) soft: bool,
    /// With --lists or --soft: built-in scenes. Default: all large ones
    #[arg(value_name = "SCENE", requires = "of_scenes")]
    pub(crate) scenes: Vec<String>,
    /// Runs of each side; the ratio is that of their medians
    #[arg(long, value_name = "COUNT", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) runs: u32,
}

/// Prints each ratio when it is measured, then a table of all.
pub(crate) fn bench(arguments: &BenchArguments) -> Result<()> {
    let mut pairs = Vec::new();
    let on_pair = |pair: Pair| {
        println!("{}: {:.2} x", pair.work, pair.ratio);
        if let Some(fault) = &pair.fault {
            println!("  FAULT: {fault}");
        }
        pairs.push(pair);
    };
    if arguments.lists {
        check_scenes(&arguments.scenes)?;
        let mut gpu = adapter();
        lists(
            arguments.runs as usize,
            &arguments.scenes,
            gpu.as_mut(),
            on_pair,
        )?;
    } else if arguments.soft {
        check_scenes(&arguments.scenes)?;
        let mut gpu = adapter();
        soft(
            arguments.runs as usize,
            &arguments.scenes,
            gpu.as_mut(),
            on_pair,
        )?;
    } else {
        run_suite(arguments, on_pair)?;
    }
    println!("\n{}", table(&pairs));
    let missed = pairs.iter().filter(|p| !p.is_met()).count();
    let wrong = pairs.iter().filter(|p| p.fault.is_some()).count();
    match (wrong, missed) {
        (0, 0) => Ok(()),
        (0, _) => bail!("{missed} of {} ratios miss their target", pairs.len()),
        _ => bail!(
            "{wrong} of {} rows have wrong results; they are marked FAULT above",
            pairs.len()
        ),
    }
}

/// Checks that all names are those of built-in scenes.
fn check_scenes(names: &[String]) -> Result<()> {
    match names
        .iter()
        .find(|name| umbrage_scenes::find(name).is_none())
    {
        Some(name) => {
            bail!("there is no built-in scene `{name}`; run `compare --list` for the names")
        }
        None => Ok(()),
    }
}

/// Opens the graphics adapter. Prints why if there is none.
fn adapter() -> Option<Gpu> {
    match Gpu::new(&AdapterChoice::from_env()) {
        Ok(gpu) => Some(gpu),
        Err(why) => {
            println!("no timings on a graphics adapter: {why}");
            None
        }
    }
}

fn run_suite(arguments: &BenchArguments, on_pair: impl FnMut(Pair)) -> Result<()> {
    let mut gpu = adapter();
    let options = BenchOptions {
        runs: arguments.runs as usize,
        ..BenchOptions::default()
    };
    run(options, gpu.as_mut(), on_pair)?;
    Ok(())
}

const HEADER: [&str; 8] = [
    "work",
    "ours",
    "theirs",
    "ours ms",
    "theirs ms",
    "times as fast",
    "bar",
    "runs",
];

fn table(pairs: &[Pair]) -> Table {
    let row = |pair: &Pair| {
        let [ours, theirs] = pair.who.clone();
        let verdict = if pair.fault.is_some() {
            " FAULT"
        } else if pair.is_met() {
            ""
        } else {
            " missed"
        };
        let bar = pair
            .bar
            .map_or_else(|| format!("-{verdict}"), |bar| format!("{bar:.2}{verdict}"));
        [
            pair.work.clone(),
            ours,
            theirs,
            format!("{:.2}", pair.ours.median),
            format!("{:.2}", pair.theirs.median),
            format!("{:.2}", pair.ratio),
            bar,
            pair.runs.to_string(),
        ]
    };
    figures_table(HEADER, pairs.iter().map(row), 3)
}
