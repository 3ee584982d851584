//! `plan`: plans the technique for a scene within bounds, prints the reasons, and writes the
//! preset.

use crate::{
    cli::{
        args::shared::{BackendName, parse_size},
        figures_table::figures_table,
        inputs,
        planning::{self, PlanProgress},
        program::Program,
        usage::Usage,
    },
    compare::{Backends, FrameMotion},
    plan_files::{Written, write, write_lights},
    stability::{Demand, report::StabilityResults},
};
use anyhow::{Result, bail};
use clap::{Args, ValueEnum};
use comfy_table::Table;
use std::path::PathBuf;
use umbrage_core::{Backend, Geometry, Scene, glam::UVec2};
use umbrage_plan::{
    Bounds, Coverage, Hold, LightsBudget, LightsPlan, MAX_GRAIN, Plan, PlanOptions, RendererData,
    Setting, Weighting, catalogue::Catalogue, cost::CostModel, plan_by_clock, plan_lights,
};

#[derive(Args, Clone, Debug, PartialEq)]
#[command(after_help = "Examples:
  cargo xtask plan cubes --max-error 0.05             cheapest setting within an error bound
  cargo xtask plan nave --max-relative-error 0.2      a fifth of the error without shadows
  cargo xtask plan lamp.toml --max-time 2             most accurate setting within a time bound
  cargo xtask plan night-room --budget-ms 8           all lights of a scene within a time budget
  cargo xtask plan night-room --budget-error 0.05     all lights within an error, in the least time
  cargo xtask plan street --max-error 0.1 --cameras path.toml --hold 95%
  cargo xtask plan street --max-error 0.1 --still     static camera and scene: only lookups count
  cargo xtask plan cubes --max-error 0.1 --max-shimmer 0.001
  cargo xtask plan cubes --max-error 0.1 --stability results.json --no-failing-rows
  cargo xtask plan lamp.toml --max-error 0.05 --light 2 --size 1920x1080
  cargo xtask plan model.obj --max-error 0.05 --max-bytes 4194304 --backend wgpu
  cargo xtask plan street --max-error 0.1 --prices my-gpu.toml --backend wgpu
  cargo xtask plan --regret                           check plans against sweeps of the suite
  cargo xtask plan --regret cubes --errors 0.05,0.1   the same for one scene and two bounds")]
pub(crate) struct PlanArguments {
    /// Scene: a built-in name, scene file (.toml) or model (.obj, .glb, .gltf)
    ///
    /// With --regret any number of scenes. Default: the built-in suite.
    #[arg(value_name = "SCENE", required_unless_present = "regret")]
    pub(crate) scenes: Vec<String>,
    /// Maximum error: root mean square difference of visibility from the reference, 0 to 1
    #[arg(long, value_name = "E", value_parser = parse_share)]
    pub(crate) max_error: Option<f64>,
    /// Maximum error as a share of the error without shadows, 0 to 1
    #[arg(long, value_name = "SHARE", value_parser = parse_share)]
    pub(crate) max_relative_error: Option<f64>,
    /// Maximum time of all shadow work in a frame, milliseconds
    #[arg(long = "max-time", value_name = "MS", value_parser = parse_ms)]
    pub(crate) max_ms: Option<f64>,
    /// Maximum memory of maps and tables, bytes
    #[arg(long, value_name = "B")]
    pub(crate) max_bytes: Option<u64>,
    /// Maximum noise in penumbrae, as a standard deviation, 0 to 1; 1 is no bound
    #[arg(long, value_name = "SHARE", default_value_t = MAX_GRAIN, value_parser = parse_share)]
    pub(crate) max_grain: f64,
    /// Maximum mean change of visibility between frames of a camera pan, 0 to 1
    ///
    /// Also makes maps with a stable fit candidates.
    #[arg(long, value_name = "SHARE", value_parser = parse_share)]
    pub(crate) max_shimmer: Option<f64>,
    /// Plan all lights of the scene: minimise the error within this total time, milliseconds
    #[arg(long, value_name = "MS", value_parser = parse_ms, conflicts_with_all = ["max_error", "max_relative_error", "max_ms", "max_bytes", "light", "budget_error", "regret"])]
    pub(crate) budget_ms: Option<f64>,
    /// Plan all lights of the scene: minimise the time within this error
    ///
    /// The error is the root mean square over the lights.
    #[arg(long, value_name = "E", value_parser = parse_share, conflicts_with_all = ["max_error", "max_relative_error", "max_ms", "max_bytes", "light", "regret"])]
    pub(crate) budget_error: Option<f64>,
    /// Nothing moves: the frame time includes the lookup only
    #[arg(long, conflicts_with_all = ["camera_moves", "all_moves"])]
    pub(crate) still: bool,
    /// The camera moves: the frame time includes all work redone for it (default)
    #[arg(long, conflicts_with = "all_moves")]
    pub(crate) camera_moves: bool,
    /// Casters, lights and camera move: the frame time includes all work
    #[arg(long)]
    pub(crate) all_moves: bool,
    /// File of cameras (TOML). Default: the scene's camera
    ///
    /// Poses are [[camera]] tables with eye and target. `between = N` adds cameras on a path
    /// through them.
    #[arg(long, value_name = "FILE", conflicts_with = "regret")]
    pub(crate) cameras: Option<PathBuf>,
    /// Share of the cameras that must meet the bounds: `worst` (all of them), or for example 95%
    #[arg(long, value_name = "HOW", default_value = "worst", value_parser = parse_hold)]
    pub(crate) hold: Hold,
    /// Weight of each pixel's error
    #[arg(long, value_name = "HOW", default_value = "even")]
    pub(crate) weight: PlanWeight,
    /// Data that the renderer has on the CPU when it makes recipes
    #[arg(long, value_name = "WHAT", default_value = "triangles")]
    pub(crate) renderer: PlanRenderer,
    /// The results.json of a `stability` run, for --must-pass and --no-failing-rows
    #[arg(long, value_name = "FILE")]
    pub(crate) stability: Option<PathBuf>,
    /// Rows (numbers) or cases (names) of the stability matrix that the technique must pass
    #[arg(
        long,
        value_name = "ROW",
        value_delimiter = ',',
        requires = "stability"
    )]
    pub(crate) must_pass: Vec<String>,
    /// Only use techniques that fail no row of the stability matrix
    #[arg(long, requires = "stability", conflicts_with = "must_pass")]
    pub(crate) no_failing_rows: bool,
    /// Use predicted costs only, so that every run returns the same plan
    ///
    /// Otherwise candidates with overlapping predicted costs are benchmarked, unless --prices is
    /// given.
    #[arg(long)]
    pub(crate) counted: bool,
    /// Backend whose prices apply, and which runs the benchmarks
    #[arg(long, value_name = "NAME", default_value = "cpu")]
    pub(crate) backend: PlanBackend,
    /// File with prices of work, from `bench --costs --write` or `card` (.json). Default: the
    /// built-in prices
    #[arg(long, value_name = "FILE")]
    pub(crate) prices: Option<PathBuf>,
    /// Number of the light in the scene, from 1; --regret uses all lights
    #[arg(long, value_name = "NUMBER", default_value_t = 1, conflicts_with = "regret", value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) light: u16,
    /// Image size in pixels. Default: 1280x720; with --regret each scene's own
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub(crate) size: Option<[u32; 2]>,
    /// Receivers to sample under lights with an extent; four times as many under ideal lights
    #[arg(long, value_name = "COUNT", default_value_t = 4096, value_parser = clap::value_parser!(u32).range(64..=1_048_576))]
    pub(crate) samples: u32,
    /// Seed of the sample; the same seed returns the same plan
    #[arg(long, value_name = "NUMBER", default_value_t = 1)]
    pub(crate) seed: u32,
    /// Folder for presets, images and figures. Default: target/plan in the repository
    #[arg(long, value_name = "FOLDER")]
    pub(crate) out: Option<PathBuf>,
    /// Compare plans with exhaustive sweeps of all candidates
    ///
    /// Reports whether the bounds hold, and the cost relative to the least one, predicted and
    /// measured.
    #[arg(long, conflicts_with_all = ["max_error", "max_relative_error", "max_ms", "max_bytes"])]
    pub(crate) regret: bool,
    /// Error bounds to test with --regret
    #[arg(long, value_name = "E", value_delimiter = ',', value_parser = parse_share, default_values_t = [0.02, 0.05, 0.1], requires = "regret")]
    pub(crate) errors: Vec<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum PlanWeight {
    /// Equal weight of all pixels
    Even,
    /// Weight by the square of the light's irradiance, by which shading multiplies the visibility
    Irradiance,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum PlanRenderer {
    /// Triangles, and the visible points, read back from the GPU
    SeenPoints,
    /// Triangles
    Triangles,
    /// A bounding box of the casters, whose triangles are on the GPU only
    CasterBox,
    /// A light set with casters on the GPU only: as caster-box, and `exact`
    LightSet,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum PlanBackend {
    /// The CPU backend
    Cpu,
    /// The wgpu backend; the built-in prices are those of a software driver
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

/// Default image size of plans, pixels. It is as large as that of typical programs, since the size
/// decides which technique is cheapest.
const SIZE: UVec2 = UVec2::new(1280, 720);

/// Plans, prints the plan and writes its files. Errors if no setting is within the bounds.
pub(crate) fn plan(program: &Program, arguments: &PlanArguments) -> Result<()> {
    let [name] = &arguments.scenes[..] else {
        return Err(Usage(
            "`plan` needs exactly one scene: give one SCENE, or use --regret".to_owned(),
        )
        .into());
    };
    let bounds = bounds_of(arguments);
    let budget = budget_of(arguments);
    if budget.is_none() {
        bounds.validate().map_err(|_| {
            Usage(
                "no bound is given: use --max-error, --max-relative-error, --max-time or --max-bytes; for all lights \
                 --budget-ms or --budget-error"
                    .to_owned(),
            )
        })?;
    }
    let scene = inputs::scene(program, name)?;
    let options = options_for(program, arguments, &scene)?;
    let mut clock = clock_of(arguments)?;
    let progress = PlanProgress::new();
    let on_step = |step: umbrage_plan::Step<'_>| progress.note(step);
    let folder = program.folder(arguments.out.as_deref(), "plan");
    let backend: Option<&mut dyn Backend> = match &mut clock {
        Some(clock) => Some(&mut *clock.backends[0]),
        None => None,
    };
    if let Some(budget) = budget {
        let found = plan_lights(&scene, budget, &bounds, &options, backend, &on_step);
        progress.finish();
        let found = found?;
        let files = write_lights(&found, &scene, &options, &folder)?;
        print_lights(&found);
        return end(&files, found.miss.clone());
    }
    let found = plan_by_clock(&scene, &bounds, &options, backend, &on_step);
    progress.finish();
    let plan = found?;
    let files = write(&plan, Some((&scene, &options)), &folder)?;
    print(&plan, &PriceSource::from_arguments(arguments));
    end(&files, plan.preset().err().map(|miss| miss.to_string()))
}

/// Lists the written files. Errors if no setting was within the bounds.
fn end(files: &[Written], miss: Option<String>) -> Result<()> {
    println!();
    for file in files {
        println!("{}: {}", file.what, file.path.display());
    }
    match miss {
        None => Ok(()),
        Some(miss) => bail!("{miss}"),
    }
}

/// Returns the bounds of the arguments. With a budget for all lights, they apply to each light.
fn bounds_of(arguments: &PlanArguments) -> Bounds {
    Bounds {
        max_error: arguments.max_error,
        max_relative_error: arguments.max_relative_error,
        max_ms: arguments.max_ms,
        max_bytes: arguments.max_bytes,
        max_grain: Some(arguments.max_grain),
        max_shimmer: arguments.max_shimmer,
        renderer: match arguments.renderer {
            PlanRenderer::SeenPoints => RendererData::SeenPoints,
            PlanRenderer::Triangles => RendererData::Triangles,
            PlanRenderer::CasterBox => RendererData::CasterBox,
            PlanRenderer::LightSet => RendererData::LightSet,
        },
    }
}

fn budget_of(arguments: &PlanArguments) -> Option<LightsBudget> {
    let time = arguments.budget_ms.map(LightsBudget::Milliseconds);
    time.or(arguments.budget_error.map(LightsBudget::Error))
}

/// Returns the kind of backend whose prices apply.
fn kind(arguments: &PlanArguments) -> &'static str {
    match arguments.backend {
        PlanBackend::Cpu => "cpu",
        PlanBackend::Wgpu => "wgpu",
    }
}

/// Opens the backends for benchmarks. `None` if costs are predicted only.
pub(crate) fn clock_of(arguments: &PlanArguments) -> Result<Option<Backends>> {
    if arguments.counted || arguments.prices.is_some() {
        return Ok(None);
    }
    let name = match arguments.backend {
        PlanBackend::Cpu => BackendName::Cpu,
        PlanBackend::Wgpu => BackendName::Wgpu,
    };
    Ok(Some(inputs::open(name, None)?))
}

/// Returns the options that don't depend on the scene.
pub(crate) fn options_of(program: &Program, arguments: &PlanArguments) -> Result<PlanOptions> {
    let prices = inputs::prices(arguments.prices.as_deref())?;
    Ok(PlanOptions {
        catalogue: demanded_catalogue(&program.catalogue, arguments)?,
        samples: arguments.samples,
        seed: arguments.seed,
        cost: prices.model_for_backend(kind(arguments)),
        // The command numbers lights from 1.
        light: usize::from(arguments.light) - 1,
        size: match arguments.size {
            Some(size) => Some(UVec2::from_array(size)),
            None if arguments.regret => None,
            None => Some(SIZE),
        },
        motion: match () {
            () if arguments.still => FrameMotion::Still,
            () if arguments.all_moves => FrameMotion::AllMoves,
            () => FrameMotion::CameraMoves,
        },
        hold: arguments.hold,
        weighting: match arguments.weight {
            PlanWeight::Even => Weighting::Even,
            PlanWeight::Irradiance => Weighting::Irradiance,
        },
        ..PlanOptions::default()
    })
}

fn options_for(program: &Program, arguments: &PlanArguments, scene: &Scene) -> Result<PlanOptions> {
    let mut options = options_of(program, arguments)?;
    if let Some(path) = &arguments.cameras {
        options.cameras = umbrage_scenes::cameras(path, &Geometry::bake(scene)?, scene.anchor)?;
    }
    Ok(options)
}

/// Returns the techniques that meet the demands on the stability matrix.
fn demanded_catalogue(techniques: &Catalogue, arguments: &PlanArguments) -> Result<Catalogue> {
    let Some(path) = &arguments.stability else {
        return Ok(techniques.clone());
    };
    let demand = match (&arguments.must_pass[..], arguments.no_failing_rows) {
        ([], false) => {
            let why = "--stability needs a demand: add --must-pass or --no-failing-rows";
            return Err(Usage(why.to_owned()).into());
        }
        ([], true) => Demand::FailNone,
        (rows, _) => Demand::Pass(rows.to_vec()),
    };
    let results = StabilityResults::read(path).map_err(|e| Usage(e.to_string()))?;
    let stability = results.stability;
    let mut left = Vec::new();
    for name in techniques.names() {
        if stability
            .meets(name, &demand)
            .map_err(|e| Usage(e.to_string()))?
        {
            left.push(name);
        }
    }
    if left.is_empty() {
        bail!("no technique passes the demanded rows of the stability matrix; demand fewer");
    }
    println!(
        "techniques that pass the demanded rows of the stability matrix: {}",
        left.join(", ")
    );
    Ok(techniques.clone().retain(|name| left.contains(&name)))
}

/// The source of predicted times.
struct PriceSource {
    kind: &'static str,
    /// The file of prices. `None` for the built-in ones.
    file: Option<String>,
}

impl PriceSource {
    fn from_arguments(arguments: &PlanArguments) -> Self {
        let file = arguments.prices.as_ref();
        Self {
            kind: kind(arguments),
            file: file.map(|path| path.display().to_string()),
        }
    }

    /// Returns a predicted time with its uncertainty: `about 2.1 ms (0.7 to 6.2)`.
    fn approximate_time(&self, ms: f64) -> String {
        match &self.file {
            Some(file) => format!("{ms:.2} ms by the prices of `{file}`"),
            None => {
                let factor = CostModel::factor_of_nine_in_ten(self.kind);
                let [low, high] = [ms / factor, ms * factor];
                format!("about {ms:.2} ms ({low:.2} to {high:.2}) on the reference machine")
            }
        }
    }
}

fn print(plan: &Plan, prices: &PriceSource) {
    let [w, h] = plan.size;
    let s = &plan.sampled;
    println!(
        "{}: {} light, {w} x {h}, {}; {}",
        plan.scene,
        plan.light,
        plan.bounds,
        plan.motion.words()
    );
    if plan.cameras > 1 {
        println!(
            "{} cameras; figures are those of the worst camera that must meet the bounds",
            plan.cameras
        );
    }
    println!(
        "{} receivers sampled in {:.1} s, {} settings evaluated in {:.1} s (truth of {} receivers)",
        s.receivers, s.looking, s.settings, s.trying, s.traced
    );
    println!("{}\n", promise(&plan.coverage));
    if let Some(chosen) = &plan.chosen {
        println!("{}", chosen.label());
        let e = &chosen.estimate;
        println!(
            "  error {:.4} (90 % interval {:.4} to {:.4}); too dark {:.4}, too light {:.4}",
            e.error, e.low, e.high, e.too_dark, e.too_light
        );
        let none = plan.error_of_no_shadow.error;
        if none > 0.0 {
            let percent = 100.0 * e.error / none;
            println!("  {percent:.0} % of the error without shadows ({none:.4})");
        }
        if let Some(grain) = chosen.grain {
            println!("  noise {grain:.3} in penumbrae");
        }
        if let Some(shimmer) = chosen.shimmer {
            println!("  shimmer {shimmer:.5}: mean change between frames of a pan");
        }
        let bytes = planning::bytes(chosen.bytes);
        println!(
            "  {} predicted, {bytes}",
            prices.approximate_time(chosen.milliseconds)
        );
        if let Some(ms) = chosen.measured_ms {
            println!("  {ms:.2} ms measured on this machine");
        }
    }
    for reason in &plan.reasons {
        println!("  * {reason}");
    }
    for left_out in &plan.left_out {
        println!("  * {}", left_out.words());
    }
    if !plan.runners_up.is_empty() {
        println!(
            "\nOther settings that no candidate beats in both error and time:\n{}",
            table(&plan.runners_up)
        );
    }
}

/// Formats the number of pixels for which a plan is valid.
fn promise(coverage: &Coverage) -> String {
    let share = |count: u64| 100.0 * count as f64 / coverage.receivers.max(1) as f64;
    format!(
        "valid for {} of {} pixels (+-{}); {} show a receiver: {} of them face away from the light, {} \
         ({:.2} %) are ambiguous; truth was traced at {}, {} are estimated from that sample",
        coverage.certain,
        coverage.pixels,
        coverage.certain_margin,
        coverage.receivers,
        coverage.unlit,
        coverage.ambiguous,
        share(coverage.ambiguous),
        coverage.traced,
        coverage.unsampled_pixels()
    )
}

const LIGHTS_HEADER: [&str; 7] = [
    "light",
    "technique",
    "error",
    "without shadows",
    "ms",
    "memory",
    "choices",
];

fn print_lights(plan: &LightsPlan) {
    let [w, h] = plan.size;
    let budget = match plan.budget {
        LightsBudget::Milliseconds(ms) => format!("at most {ms} ms"),
        LightsBudget::Error(error) => format!("error at most {error}"),
    };
    println!(
        "{}: {} lights, {w} x {h}, {budget} together; {}",
        plan.scene,
        plan.lights.len(),
        plan.motion.words()
    );
    let mut rows = Vec::new();
    for light in &plan.lights {
        let mut row = vec![format!("{}: {}", light.number, light.kind)];
        match &light.chosen {
            Some(chosen) => row.extend([
                chosen.label(),
                format!("{:.4}", chosen.estimate.error),
                format!("{:.4}", light.error_of_no_shadow.error),
                format!("{:.3}", chosen.measured_ms.unwrap_or(chosen.milliseconds)),
                planning::bytes(chosen.bytes),
            ]),
            None => row.extend(["nothing", "-", "-", "-", "-"].map(str::to_owned)),
        }
        row.push(light.front.len().to_string());
        rows.push(row);
    }
    println!("{}", figures_table(LIGHTS_HEADER, rows, 2));
    let is_timed = plan
        .lights
        .iter()
        .flat_map(|light| &light.front)
        .any(|s| s.measured_ms.is_some());
    let clock = if is_timed { "measured" } else { "predicted" };
    println!(
        "total {:.3} ms {clock}, error {:.4} (up to {:.4})",
        plan.milliseconds, plan.error, plan.high
    );
    for light in &plan.lights {
        println!("light {}: {}", light.number, promise(&light.coverage));
    }
}

fn table(settings: &[Setting]) -> Table {
    let header = [
        "technique",
        "settings",
        "error",
        "90 % interval",
        "ms",
        "memory",
    ];
    let row = |s: &Setting| {
        let e = &s.estimate;
        [
            s.technique.clone(),
            s.settings.clone(),
            format!("{:.4}", e.error),
            format!("{:.4} to {:.4}", e.low, e.high),
            format!("{:.3}", s.milliseconds),
            planning::bytes(s.bytes),
        ]
    };
    figures_table(header, settings.iter().map(row), 2)
}
