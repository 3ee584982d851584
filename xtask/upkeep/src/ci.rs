//! All checks of a change.

use crate::{
    cli::{CiOptions, DriverTests, TestOptions},
    run::{cargo, metadata, root, run},
    test, tidy, wheel,
};
use anyhow::{Context as _, Result, bail};
use comfy_table::Table;
use std::{
    fmt::Write as _,
    fs,
    path::{Path, PathBuf},
    process::Command,
    time::Instant,
};

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
    steps.push(("package", Box::new(package)));
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

/// Checks that the packages for browsers compile for them: with the wgpu backend alone, and with
/// all features, as docs.rs documents them.
fn browser() -> Result<()> {
    install_browser_target()?;
    let features: [&[&str]; 2] = [
        &["--no-default-features", "--features", "umbrage/wgpu"],
        &["--all-features"],
    ];
    for features in features {
        let mut command = cargo();
        command.args(["check", "--target", BROWSER_TARGET]);
        command.args(features);
        for package in IN_BROWSERS {
            command.args(["--package", package]);
        }
        run(&mut command)?;
    }
    Ok(())
}

fn doc() -> Result<()> {
    let mut command = cargo();
    command
        .args(["doc", "--no-deps", "--all-features"])
        .env("RUSTDOCFLAGS", "-D warnings");
    run(&mut command)
}

/// Packs every published package, and checks the packed files as its users receive them. A missing
/// file or an undeclared dependency is an error there.
fn package() -> Result<()> {
    let folder = root().join("target").join("packed");
    // Remove the files of an earlier run, if any.
    drop(fs::remove_dir_all(&folder));
    let packed = pack(&folder)?;
    check_packed(&folder, &packed)
}

/// A package that was packed and unpacked again.
struct Packed {
    name: String,
    /// Folder that it was unpacked to.
    folder: PathBuf,
}

/// Packs all published packages, and unpacks each into a folder inside `folder`.
fn pack(folder: &Path) -> Result<Vec<Packed>> {
    let published = published_packages()?;
    let mut command = cargo();
    // Uncommitted changes may be packed, too. `check_packed` verifies the packed files.
    command.args(["package", "--allow-dirty", "--no-verify"]);
    for package in &published {
        command.args(["--package", &package.name]);
    }
    command.arg("--target-dir").arg(folder);
    run(&mut command)?;
    let archives = folder.join("package");
    let mut packed = Vec::new();
    for package in published {
        let stem = format!("{}-{}", package.name, package.version);
        let archive = archives.join(format!("{stem}.crate"));
        // Files in archives are dated 2006, so cargo would treat them as unchanged: `m` gives them
        // the present time.
        let mut tar = Command::new("tar");
        tar.arg("-xzmf").arg(archive).arg("-C").arg(folder);
        run(&mut tar)?;
        packed.push(Packed {
            name: package.name,
            folder: folder.join(stem),
        });
    }
    Ok(packed)
}

/// Checks unpacked packages in a separate workspace, where they replace each other's versions of a
/// registry. Dependencies that clippy has already checked are reused from this workspace's target
/// folder.
fn check_packed(folder: &Path, packed: &[Packed]) -> Result<()> {
    let mut manifest = "[workspace]\nresolver = \"3\"\nmembers = [".to_owned();
    let mut patches = String::from("[patch.crates-io]\n");
    for package in packed {
        let name = &package.name;
        let place = package
            .folder
            .file_name()
            .context("unpacked packages have folders")?
            .to_string_lossy();
        write!(manifest, "\"{place}\", ")?;
        writeln!(patches, "{name} = {{ path = \"{place}\" }}")?;
    }
    let own_manifest = fs::read_to_string(root().join("Cargo.toml"))?;
    let profiles = profiles(&own_manifest)?;
    let text = format!("{manifest}]\n{patches}{profiles}");
    fs::write(folder.join("Cargo.toml"), text)?;
    fs::copy(root().join("Cargo.lock"), folder.join("Cargo.lock"))?;
    let mut command = cargo();
    command
        .current_dir(folder)
        .args(["check", "--workspace", "--all-features", "--target-dir"])
        .arg(root().join("target"));
    run(&mut command)
}

/// Returns the profiles of a manifest, which are at its end. With other profiles, all would be
/// checked again.
fn profiles(manifest: &str) -> Result<String> {
    let start = manifest
        .find("\n[profile.")
        .context("the workspace's manifest has no profiles")?;
    Ok(manifest[start..].to_owned())
}

/// A published package.
pub(crate) struct Published {
    pub(crate) name: String,
    version: String,
}

/// Returns all packages without `publish = false`.
pub(crate) fn published_packages() -> Result<Vec<Published>> {
    let metadata = metadata()?;
    let packages = metadata["packages"]
        .as_array()
        .context("cargo metadata names no packages")?;
    let mut out = Vec::new();
    for package in packages.iter().filter(|p| p["publish"].is_null()) {
        let name = package["name"].as_str();
        let version = package["version"].as_str();
        if let (Some(name), Some(version)) = (name, version) {
            out.push(Published {
                name: name.to_owned(),
                version: version.to_owned(),
            });
        }
    }
    Ok(out)
}
