//! The command line.

use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;

/// Runs umbrage's development tasks: tests, style checks, golden images, all checks of a change,
/// the viewer's page and the site.
#[derive(Debug, Parser)]
#[command(
    name = "cargo xtask",
    bin_name = "cargo xtask",
    disable_help_subcommand = true
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Run all tests, with a graphics adapter
    Test(TestOptions),
    /// Write golden images again, after you have reviewed the changes
    Bless(BlessOptions),
    /// Check the style: sizes of functions and files, names and text
    #[command(after_help = "Examples:\n  cargo xtask tidy")]
    Tidy,
    /// Run tests, tidy, format, clippy, browser, doc and wheel
    Ci(CiOptions),
    /// Pack the programs that measure a graphics card, for a machine without a compiler or network
    Card(PackOptions),
    /// Build the viewer for browsers, and serve it
    Web(WebOptions),
    /// Build the documentation as a site with the viewer in it, and serve it
    Site(SiteOptions),
    /// Run the checks of a release in addition to `ci`: oldest Rust, licences, versions, publishing
    ReleaseCheck(ReleaseOptions),
}

#[derive(Args, Clone, Debug, PartialEq)]
#[command(after_help = "Examples:
  cargo xtask test                                  with the installed graphics adapter
  cargo xtask test --install-driver                 install a software driver if needed, as in a container
  cargo xtask test --drivers all                    all tests that compare an adapter with the CPU, under each driver model
  cargo xtask test -- -p umbrage-core light_space   further arguments go to `cargo test`")]
pub(crate) struct TestOptions {
    /// If there is no graphics adapter, install a software driver (Debian and Ubuntu, as root or
    /// with sudo). Also fetch a second one, SwiftShader, into cargo's target folder (Debian)
    #[arg(long)]
    pub(crate) install_driver: bool,
    /// Tests to run under each model of a driver with other rounding, and on SwiftShader
    #[arg(long, value_name = "HOW", value_enum, default_value = "part")]
    pub(crate) drivers: DriverTests,
    /// Fail unless the adapter is the software driver on which the backends promise the same bits.
    /// Without this option, other drivers are compared by decided pixels
    #[arg(long)]
    pub(crate) pinned_driver: bool,
    /// Further arguments of `cargo test`
    #[arg(last = true, value_name = "ARGUMENT")]
    pub(crate) arguments: Vec<String>,
}

/// Tests to run under driver models.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum DriverTests {
    /// Every tenth case with rewritten shaders, every thirtieth on the second driver, and all cases
    /// that failed once
    Part,
    /// All tests that compare an adapter with the CPU
    All,
}

#[derive(Args, Clone, Debug, PartialEq)]
#[command(after_help = "Examples:
  cargo xtask bless            list the golden images that differ from the current rendering
  cargo xtask bless cubes.pcf  write this one again
  cargo xtask bless --all      write all that differ")]
pub(crate) struct BlessOptions {
    /// Golden images to write, by name
    #[arg(value_name = "NAME")]
    pub(crate) names: Vec<String>,
    /// Write all that differ
    #[arg(long, conflicts_with = "names")]
    pub(crate) all: bool,
}

#[derive(Args, Clone, Debug, PartialEq)]
#[command(after_help = "Examples:
  cargo xtask ci                    all checks
  cargo xtask ci --after-tests      all but the tests, which `cargo xtask test` has just run")]
pub(crate) struct CiOptions {
    /// Skip the tests
    #[arg(long)]
    pub(crate) after_tests: bool,
    /// Same as `cargo xtask test --pinned-driver`
    #[arg(long, conflicts_with = "after_tests")]
    pub(crate) pinned_driver: bool,
    /// Same as `cargo xtask test --install-driver`
    #[arg(long, conflicts_with = "after_tests")]
    pub(crate) install_driver: bool,
}

#[derive(Args, Clone, Debug, PartialEq)]
#[command(after_help = "Examples:
  cargo xtask card --pack card    programs, Vulkan's loader and run.sh in the folder `card`")]
pub(crate) struct PackOptions {
    /// Folder to pack into; created if needed
    #[arg(long, value_name = "FOLDER")]
    pub(crate) pack: PathBuf,
}

/// Options for serving a build.
#[derive(Args, Clone, Debug, PartialEq)]
pub(crate) struct ServeOptions {
    /// Only build it
    #[arg(long)]
    pub(crate) no_serve: bool,
    /// Port of this machine to serve at
    #[arg(
        long,
        value_name = "NUMBER",
        default_value_t = 8000,
        conflicts_with = "no_serve"
    )]
    pub(crate) port: u16,
}

#[derive(Args, Clone, Debug, PartialEq)]
#[command(after_help = "Examples:
  cargo xtask web                      build the page, and serve it at http://localhost:8000/
  cargo xtask web --port 8123          at another port; 0 selects a free one
  cargo xtask web --no-serve --out www only build it, into the folder www")]
pub(crate) struct WebOptions {
    #[command(flatten)]
    pub(crate) serve: ServeOptions,
    /// Folder that the page is written into; else `web` in cargo's target folder
    #[arg(long, value_name = "FOLDER")]
    pub(crate) out: Option<PathBuf>,
}

#[derive(Args, Clone, Debug, PartialEq)]
#[command(after_help = "Examples:
  cargo xtask site                      build the site, and serve it at http://localhost:8000/
  cargo xtask site --without-viewer     only the pages: seconds instead of minutes
  cargo xtask site --port 8123          at another port; 0 selects a free one
  cargo xtask site --no-serve --out www only build it, into the folder www")]
pub(crate) struct SiteOptions {
    #[command(flatten)]
    pub(crate) serve: ServeOptions,
    /// Folder for the site, a new one or one with an earlier site; else `site` in cargo's target
    /// folder
    #[arg(long, value_name = "FOLDER")]
    pub(crate) out: Option<PathBuf>,
    /// Skip the viewer: its page states this and shows an image instead
    #[arg(long)]
    pub(crate) without_viewer: bool,
}

#[derive(Args, Clone, Debug, PartialEq)]
#[command(after_help = "Examples:
  cargo xtask release-check                   all steps
  cargo xtask release-check --only licences   one step")]
pub(crate) struct ReleaseOptions {
    /// Run only these steps
    #[arg(long, value_name = "STEP", value_enum, value_delimiter = ',')]
    pub(crate) only: Vec<ReleaseStep>,
}

/// Release checks in addition to `ci`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum ReleaseStep {
    /// The workspace compiles with the oldest Rust in its manifest
    OldestRust,
    /// `cargo deny check`: licences, advisories, sources and bans
    Licences,
    /// `cargo semver-checks` against the last release, after a control with a removed function
    Versions,
    /// Tests of umbrage-core in Miri that end within minutes
    Miri,
    /// `cargo publish --dry-run` of every published package, and packages for browsers with all
    /// features
    Publish,
    /// The viewer's lints and tests, and end-to-end tests of its window and page with keys and a
    /// mouse: Xvfb, Chromium, Python
    Viewer,
}

#[cfg(test)]
mod tests {
    use super::Cli;
    use clap::{CommandFactory as _, Parser as _};

    #[test]
    fn every_command_shows_examples() {
        for command in Cli::command().get_subcommands() {
            let help = command.clone().render_long_help().to_string();
            let example = format!("Examples:\n  cargo xtask {}", command.get_name());
            assert!(help.contains(&example), "{help}");
        }
    }

    #[test]
    fn the_overview_has_the_first_line_of_each_help() {
        let commands = include_str!("../../src/commands.rs");
        let commands = commands.split_whitespace().collect::<Vec<_>>().join(" ");
        for command in Cli::command().get_subcommands() {
            let name = command.get_name();
            // The overview has `card` with the summary of the measuring program.
            if name != "card" {
                let about = command.get_about().expect("documented");
                let entry = format!("\"{name}\", \"{about}\"");
                assert!(
                    commands.contains(&entry),
                    "xtask/src/commands.rs lacks {entry}"
                );
            }
        }
    }

    #[test]
    fn options_that_exclude_each_other_are_refused() {
        for arguments in [
            &["bless", "--all", "cubes.pcf"][..],
            &["ci", "--after-tests", "--install-driver"],
            &["web", "--no-serve", "--port", "80"],
            &["site", "--no-serve", "--port", "80"],
        ] {
            let error = Cli::try_parse_from(std::iter::once(&"xtask").chain(arguments))
                .expect_err("wrong usage");
            assert_eq!(error.exit_code(), 2, "{arguments:?}");
        }
    }
}
