//! `compare`, `stability` and `plan` with the techniques of these examples in addition to the
//! built-in ones: `cargo run --release --example measure -- compare cubes --technique variance,pcf
//! --quick`.

use std::process::ExitCode;
use umbrage::Invalid;
use umbrage_examples::{rivals::contact::ContactShadows, variance::Variance};
use umbrage_lab::cli::Program;
use umbrage_plan::catalogue::CatalogueEntry;

fn main() -> Result<ExitCode, Invalid> {
    let program = Program::default()
        .with(CatalogueEntry::for_technique::<Variance>())?
        .with(CatalogueEntry::for_technique::<ContactShadows>())?;
    Ok(program.run())
}
