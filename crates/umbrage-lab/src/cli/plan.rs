//! `plan`: plans the technique for a scene within bounds, prints the reasons, and writes the preset.

use crate::cli::program::Program;
use crate::cli::{
    args::{Backend as BackendName, PlanArguments, PlanBackend, PlanRenderer, PlanWeight},
    usage::Usage,
};
use crate::cli::{
    inputs,
    planning::{self, Progress},
};
use crate::{
    compare::{Backends, FrameMotion},
    plan_files::{Written, write, write_lights},
    stability::{Demand, Stability},
};
use anyhow::{Result, bail};
use comfy_table::{CellAlignment, ContentArrangement, Table, presets::UTF8_FULL_CONDENSED};
use umbrage_core::{Backend, Geometry, Scene, glam::UVec2};
use umbrage_plan::catalogue::Catalogue;
use umbrage_plan::{
    Bounds, Coverage, LightsBudget, LightsPlan, Plan, PlanOptions, RendererData, Setting,
    Weighting, cost::CostModel, plan as find, plan_by_clock, plan_lights,
};

/// The image size that plans are made for if nobody says otherwise, pixels: no smaller than what people play at, since the size decides
/// which technique is the least.
const SIZE: UVec2 = UVec2::new(1280, 720);

/// Plans, prints and writes; errors if nothing is within the bounds.
pub(crate) fn plan(program: &Program, arguments: &PlanArguments) -> Result<()> {
    let [name] = &arguments.scenes[..] else {
        return Err(
            Usage("plan one scene at a time: give one SCENE, or --regret".to_owned()).into(),
        );
    };
    let bounds = bounds_of(arguments);
    let budget = budget_of(arguments);
    if budget.is_none() {
        bounds.validate().map_err(|_| {
            Usage(
                "give --max-error, --max-relative-error, --max-time or --max-bytes, or some of them; for all lights \
                 --budget-ms or --budget-error"
                    .to_owned(),
            )
        })?;
    }
    let scene = inputs::scene(program, name)?;
    let options = options_for(program, arguments, &scene)?;
    let mut clock = clock_of(arguments)?;
    let progress = Progress::new();
    let on_step = |step: umbrage_plan::Step<'_>| progress.note(step);
    let folder = program.folder(arguments.out.as_deref(), "plan");
    if let Some(budget) = budget {
        let backend: Option<&mut dyn Backend> = match &mut clock {
            Some(clock) => Some(&mut *clock.playing[0]),
            None => None,
        };
        let found = plan_lights(&scene, budget, &bounds, &options, backend, &on_step);
        progress.finish();
        let found = found?;
        let files = write_lights(&found, &scene, &options, &folder)?;
        print_lights(&found);
        return end(&files, found.miss.clone());
    }
    let found = match &mut clock {
        Some(clock) => plan_by_clock(&scene, &bounds, &options, &mut *clock.playing[0], &on_step),
        None => find(&scene, &bounds, &options, &on_step),
    };
    progress.finish();
    let plan = found?;
    let files = write(&plan, Some((&scene, &options)), &folder)?;
    print(&plan, &Prices::of(arguments));
    end(&files, plan.preset().err().map(|miss| miss.to_string()))
}

/// Lists the files that were written; errors if nothing was within the bounds.
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

/// Returns the bounds that are asked for; with a budget of all lights those of each light.
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
        },
    }
}

fn budget_of(arguments: &PlanArguments) -> Option<LightsBudget> {
    let time = arguments.budget_ms.map(LightsBudget::Milliseconds);
    time.or(arguments.budget_error.map(LightsBudget::Error))
}

/// Returns the kind of backend whose prices count.
fn kind(arguments: &PlanArguments) -> &'static str {
    match arguments.backend {
        PlanBackend::Cpu => "cpu",
        PlanBackend::Wgpu => "wgpu",
    }
}

/// Opens what plays what is timed; none where costs are counted alone.
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

/// Returns the options that do not depend on the scene.
pub(crate) fn options_of(program: &Program, arguments: &PlanArguments) -> Result<PlanOptions> {
    let prices = inputs::prices(arguments.prices.as_deref())?;
    Ok(PlanOptions {
        catalogue: demanded(&program.catalogue, arguments)?,
        samples: arguments.samples,
        seed: arguments.seed,
        cost: prices.of(kind(arguments)),
        // The command counts lights from 1.
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
        options.cameras = umbrage_scenes::cameras(path, &Geometry::bake(scene)?)?;
    }
    Ok(options)
}

/// Returns the techniques that meet what is asked of the stability matrix.
fn demanded(techniques: &Catalogue, arguments: &PlanArguments) -> Result<Catalogue> {
    let Some(path) = &arguments.stability else {
        return Ok(techniques.clone());
    };
    let demand = match (&arguments.must_pass[..], arguments.no_failing_rows) {
        ([], false) => {
            let why = "--stability: say what is asked of it by --must-pass or --no-failing-rows";
            return Err(Usage(why.to_owned()).into());
        }
        ([], true) => Demand::FailNone,
        (rows, _) => Demand::Pass(rows.to_vec()),
    };
    let stability = Stability::read(path).map_err(|e| Usage(e.to_string()))?;
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
        bail!("no technique passes what is asked of the stability matrix: ask less");
    }
    println!(
        "by the stability matrix these are left: {}",
        left.join(", ")
    );
    Ok(techniques.clone().retain(|name| left.contains(&name)))
}

/// Where predicted times come from.
struct Prices {
    kind: &'static str,
    /// The file of prices, if they aren't the built-in ones.
    file: Option<String>,
}

impl Prices {
    fn of(arguments: &PlanArguments) -> Self {
        let file = arguments.prices.as_ref();
        Self {
            kind: kind(arguments),
            file: file.map(|path| path.display().to_string()),
        }
    }

    /// Returns a predicted time with its uncertainty: `about 2.1 ms (0.7 to 6.2)`.
    fn about(&self, ms: f64) -> String {
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

fn print(plan: &Plan, prices: &Prices) {
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
            "{} cameras; figures are of the worst that the plan holds for",
            plan.cameras
        );
    }
    println!(
        "{} receivers sampled in {:.1} s, {} settings tried in {:.1} s (truth of {} receivers in all)",
        s.receivers, s.looking, s.settings, s.trying, s.traced
    );
    println!("{}\n", promise(&plan.coverage));
    if let Some(chosen) = &plan.chosen {
        println!("{}", chosen.label());
        let e = &chosen.estimate;
        println!(
            "  error {:.4} ({:.4} to {:.4}, 9 in 10), of which too dark {:.4}, too light {:.4}",
            e.error, e.low, e.high, e.too_dark, e.too_light
        );
        let none = plan.error_of_no_shadow.error;
        if none > 0.0 {
            let percent = 100.0 * e.error / none;
            println!("  {percent:.0} % of what no shadow at all would err by ({none:.4})");
        }
        if let Some(grain) = chosen.grain {
            println!("  grain {grain:.3} in penumbrae");
        }
        if let Some(shimmer) = chosen.shimmer {
            println!("  shimmer {shimmer:.5}: the mean change from frame to frame of a pan");
        }
        let bytes = planning::bytes(chosen.bytes);
        println!(
            "  {} by counting, {bytes}",
            prices.about(chosen.milliseconds)
        );
        if let Some(ms) = chosen.measured_ms {
            println!("  {ms:.2} ms by the clock, here");
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
            "\nOthers that nothing tried beats in both error and time:\n{}",
            table(&plan.runners_up)
        );
    }
}

/// Says for how many pixels a plan holds.
fn promise(coverage: &Coverage) -> String {
    let share = |count: u64| 100.0 * count as f64 / coverage.receivers.max(1) as f64;
    format!(
        "it holds for {} of {} pixels (+-{}): {} show something that receives, of which {} face away from the light and {} \
         ({:.2} %) hang on rounding; truth was traced at {}, and of the other {} the sample tells",
        coverage.certain,
        coverage.pixels,
        coverage.certain_margin,
        coverage.receivers,
        coverage.unlit,
        coverage.ambiguous,
        share(coverage.ambiguous),
        coverage.traced,
        coverage.unsampled()
    )
}

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
    let mut table = Table::new();
    table
        .load_style(UTF8_FULL_CONDENSED)
        .set_content_arrangement(ContentArrangement::Dynamic)
        .set_header([
            "light",
            "technique",
            "error",
            "of no shadow",
            "ms",
            "memory",
            "choices",
        ]);
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
        table.add_row(row);
    }
    for column in table.column_iter_mut().skip(2) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    println!("{table}");
    let is_timed = plan
        .lights
        .iter()
        .flat_map(|light| &light.front)
        .any(|s| s.measured_ms.is_some());
    let clock = if is_timed {
        "by the clock, here"
    } else {
        "by counting"
    };
    println!(
        "together {:.3} ms {clock}, error {:.4} (up to {:.4})",
        plan.milliseconds, plan.error, plan.high
    );
    for light in &plan.lights {
        println!("light {}: {}", light.number, promise(&light.coverage));
    }
}

fn table(settings: &[Setting]) -> Table {
    let mut table = Table::new();
    table
        .load_style(UTF8_FULL_CONDENSED)
        .set_content_arrangement(ContentArrangement::Dynamic);
    table.set_header(["technique", "settings", "error", "9 in 10", "ms", "memory"]);
    for s in settings {
        let e = &s.estimate;
        table.add_row([
            s.technique.clone(),
            s.settings.clone(),
            format!("{:.4}", e.error),
            format!("{:.4} to {:.4}", e.low, e.high),
            format!("{:.3}", s.milliseconds),
            planning::bytes(s.bytes),
        ]);
    }
    for column in table.column_iter_mut().skip(2) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}
