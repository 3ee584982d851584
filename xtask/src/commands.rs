//! The list of commands, and the program of each.

use std::ffi::OsString;

/// A command of `cargo xtask`.
#[derive(Clone, Copy)]
pub(crate) struct XtaskCommand {
    pub(crate) name: &'static str,
    pub(crate) summary: &'static str,
    pub(crate) program: Program,
    /// Text of `--help`, if it is kept in a file, which the program's test writes.
    pub(crate) help: Option<&'static str>,
}

/// A program that implements commands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Program {
    /// The measuring program, which is built optimised.
    Measure,
    /// The program that tests and checks.
    Upkeep,
}

impl Program {
    /// Returns the name of the package, and of its program.
    pub(crate) fn package(self) -> &'static str {
        match self {
            Self::Measure => "xtask-measure",
            Self::Upkeep => "xtask-upkeep",
        }
    }

    /// Returns cargo's option for the profile that the program is built in.
    pub(crate) fn profile(self) -> &'static [&'static str] {
        match self {
            Self::Measure => &["--profile", "measure"],
            Self::Upkeep => &[],
        }
    }

    /// Returns the folder in cargo's target folder for that profile.
    pub(crate) fn folder(self) -> &'static str {
        match self {
            Self::Measure => "measure",
            Self::Upkeep => "debug",
        }
    }
}

impl XtaskCommand {
    /// Returns the command with the program for these arguments: `card --pack` builds programs, so
    /// it is part of the other program.
    pub(crate) fn for_arguments(&self, arguments: &[OsString]) -> Self {
        let is_pack = |argument: &OsString| {
            let text = argument.to_string_lossy();
            text == "--pack" || text.starts_with("--pack=")
        };
        if self.name == "card" && arguments.iter().any(is_pack) {
            return upkeep(self.name, self.summary);
        }
        *self
    }
}

const fn measure(name: &'static str, summary: &'static str, help: &'static str) -> XtaskCommand {
    XtaskCommand {
        name,
        summary,
        program: Program::Measure,
        help: Some(help),
    }
}

const fn upkeep(name: &'static str, summary: &'static str) -> XtaskCommand {
    XtaskCommand {
        name,
        summary,
        program: Program::Upkeep,
        help: None,
    }
}

pub(crate) const COMMANDS: [XtaskCommand; 16] = [
    measure(
        "compare",
        "Measure techniques on scenes: speed, and error against ray-traced truth",
        include_str!("../help/compare.snap"),
    ),
    measure(
        "stability",
        "Run the failure tests: where each technique passes, degrades or fails",
        include_str!("../help/stability.snap"),
    ),
    measure(
        "plan",
        "Plan the cheapest technique for a scene within bounds of error, time or memory",
        include_str!("../help/plan.snap"),
    ),
    measure(
        "which",
        "Write recommendations by light, size, motion and budget, from measured results",
        include_str!("../help/which.snap"),
    ),
    measure(
        "bias",
        "Compare the default bias with the best manually tuned one",
        include_str!("../help/bias.snap"),
    ),
    measure(
        "merge",
        "Join the reports of the shards of a comparison",
        include_str!("../help/merge.snap"),
    ),
    measure(
        "bench",
        "Time the CPU backend, the wgpu backend and ray tracing against reference implementations",
        include_str!("../help/bench.snap"),
    ),
    measure(
        "card",
        "Measure a graphics card: its rounding, agreement with the CPU, and frame times",
        include_str!("../help/card.snap"),
    ),
    measure(
        "wgsl",
        "Print the shader text of a technique, to paste into a shader",
        include_str!("../help/wgsl.snap"),
    ),
    upkeep("test", "Run all tests, with a graphics adapter"),
    upkeep(
        "bless",
        "Write golden images again, after you have reviewed the changes",
    ),
    upkeep(
        "tidy",
        "Check the style: sizes of functions and files, names and text",
    ),
    upkeep("ci", "Run tests, tidy, format, clippy, docs and packaging"),
    upkeep("web", "Build the viewer for browsers, and serve it"),
    upkeep(
        "site",
        "Build the documentation as a site with the viewer in it, and serve it",
    ),
    upkeep(
        "release-check",
        "Run the release checks in addition to `ci`: oldest Rust, licences, versions, Miri, publishing",
    ),
];
