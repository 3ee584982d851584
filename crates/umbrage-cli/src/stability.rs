//! `stability`: rows in, a matrix and a report out. All the work is the lab's.

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

/// Plays, prints, reports; fails if anything came out that must not be.
pub(crate) fn stability(program: &Program, arguments: &StabilityArguments) -> Result<()> {
    if arguments.list {
        println!("{}", list());
        return Ok(());
    }
    let options = options_of(program, arguments)?;
    let open = || inputs::open(backend(arguments), arguments.adapter.as_ref());
    let mut backends = open()?;
    backends.notices.iter().for_each(|line| println!("{line}"));
    backends
        .playing
        .iter()
        .for_each(|b| println!("on {}", b.name()));
    let start = Instant::now();
    let mut stability = play(&options, &mut backends)?;
    println!("{}", matrix(&stability));
    let [pass, degraded, fails] = stability.counts();
    println!(
        "✓ {pass} pass   ~ {degraded} degraded   ✗ {fails} fail   – not served   ! must not be"
    );
    let sweeps = if arguments.rows.is_empty() && arguments.techniques.is_empty() {
        turn(&options, &mut backends).unwrap_or_else(|e| {
            // What the rows found is kept; the run fails all the same.
            stability.faults.push(format!("sweeps: {e:#}"));
            Vec::new()
        })
    } else {
        Vec::new()
    };
    stability
        .faults
        .extend(sweeps.iter().filter_map(Sweep::fault));
    stability
        .faults
        .extend(check_state(&mut backends.playing, &mut open()?.playing)?);
    let page = report::write(
        &program.folder(arguments.out.as_deref(), "stability"),
        &stability,
        &sweeps,
    )?;
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

/// All sweeps.
fn turn(options: &StabilityOptions, backends: &mut Backends) -> Result<Vec<Sweep>> {
    let bar = ProgressBar::new_spinner();
    let sweeps = sweeps::sweeps(options, backends, &mut |name| {
        bar.set_message(format!("sweep: {name}"));
        bar.tick();
    });
    bar.finish_and_clear();
    Ok(sweeps?)
}

/// One case in a line, for logs.
fn line(result: &CaseResult) -> String {
    let signs: String = result.cells.iter().map(Cell::sign).collect();
    format!(
        "{:>2} {:<26} {signs}  {}",
        result.row, result.case, result.measure
    )
}

/// The matrix: a line a case, a column a technique, in each cell a sign and a figure for each of its settings.
fn matrix(stability: &Stability) -> Table {
    let techniques = stability.techniques();
    let mut table = Table::new();
    table
        .load_style(UTF8_FULL_CONDENSED)
        .set_content_arrangement(ContentArrangement::Disabled);
    let head = ["#", "case", "measure", "pass", "fail"]
        .map(str::to_owned)
        .into_iter();
    table.set_header(head.chain(techniques.iter().map(|t| (*t).to_owned())));
    for result in &stability.cases {
        let unit = if result.unit.is_empty() {
            String::new()
        } else {
            format!(", {}", result.unit)
        };
        let words = [
            result.row.to_string(),
            result.case.clone(),
            format!("{}{unit}", result.measure),
        ];
        let limits = [result.limits.pass, result.limits.fails].map(number);
        let cells = techniques.iter().map(|technique| {
            let its = result.cells.iter().filter(|c| c.technique == *technique);
            its.map(|c| {
                c.figure().map_or(c.sign().to_string(), |f| {
                    format!("{} {}", c.sign(), number(f))
                })
            })
            .collect::<Vec<_>>()
            .join("\n")
        });
        table.add_row(words.into_iter().chain(limits).chain(cells));
    }
    table
        .column_iter_mut()
        .skip(3)
        .take(2)
        .for_each(|c| c.set_cell_alignment(CellAlignment::Right));
    table
}

/// Three digits that count.
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

/// The rows, their cases and what they are judged by.
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

/// A software driver is too slow for a first look.
fn backend(arguments: &StabilityArguments) -> Backend {
    let otherwise = if arguments.quick {
        Backend::Cpu
    } else {
        Backend::Available
    };
    arguments.backend.unwrap_or(otherwise)
}
