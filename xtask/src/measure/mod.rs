//! The commands that measure. `cargo xtask` itself is built without them, so that it is there in seconds; they are built,
//! optimised, when they are first asked for.

#[cfg(feature = "measure")]
mod bench;
#[cfg(feature = "measure")]
mod bias;
#[cfg(feature = "measure")]
mod compare;
#[cfg(feature = "measure")]
mod cost;
#[cfg(feature = "measure")]
mod costs;
#[cfg(feature = "measure")]
mod inputs;
#[cfg(feature = "measure")]
mod list;
#[cfg(feature = "measure")]
mod merge;
#[cfg(feature = "measure")]
mod plan;
#[cfg(feature = "measure")]
mod planning;
#[cfg(feature = "measure")]
mod progress;
#[cfg(feature = "measure")]
mod regret;
#[cfg(feature = "measure")]
mod stability;
#[cfg(feature = "measure")]
mod table;

use crate::cli::Command;
use anyhow::Result;

/// Runs the command.
#[cfg(feature = "measure")]
pub(crate) fn dispatch(command: &Command) -> Result<()> {
    match command {
        Command::Compare(options) if options.list => list::list(),
        Command::Compare(options) => compare::compare(options),
        Command::Merge(options) => merge::merge(options),
        Command::Stability(options) => stability::stability(options),
        Command::Bench(options) if options.costs => costs::costs(options),
        Command::Plan(options) if options.regret => regret::regret(options),
        Command::Plan(options) => plan::plan(options),
        Command::Bench(options) => bench::bench(options),
        Command::Bias(options) => bias::bias(options),
        _ => Ok(()),
    }
}

/// Runs the command in a build of this program that can.
#[cfg(not(feature = "measure"))]
pub(crate) fn dispatch(_command: &Command) -> Result<()> {
    use crate::run::{cargo, root, spell};
    use anyhow::Context as _;
    let mut again = cargo();
    again.args([
        "run",
        "--release",
        "--package",
        "xtask",
        "--features",
        "measure",
        "--manifest-path",
    ]);
    again
        .arg(root().join("Cargo.toml"))
        .arg("--")
        .args(std::env::args_os().skip(1));
    // Paths that were typed count from where they were typed.
    again.current_dir(std::env::current_dir()?);
    if is_built() {
        again.env("CARGO_TERM_QUIET", "true");
    } else {
        println!("building what measures, optimised: this takes some minutes the first time");
    }
    let line = spell(&again);
    let status = again
        .status()
        .with_context(|| format!("`{line}` did not start"))?;
    std::process::exit(status.code().unwrap_or(1));
}

/// Whether an optimised build has been made before: `target/debug/xtask` has `target/release/xtask` for a cousin.
#[cfg(not(feature = "measure"))]
fn is_built() -> bool {
    let here = std::env::current_exe().ok();
    let target = here.as_deref().and_then(|p| p.parent()?.parent());
    target.is_some_and(|t| {
        t.join("release")
            .join(format!("xtask{}", std::env::consts::EXE_SUFFIX))
            .is_file()
    })
}
