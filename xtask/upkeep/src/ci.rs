//! Everything that a change has to pass.

use crate::{
    cli::{CiOptions, TestOptions},
    run::{cargo, root, run},
    test, tidy,
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
            arguments: Vec::new(),
        })
    };
    let mut steps: Vec<Step> = Vec::new();
    if !options.after_tests {
        steps.push(("test", Box::new(test)));
    }
    let words = |words: &'static [&'static str]| move || run(cargo().args(words));
    steps.extend::<[Step; 5]>([
        ("tidy", Box::new(tidy::tidy)),
        ("format", Box::new(words(&["fmt", "--all", "--check"]))),
        ("clippy", Box::new(words(&CLIPPY))),
        (
            "doc",
            Box::new(|| run(doc().env("RUSTDOCFLAGS", "-D warnings"))),
        ),
        ("package", Box::new(package)),
    ]);
    steps
}

const CLIPPY: [&str; 7] = [
    "clippy",
    "--workspace",
    "--all-targets",
    "--all-features",
    "--",
    "-D",
    "warnings",
];

fn doc() -> Command {
    let mut command = cargo();
    command.args(["doc", "--workspace", "--no-deps", "--all-features"]);
    command
}

/// Packs every published package, and checks what was packed as its users would get it: a file that a package lacks, or a
/// dependency that it doesn't name, is an error there.
fn package() -> Result<()> {
    let folder = root().join("target").join("packed");
    // What an earlier run left is not what is asked about.
    drop(fs::remove_dir_all(&folder));
    let packed = pack(&folder)?;
    check_packed(&folder, &packed)
}

/// A package's name, and the folder that it was unpacked to.
type Packed = (String, PathBuf);

fn pack(folder: &Path) -> Result<Vec<Packed>> {
    let published = published()?;
    let names = published.iter().flat_map(|(name, _)| ["--package", name]);
    // What is packed is the question here, not whether it is committed; what is packed is checked below.
    let mut command = cargo();
    command
        .args(["package", "--allow-dirty", "--no-verify"])
        .args(names)
        .arg("--target-dir")
        .arg(folder);
    run(&mut command)?;
    let archives = folder.join("package");
    let unpack = |(name, version): &(String, String)| {
        let stem = format!("{name}-{version}");
        // Archives hold files of 2006, which cargo would take for unchanged: `m` leaves that time out.
        run(Command::new("tar")
            .arg("-xzmf")
            .arg(archives.join(format!("{stem}.crate")))
            .arg("-C")
            .arg(folder))?;
        Ok((name.clone(), folder.join(stem)))
    };
    published.iter().map(unpack).collect()
}

/// Checks unpacked packages in a workspace of their own, each with the others in place of those that a registry would give.
/// What they depend on is taken from this workspace's target folder where clippy has checked it already.
fn check_packed(folder: &Path, packed: &[Packed]) -> Result<()> {
    let mut manifest = "[workspace]\nresolver = \"3\"\nmembers = [".to_owned();
    let mut patches = String::from("[patch.crates-io]\n");
    for (name, place) in packed {
        let place = place
            .file_name()
            .context("unpacked packages have folders")?
            .to_string_lossy();
        write!(manifest, "\"{place}\", ")?;
        writeln!(patches, "{name} = {{ path = \"{place}\" }}")?;
    }
    let profiles = profiles(&fs::read_to_string(root().join("Cargo.toml"))?)?;
    fs::write(
        folder.join("Cargo.toml"),
        format!("{manifest}]\n{patches}{profiles}"),
    )?;
    fs::copy(root().join("Cargo.lock"), folder.join("Cargo.lock"))?;
    let mut command = cargo();
    command
        .current_dir(folder)
        .args(["check", "--workspace", "--all-features", "--target-dir"]);
    run(command.arg(root().join("target")))
}

/// Returns the profiles of a manifest, which stand at its end. What is checked with other ones is checked anew.
fn profiles(manifest: &str) -> Result<String> {
    let start = manifest
        .find("\n[profile.")
        .context("the workspace's manifest has no profiles")?;
    Ok(manifest[start..].to_owned())
}

/// The names and versions of all packages that don't say `publish = false`.
fn published() -> Result<Vec<(String, String)>> {
    let output = cargo()
        .args(["metadata", "--format-version", "1", "--no-deps"])
        .output()?;
    let metadata: serde_json::Value =
        serde_json::from_slice(&output.stdout).context("cargo metadata is not JSON")?;
    let packages = metadata["packages"]
        .as_array()
        .context("cargo metadata names no packages")?;
    let public = packages.iter().filter(|p| p["publish"].is_null());
    let text = |value: &serde_json::Value| value.as_str().map(str::to_owned);
    Ok(public
        .filter_map(|p| text(&p["name"]).zip(text(&p["version"])))
        .collect())
}
