//! What can be typed.

mod bias;
mod merge;
mod plan;
mod stability;

pub(crate) use bias::BiasOptions;
pub(crate) use merge::{MergeOptions, Shard};
#[cfg(feature = "measure")]
pub(crate) use plan::PlanBackend;
pub(crate) use plan::PlanOptions;
pub(crate) use stability::StabilityOptions;

use clap::{Args, Parser, Subcommand};
use merge::parse_shard;
use std::path::PathBuf;

/// umbrage's own commands.
#[derive(Debug, Parser)]
#[command(
    name = "cargo xtask",
    bin_name = "cargo xtask",
    disable_help_subcommand = true
)]
#[command(after_help = "Examples:
  cargo xtask compare                   every built-in scene, technique and backend: table and report
  cargo xtask stability --quick         where each technique fails: a matrix with pictures
  cargo xtask plan cubes --max-time 2   the best shadows for that scene within two milliseconds
  cargo xtask test --install-driver     all tests, on a software driver if need be
  cargo xtask ci                        all that a change has to pass")]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Measure techniques on scenes: speed, and error against ray-traced truth
    Compare(CompareOptions),
    /// Play the catalogue of failures: where each technique passes, degrades or fails
    Stability(StabilityOptions),
    /// Find the least that a scene needs: the cheapest technique and setting within an error, time or memory
    Plan(PlanOptions),
    /// Compare the default bias with the best that could be tuned by hand
    Bias(BiasOptions),
    /// Join the reports of a comparison's shards
    Merge(MergeOptions),
    /// Run all tests, with a graphics adapter
    Test(TestOptions),
    /// Time the CPU backend, the wgpu backend and ray tracing against their yardsticks
    Bench(BenchOptions),
    /// Make golden images anew, after you have looked at what changed
    Bless(BlessOptions),
    /// Measure functions and files, and refuse what house style refuses
    #[command(after_help = "Examples:\n  cargo xtask tidy")]
    Tidy,
    /// Run tests, tidy, format, clippy, docs and packaging
    Ci(CiOptions),
}

#[derive(Args, Clone, Debug, PartialEq)]
#[command(after_help = "Examples:
  cargo xtask compare                                        the built-in suite
  cargo xtask compare --list                                 what there is to compare
  cargo xtask compare cubes --technique pcf --backend cpu    one scene, technique and backend
  cargo xtask compare lamp.toml model.obj --quick            scenes of your own, small and fast
  cargo xtask compare cubes --size 640x480 --map-sizes 512,2048 --arrays --out report
  cargo xtask compare figure --color --map-sizes 1024        with shaded pictures
  cargo xtask compare --deterministic --shard 2/8 --out s2   an eighth of the suite, for `cargo xtask merge`
  cargo xtask compare --baseline old/results.json            fail if anything got slower or less accurate")]
pub(crate) struct CompareOptions {
    /// Built-in scenes by name, scene files (.toml) or models (.obj); none: the built-in suite
    #[arg(value_name = "SCENE")]
    pub(crate) scenes: Vec<String>,
    /// Only these techniques; may be repeated, or separated by commas
    #[arg(long = "technique", value_name = "NAME", value_delimiter = ',')]
    pub(crate) techniques: Vec<String>,
    /// Which backends play
    #[arg(long, value_name = "NAME", default_value = "available")]
    pub(crate) backend: Backend,
    /// Graphics adapter by part of its name, such as llvmpipe
    #[arg(long, value_name = "NAME")]
    pub(crate) adapter: Option<String>,
    /// Image size in pixels; else each scene's own
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub(crate) size: Option<[u32; 2]>,
    /// Sides of the shadow maps, texels, rising; every setting is compared at the middle one, each technique's first at
    /// all; else 512, 1024 and 2048, or 512 alone with --quick
    #[arg(long, value_name = "SIDE", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(1..=16_384))]
    pub(crate) map_sizes: Vec<u32>,
    /// Truth's rays a pixel for lights with an extent
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u32).range(1..=65_536))]
    pub(crate) samples: Option<u32>,
    /// Timed runs of each row; their median is kept
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) runs: Option<u32>,
    /// Folder for the report; else target/compare in the repository
    #[arg(long, value_name = "FOLDER")]
    pub(crate) out: Option<PathBuf>,
    /// Small images, few samples, few runs: a look rather than a measurement
    #[arg(long)]
    pub(crate) quick: bool,
    /// Write NumPy arrays of truth, distance and every mask, too
    #[arg(long)]
    pub(crate) arrays: bool,
    /// Shade every row in colour, too, and compare the colours between backends
    #[arg(long)]
    pub(crate) color: bool,
    /// No wall-clock times and no date, so that the report is the same, byte for byte, whenever it is made
    #[arg(long, conflicts_with = "runs")]
    pub(crate) deterministic: bool,
    /// Compare with the results.json of an earlier run, kept in another folder than this report's, and fail if anything got
    /// slower or less accurate beyond the noise, is missing or can't be compared any more
    #[arg(long, value_name = "RESULTS.JSON")]
    pub(crate) baseline: Option<PathBuf>,
    /// What may be missing or changed since the baseline: a scene, technique, backend or `technique (settings)`; may be
    /// repeated
    #[arg(long, value_name = "NAME", requires = "baseline")]
    pub(crate) baseline_except: Vec<String>,
    /// Only every N-th scene, from the K-th on; `cargo xtask merge` joins the shards
    #[arg(long, value_name = "K/N", value_parser = parse_shard)]
    pub(crate) shard: Option<Shard>,
    /// Measure every scene anew, even if the folder has it from a run that was stopped
    #[arg(long)]
    pub(crate) fresh: bool,
    /// List scenes and techniques, and end
    #[arg(long)]
    pub(crate) list: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Backend {
    /// The CPU, and wgpu if there is a graphics adapter
    Available,
    /// The CPU alone
    Cpu,
    /// wgpu alone; fails without a graphics adapter
    Wgpu,
    /// Both; fails without a graphics adapter
    Both,
}

#[derive(Args, Clone, Debug, PartialEq)]
#[command(after_help = "Examples:
  cargo xtask test                                  where there is a graphics adapter
  cargo xtask test --install-driver                 where there may be none, as in a container
  cargo xtask test -- -p umbrage-core light_space   further arguments go to `cargo test`")]
pub(crate) struct TestOptions {
    /// Where no graphics adapter is found, install a software driver (Debian and Ubuntu, as root or with sudo); and fetch a second
    /// one, SwiftShader, into cargo's target folder (Debian)
    #[arg(long)]
    pub(crate) install_driver: bool,
    /// Further arguments of `cargo test`
    #[arg(last = true, value_name = "ARGUMENT")]
    pub(crate) arguments: Vec<String>,
}

#[derive(Args, Clone, Debug, PartialEq)]
#[command(after_help = "Examples:
  cargo xtask bench               every ratio, medians of 20 runs taken in turn
  cargo xtask bench --runs 100    the same, steadier
  cargo xtask bench --costs       what a texel, a tap, a ray costs here: prices for deterministic costs")]
pub(crate) struct BenchOptions {
    /// Measure the prices of work on this machine instead
    #[arg(long)]
    pub(crate) costs: bool,
    /// Runs of each side; their medians are compared
    #[arg(long, value_name = "COUNT", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) runs: u32,
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
    /// As `cargo xtask test --install-driver`
    #[arg(long, conflicts_with = "after_tests")]
    pub(crate) install_driver: bool,
}

fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let sides = text
        .split_once('x')
        .and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    match sides {
        Some(size) if size.iter().all(|s| (1..=16_384).contains(s)) => Ok(size),
        Some(_) => Err("each side must be 1 to 16384 pixels".to_owned()),
        None => Err("write width and height like 640x480".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::Cli;
    use clap::{CommandFactory as _, Parser as _};

    /// Every command's help, as `--help` prints it to a terminal of 100 columns.
    #[test]
    fn help() {
        let command = || Cli::command().term_width(100);
        let mut text = command().render_long_help().to_string();
        for name in command().get_subcommands().map(|c| c.get_name().to_owned()) {
            let mut whole = command();
            whole.build();
            let one = whole
                .find_subcommand_mut(&name)
                .map(|c| c.render_long_help().to_string());
            text += &format!("\n==== {name} --help\n{}", one.unwrap_or_default());
        }
        insta::assert_snapshot!(text);
    }

    #[test]
    fn every_command_shows_examples() {
        for command in Cli::command().get_subcommands() {
            let help = command.clone().render_long_help().to_string();
            let example = format!("Examples:\n  cargo xtask {}", command.get_name());
            assert!(help.contains(&example), "{help}");
        }
    }

    /// What wrong usage says.
    #[test]
    fn usage_errors() {
        let wrong: [&[&str]; 16] = [
            &[],
            &["compere"],
            &["compare", "--size", "640"],
            &["compare", "--size", "0x480"],
            &["compare", "--map-sizes", "512,0"],
            &["compare", "--backend", "cuda"],
            &["compare", "--runs", "0"],
            &["plan"],
            &["plan", "cubes", "--max-error", "nan"],
            &["plan", "cubes", "--max-time", "-1"],
            &["plan", "--regret", "--max-error", "0.1"],
            &["compare", "--shard", "9/8"],
            &["compare", "--deterministic", "--runs", "3"],
            &["merge", "s1", "s2"],
            &["bless", "--all", "cubes.pcf"],
            &["ci", "--after-tests", "--install-driver"],
        ];
        let say = |arguments: &[&str]| {
            let error = Cli::try_parse_from(std::iter::once(&"xtask").chain(arguments))
                .expect_err("wrong usage");
            assert_eq!(error.exit_code(), 2, "{arguments:?}");
            format!("$ cargo xtask {}\n{error}\n", arguments.join(" "))
        };
        insta::assert_snapshot!(wrong.map(say).concat());
    }
}
