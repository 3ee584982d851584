//! Golden images of the tests.

use crate::{
    cli::BlessOptions,
    run::{Usage, cargo, run, sibling_program},
};
use anyhow::{Result, bail};

/// Builds and runs the program that renders and writes golden images. It is built like the tests,
/// so that both share their dependencies.
pub(crate) fn bless(options: &BlessOptions) -> Result<()> {
    run(cargo().args(["build", "--bin", "bless"]))?;
    let mut command = sibling_program("bless")?;
    if options.all {
        command.arg("--all");
    } else {
        command.args(&options.names);
    }
    let status = command.status()?;
    match status.code() {
        Some(0) => Ok(()),
        Some(2) => Err(Usage("no such golden image".to_owned()).into()),
        _ => bail!("`bless` ended with {status}"),
    }
}
