//! All checks of a change.

use crate::{
    cli::{CiOptions, DriverTests, TestOptions},
    run::{cargo, run},
    test, tidy, wheel,
};
use anyhow::{Context as _, Result, bail};
use comfy_table::Table;
use std::{process::Command, time::Instant};

/// Name of a step, and its function.
pub(crate) type Step = (&'static str, Box<dyn Fn() -> Result<()>>);

/// Runs all checks of a change.
pub(crate) fn ci(options: &CiOptions) -> Result<()> {
    run_all(steps(options))
}

/// Runs all steps, also after one has failed, and prints the result of each.
pub(crate) fn run_all(steps: Vec<Step>) -> Result<()> {
    let mut table = Table::new();
    table.set_header(["step", "result", "seconds"]);
    let mut failed = Vec::new();
    for (name, step) in steps {
        println!("==== {name}");
        let start = Instant::now();
        let result = step();
        if let Err(error) = &result {
            println!("{name}: {error:#}");
            failed.push(name);
        }
        let verdict = if result.is_ok() { "ok" } else { "FAILED" };
        table.add_row([
            name,
            verdict,
            &format!("{:.0}", start.elapsed().as_secs_f64()),
        ]);
    }
    println!("{table}");
    if failed.is_empty() {
        Ok(())
    } else {
        bail!("failed: {}", failed.join(", "))
    }
}

fn steps(options: &CiOptions) -> Vec<Step> {
    let install_driver = options.install_driver;
    let pinned_driver = options.pinned_driver;
    let test = move || {
        test::test(&TestOptions {
            install_driver,
            pinned_driver,
            drivers: DriverTests::Part,
            arguments: Vec::new(),
        })
    };
    let mut steps: Vec<Step> = Vec::new();
    if !options.after_tests {
        steps.push(("test", Box::new(test)));
    }
    steps.push(("tidy", Box::new(tidy::tidy)));
    steps.push(("format", Box::new(|| run(cargo().args(FORMAT)))));
    steps.push(("clippy", Box::new(|| run(cargo().args(CLIPPY)))));
    steps.push(("browser", Box::new(browser)));
    steps.push(("doc", Box::new(doc)));
    steps.push(("wheel", Box::new(wheel::wheel)));
    steps
}

const FORMAT: [&str; 3] = ["fmt", "--all", "--check"];

const CLIPPY: [&str; 6] = [
    "clippy",
    "--all-targets",
    "--all-features",
    "--",
    "-D",
    "warnings",
];

/// Packages that programs in browsers use.
const IN_BROWSERS: [&str; 4] = [
    "umbrage-core",
    "umbrage-techniques",
    "umbrage-wgpu",
    "umbrage",
];

/// Target of programs in browsers.
pub(crate) const BROWSER_TARGET: &str = "wasm32-unknown-unknown";

/// Installs the browser target if it is missing.
pub(crate) fn install_browser_target() -> Result<()> {
    let mut install = Command::new("rustup");
    install.args(["target", "add", BROWSER_TARGET]);
    run(&mut install).context("programs for browsers need a target, which rustup installs")
}

/// Checks that the packages for browsers compile for them with the wgpu backend alone.
fn browser() -> Result<()> {
    check_in_browsers(&["--no-default-features", "--features", "umbrage/wgpu"])
}

/// Checks that the packages for browsers compile for them with these features.
pub(crate) fn check_in_browsers(features: &[&str]) -> Result<()> {
    install_browser_target()?;
    let mut command = cargo();
    command.args(["check", "--target", BROWSER_TARGET]);
    command.args(features);
    for package in IN_BROWSERS {
        command.args(["--package", package]);
    }
    run(&mut command)
}

fn doc() -> Result<()> {
    let mut command = cargo();
    command
        .args(["doc", "--no-deps", "--all-features"])
        .env("RUSTDOCFLAGS", "-D warnings");
    run(&mut command)
}
