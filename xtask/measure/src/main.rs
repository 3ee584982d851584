//! `cargo xtask compare`, `stability`, `plan`, `which`, `bias`, `bench`, `card` and `merge`:
//! umbrage's commands with this repository's folder for reports. A program with its own techniques
//! has the same structure.

use std::{path::Path, process::ExitCode};

fn main() -> ExitCode {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let repository = package.ancestors().nth(2).unwrap_or(package);
    let program = umbrage_lab::cli::Program {
        invocation: "cargo xtask",
        reports: repository.join("target"),
        light_set_ratios: Some(umbrage_examples::light_set::ratios),
        ..umbrage_lab::cli::Program::default()
    };
    program.run()
}
