//! Release checks in addition to `ci`: they need more programs and take longer.

mod versions;

use crate::{
    ci::{Step, check_in_browsers, run_all},
    cli::{ReleaseOptions, ReleaseStep},
    run::{cargo, root, run, target_folder},
    web::build_page,
};
use anyhow::{Context as _, Result, bail};
use clap::ValueEnum as _;
use std::process::Command;

/// Flags for Miri:
/// * tests read snapshots and the time;
/// * rayon's threads outlive the tests; its queues (crossbeam-epoch) are valid under tree borrows,
///   not under stacked borrows (<https://github.com/crossbeam-rs/crossbeam/issues/545>), and keep
///   numbers in pointers;
/// * sines differ from call to call without the last flag, and so would results of equal calls.
const MIRI_FLAGS: &str = "-Zmiri-disable-isolation -Zmiri-ignore-leaks -Zmiri-tree-borrows -Zmiri-permissive-provenance \
                          -Zmiri-deterministic-floats";

/// Modules of the core whose tests end within minutes in Miri. Tests that trace or fit thousands of
/// triangles take hours.
const MIRI_TESTS: [&str; 10] = [
    "geometry::aabb",
    "geometry::derived",
    "geometry::weld",
    "light_space::cascades",
    "light_space::depth_range",
    "metrics::",
    "picture::",
    "recipe::",
    "scene::",
    "snapping::",
];

/// Runs the selected steps, or all.
pub(crate) fn release_check(options: &ReleaseOptions) -> Result<()> {
    let is_requested = |step: ReleaseStep| options.only.is_empty() || options.only.contains(&step);
    let steps = ReleaseStep::value_variants()
        .iter()
        .filter(|&&step| is_requested(step))
        .map(|&step| -> Step {
            match step {
                ReleaseStep::OldestRust => ("oldest-rust", Box::new(oldest_rust)),
                ReleaseStep::Licences => ("licences", Box::new(licences)),
                ReleaseStep::Versions => ("versions", Box::new(versions::versions)),
                ReleaseStep::Miri => ("miri", Box::new(miri)),
                ReleaseStep::Publish => ("publish", Box::new(publish)),
                ReleaseStep::Viewer => ("viewer", Box::new(viewer)),
            }
        })
        .collect();
    run_all(steps)
}

/// Oldest Rust in the workspace's manifest.
const OLDEST_RUST: &str = env!("CARGO_PKG_RUST_VERSION");

/// Checks that the workspace compiles with that Rust.
fn oldest_rust() -> Result<()> {
    println!("oldest Rust in the manifest: {OLDEST_RUST}");
    let reported = cargo().arg("--version").output()?.stdout;
    let mut check = if is_of(&String::from_utf8_lossy(&reported), OLDEST_RUST) {
        println!("it is the running toolchain");
        cargo()
    } else {
        // The cargo that runs this program belongs to one toolchain; rustup's selects another.
        let mut rustup = Command::new("rustup");
        rustup.current_dir(root());
        rustup.args(["run", "--install", OLDEST_RUST, "cargo"]);
        rustup
    };
    check.args([
        "check",
        "--workspace",
        "--all-targets",
        "--all-features",
        "--locked",
    ]);
    run(&mut check)
}

/// Reports whether `cargo --version` printed a version, such as 1.95, or a patch of it, such as
/// 1.95.1, but no pre-release, such as 1.95.0-nightly.
fn is_of(reported: &str, version: &str) -> bool {
    let number = reported.strip_prefix("cargo ").unwrap_or_default();
    let number = number.split_whitespace().next().unwrap_or_default();
    let rest = number.strip_prefix(version);
    rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('.')) && !number.contains('-')
}

/// Checks licences, known vulnerabilities, sources and bans of all dependencies: see `deny.toml`.
fn licences() -> Result<()> {
    needs("deny", "cargo-deny")?;
    let checks = ["deny", "--all-features", "check"];
    run(cargo().args(checks).args(["bans", "licenses", "sources"]))?;
    // The database is fetched from the network.
    run(cargo().args(checks).arg("advisories")).context(
        "either a dependency has a known vulnerability, as printed above, or the advisory database, \
         https://github.com/RustSec/advisory-db, can't be reached, so advisories are unchecked. \
         Bans, licences and sources passed",
    )
}

/// Runs tests of the core in an interpreter that detects undefined behaviour. The workspace forbids
/// unsafe code; its dependencies have some.
fn miri() -> Result<()> {
    let mut install = Command::new("rustup");
    install.args(["component", "add", "--toolchain", "nightly"]);
    run(install.args(["miri", "rust-src"])).context("Miri comes with the nightly toolchain")?;
    let mut test = Command::new("rustup");
    test.current_dir(root());
    test.env("MIRIFLAGS", MIRI_FLAGS);
    // Everything runs about a thousand times slower in Miri, so limit the random cases.
    test.env("PROPTEST_CASES", "2");
    test.args(["run", "nightly", "cargo", "miri", "test"]);
    test.args(["--package", "umbrage-core", "--lib", "--"]);
    run(test.args(MIRI_TESTS))
}

/// Packs every published package, and compiles it as its users will. Also compiles the packages for
/// browsers with all features, as docs.rs documents them.
fn publish() -> Result<()> {
    run(cargo().args(["publish", "--workspace", "--dry-run", "--all-features"]))?;
    check_in_browsers(&["--all-features"])
}

/// Lints and tests the viewer, and runs the end-to-end tests of its window and its page. The
/// example `forward` uses the page's preset, too.
fn viewer() -> Result<()> {
    let package = ["--release", "--package", "umbrage-viewer"];
    let mut clippy = cargo();
    clippy.arg("clippy").args(package);
    run(clippy.args(["--all-targets", "--", "--deny", "warnings"]))?;
    let mut test = cargo();
    run(test.arg("test").args(package))?;
    let target = target_folder()?;
    let page = target.join("web");
    build_page(&target, &page)?;
    let tried = target.join("web-tried");
    let mut on_page = python("examples/viewer/web/try.py");
    on_page.arg("--page").arg(&page).arg("--out").arg(&tried);
    run(&mut on_page).context("its requirements are at the head of examples/viewer/web/try.py")?;
    let mut in_window = python("examples/viewer/try.py");
    in_window.arg("--copied").arg(tried.join(COPIED));
    run(&mut in_window).context("its requirements are at the head of examples/viewer/try.py")
}

/// Preset that the end-to-end test of the page copied.
const COPIED: &str = "copied.preset.toml";

fn python(script: &str) -> Command {
    let mut command = Command::new("python3");
    command.current_dir(root()).arg(script);
    command
}

/// Checks that cargo has an additional command.
fn needs(command: &str, package: &str) -> Result<()> {
    let found = cargo().args([command, "--version"]).output()?;
    if !found.status.success() {
        bail!("{package} is missing: run `cargo install --locked {package}`");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::is_of;

    #[test]
    fn corrections_of_a_version_are_of_it() {
        assert!(is_of("cargo 1.95.0 (f2d3ce0bd 2026-03-21)\n", "1.95"));
        assert!(is_of("cargo 1.95.1 (f2d3ce0bd 2026-03-21)\n", "1.95.1"));
        for other in [
            "cargo 1.950.0 (a)",
            "cargo 1.96.0 (a)",
            "cargo 1.95.0-nightly (a)",
            "",
        ] {
            assert!(!is_of(other, "1.95"), "{other}");
        }
    }
}
