//! The command `umbrage-sun`: hours of sun and lit areas of a model's facets.

mod answer;
mod cli;
mod files;
mod picture;
mod sky;

use anyhow::{Context as _, Result};
use clap::Parser as _;
use std::{
    io::{ErrorKind, Write as _},
    process::ExitCode,
};
use umbrage_surfaces::{Facets, Options, Up};

/// Exit code after writing into a closed pipe, as shells report for SIGPIPE.
const CLOSED_PIPE: u8 = 141;

fn main() -> ExitCode {
    match run(&cli::Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) if is_closed_pipe(&error) => ExitCode::from(CLOSED_PIPE),
        Err(error) => {
            // Nothing is left to do if standard error is closed, too.
            let _ = writeln!(std::io::stderr(), "error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn is_closed_pipe(error: &anyhow::Error) -> bool {
    let kind = error.downcast_ref::<std::io::Error>().map(|e| e.kind());
    kind == Some(ErrorKind::BrokenPipe)
}

fn run(arguments: &cli::Arguments) -> Result<()> {
    // Refuse what can't be written before computing it.
    for out in &arguments.out {
        files::Format::of_path(out)?;
    }
    let sky = sky::Sky::of_arguments(arguments)?;
    // Read the model.
    let model = umbrage_scenes::load_triangles(&arguments.model)?;
    for notice in &model.notices {
        writeln!(std::io::stderr(), "{notice}")?;
    }
    // Models of .obj have no axes of their own; glTF prescribes y up.
    let extension = arguments.model.extension();
    let is_obj = extension.is_some_and(|extension| extension.eq_ignore_ascii_case("obj"));
    let own_up = if is_obj { Up::Z } else { Up::Y };
    let options = Options {
        up: arguments.up.unwrap_or(own_up),
        unit_m: arguments.unit,
        sides: arguments.sides,
        ..Options::default()
    };
    let facets = Facets::new(&model.vertices, &model.triangles, &options)?;
    // Compute and write the answer.
    let answer = answer::FacetTable::compute(&facets, &sky, arguments)?;
    for out in &arguments.out {
        files::write(out, &facets, &answer)
            .with_context(|| format!("{} can't be written", out.display()))?;
    }
    let mut out = std::io::stdout().lock();
    for line in answer.report(&facets) {
        writeln!(out, "{line}")?;
    }
    Ok(())
}
