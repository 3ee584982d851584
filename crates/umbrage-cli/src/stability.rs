//! `stability`: plays the rows, prints the matrix and writes the report.

use crate::inputs;
use crate::program::Program;
use crate::{
    args::{Backend, StabilityArguments},
    usage::Usage,
};
use anyhow::{Result, bail};
use comfy_table::{CellAlignment, ContentArrangement, Table, presets::UTF8_FULL_CONDENSED};
use indicatif::{ProgressBar, ProgressStyle};
use std::time::Instant;
use umbrage_lab::{
    compare::Backends,
    stability::{
        CaseResult, Cell, Stability, StabilityEvent, StabilityOptions, check_state, report, rows,
        run,
        sweeps::{self, Sweep},
    },
};

/// Plays, prints and reports; errors if there are faults.
pub(crate) fn stability(program: &Program, arguments: &StabilityArguments) -> Result<()> {
    if arguments.list {
        println!("{}", list());
        return Ok(());
    }
    let options = options_of(program, arguments)?;
    let mut backends = inputs::open(backend(arguments), arguments.adapter.as_ref())?;
    for line in &backends.notices {
        println!("{line}");
    }
    for backend in &backends.playing {
        println!("on {}", backend.name());
    }
    let start = Instant::now();
    let mut stability = play(&options, &mut backends)?;
    println!("{}", matrix(&stability));
    let [pass, degraded, fails] = stability.counts();
    println!(
        "✓ {pass} pass   ~ {degraded} degraded   ✗ {fails} fail   – not served   ! must not be"
    );
    let mut sweeps = Vec::new();
    if arguments.rows.is_empty() && arguments.techniques.is_empty() {
        match run_sweeps(&options, &mut backends) {
            Ok(found) => sweeps = found,
            // The rows' results are kept; the run fails nevertheless.
            Err(e) => stability.faults.push(format!("sweeps: {e:#}")),
        }
    }
    let of_sweeps = sweeps.iter().filter_map(Sweep::fault);
    stability.faults.extend(of_sweeps);
    let mut fresh = inputs::open(backend(arguments), arguments.adapter.as_ref())?;
    let of_state = check_state(&mut backends.playing, &mut fresh.playing)?;
    stability.faults.extend(of_state);
    let folder = program.folder(arguments.out.as_deref(), "stability");
    let page = report::write(&folder, &stability, &sweeps)?;
    println!(
        "report: {} ({:.0} s)",
        page.display(),
        start.elapsed().as_secs_f64()
    );
    verdict(&stability)
}

fn options_of(program: &Program, arguments: &StabilityArguments) -> Result<StabilityOptions> {
    let base = if arguments.quick {
        StabilityOptions::quick()
    } else {
        StabilityOptions::default()
    };
    let out = StabilityOptions {
        registry: program.techniques.clone(),
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

fn play(options: &StabilityOptions, backends: &mut Backends) -> Result<Stability> {
    let style = ProgressStyle::with_template(
        "{bar:30} {pos:>3}/{len}  {elapsed} gone, {eta} to go  {wide_msg}",
    );
    let bar =
        ProgressBar::new(0).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    let stability = run(options, backends, &mut |event| match event {
        StabilityEvent::Case { name, index, of } => {
            bar.set_length(of as u64);
            bar.set_position(index as u64);
            bar.set_message(name.to_owned());
        }
        StabilityEvent::Done { result } if bar.is_hidden() => println!("{}", line(result)),
        StabilityEvent::Done { .. } => {}
    });
    bar.finish_and_clear();
    Ok(stability?)
}

/// Runs all sweeps.
fn run_sweeps(options: &StabilityOptions, backends: &mut Backends) -> Result<Vec<Sweep>> {
    let bar = ProgressBar::new_spinner();
    let sweeps = sweeps::sweeps(options, backends, &mut |name| {
        bar.set_message(format!("sweep: {name}"));
        bar.tick();
    });
    bar.finish_and_clear();
    Ok(sweeps?)
}

/// Returns a case as a line for logs.
fn line(result: &CaseResult) -> String {
    let signs: String = result.cells.iter().map(Cell::sign).collect();
    format!(
        "{:>2} {:<26} {signs}  {}",
        result.row, result.case, result.measure
    )
}

/// Returns the matrix: a line for each case, a column for each technique, in each cell a sign and a figure for each of its
/// settings.
fn matrix(stability: &Stability) -> Table {
    let techniques = stability.techniques();
    let mut table = Table::new();
    table
        .load_style(UTF8_FULL_CONDENSED)
        .set_content_arrangement(ContentArrangement::Disabled);
    let mut head = vec!["#", "case", "measure", "pass", "fail"];
    head.extend(&techniques);
    table.set_header(head);
    for result in &stability.cases {
        let measure = if result.unit.is_empty() {
            result.measure.clone()
        } else {
            format!("{}, {}", result.measure, result.unit)
        };
        let mut line = vec![
            result.row.to_string(),
            result.case.clone(),
            measure,
            number(result.limits.pass),
            number(result.limits.fails),
        ];
        for technique in &techniques {
            line.push(signs_and_figures(result, technique));
        }
        table.add_row(line);
    }
    for column in table.column_iter_mut().skip(3).take(2) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

/// Returns a line for each setting of a technique.
fn signs_and_figures(result: &CaseResult, technique: &str) -> String {
    let mut lines = Vec::new();
    for cell in result.cells.iter().filter(|c| c.technique == technique) {
        let sign = cell.sign();
        lines.push(match cell.figure() {
            Some(figure) => format!("{sign} {}", number(figure)),
            None => sign.to_string(),
        });
    }
    lines.join("\n")
}

/// Formats a number with three significant digits, fewer below .1.
fn number(v: f64) -> String {
    match v.abs() {
        0.0 => "0".to_owned(),
        a if a < 0.001 => format!("{v:.0e}"),
        a if a < 1.0 => format!("{v:.3}"),
        a if a < 10.0 => format!("{v:.2}"),
        a if a < 100.0 => format!("{v:.1}"),
        _ => format!("{v:.0}"),
    }
}

/// Returns the table of all rows, their cases and measures.
fn list() -> Table {
    let mut table = Table::new();
    table.load_style(comfy_table::presets::NOTHING).set_header([
        "row",
        "what fails",
        "case",
        "motion",
        "measure",
        "limits",
    ]);
    for row in rows() {
        for case in row.cases {
            let measure = case.measure;
            table.add_row([
                format!("{} {}", row.number, row.title),
                row.weakness.to_owned(),
                case.name.to_owned(),
                case.motion.label().to_owned(),
                measure.name().to_owned(),
                measure.reason().to_owned(),
            ]);
        }
    }
    table.set_content_arrangement(ContentArrangement::Dynamic);
    table
}

fn verdict(stability: &Stability) -> Result<()> {
    if stability.faults.is_empty() {
        return Ok(());
    }
    bail!(
        "{} results must not be:\n  {}",
        stability.faults.len(),
        stability.faults.join("\n  ")
    )
}

/// Returns the backends to play on. A quick run plays on the CPU alone unless others are named, as software drivers are slow.
fn backend(arguments: &StabilityArguments) -> Backend {
    let otherwise = if arguments.quick {
        Backend::Cpu
    } else {
        Backend::Available
    };
    arguments.backend.unwrap_or(otherwise)
}
