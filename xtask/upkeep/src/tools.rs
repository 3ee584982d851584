//! Third-party programs that commands need. Each has a fixed version, and is installed into cargo's
//! target folder on first use. CI uses none of them.

use crate::run::{cargo, run};
use anyhow::{Context as _, Result};
use std::{
    path::{Path, PathBuf},
    process::Command,
};

/// A program that cargo can install.
pub(crate) struct Tool<'a> {
    /// Name of its package.
    pub(crate) package: &'a str,
    /// Name on the command line.
    pub(crate) program: &'a str,
    pub(crate) version: &'a str,
    /// Purpose and reason for the version, for the user who waits.
    pub(crate) reason: &'a str,
    /// Duration of the installation on two cores, minutes.
    pub(crate) minutes: u32,
    /// Additional options of `cargo install`.
    pub(crate) options: &'a [&'a str],
}

impl Tool<'_> {
    /// Returns the program in the target folder or on the PATH if it has this version; otherwise
    /// installs it.
    pub(crate) fn find_or_install(&self, target: &Path) -> Result<PathBuf> {
        let tools = target.join("tools");
        let name = format!("{}{}", self.program, std::env::consts::EXE_SUFFIX);
        let own = tools.join("bin").join(name);
        for program in [own.clone(), PathBuf::from(self.program)] {
            if is_version(&program, self.version) {
                return Ok(program);
            }
        }
        let Self {
            program,
            version,
            minutes,
            reason,
            ..
        } = self;
        println!(
            "installing {program} {version} into {}, once: about {minutes} min on two cores; {reason}",
            tools.display()
        );
        let install = |how: &[&str]| {
            let mut install = cargo();
            install.args(["install", self.package, "--version", version]);
            install.args(self.options);
            run(install.args(how).arg("--root").arg(&tools))
        };
        if let Err(error) = install(&["--force", "--locked"]) {
            // Mirrors of crates.io may lack locked versions.
            println!(
                "{error:#}, as printed above; trying again with the newest dependencies of {program} instead of the locked ones"
            );
            install(&["--force"]).with_context(|| {
                format!("put {program} {version} on the PATH, or connect to crates.io")
            })?;
            println!("{program} {version} is installed");
        }
        Ok(own)
    }
}

/// Reports whether a program exists and has that version.
fn is_version(program: &Path, version: &str) -> bool {
    let Ok(output) = Command::new(program).arg("--version").output() else {
        return false;
    };
    names_version(&String::from_utf8_lossy(&output.stdout), version)
}

/// Reports whether a program's version output, such as `mdbook v0.5.4`, contains that version.
fn names_version(said: &str, version: &str) -> bool {
    said.split_whitespace()
        .nth(1)
        .is_some_and(|word| word.trim_start_matches('v') == version)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_are_reported_with_and_without_a_letter() {
        assert!(names_version("wasm-bindgen 0.2.130\n", "0.2.130"));
        assert!(names_version("mdbook v0.5.4\n", "0.5.4"));
        assert!(!names_version("mdbook v0.5.40\n", "0.5.4"));
        assert!(!names_version("mdbook", "0.5.4"));
        assert!(!is_version(Path::new("no-such-program"), "1.0.0"));
    }
}
