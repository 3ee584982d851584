//! Arguments of `plan`.

use super::parse_size;
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use umbrage_plan::{Hold, MAX_GRAIN};

#[derive(Args, Clone, Debug, PartialEq)]
#[command(after_help = "Examples:
  cargo xtask plan cubes --max-error 0.05             the cheapest within an error
  cargo xtask plan nave --max-relative-error 0.2      a fifth of what no shadow at all would err by
  cargo xtask plan lamp.toml --max-time 2             the most accurate within a time
  cargo xtask plan night-room --budget-ms 8           all lights of a scene within a time
  cargo xtask plan night-room --budget-error 0.05     all lights within an error, for the least time
  cargo xtask plan street --max-error 0.1 --cameras path.toml --hold 95%
  cargo xtask plan street --max-error 0.1 --still     a camera and a scene at rest: only lookups count
  cargo xtask plan cubes --max-error 0.1 --max-shimmer 0.001
  cargo xtask plan cubes --max-error 0.1 --stability results.json --no-failing-rows
  cargo xtask plan lamp.toml --max-error 0.05 --light 2 --size 1920x1080
  cargo xtask plan model.obj --max-error 0.05 --max-bytes 4194304 --backend wgpu
  cargo xtask plan street --max-error 0.1 --prices my-gpu.toml --backend wgpu
  cargo xtask plan --regret                           are plans right? against sweeps of the suite
  cargo xtask plan --regret cubes --errors 0.05,0.1   the same: one scene, two bounds")]
pub(crate) struct PlanArguments {
    /// Built-in scene by name, scene file (.toml) or model (.obj, .glb, .gltf); with --regret any number, none: the suite
    #[arg(value_name = "SCENE", required_unless_present = "regret")]
    pub(crate) scenes: Vec<String>,
    /// Greatest error: root mean square of visibility less truth, 0 to 1
    #[arg(long, value_name = "E", value_parser = parse_share)]
    pub(crate) max_error: Option<f64>,
    /// Greatest error as a share of that of no shadow at all, 0 to 1
    #[arg(long, value_name = "SHARE", value_parser = parse_share)]
    pub(crate) max_relative_error: Option<f64>,
    /// Greatest time of shadows a frame, milliseconds
    #[arg(long = "max-time", value_name = "MS", value_parser = parse_ms)]
    pub(crate) max_ms: Option<f64>,
    /// Most bytes of maps and tables
    #[arg(long, value_name = "B")]
    pub(crate) max_bytes: Option<u64>,
    /// Greatest noise in penumbrae, as a standard deviation, 0 to 1; 1 allows any
    #[arg(long, value_name = "SHARE", default_value_t = MAX_GRAIN, value_parser = parse_share)]
    pub(crate) max_grain: f64,
    /// Greatest mean change of visibility from frame to frame of a pan, 0 to 1; maps with a stable fit are tried, too
    #[arg(long, value_name = "SHARE", value_parser = parse_share)]
    pub(crate) max_shimmer: Option<f64>,
    /// All lights of the scene, their times together at most so many milliseconds, with the least error
    #[arg(long, value_name = "MS", value_parser = parse_ms, conflicts_with_all = ["max_error", "max_relative_error", "max_ms", "max_bytes", "light", "budget_error", "regret"])]
    pub(crate) budget_ms: Option<f64>,
    /// All lights of the scene, their errors together (root mean square over the lights) at most this, for the least time
    #[arg(long, value_name = "E", value_parser = parse_share, conflicts_with_all = ["max_error", "max_relative_error", "max_ms", "max_bytes", "light", "regret"])]
    pub(crate) budget_error: Option<f64>,
    /// Frames in which nothing moves: the lookup alone counts
    #[arg(long, conflicts_with_all = ["camera_moves", "all_moves"])]
    pub(crate) still: bool,
    /// Frames in which the camera moves: what is made anew for it counts (the default)
    #[arg(long, conflicts_with = "all_moves")]
    pub(crate) camera_moves: bool,
    /// Frames in which casters, lights and camera move: all counts
    #[arg(long)]
    pub(crate) all_moves: bool,
    /// File of cameras (TOML): poses as [[camera]] tables with eye and target, `between = N` for a path through them; else
    /// the scene's camera
    #[arg(long, value_name = "FILE", conflicts_with = "regret")]
    pub(crate) cameras: Option<PathBuf>,
    /// For how many of the cameras the bounds hold: `worst` (for all), or a share such as 95%
    #[arg(long, value_name = "HOW", default_value = "worst", value_parser = parse_hold)]
    pub(crate) hold: Hold,
    /// How much each pixel's error counts
    #[arg(long, value_name = "HOW", default_value = "even")]
    pub(crate) weight: PlanWeight,
    /// What the renderer has on the CPU when it makes recipes
    #[arg(long, value_name = "WHAT", default_value = "triangles")]
    pub(crate) renderer: PlanRenderer,
    /// Results of `stability` (results.json) that --must-pass and --no-failing-rows ask
    #[arg(long, value_name = "FILE")]
    pub(crate) stability: Option<PathBuf>,
    /// Rows of the stability matrix, by number, or cases by name, that the technique must pass
    #[arg(
        long,
        value_name = "ROW",
        value_delimiter = ',',
        requires = "stability"
    )]
    pub(crate) must_pass: Vec<String>,
    /// Only techniques that fail no row of the stability matrix
    #[arg(long, requires = "stability", conflicts_with = "must_pass")]
    pub(crate) no_failing_rows: bool,
    /// Counted and priced costs alone: the same plan on every run. Else what these can't tell apart is played and timed, unless
    /// --prices says what another machine takes
    #[arg(long)]
    pub(crate) counted: bool,
    /// Whose prices count, and what plays what is timed
    #[arg(long, value_name = "NAME", default_value = "cpu")]
    pub(crate) backend: PlanBackend,
    /// Prices of work, as `bench --costs --write` or `card` (.json) measures them; else the built-in ones
    #[arg(long, value_name = "FILE")]
    pub(crate) prices: Option<PathBuf>,
    /// Which of the scene's lights, from 1; with --regret all of them
    #[arg(long, value_name = "NUMBER", default_value_t = 1, conflicts_with = "regret", value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) light: u16,
    /// Image size in pixels, of the screen that the shadows are for; else 1280x720 (with --regret the scenes' own)
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub(crate) size: Option<[u32; 2]>,
    /// Receivers sampled under lights with an extent; four times as many under others
    #[arg(long, value_name = "COUNT", default_value_t = 4096, value_parser = clap::value_parser!(u32).range(64..=1_048_576))]
    pub(crate) samples: u32,
    /// Which sample; the same seed gives the same plan
    #[arg(long, value_name = "NUMBER", default_value_t = 1)]
    pub(crate) seed: u32,
    /// Folder for the presets, pictures and figures; else target/plan in the repository
    #[arg(long, value_name = "FOLDER")]
    pub(crate) out: Option<PathBuf>,
    /// Compare plans with sweeps of all candidates: bounds kept, and cost over the least, by count and by the clock
    #[arg(long, conflicts_with_all = ["max_error", "max_relative_error", "max_ms", "max_bytes"])]
    pub(crate) regret: bool,
    /// Errors asked for with --regret
    #[arg(long, value_name = "E", value_delimiter = ',', value_parser = parse_share, default_values_t = [0.02, 0.05, 0.1], requires = "regret")]
    pub(crate) errors: Vec<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum PlanWeight {
    /// All alike
    Even,
    /// By the square of the light's irradiance, which shading multiplies shadows by
    Irradiance,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum PlanRenderer {
    /// Triangles, and the points that the camera sees, read back from the GPU
    SeenPoints,
    /// Triangles
    Triangles,
    /// A box around the casters: their triangles are on the GPU alone
    CasterBox,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum PlanBackend {
    /// The CPU backend's
    Cpu,
    /// The wgpu backend's, on a software driver
    Wgpu,
}

fn parse_share(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(share) if (0.0..=1.0).contains(&share) => Ok(share),
        _ => Err("write a number from 0 to 1, such as 0.05".to_owned()),
    }
}

fn parse_hold(text: &str) -> Result<Hold, String> {
    if text == "worst" {
        return Ok(Hold::Worst);
    }
    let percent = text
        .strip_suffix('%')
        .and_then(|number| number.parse::<f64>().ok());
    match percent {
        Some(percent) if percent > 0.0 && percent <= 100.0 => Ok(Hold::Share(percent / 100.0)),
        _ => Err("write worst, or a share of the cameras such as 95%".to_owned()),
    }
}

fn parse_ms(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(ms) if ms >= 0.0 && ms.is_finite() => Ok(ms),
        _ => Err("write milliseconds, 0 or more".to_owned()),
    }
}
