//! `compare`, `stability` and `plan` with the techniques that others have and the library has not, as prototypes beside its own:
//! `cargo run --release --example measure_others -- compare street --technique contact,hard,pcf`.

use std::process::ExitCode;
use umbrage::Invalid;
use umbrage_examples::contact::ContactShadows;
use umbrage_lab::cli::Program;
use umbrage_plan::catalogue::CatalogueEntry;

fn main() -> Result<ExitCode, Invalid> {
    let program = Program::default().with(CatalogueEntry::of::<ContactShadows>())?;
    Ok(program.run())
}
