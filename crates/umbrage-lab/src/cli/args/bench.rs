//! Arguments of `bench`.

use super::Backend;
use clap::Args;

#[derive(Args, Clone, Debug, PartialEq)]
#[command(after_help = "Examples:
  cargo xtask bench               every ratio, medians of 20 runs taken in turn
  cargo xtask bench --runs 100    the same, steadier
  cargo xtask bench --plans       planning against drawing, in all scenes with content
  cargo xtask bench --plans nave  the same in one of them
  cargo xtask bench --lists nave  lists of casters against hard maps and rays, in one scene
  cargo xtask bench --soft --runs 2 nave-soft    points of a wide light against rays with the same error
  cargo xtask bench --costs       what a texel, a tap, a ray costs here: prices for deterministic costs
  cargo xtask bench --costs --backend wgpu         those of the graphics adapter alone, within a minute on a card
  cargo xtask bench --costs --write prices.toml    the same, kept for `compare --prices` and `plan --prices`")]
pub(crate) struct BenchArguments {
    /// Measure the prices of work on this machine instead
    #[arg(long)]
    pub(crate) costs: bool,
    /// With --costs: whose prices are measured; the others stay the built-in ones
    #[arg(
        long,
        value_name = "NAME",
        default_value = "available",
        requires = "costs"
    )]
    pub(crate) backend: Backend,
    /// Write the prices to this file, for `--prices` of `compare` and `plan`
    #[arg(long, value_name = "FILE", requires = "costs")]
    pub(crate) write: Option<std::path::PathBuf>,
    /// Time planning against drawing instead, on the CPU
    #[arg(long, conflicts_with = "costs", group = "of_scenes")]
    pub(crate) plans: bool,
    /// Time the lists of `exact` against hard maps and rays instead
    #[arg(long, conflicts_with = "costs", group = "of_scenes")]
    pub(crate) lists: bool,
    /// Time `soft` against rays with the same error instead
    #[arg(long, conflicts_with = "costs", group = "of_scenes")]
    pub(crate) soft: bool,
    /// With `--plans`, `--lists` or `--soft`: the built-in scenes; all large ones if none is named
    #[arg(value_name = "SCENE", requires = "of_scenes")]
    pub(crate) scenes: Vec<String>,
    /// Runs of each side; their medians are compared
    #[arg(long, value_name = "COUNT", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) runs: u32,
}
