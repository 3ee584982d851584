//! `compare`, `stability` and `plan` with a technique of the program's own beside the built-in ones:
//! `cargo run --release --example measure_variance -- compare cubes --technique variance,pcf --quick`.

use std::process::ExitCode;
use umbrage::Invalid;
use umbrage_examples::variance::Variance;
use umbrage_lab::cli::Program;
use umbrage_plan::catalogue::CatalogueEntry;

fn main() -> Result<ExitCode, Invalid> {
    let program = Program::default().with(CatalogueEntry::of::<Variance>())?;
    Ok(program.run())
}
