//! The command line.

use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;

/// Keeps umbrage in order: tests, house style, golden images, all that a change has to pass, the
/// viewer's page and the site.
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
    /// Make golden images anew, after you have looked at what changed
    Bless(BlessOptions),
    /// Measure functions and files, and refuse what house style refuses
    #[command(after_help = "Examples:\n  cargo xtask tidy")]
    Tidy,
    /// Run tests, tidy, format, clippy, docs and packaging
    Ci(CiOptions),
    /// Pack what measures a graphics card, for a machine without a compiler or network
    Card(PackOptions),
    /// Build the viewer for browsers, and serve it
    Web(WebOptions),
    /// Build the documentation as a site with the viewer in it, and serve it
    Site(SiteOptions),
    /// Run what a release has to pass besides `ci`: the oldest Rust, licences and advisories,
    /// versions, Miri, publishing
    ReleaseCheck(ReleaseOptions),
}

#[derive(Args, Clone, Debug, PartialEq)]
#[command(after_help = "Examples:
  cargo xtask test                                  where there is a graphics adapter
  cargo xtask test --install-driver                 where there may be none, as in a container
  cargo xtask test --drivers all                    all that compares an adapter with the CPU, under each model of a driver
  cargo xtask test -- -p umbrage-core light_space   further arguments go to `cargo test`")]
pub(crate) struct TestOptions {
    /// Where no graphics adapter is found, install a software driver (Debian and Ubuntu, as root or
    /// with sudo); and fetch a second one, SwiftShader, into cargo's target folder (Debian)
    #[arg(long)]
    pub(crate) install_driver: bool,
    /// How much runs under each model of a driver that rounds otherwise, and on SwiftShader
    #[arg(long, value_name = "HOW", value_enum, default_value = "tenth")]
    pub(crate) drivers: DriverTests,
    /// Fail unless the adapter is the software driver on which the backends promise the same bits;
    /// else other drivers are compared by decided pixels
    #[arg(long)]
    pub(crate) pinned_driver: bool,
    /// Further arguments of `cargo test`
    #[arg(last = true, value_name = "ARGUMENT")]
    pub(crate) arguments: Vec<String>,
}

/// What runs under models of drivers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum DriverTests {
    /// A fixed tenth of the cases, and all that failed once
    Tenth,
    /// All tests that compare an adapter with the CPU
    All,
}

#[derive(Args, Clone, Debug, PartialEq)]
#[command(after_help = "Examples:
  cargo xtask bless            say which golden images differ from what is rendered now
  cargo xtask bless cubes.pcf  write that one anew
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
  cargo xtask ci                    all of it
  cargo xtask ci --after-tests      all but the tests, which `cargo xtask test` has just run")]
pub(crate) struct CiOptions {
    /// Leave out the tests
    #[arg(long)]
    pub(crate) after_tests: bool,
    /// As `cargo xtask test --pinned-driver`
    #[arg(long, conflicts_with = "after_tests")]
    pub(crate) pinned_driver: bool,
    /// As `cargo xtask test --install-driver`
    #[arg(long, conflicts_with = "after_tests")]
    pub(crate) install_driver: bool,
}

#[derive(Args, Clone, Debug, PartialEq)]
#[command(after_help = "Examples:
  cargo xtask card --pack card    programs, Vulkan's loader and run.sh in the folder `card`")]
pub(crate) struct PackOptions {
    /// Folder that is packed; it is made if need be
    #[arg(long, value_name = "FOLDER")]
    pub(crate) pack: PathBuf,
}

/// Whether and where what was built is served.
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
  cargo xtask web --port 8123          at another port; 0 for one that is free
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
  cargo xtask site --without-viewer     the pages alone: seconds instead of minutes
  cargo xtask site --port 8123          at another port; 0 for one that is free
  cargo xtask site --no-serve --out www only build it, into the folder www")]
pub(crate) struct SiteOptions {
    #[command(flatten)]
    pub(crate) serve: ServeOptions,
    /// Folder that the site is written into, a new one or one with an earlier site; else `site` in
    /// cargo's target folder
    #[arg(long, value_name = "FOLDER")]
    pub(crate) out: Option<PathBuf>,
    /// Leave out the viewer: its page says so, and shows a picture
    #[arg(long)]
    pub(crate) without_viewer: bool,
}

#[derive(Args, Clone, Debug, PartialEq)]
#[command(after_help = "Examples:
  cargo xtask release-check                   all of it
  cargo xtask release-check --only licences   one step")]
pub(crate) struct ReleaseOptions {
    /// Run these steps alone
    #[arg(long, value_name = "STEP", value_enum, value_delimiter = ',')]
    pub(crate) only: Vec<ReleaseStep>,
}

/// What a release has to pass besides `ci`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum ReleaseStep {
    /// The workspace compiles with the oldest Rust that it names
    OldestRust,
    /// `cargo deny check`: licences, advisories, sources and bans
    Licences,
    /// `cargo semver-checks` against the last release
    Versions,
    /// Tests of umbrage-core in Miri, those that end within minutes
    Miri,
    /// `cargo publish --dry-run` of every published package
    Publish,
    /// The viewer's lints and tests, and its window and page played with keys and a mouse: Xvfb,
    /// Chromium, Python
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
