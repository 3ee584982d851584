//! `bench`: prints speeds as ratios.

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
  cargo xtask bench               every ratio, medians of 20 runs taken in turn
  cargo xtask bench --runs 100    the same, steadier
  cargo xtask bench --lists nave  lists of casters against hard maps and rays, in one scene
  cargo xtask bench --soft --runs 2 nave-soft    points of a wide light against rays with the same error
  cargo xtask bench --costs       what a texel, a tap, a ray costs here: prices for deterministic costs
  cargo xtask bench --costs --backend wgpu         those of the graphics adapter alone, within a minute on a card
  cargo xtask bench --costs --write prices.toml    the same, kept for `compare --prices` and `plan --prices`")]
pub(crate) struct BenchArguments {
    /// Measure the prices of work on this machine instead
    #[arg(long)]
    pub(crate) costs: bool,
    /// With --costs: whose prices are measured; the others stay the built-in ones
    #[arg(
        long,
        value_name = "NAME",
        default_value = "available",
        requires = "costs"
    )]
    pub(crate) backend: BackendName,
    /// Write the prices to this file, for `--prices` of `compare` and `plan`
    #[arg(long, value_name = "FILE", requires = "costs")]
    pub(crate) write: Option<std::path::PathBuf>,
    /// Time the lists of `exact` against hard maps and rays instead
    #[arg(long, conflicts_with = "costs", group = "of_scenes")]
    pub(crate) lists: bool,
    /// Time `soft` against rays with the same error instead
    #[arg(long, conflicts_with = "costs", group = "of_scenes")]
    pub(crate) soft: bool,
    /// With `--lists` or `--soft`: the built-in scenes; all large ones if none is named
    #[arg(value_name = "SCENE", requires = "of_scenes")]
    pub(crate) scenes: Vec<String>,
    /// Runs of each side; their medians are compared
    #[arg(long, value_name = "COUNT", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) runs: u32,
}

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
    if arguments.lists {
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
        } else if pair.met() {
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
