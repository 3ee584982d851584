//! The one list of commands, and which program each is part of.

use std::ffi::OsString;

/// A command of `cargo xtask`.
#[derive(Clone, Copy)]
pub(crate) struct Command {
    pub(crate) name: &'static str,
    pub(crate) summary: &'static str,
    pub(crate) program: Program,
    /// What `--help` prints, where it is kept in a file: as its program's test wrote it.
    pub(crate) help: Option<&'static str>,
}

/// A program behind commands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Program {
    /// Measures, and so is optimised.
    Measure,
    /// Tests and checks.
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

impl Command {
    /// Returns the command with the program that these arguments are for: `card --pack` builds, and
    /// so is part of the other program.
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

const fn measure(name: &'static str, summary: &'static str, help: &'static str) -> Command {
    Command {
        name,
        summary,
        program: Program::Measure,
        help: Some(help),
    }
}

const fn upkeep(name: &'static str, summary: &'static str) -> Command {
    Command {
        name,
        summary,
        program: Program::Upkeep,
        help: None,
    }
}

pub(crate) const COMMANDS: [Command; 16] = [
    measure(
        "compare",
        "Measure techniques on scenes: speed, and error against ray-traced truth",
        include_str!("../help/compare.snap"),
    ),
    measure(
        "stability",
        "Play the catalogue of failures: where each technique passes, degrades or fails",
        include_str!("../help/stability.snap"),
    ),
    measure(
        "plan",
        "Find the least that a scene needs: the cheapest technique within an error, time or memory",
        include_str!("../help/plan.snap"),
    ),
    measure(
        "which",
        "Write which technique to use by light, size, motion and budget, from what was measured",
        include_str!("../help/which.snap"),
    ),
    measure(
        "bias",
        "Compare the default bias with the best that could be tuned by hand",
        include_str!("../help/bias.snap"),
    ),
    measure(
        "merge",
        "Join the reports of a comparison's shards",
        include_str!("../help/merge.snap"),
    ),
    measure(
        "bench",
        "Time the CPU backend, the wgpu backend and ray tracing against their yardsticks",
        include_str!("../help/bench.snap"),
    ),
    measure(
        "card",
        "Measure a graphics card: how it rounds, whether it agrees with the CPU, how long it takes",
        include_str!("../help/card.snap"),
    ),
    measure(
        "wgsl",
        "Print the shader text of a technique, as it is pasted into a shader",
        include_str!("../help/wgsl.snap"),
    ),
    upkeep("test", "Run all tests, with a graphics adapter"),
    upkeep(
        "bless",
        "Make golden images anew, after you have looked at what changed",
    ),
    upkeep(
        "tidy",
        "Measure functions and files, and refuse what house style refuses",
    ),
    upkeep("ci", "Run tests, tidy, format, clippy, docs and packaging"),
    upkeep("web", "Build the viewer for browsers, and serve it"),
    upkeep(
        "site",
        "Build the documentation as a site with the viewer in it, and serve it",
    ),
    upkeep(
        "release-check",
        "Run what a release has to pass besides `ci`: oldest Rust, licences, versions, Miri, publishing",
    ),
];
