//! Runs other programs.

use anyhow::{Context as _, Result, bail};
use std::{
    ffi::OsString,
    path::{Path, PathBuf},
    process::Command,
};

/// Error for wrong usage, such as an unknown name; the program ends with code 2.
#[derive(Debug)]
pub(crate) struct Usage(pub(crate) String);

impl std::fmt::Display for Usage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Usage {}

/// Returns the cargo that runs this program.
pub(crate) fn cargo() -> Command {
    let mut command =
        Command::new(std::env::var_os("CARGO").unwrap_or_else(|| OsString::from("cargo")));
    command.current_dir(root());
    command
}

/// Returns the repository's top folder.
pub(crate) fn root() -> &'static Path {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    package.ancestors().nth(2).unwrap_or(package)
}

/// Returns cargo's description of the workspace.
pub(crate) fn metadata() -> Result<serde_json::Value> {
    let arguments = ["metadata", "--format-version", "1", "--no-deps"];
    let output = cargo().args(arguments).output()?;
    serde_json::from_slice(&output.stdout).context("cargo metadata is not JSON")
}

/// Returns cargo's target folder.
pub(crate) fn target_folder() -> Result<PathBuf> {
    let metadata = metadata()?;
    let folder = metadata["target_directory"].as_str();
    let folder = folder.context("cargo metadata names no target folder")?;
    Ok(PathBuf::from(folder))
}

/// Returns a command of one of our programs, which cargo has built next to this one.
pub(crate) fn sibling_program(name: &str) -> Result<Command> {
    let program = std::env::current_exe().context("the path of this program is unknown")?;
    Ok(Command::new(program.with_file_name(format!(
        "{name}{}",
        std::env::consts::EXE_SUFFIX
    ))))
}

/// Runs a program to its end.
pub(crate) fn run(command: &mut Command) -> Result<()> {
    let line = spell(command);
    let status = command
        .status()
        .with_context(|| format!("`{line}` did not start"))?;
    if !status.success() {
        bail!("`{line}` ended with {status}");
    }
    Ok(())
}

/// Returns a command line as typed in a shell.
pub(crate) fn spell(command: &Command) -> String {
    let mut words = Vec::new();
    for word in std::iter::once(command.get_program()).chain(command.get_args()) {
        let word = word.to_string_lossy();
        words.push(if word.ends_with("/cargo") {
            "cargo".to_owned()
        } else {
            word.into_owned()
        });
    }
    words.join(" ")
}
