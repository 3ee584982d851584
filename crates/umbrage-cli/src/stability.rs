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
        Base, BiasWindow, CaseResult, Cell, CriterionResult, Stability, StabilityEvent,
        StabilityOptions, Verdict, check_state, report, rows, run,
        sweeps::{self, Sweep},
        windows,
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
    if let Some(sanity) = stability.sanity_line() {
        println!("{sanity}");
    }
    println!("{}", legend(&stability));
    println!(
        "a figure in brackets is the second measure's: what a cure for the failure takes away"
    );
    if arguments.rows.is_empty() {
        match run_windows(&options, &mut backends) {
            Ok(found) => stability.windows = found,
            // The rows' results are kept; the run fails nevertheless.
            Err(e) => stability.faults.push(format!("bias windows: {e:#}")),
        }
    }
    let of_windows = stability.windows.iter().filter_map(BiasWindow::fault);
    stability.faults.extend(of_windows.collect::<Vec<_>>());
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
    if !stability.windows.is_empty() {
        println!("{}", windows_table(&stability.windows));
    }
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

/// Finds the windows of bias.
fn run_windows(options: &StabilityOptions, backends: &mut Backends) -> Result<Vec<BiasWindow>> {
    let bar = ProgressBar::new_spinner();
    let windows = windows(options, backends, &mut |technique| {
        bar.set_message(format!("bias window: {technique}"));
        bar.tick();
    });
    bar.finish_and_clear();
    Ok(windows?)
}

/// Returns a line for each technique: the normal offsets at which it has neither acne nor a gap.
fn windows_table(windows: &[BiasWindow]) -> Table {
    let mut table = Table::new();
    table
        .load_style(UTF8_FULL_CONDENSED)
        .set_content_arrangement(ContentArrangement::Disabled)
        .set_header([
            "technique",
            "normal offsets that pass acne and gap, beside its default bias",
            "width, texels",
            "alone",
            "width, texels",
        ]);
    for own in windows.iter().filter(|window| window.base == Base::Own) {
        let bare = windows
            .iter()
            .find(|window| window.base == Base::Bare && window.technique == own.technique);
        let tuning = if own.needs_no_tuning() {
            ": no tuning"
        } else {
            ""
        };
        table.add_row([
            own.technique.clone(),
            format!("{}{tuning}", own.words()),
            number(own.width()),
            bare.map_or_else(String::new, BiasWindow::words),
            bare.map_or_else(String::new, |window| number(window.width())),
        ]);
    }
    table
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

/// Returns how many cells have each verdict, beside its sign.
fn legend(stability: &Stability) -> String {
    let verdicts = [
        (Verdict::Pass, "pass"),
        (Verdict::Degraded, "degraded"),
        (Verdict::Fails, "fail"),
        (Verdict::NotMeasured, "not measured (could not fail)"),
    ];
    let mut parts = Vec::new();
    for (verdict, what) in verdicts {
        let count = stability.count(verdict);
        parts.push(format!("{} {count} {what}", verdict.sign()));
    }
    let counts = parts.join("   ");
    format!("{counts}   – not served   ! must not be")
}

/// Returns a case as a line for logs.
fn line(result: &CaseResult) -> String {
    let signs: String = result.cells.iter().map(Cell::sign).collect();
    format!(
        "{:>2} {:<26} {signs}  {}",
        result.row,
        result.case,
        measures(result, |c| c.measure.clone()).join(", ")
    )
}

/// Returns what `text` says of each of a case's criteria; that of all but the first in brackets.
fn measures(result: &CaseResult, text: impl Fn(&CriterionResult) -> String) -> Vec<String> {
    let mut out = Vec::new();
    for (k, criterion) in result.criteria.iter().enumerate() {
        out.push(bracketed(k, text(criterion)));
    }
    out
}

/// Returns the text as it is for a case's first criterion, and in brackets for the others.
fn bracketed(criterion: usize, text: String) -> String {
    if criterion == 0 {
        text
    } else {
        format!("({text})")
    }
}

/// Returns a measure's name and unit.
fn with_unit(criterion: &CriterionResult) -> String {
    if criterion.unit.is_empty() {
        criterion.measure.clone()
    } else {
        format!("{}, {}", criterion.measure, criterion.unit)
    }
}

/// Returns the matrix: a line for each case that tells techniques apart, a column for each technique, in each cell a sign and
/// the figure that decides for each of its settings.
fn matrix(stability: &Stability) -> Table {
    let techniques = stability.techniques();
    let mut table = Table::new();
    table
        .load_style(UTF8_FULL_CONDENSED)
        .set_content_arrangement(ContentArrangement::Disabled);
    let mut head = vec!["#", "case", "measure", "pass", "fail"];
    head.extend(&techniques);
    table.set_header(head);
    for result in stability.telling() {
        let mut line = vec![
            result.row.to_string(),
            result.case.clone(),
            measures(result, with_unit).join("\n"),
            measures(result, |c| number(c.limits.pass)).join("\n"),
            measures(result, |c| number(c.limits.fails)).join("\n"),
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
        lines.push(match decisive_figure(cell) {
            Some(figure) => format!("{sign} {figure}"),
            None => sign.to_string(),
        });
    }
    lines.join("\n")
}

/// Returns the figure that decides a cell's verdict; none if there is none.
fn decisive_figure(cell: &Cell) -> Option<String> {
    let criterion = cell.decisive()?;
    let figure = cell.judgements()[criterion].figure?;
    Some(bracketed(criterion, number(figure)))
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
            let criteria = [Some(case.measure), case.measure.opposite()];
            let names: Vec<&str> = criteria.iter().flatten().map(|m| m.name()).collect();
            let reasons: Vec<&str> = criteria.iter().flatten().map(|m| m.reason()).collect();
            table.add_row([
                format!("{} {}", row.number, row.title),
                row.weakness.to_owned(),
                case.name.to_owned(),
                case.motion.label().to_owned(),
                names.join("; "),
                reasons.join("; "),
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
