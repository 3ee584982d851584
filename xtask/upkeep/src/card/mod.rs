//! `cargo xtask card --pack`: packs the measuring programs for a machine with a graphics card,
//! without a compiler or a network.

#[path = "../../../../crates/umbrage-lab/src/compare/commit.rs"]
mod commit;

use crate::{
    adapter,
    cli::PackOptions,
    run::{Usage, cargo, root, run, target_folder},
};
use anyhow::{Context as _, Result, bail};
use commit::commit;
use std::{
    fs, io,
    path::{Path, PathBuf},
    process::Command,
};

/// Script that runs on that machine.
const RUN_SCRIPT: &str = include_str!("run.sh");

/// Debian's packages of Vulkan's loader, and of further libraries that NVIDIA's driver loads.
/// Compute machines lack them.
const LOADER: [&str; 7] = [
    "libvulkan1",
    "libegl1",
    "libglvnd0",
    "libopengl0",
    "libgl1",
    "libglx0",
    "libgles2",
];

/// Test programs that compare an adapter with the CPU.
const TESTS: [&str; 2] = ["nets", "second_driver"];

/// Name in the folder, and path of a program.
type Packed = (String, PathBuf);

/// Builds the programs and packs them.
pub(crate) fn pack(options: &PackOptions) -> Result<()> {
    let folder = &options.pack;
    check_folder(folder)?;
    let mut programs = build()?;
    let bevy = root().join("examples/rivals/engines/target/release/rival_bevy");
    if bevy.is_file() {
        programs.push(("rival_bevy".to_owned(), bevy));
    } else {
        println!("skipped Bevy: examples/rivals/engines is not built; see its README");
    }
    write_folder(folder, &programs)?;
    download_loader(&folder.join("loader"))?;
    println!(
        "packed: {}; copy it to the machine with the card, then run `bash run.sh` in it",
        folder.display()
    );
    Ok(())
}

/// Rejects folders with other files. A new folder, an empty one and one that was packed before are
/// accepted.
fn check_folder(folder: &Path) -> Result<()> {
    let refuse = |why: String| Usage(format!("--pack: `{}` {why}", folder.display()));
    let is_empty = match fs::read_dir(folder) {
        Ok(mut entries) => entries.next().is_none(),
        Err(e) if e.kind() == io::ErrorKind::NotFound => true,
        Err(e) => bail!(refuse(format!("cannot be read: {e}"))),
    };
    // The script's first two lines are equal in all versions.
    let head = |script: &str| {
        script
            .lines()
            .take(2)
            .map(str::to_owned)
            .collect::<Vec<_>>()
    };
    let before = fs::read_to_string(folder.join("run.sh")).unwrap_or_default();
    if !is_empty && head(&before) != head(RUN_SCRIPT) {
        bail!(refuse("is not empty; name a new folder".to_owned()));
    }
    Ok(())
}

/// Builds the programs to pack, and returns them.
fn build() -> Result<Vec<Packed>> {
    let measure = ["--profile", "measure", "--package", "xtask-measure"];
    run(cargo().arg("build").args(measure))?;
    let program = target_folder()?.join("measure").join("xtask-measure");
    let mut programs = vec![("xtask-measure".to_owned(), program)];
    let mut command = cargo();
    command.args([
        "test",
        "--all-features",
        "--no-run",
        "--message-format=json",
    ]);
    // Cargo's own lines go to standard error, which is visible.
    command.stderr(std::process::Stdio::inherit());
    for test in TESTS {
        command.args(["--test", test]);
    }
    let output = command.output().context("cargo did not start")?;
    if !output.status.success() {
        bail!("the tests do not build");
    }
    for test in TESTS {
        let executable = String::from_utf8_lossy(&output.stdout)
            .lines()
            .find_map(|line| executable_of(line, test));
        let path = executable.with_context(|| format!("cargo built no test `{test}`"))?;
        programs.push((test.to_owned(), path));
    }
    Ok(programs)
}

/// Returns the program in a line of cargo's JSON if it is the target of that name.
fn executable_of(line: &str, target: &str) -> Option<PathBuf> {
    let message: serde_json::Value = serde_json::from_str(line).ok()?;
    let is_target = message["target"]["name"] == target;
    let executable = message["executable"].as_str()?;
    is_target.then(|| PathBuf::from(executable))
}

/// Writes the run script, the commit and the programs.
fn write_folder(folder: &Path, programs: &[Packed]) -> Result<()> {
    fs::create_dir_all(folder).with_context(|| format!("`{}`", folder.display()))?;
    let bin = tempfile::tempdir().context("there is no folder for temporary files")?;
    for (name, path) in programs {
        let packed = bin.path().join(name);
        fs::copy(path, &packed)
            .with_context(|| format!("`{}` cannot be copied", path.display()))?;
        // Strip symbols; without `strip` the program is packed as it is.
        drop(Command::new("strip").arg(&packed).status());
    }
    let archive = folder.join("bin.tar.xz");
    let mut tar = Command::new("tar");
    tar.env("XZ_OPT", "-3 -T0").arg("-C").arg(bin.path());
    run(tar.arg("-cJf").arg(&archive).arg("."))?;
    fs::write(folder.join("run.sh"), RUN_SCRIPT)?;
    fs::write(folder.join("commit"), commit(root()).unwrap_or_default())?;
    Ok(())
}

/// Downloads Vulkan's loader, which compute machines lack.
fn download_loader(folder: &Path) -> Result<()> {
    if !adapter::is_debian() {
        println!("skipped Vulkan's loader: it is only packed on Debian and Ubuntu");
        return Ok(());
    }
    fs::create_dir_all(folder)?;
    let mut download = adapter::apt_get(&[]);
    run(download.current_dir(folder).arg("download").args(LOADER))
        .context("Vulkan's loader cannot be downloaded: run `apt-get update` as root first")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn programs_are_found_in_what_cargo_prints() {
        let line =
            r#"{"reason":"compiler-artifact","target":{"name":"nets"},"executable":"/t/nets-1"}"#;
        assert_eq!(
            executable_of(line, "nets"),
            Some(PathBuf::from("/t/nets-1"))
        );
        assert_eq!(executable_of(line, "suite"), None);
        assert_eq!(executable_of("Compiling", "nets"), None);
    }

    #[test]
    fn only_folders_of_ours_are_packed_into() {
        let dir = tempfile::tempdir().expect("a folder");
        let folder = dir.path().join("packed");
        check_folder(&folder).expect("a new one");
        // Other files in the folder are kept.
        let kept = folder.join("bin/program");
        fs::create_dir_all(folder.join("bin")).expect("a folder");
        fs::write(&kept, "mine").expect("there");
        let error = check_folder(&folder).expect_err("not ours").to_string();
        assert!(
            error.ends_with("is not empty; name a new folder"),
            "{error}"
        );
        fs::write(folder.join("run.sh"), "#!/usr/bin/env bash\n").expect("there");
        check_folder(&folder).expect_err("another script");
        for _ in 0..2 {
            write_folder(&folder, &[]).expect("it packs");
            check_folder(&folder).expect("packed before");
        }
        assert_eq!(fs::read_to_string(&kept).expect("still there"), "mine");
    }

    /// Packs the program that `cargo test` has built, and runs its first part as on a machine with
    /// a card.
    #[cfg(unix)]
    #[test]
    fn the_adapter_part_runs_from_a_packed_folder() {
        let dir = tempfile::tempdir().expect("a folder");
        let folder = dir.path().join("packed");
        // This test is `target/debug/deps/..`.
        let this = std::env::current_exe().expect("it has a place");
        let debug = this.ancestors().nth(2).expect("two folders");
        let program = debug.join("xtask-measure");
        assert!(
            program.is_file(),
            "build it first: cargo build --package xtask-measure"
        );
        write_folder(&folder, &[("xtask-measure".to_owned(), program)]).expect("it packs");
        let mut script = Command::new("bash");
        script.arg(folder.join("run.sh")).arg("adapter");
        let output = adapter::with_runtime_dir(&mut script)
            .expect("a folder")
            .current_dir(dir.path())
            .output()
            .expect("bash is there");
        let printed = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success(), "{printed}");
        let card = fs::read_to_string(folder.join("results/card.json")).expect("figures");
        let card: serde_json::Value = serde_json::from_str(&card).expect("JSON");
        for known in ["adapter", "driver", "grid", "fusing", "limits"] {
            assert!(!card[known].is_null(), "{known}: {printed}");
        }
        assert_eq!(card["commit"].as_str().map(str::to_owned), commit(root()));
        assert!(
            card["times"].is_null() && card["prices"].is_null(),
            "{card}"
        );
    }
}
