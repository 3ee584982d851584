//! The Python wheel of `umbrage-surfaces`: built, installed from its file, and tested.

use crate::run::{cargo, root, run, target_folder};
use anyhow::{Context as _, Result, ensure};
use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

/// Builder of wheels.
const MATURIN: &str = "maturin==1.16.0";
/// Greatest size of the wheel, bytes.
const MOST_BYTES: u64 = 1_500_000;

/// Builds the wheel with the packages that tests have built, installs it in a new environment, and
/// compares its answers with those of `umbrage-sun`.
pub(crate) fn wheel() -> Result<()> {
    let target = target_folder()?;
    let folder = target.join("wheel");
    let [tools, fresh, dist] = ["tools", "fresh", "dist"].map(|name| folder.join(name));
    // Remove the wheel of an earlier run, if any.
    drop(fs::remove_dir_all(&dist));
    // Build, with the builder in an environment that is kept.
    if !program(&tools, "maturin").exists() {
        create_environment(&tools, &[MATURIN])?;
    }
    let mut build = Command::new(program(&tools, "maturin"));
    build.current_dir(root().join("crates/umbrage-python"));
    build.args(["build", "--profile", "dev", "--locked", "--out"]);
    build
        .arg(&dist)
        .arg("--interpreter")
        .arg(program(&tools, "python"));
    run(&mut build)?;
    let built: Vec<PathBuf> = fs::read_dir(&dist)?
        .filter_map(|entry| Some(entry.ok()?.path()))
        .collect();
    let [wheel] = &built[..] else {
        ensure!(false, "{} files were built, not a wheel", built.len());
        return Ok(());
    };
    let bytes = fs::metadata(wheel)?.len();
    ensure!(
        bytes <= MOST_BYTES,
        "the wheel has {bytes} bytes, at most {MOST_BYTES} are allowed"
    );
    // Install it from its file, and test it.
    drop(fs::remove_dir_all(&fresh));
    let wheel = wheel
        .to_str()
        .context("the path of the wheel is not UTF-8")?;
    create_environment(&fresh, &["numpy", wheel])?;
    // Tests have built this program with the same features.
    run(cargo().args(["build", "--all-features", "--bin", "umbrage-sun"]))?;
    let mut test = Command::new(program(&fresh, "python"));
    test.arg(root().join("crates/umbrage-python/tests/test_wheel.py"));
    test.arg(target.join("debug").join("umbrage-sun"));
    run(&mut test)
}

/// Creates a Python environment with these packages.
fn create_environment(folder: &Path, packages: &[&str]) -> Result<()> {
    let mut create = Command::new("python3");
    create.args(["-m", "venv", "--clear"]).arg(folder);
    run(&mut create).context("the wheel needs Python 3.10 with `venv`")?;
    let mut install = Command::new(program(folder, "python"));
    install.args(["-m", "pip", "install", "--quiet", "--only-binary", ":all:"]);
    run(install.args(packages))
}

/// Returns the path of a program in an environment.
fn program(environment: &Path, name: &str) -> PathBuf {
    let folder = if cfg!(windows) { "Scripts" } else { "bin" };
    environment
        .join(folder)
        .join(format!("{name}{}", std::env::consts::EXE_SUFFIX))
}
