//! Third-party programs that commands need: each of one version, installed into cargo's target
//! folder when it is first used. CI uses none of them.

use crate::run::{cargo, run};
use anyhow::{Context as _, Result};
use std::{
    path::{Path, PathBuf},
    process::Command,
};

/// A program that cargo can install.
pub(crate) struct Tool<'a> {
    /// The name of its package.
    pub(crate) package: &'a str,
    /// What it is called on the command line.
    pub(crate) program: &'a str,
    pub(crate) version: &'a str,
    /// What it is needed for, and why in that version, for the one who waits.
    pub(crate) reason: &'a str,
    /// Minutes that installing takes on two cores.
    pub(crate) minutes: u32,
    /// Further options of `cargo install`.
    pub(crate) options: &'a [&'a str],
}

impl Tool<'_> {
    /// Returns the program: the one in the target folder or on the PATH if either is of that
    /// version; else installs it.
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
            // Mirrors of crates.io may lack what was locked.
            println!(
                "{error:#}, as told above; trying again with the newest releases of what {program} depends on instead of those it was \
                 locked to"
            );
            install(&["--force"]).with_context(|| {
                format!("put {program} {version} on the PATH by hand, or connect to crates.io")
            })?;
            println!("{program} {version} is installed");
        }
        Ok(own)
    }
}

/// Returns whether a program is there, and is of that version.
fn is_version(program: &Path, version: &str) -> bool {
    let Ok(output) = Command::new(program).arg("--version").output() else {
        return false;
    };
    names_version(&String::from_utf8_lossy(&output.stdout), version)
}

/// Returns whether what a program says of itself, such as `mdbook v0.5.4`, names that version.
fn names_version(said: &str, version: &str) -> bool {
    said.split_whitespace()
        .nth(1)
        .is_some_and(|word| word.trim_start_matches('v') == version)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_are_told_with_and_without_a_letter() {
        assert!(names_version("wasm-bindgen 0.2.130\n", "0.2.130"));
        assert!(names_version("mdbook v0.5.4\n", "0.5.4"));
        assert!(!names_version("mdbook v0.5.40\n", "0.5.4"));
        assert!(!names_version("mdbook", "0.5.4"));
        assert!(!is_version(Path::new("no-such-program"), "1.0.0"));
    }
}
