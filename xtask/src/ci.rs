//! Everything that a change has to pass.

use crate::{
    cli::{CiOptions, TestOptions},
    run::{cargo, run},
    test, tidy,
};
use anyhow::{Context as _, Result, bail};
use comfy_table::Table;
use std::{process::Command, time::Instant};

type Step = (&'static str, Box<dyn Fn() -> Result<()>>);

/// Runs all steps, also after one has failed, and prints what each came to.
pub(crate) fn ci(options: &CiOptions) -> Result<()> {
    let mut table = Table::new();
    table.set_header(["step", "result", "seconds"]);
    let mut failed = Vec::new();
    for (name, step) in steps(options) {
        println!("==== {name}");
        let start = Instant::now();
        let result = step();
        if let Err(error) = &result {
            println!("{name}: {error:#}");
            failed.push(name);
        }
        let verdict = if result.is_ok() { "ok" } else { "FAILED" };
        table.add_row([name, verdict, &format!("{:.0}", start.elapsed().as_secs_f64())]);
    }
    println!("{table}");
    if failed.is_empty() { Ok(()) } else { bail!("failed: {}", failed.join(", ")) }
}

fn steps(options: &CiOptions) -> Vec<Step> {
    let install_driver = options.install_driver;
    let test = move || test::test(&TestOptions { install_driver, arguments: Vec::new() });
    let mut steps: Vec<Step> = Vec::new();
    if !options.after_tests {
        steps.push(("test", Box::new(test)));
    }
    let words = |words: &'static [&'static str]| move || run(cargo().args(words));
    steps.extend::<[Step; 5]>([
        ("tidy", Box::new(tidy::tidy)),
        ("format", Box::new(words(&["fmt", "--all", "--check"]))),
        ("clippy", Box::new(words(&CLIPPY))),
        ("doc", Box::new(|| run(doc().env("RUSTDOCFLAGS", "-D warnings")))),
        ("package", Box::new(package)),
    ]);
    steps
}

const CLIPPY: [&str; 7] = ["clippy", "--workspace", "--all-targets", "--all-features", "--", "-D", "warnings"];

fn doc() -> Command {
    let mut command = cargo();
    command.args(["doc", "--workspace", "--no-deps", "--all-features"]);
    command
}

/// Packs and builds every published package as its users would get it.
fn package() -> Result<()> {
    let names = published()?;
    let names = names.iter().flat_map(|name| ["--package", name]);
    // Cargo remembers what it unpacked by folder and version, so a second run in the same folder would build old code.
    let folder = std::env::temp_dir().join(format!("umbrage-package-{}", std::process::id()));
    // What is packed is the question here, not whether it is committed.
    let mut command = cargo();
    command.args(["package", "--allow-dirty"]).args(names).arg("--target-dir").arg(&folder);
    // Whether it builds is the question, not how fast it runs: unoptimised, that takes half as long.
    let result = run(command.env("CARGO_PROFILE_DEV_DEBUG", "0").env("CARGO_PROFILE_DEV_OPT_LEVEL", "0"));
    // Left-overs in the system's folder for them do no harm.
    drop(std::fs::remove_dir_all(&folder));
    result
}

/// The names of all packages that don't say `publish = false`.
fn published() -> Result<Vec<String>> {
    let output = cargo().args(["metadata", "--format-version", "1", "--no-deps"]).output()?;
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout).context("cargo metadata is not JSON")?;
    let packages = metadata["packages"].as_array().context("cargo metadata names no packages")?;
    let public = packages.iter().filter(|p| p["publish"].is_null());
    Ok(public.filter_map(|p| p["name"].as_str().map(str::to_owned)).collect())
}
