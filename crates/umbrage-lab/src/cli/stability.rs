//! `stability`: runs the failure tests, prints the matrix and writes the report.

use crate::{
    cli::{
        args::shared::BackendName, inputs, program::Program, stability_summary,
        stability_tables as tables, usage::Usage,
    },
    compare::Backends,
    stability::{
        BiasWindow, CaseResult, Cell, Stability, StabilityEvent, StabilityOptions, check_state,
        report::{self, StabilityResults},
        run,
        sweeps::{self, Sweep},
        windows,
    },
};
use anyhow::{Result, bail};
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use std::{path::PathBuf, time::Instant};

#[derive(Args, Clone, Debug, PartialEq)]
#[command(after_help = "Examples:
  cargo xtask stability                              all rows, sweeps and bias windows
  cargo xtask stability --list                       list the rows and their criteria
  cargo xtask stability 3 12 --technique hard,pcf    two rows, two techniques
  cargo xtask stability --technique pcf              one technique in all rows, and its bias window
  cargo xtask stability thin-plate --backend cpu     one case, CPU only
  cargo xtask stability --quick --out look           small images and maps, in your own folder")]
pub(crate) struct StabilityArguments {
    /// Rows (numbers) or cases (names) to run
    ///
    /// Default: all rows and the bias window of each technique; without --technique also all
    /// sweeps.
    #[arg(value_name = "ROW")]
    pub(crate) rows: Vec<String>,
    /// Techniques to test; repeat the option, or separate names by commas. Default: all
    #[arg(long = "technique", value_name = "NAME", value_delimiter = ',')]
    pub(crate) techniques: Vec<String>,
    /// Backends to run. Default: the available ones; with --quick the CPU
    ///
    /// Figures are those of the first backend, with which the others must agree. The others run the
    /// first and last frame of moving rows, and the ends and middle of sweeps.
    #[arg(long, value_name = "NAME")]
    pub(crate) backend: Option<BackendName>,
    /// Graphics adapter, by part of its name, such as llvmpipe
    #[arg(long, value_name = "NAME")]
    pub(crate) adapter: Option<String>,
    /// Preview: small images and maps, few frames and samples
    #[arg(long)]
    pub(crate) quick: bool,
    /// Folder for the report. Default: target/stability in the repository
    #[arg(long, value_name = "FOLDER")]
    pub(crate) out: Option<PathBuf>,
    /// List the rows with their scenes, measures and limits, and exit
    #[arg(long)]
    pub(crate) list: bool,
}

/// Runs the rows, prints the matrix and writes the report. Errors if there are faults.
pub(crate) fn stability(program: &Program, arguments: &StabilityArguments) -> Result<()> {
    if arguments.list {
        println!("{}", tables::list());
        return Ok(());
    }
    let options = options_of(program, arguments)?;
    let mut backends = inputs::open(backend(arguments), arguments.adapter.as_ref())?;
    for line in &backends.notices {
        println!("{line}");
    }
    for backend in &backends.backends {
        println!("on {}", backend.name());
    }
    let start = Instant::now();
    let mut stability = run_rows(&options, &mut backends)?;
    if !arguments.rows.is_empty() {
        println!("{}", tables::matrix(&stability));
        println!("{}", tables::legend(&stability));
        println!(
            "figures in brackets belong to the second measure: the side effect of fixing the failure"
        );
    }
    if arguments.rows.is_empty() {
        match run_windows(&options, &mut backends) {
            Ok(found) => stability.windows = found,
            // Keep the results of the rows. The run fails nevertheless.
            Err(e) => stability.faults.push(format!("bias windows: {e:#}")),
        }
    }
    // Print windows of named techniques only: the page has all of them.
    if !arguments.techniques.is_empty() && !stability.windows.is_empty() {
        println!("{}", tables::windows_table(&stability.windows));
    }
    let of_windows = stability.windows.iter().filter_map(BiasWindow::fault);
    stability.faults.extend(of_windows.collect::<Vec<_>>());
    let mut sweeps = Vec::new();
    if arguments.rows.is_empty() && arguments.techniques.is_empty() {
        match run_sweeps(&options, &mut backends) {
            Ok(found) => sweeps = found,
            // Keep the results of the rows. The run fails nevertheless.
            Err(e) => stability.faults.push(format!("sweeps: {e:#}")),
        }
    }
    let of_sweeps = sweeps.iter().filter_map(Sweep::fault);
    stability.faults.extend(of_sweeps);
    let mut fresh = inputs::open(backend(arguments), arguments.adapter.as_ref())?;
    let of_state = check_state(&mut backends.backends, &mut fresh.backends)?;
    stability.faults.extend(of_state);
    let folder = program.folder(arguments.out.as_deref(), "stability");
    let results = StabilityResults::new(stability, sweeps, &backends);
    let page = report::write(&folder, &results)?;
    println!();
    for line in stability_summary::lines(&results.stability) {
        println!("{line}");
    }
    let seconds = start.elapsed().as_secs_f64();
    println!("report: {} ({seconds:.0} s)", page.display());
    verdict(&results.stability)
}

fn options_of(program: &Program, arguments: &StabilityArguments) -> Result<StabilityOptions> {
    let base = if arguments.quick {
        StabilityOptions::quick()
    } else {
        StabilityOptions::default()
    };
    let out = StabilityOptions {
        catalogue: program.catalogue.clone(),
        rows: arguments.rows.clone(),
        techniques: arguments.techniques.clone(),
        ..base
    };
    out.validate().map_err(|e| {
        Usage(format!(
            "{e} (see `{} stability --list`)",
            program.invocation
        ))
    })?;
    Ok(out)
}

fn run_rows(options: &StabilityOptions, backends: &mut Backends) -> Result<Stability> {
    let style = ProgressStyle::with_template(
        "{bar:30} {pos:>3}/{len}  {elapsed} elapsed, {eta} left  {wide_msg}",
    );
    let bar =
        ProgressBar::new(0).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    let mut done = 0;
    let stability = run(options, backends, &mut |event| match event {
        StabilityEvent::Case { name, index, of } => {
            bar.set_length(of as u64);
            bar.set_position(index as u64);
            bar.set_message(name.to_owned());
        }
        StabilityEvent::Done { result } if bar.is_hidden() => {
            done += 1;
            println!("{}", log_line(done, bar.length(), &line(result)));
        }
        StabilityEvent::Done { .. } => {}
    });
    bar.finish_and_clear();
    Ok(stability?)
}

/// Returns a line of the log: the number of finished cases and the last of them.
fn log_line(done: u64, of: Option<u64>, case: &str) -> String {
    format!("{done:>3} of {}: {case}", of.unwrap_or(done))
}

/// Shows the current step next to the bar, or as a line without a terminal.
fn show(bar: &ProgressBar, message: String) {
    if bar.is_hidden() {
        println!("{message}");
    }
    bar.set_message(message);
    bar.tick();
}

/// Measures the bias windows.
fn run_windows(options: &StabilityOptions, backends: &mut Backends) -> Result<Vec<BiasWindow>> {
    let bar = ProgressBar::new_spinner();
    let windows = windows(options, backends, &mut |technique| {
        show(&bar, format!("bias window: {technique}"));
    });
    bar.finish_and_clear();
    Ok(windows?)
}

/// Runs all sweeps.
fn run_sweeps(options: &StabilityOptions, backends: &mut Backends) -> Result<Vec<Sweep>> {
    let bar = ProgressBar::new_spinner();
    let sweeps = sweeps::sweeps(options, backends, &mut |name| {
        show(&bar, format!("sweep: {name}"));
    });
    bar.finish_and_clear();
    Ok(sweeps?)
}

/// Returns a case as a log line.
fn line(result: &CaseResult) -> String {
    let signs: String = result.cells.iter().map(Cell::sign).collect();
    format!(
        "{:>2} {:<26} {signs}  {}",
        result.row,
        result.case,
        tables::measures(result, |c| c.measure.clone()).join(", ")
    )
}

fn verdict(stability: &Stability) -> Result<()> {
    if stability.faults.is_empty() {
        return Ok(());
    }
    bail!(
        "{} results are invalid:\n  {}",
        stability.faults.len(),
        stability.faults.join("\n  ")
    )
}

/// Returns the backends to run. The default of quick runs is the CPU only, as software drivers are
/// slow.
fn backend(arguments: &StabilityArguments) -> BackendName {
    let otherwise = if arguments.quick {
        BackendName::Cpu
    } else {
        BackendName::Available
    };
    arguments.backend.unwrap_or(otherwise)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_of_the_log_says_how_far_it_is() {
        assert_eq!(log_line(3, Some(69), "1 low-sun"), "  3 of 69: 1 low-sun");
    }
}
