//! Check that version numbers reflect the changes since the last release.

use crate::{
    run::{metadata, root, run, target_folder},
    tools::Tool,
};
use anyhow::{Context as _, Result, bail};
use std::{fs, path::Path, process::Command};

/// The program that finds changes of a public interface.
const SEMVER_CHECKS: Tool = Tool {
    package: "cargo-semver-checks",
    program: "cargo-semver-checks",
    version: "0.51.0",
    reason: "it compares public interfaces, and reads the documentation of Rust 1.93 and later",
    minutes: 4,
    // Its own profile optimises all dependencies.
    options: &[
        "--debug",
        "--config",
        "profile.dev.package.\"*\".opt-level=0",
        "--config",
        "profile.dev.debug=false",
    ],
};

/// Checks the versions of all published packages. First confirms that the program detects a removed
/// function.
pub(super) fn versions() -> Result<()> {
    let program = SEMVER_CHECKS.find_or_install(&target_folder()?)?;
    detect_removed_function(&program)?;
    let packages = published_packages()?;
    match comparison(&program, root(), &packages)? {
        Some(mut comparison) => run(&mut comparison),
        None => {
            println!("skipped: there is no tag `v*`, so no release to compare with");
            Ok(())
        }
    }
}

/// Returns the names of all packages without `publish = false`.
fn published_packages() -> Result<Vec<String>> {
    let metadata = metadata()?;
    let packages = metadata["packages"]
        .as_array()
        .context("cargo metadata names no packages")?;
    let published = packages.iter().filter(|p| p["publish"].is_null());
    let names = published.filter_map(|package| package["name"].as_str());
    Ok(names.map(str::to_owned).collect())
}

/// Returns the command that compares packages of a checkout with its last release; `None` before
/// the first release.
fn comparison(program: &Path, checkout: &Path, packages: &[String]) -> Result<Option<Command>> {
    let Some(tag) = last_release(checkout)? else {
        return Ok(None);
    };
    let mut command = Command::new(program);
    command.current_dir(checkout);
    command.args(["semver-checks", "--baseline-rev", &tag]);
    for package in packages {
        command.args(["--package", package]);
    }
    Ok(Some(command))
}

/// Returns the tag of the last release; `None` before the first one.
fn last_release(checkout: &Path) -> Result<Option<String>> {
    let mut git = Command::new("git");
    git.current_dir(checkout);
    git.args(["tag", "--list", "v*", "--sort=-version:refname"]);
    let output = git.output().context("git did not start")?;
    if !output.status.success() {
        bail!("git can't list its tags: is this a checkout?");
    }
    let tags = String::from_utf8_lossy(&output.stdout);
    Ok(tags.lines().next().map(str::to_owned))
}

const CONTROL_MANIFEST: &str =
    "[package]\nname = \"control\"\nversion = \"0.1.0\"\nedition = \"2024\"\n\n[workspace]\n";
const KEPT_FUNCTION: &str = "pub fn kept() {}\n";
const REMOVED_FUNCTION: &str = "pub fn removed() {}\n";

/// Confirms on a package of two functions, released in a temporary repository, that no change
/// passes, and that the removal of a function is reported by its name.
fn detect_removed_function(program: &Path) -> Result<()> {
    let folder = tempfile::tempdir()?;
    let library = folder.path().join("src/lib.rs");
    fs::create_dir(folder.path().join("src"))?;
    fs::write(folder.path().join("Cargo.toml"), CONTROL_MANIFEST)?;
    fs::write(folder.path().join(".gitignore"), "/target\n")?;
    fs::write(&library, KEPT_FUNCTION.to_owned() + REMOVED_FUNCTION)?;
    release(folder.path())?;
    let check = || -> Result<(bool, String)> {
        let comparison = comparison(program, folder.path(), &["control".to_owned()])?;
        let output = comparison.context("the control has no tag")?.output()?;
        let printed = [output.stdout, output.stderr].concat();
        let printed = String::from_utf8_lossy(&printed).into_owned();
        Ok((output.status.success(), printed))
    };
    let (is_accepted, printed) = check()?;
    if !is_accepted {
        bail!("control: the same interface as in the release is refused:\n{printed}");
    }
    fs::write(&library, KEPT_FUNCTION)?;
    let (is_accepted, printed) = check()?;
    let mut lines = printed.lines();
    let finding = lines.find(|line| line.contains("function control::removed"));
    match finding {
        Some(finding) if !is_accepted => {
            println!("control: a removed function is detected:{finding}");
            Ok(())
        }
        _ => bail!("control: a removed function is not detected:\n{printed}"),
    }
}

/// Commits the files of a folder to a new repository, with the tag of a release.
fn release(folder: &Path) -> Result<()> {
    let git = |arguments: &[&str]| {
        let mut git = Command::new("git");
        git.current_dir(folder);
        for setting in [
            "user.name=control",
            "user.email=control@example.org",
            "commit.gpgsign=false",
            "tag.gpgsign=false",
        ] {
            git.args(["-c", setting]);
        }
        run(git.args(arguments))
    };
    git(&["init", "--quiet"])?;
    git(&["add", "."])?;
    git(&["commit", "--quiet", "--message", "Control"])?;
    git(&["tag", "v0.1.0"])
}
