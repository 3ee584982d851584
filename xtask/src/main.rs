//! Starts the repository's commands. Most are part of one of two programs, which are built on first
//! use: `xtask-measure` (optimised) and `xtask-upkeep`. One is a program of its own, `umbrage-sun`.

#[path = "../../crates/umbrage-lab/src/print.rs"]
#[macro_use]
mod print;

mod commands;
mod help;

use commands::{COMMANDS, Program, XtaskCommand};
use std::{
    env,
    ffi::OsString,
    path::{Path, PathBuf},
    process::{self, ExitCode},
};

/// Exit code for wrong usage.
const WRONG_USAGE: u8 = 2;

fn main() -> ExitCode {
    let arguments: Vec<OsString> = env::args_os().skip(1).collect();
    let Some(name) = arguments.first() else {
        eprintln!("{}", help::overview());
        return ExitCode::from(WRONG_USAGE);
    };
    if name == "--help" || name == "-h" {
        println!("{}", help::overview());
        return ExitCode::SUCCESS;
    }
    let Some(command) = COMMANDS.iter().find(|command| name == command.name) else {
        eprintln!("{}", help::unknown(&name.to_string_lossy()));
        return ExitCode::from(WRONG_USAGE);
    };
    let command = &command.for_arguments(&arguments[1..]);
    let built = is_built(command.program);
    if !built && let Some(answer) = help::before_building(command, &arguments[1..]) {
        return answer;
    }
    match run(command, built, &arguments) {
        Ok(code) => process::exit(code),
        Err(error) => {
            eprintln!("error: cannot start cargo: {error}; install Rust from https://rustup.rs");
            ExitCode::FAILURE
        }
    }
}

/// Builds the command's program if needed, runs it, and returns its exit code.
fn run(command: &XtaskCommand, built: bool, arguments: &[OsString]) -> std::io::Result<i32> {
    let mut cargo = process::Command::new(cargo());
    cargo.arg("run").args(command.program.profile());
    cargo.args(command.program.package());
    cargo
        .arg("--manifest-path")
        .arg(repository().join("Cargo.toml"));
    // `umbrage-sun` has no commands: drop the name.
    let first = usize::from(command.program == Program::Sun);
    cargo.arg("--").args(&arguments[first..]);
    if built {
        cargo.env("CARGO_TERM_QUIET", "true");
    } else if command.program == Program::Sun {
        println!("building umbrage-sun (release): this takes some minutes the first time");
    } else if command.program == Program::Measure {
        println!("building the benchmark tools (release): this takes some minutes the first time");
    }
    let status = cargo.status()?;
    Ok(status.code().unwrap_or(1))
}

/// Returns the cargo that runs this program.
fn cargo() -> OsString {
    env::var_os("CARGO").unwrap_or_else(|| OsString::from("cargo"))
}

fn repository() -> &'static Path {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    package.parent().unwrap_or(package)
}

/// Reports whether the program has been built before. Cargo puts it into a folder next to this
/// program's, or into the same one.
fn is_built(program: Program) -> bool {
    let file = format!("{}{}", program.name(), env::consts::EXE_SUFFIX);
    target_folder().is_some_and(|target| target.join(program.folder()).join(file).is_file())
}

/// Returns cargo's target folder: this program is `target/debug/xtask`.
fn target_folder() -> Option<PathBuf> {
    let this = env::current_exe().ok()?;
    let profile = this.parent()?;
    Some(profile.parent()?.to_owned())
}
