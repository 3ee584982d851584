//! Arguments of `plan`.

use super::parse_size;
use clap::{Args, ValueEnum};
use std::path::PathBuf;

#[derive(Args, Clone, Debug, PartialEq)]
#[command(after_help = "Examples:
  cargo xtask plan cubes --max-error 0.05             the cheapest within an error
  cargo xtask plan lamp.toml --max-time 2             the most accurate within a time
  cargo xtask plan lamp.toml --max-error 0.05 --light 2
  cargo xtask plan model.obj --max-error 0.05 --max-bytes 4194304 --backend wgpu
  cargo xtask plan street --max-error 0.1 --prices my-gpu.toml --backend wgpu
  cargo xtask plan --regret                           are plans right? against sweeps of the suite
  cargo xtask plan --regret cubes --errors 0.05,0.1   the same: one scene, two bounds")]
pub(crate) struct PlanArguments {
    /// Built-in scene by name, scene file (.toml) or model (.obj); with --regret any number, none: the suite
    #[arg(value_name = "SCENE", required_unless_present = "regret")]
    pub(crate) scenes: Vec<String>,
    /// Greatest error: root mean square of visibility less truth, 0 to 1
    #[arg(long, value_name = "E", value_parser = parse_error)]
    pub(crate) max_error: Option<f64>,
    /// Greatest time of shadows a frame, milliseconds, as the backend's prices predict it
    #[arg(long = "max-time", value_name = "MS", value_parser = parse_ms)]
    pub(crate) max_ms: Option<f64>,
    /// Most bytes of maps and tables
    #[arg(long, value_name = "B")]
    pub(crate) max_bytes: Option<u64>,
    /// Whose prices count
    #[arg(long, value_name = "NAME", default_value = "cpu")]
    pub(crate) backend: PlanBackend,
    /// Prices of work, as `bench --costs --write` measures them; else the built-in ones
    #[arg(long, value_name = "FILE")]
    pub(crate) prices: Option<PathBuf>,
    /// Which of the scene's lights, from 1; with --regret all of them
    #[arg(long, value_name = "NUMBER", default_value_t = 1, conflicts_with = "regret", value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) light: u16,
    /// Image size in pixels; else the scene's own
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub(crate) size: Option<[u32; 2]>,
    /// Receivers sampled under lights with an extent; four times as many under others
    #[arg(long, value_name = "COUNT", default_value_t = 4096, value_parser = clap::value_parser!(u32).range(64..=1_048_576))]
    pub(crate) samples: u32,
    /// Which sample; the same seed gives the same plan
    #[arg(long, value_name = "NUMBER", default_value_t = 1)]
    pub(crate) seed: u32,
    /// Folder for SCENE.preset.toml, SCENE.plan.json, SCENE.bias.csv and .svg; else target/plan in the repository
    #[arg(long, value_name = "FOLDER")]
    pub(crate) out: Option<PathBuf>,
    /// Compare plans with exhaustive sweeps over full images: bounds kept, and cost over the cheapest
    #[arg(long, conflicts_with_all = ["max_error", "max_ms", "max_bytes"])]
    pub(crate) regret: bool,
    /// Errors asked for with --regret
    #[arg(long, value_name = "E", value_delimiter = ',', value_parser = parse_error, default_values_t = [0.02, 0.05, 0.1], requires = "regret")]
    pub(crate) errors: Vec<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum PlanBackend {
    /// The CPU backend's
    Cpu,
    /// The wgpu backend's, on a software driver
    Wgpu,
}

fn parse_error(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(error) if (0.0..=1.0).contains(&error) => Ok(error),
        _ => Err("write a number from 0 to 1, such as 0.05".to_owned()),
    }
}

fn parse_ms(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(ms) if ms >= 0.0 && ms.is_finite() => Ok(ms),
        _ => Err("write milliseconds, 0 or more".to_owned()),
    }
}
