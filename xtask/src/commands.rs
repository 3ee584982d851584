//! The list of commands, and the program of each.

use std::ffi::OsString;

/// A command of `cargo xtask`.
#[derive(Clone, Copy)]
pub(crate) struct XtaskCommand {
    pub(crate) name: &'static str,
    pub(crate) program: Program,
    /// Text of `--help` as a snapshot, which a test of the measuring program writes. For the other
    /// program, only the first line.
    kept_help: &'static str,
}

/// A program that implements commands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Program {
    /// The measuring program, which is built optimised.
    Measure,
    /// The program that tests and checks.
    Upkeep,
    /// The program `umbrage-sun`, which is a command of its own.
    Sun,
}

impl Program {
    /// Returns the name of the program.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Measure => "xtask-measure",
            Self::Upkeep => "xtask-upkeep",
            Self::Sun => "umbrage-sun",
        }
    }

    /// Returns cargo's options for the program's package.
    pub(crate) fn package(self) -> &'static [&'static str] {
        match self {
            Self::Measure => &["--package", "xtask-measure"],
            Self::Upkeep => &["--package", "xtask-upkeep"],
            Self::Sun => &["--package", "umbrage-surfaces", "--features", "cli"],
        }
    }

    /// Returns cargo's option for the profile that the program is built in.
    pub(crate) fn profile(self) -> &'static [&'static str] {
        match self {
            Self::Measure | Self::Sun => &["--profile", "measure"],
            Self::Upkeep => &[],
        }
    }

    /// Returns the folder in cargo's target folder for that profile.
    pub(crate) fn folder(self) -> &'static str {
        match self {
            Self::Measure | Self::Sun => "measure",
            Self::Upkeep => "debug",
        }
    }
}

impl XtaskCommand {
    /// Returns the kept text of `--help`, without a snapshot's header between two lines of dashes.
    pub(crate) fn help(&self) -> &'static str {
        let after_header = self.kept_help.splitn(3, "---\n").nth(2);
        after_header.unwrap_or(self.kept_help)
    }

    /// Returns the first line of `--help`.
    pub(crate) fn summary(&self) -> &'static str {
        self.help().lines().next().unwrap_or_default()
    }

    /// Returns the command with the program for these arguments: `card --pack` builds programs, so
    /// it is part of the other program.
    pub(crate) fn for_arguments(&self, arguments: &[OsString]) -> Self {
        let is_pack = |argument: &OsString| {
            let text = argument.to_string_lossy();
            text == "--pack" || text.starts_with("--pack=")
        };
        if self.name == "card" && arguments.iter().any(is_pack) {
            return upkeep(self.name, self.summary());
        }
        *self
    }
}

const fn measure(name: &'static str, snapshot: &'static str) -> XtaskCommand {
    XtaskCommand {
        name,
        program: Program::Measure,
        kept_help: snapshot,
    }
}

const fn upkeep(name: &'static str, summary: &'static str) -> XtaskCommand {
    XtaskCommand {
        name,
        program: Program::Upkeep,
        kept_help: summary,
    }
}

pub(crate) const COMMANDS: [XtaskCommand; 17] = [
    measure("compare", include_str!("../help/compare.snap")),
    measure("stability", include_str!("../help/stability.snap")),
    measure("plan", include_str!("../help/plan.snap")),
    measure("which", include_str!("../help/which.snap")),
    measure("bias", include_str!("../help/bias.snap")),
    measure("merge", include_str!("../help/merge.snap")),
    measure("bench", include_str!("../help/bench.snap")),
    measure("card", include_str!("../help/card.snap")),
    measure("wgsl", include_str!("../help/wgsl.snap")),
    XtaskCommand {
        name: "sun",
        program: Program::Sun,
        kept_help: "Hours of sun and lit areas of a model's facets, as numbers (`umbrage-sun`)",
    },
    upkeep("test", "Run all tests, with a graphics adapter"),
    upkeep(
        "bless",
        "Write golden images again, after you have reviewed the changes",
    ),
    upkeep(
        "tidy",
        "Check the style: sizes of functions and files, names and text",
    ),
    upkeep(
        "ci",
        "Run tests, tidy, format, clippy, browser, doc and wheel",
    ),
    upkeep("web", "Build the viewer for browsers, and serve it"),
    upkeep(
        "site",
        "Build the documentation as a site with the viewer in it, and serve it",
    ),
    upkeep(
        "release-check",
        "Run the checks of a release in addition to `ci`: oldest Rust, licences, versions, publishing",
    ),
];
