//! `compare`: measures techniques on scenes, prints a table and writes the report.

use crate::{
    baseline::{Changes, Except, changes, check_not_overwritten, read, time_again},
    cli::{
        args::shared::{BackendName, Shard, parse_shard, parse_size},
        cost, inputs,
        left_out_limits::{check_left_out, limit_of},
        presets,
        program::Program,
        progress::Progress,
        summary, table,
        usage::Usage,
        verdicts,
    },
    compare::{
        Backends, CompareEvent, CompareOptions, Comparison, FrameMotion, KeptTruth, Runs,
        SceneInput, Section, compare as run,
    },
    report::{ComparisonPlan, Report, StabilitySource},
};
use anyhow::{Result, bail};
use clap::Args;
use std::path::{Path, PathBuf};
use umbrage_core::{Backend, Invalid, Scene, glam::UVec2};
use umbrage_scenes::{Kind, SceneEntry};
use umbrage_techniques::SOFT_ERRORS;

#[derive(Args, Clone, Debug, PartialEq)]
#[command(after_help = "Examples:
  cargo xtask compare                                        the built-in suite
  cargo xtask compare --full                                 every setting and every pixel: hours
  cargo xtask compare street nave-soft --all-moves           two scenes in which everything moves
  cargo xtask compare --list                                 list scenes and techniques
  cargo xtask compare cubes --technique pcf --backend cpu    one scene, technique and backend
  cargo xtask compare lamp.toml model.obj --quick            your own scenes, small and fast
  cargo xtask compare 'model.glb#night'                      a glTF scene, by name or number
  cargo xtask compare cubes --preset mine.toml               your own settings, or those of `plan`
  cargo xtask compare nave-soft --max-error 0.02             `soft` with your own error bound
  cargo xtask compare cubes --size 640x480 --map-sizes 512,2048 --arrays --out report
  cargo xtask compare figure --color --map-sizes 1024        also render shaded images
  cargo xtask compare --deterministic --shard 2/8 --out s2   one shard of eight, for `merge`
  cargo xtask compare --stability target/stability           also show what each setting fails
  cargo xtask compare --baseline old/results.json            fail on a regression")]
pub(crate) struct CompareArguments {
    /// Scenes: built-in names, scene files (.toml) or models (.obj, .glb, .gltf). Default: the
    /// built-in suite
    #[arg(value_name = "SCENE")]
    pub(crate) scenes: Vec<String>,
    /// Techniques to measure; repeat the option, or separate names by commas. Default: all
    ///
    /// Without a SCENE, quick runs and the suite's checks omit expensive techniques unless they are
    /// named.
    #[arg(long = "technique", value_name = "NAME", value_delimiter = ',')]
    pub(crate) techniques: Vec<String>,
    /// Preset file (.preset.toml), as written by `plan`, to measure in addition to the techniques
    ///
    /// Its rows have the file's name. May be repeated. Add `--technique none,hard` to compare it
    /// with these two only.
    #[arg(long = "preset", value_name = "FILE")]
    pub(crate) presets: Vec<PathBuf>,
    /// Also measure `soft` with this root mean square error at straight edges, 0.002 to 0.2
    ///
    /// Its rows are called `soft-E`.
    #[arg(long, value_name = "E", value_parser = parse_soft_error)]
    pub(crate) max_error: Option<f32>,
    /// Backends to measure
    #[arg(long, value_name = "NAME", default_value = "available")]
    pub(crate) backend: BackendName,
    /// Graphics adapter, by part of its name, such as llvmpipe
    #[arg(long, value_name = "NAME")]
    pub(crate) adapter: Option<String>,
    /// Image size in pixels. Default: each scene's own; 1280x720 for full-size scenes
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub(crate) size: Option<[u32; 2]>,
    /// Sides of the shadow maps, texels, in any order
    ///
    /// Every setting is measured at the middle size, and the first setting of each technique at all
    /// sizes. Default: 512, 1024 and 2048; for full-size scenes 1024 and 2048, with --full also
    /// 4096; with --quick one size.
    #[arg(long, value_name = "SIDE", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(1..=16_384))]
    pub(crate) map_sizes: Vec<u32>,
    /// File with prices of work, from `bench --costs --write` or `card` (.json). Default: the
    /// built-in prices
    #[arg(long, value_name = "FILE")]
    pub(crate) prices: Option<PathBuf>,
    /// Rays per pixel of the reference (truth), for lights with an extent
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u32).range(1..=65_536))]
    pub(crate) samples: Option<u32>,
    /// Timed runs of each row; the report shows their median
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) runs: Option<u32>,
    /// Fail if more than this share of pixels facing the light is left out as ambiguous, 0 to 1
    ///
    /// Some built-in scenes, such as those of leaves, have higher limits of their own, which this
    /// option doesn't lower. The report is written all the same.
    #[arg(long, value_name = "SHARE", default_value = "0.05", value_parser = parse_share)]
    pub(crate) max_left_out: f64,
    /// Folder for the report. Default: target/compare in the repository
    #[arg(long, value_name = "FOLDER")]
    pub(crate) out: Option<PathBuf>,
    /// Preview: small images, few samples, few runs
    ///
    /// Without a SCENE it runs four scenes with representative settings, and omits expensive
    /// techniques.
    #[arg(long)]
    pub(crate) quick: bool,
    /// Measure every setting of every technique, and every pixel, on full-size scenes, too
    #[arg(long, conflicts_with = "quick")]
    pub(crate) full: bool,
    /// Nothing moves: frame times in charts and tables include the lookup only
    #[arg(long, conflicts_with_all = ["camera_moves", "all_moves"])]
    pub(crate) still: bool,
    /// The camera moves: frame times include all work redone for it (default)
    #[arg(long, conflicts_with = "all_moves")]
    pub(crate) camera_moves: bool,
    /// Casters, lights and camera move: frame times include all work, acceleration structures
    /// included
    #[arg(long)]
    pub(crate) all_moves: bool,
    /// Also write NumPy arrays of truth, distances and all masks
    #[arg(long)]
    pub(crate) arrays: bool,
    /// Also shade every row in colour, and compare the colours between backends
    #[arg(long)]
    pub(crate) color: bool,
    /// Omit times and date, so that the report is byte-identical on every run
    #[arg(long, conflicts_with = "runs")]
    pub(crate) deterministic: bool,
    /// Compare with the results.json of an earlier run, which is in another folder; fail on
    /// regressions
    ///
    /// Fails if anything is slower or less accurate beyond the noise, missing, or not comparable.
    #[arg(long, value_name = "RESULTS.JSON")]
    pub(crate) baseline: Option<PathBuf>,
    /// Exception from the baseline check: a scene, technique, backend or `technique (settings)`
    /// that may be missing or changed. May be repeated
    #[arg(long, value_name = "NAME", requires = "baseline")]
    pub(crate) baseline_except: Vec<String>,
    /// Folder or results.json of a `stability` run: the report lists the failed rows of each
    /// setting
    ///
    /// Default: target/stability in the repository if it exists, but not with --deterministic.
    #[arg(long, value_name = "FOLDER")]
    pub(crate) stability: Option<PathBuf>,
    /// Measure the K-th of N shards of the scenes; `merge` joins the reports
    #[arg(long, value_name = "K/N", value_parser = parse_shard)]
    pub(crate) shard: Option<Shard>,
    /// Measure all scenes again, including those that the folder has from an interrupted run
    #[arg(long)]
    pub(crate) fresh: bool,
    /// List scenes and techniques, and exit
    #[arg(long)]
    pub(crate) list: bool,
}

fn parse_soft_error(text: &str) -> Result<f32, String> {
    let [least, greatest] = SOFT_ERRORS;
    let error = text.parse().ok();
    error
        .filter(|error| (least..=greatest).contains(error))
        .ok_or_else(|| format!("use {least} to {greatest}"))
}

fn parse_share(text: &str) -> Result<f64, String> {
    let share = text.parse().ok();
    share
        .filter(|share| (0.0..=1.0).contains(share))
        .ok_or_else(|| "use 0 to 1".to_owned())
}

/// Measures, prints and writes the report. Errors if backends disagree, a negative control fails,
/// or a figure is worse than the baseline's.
pub(crate) fn compare(program: &Program, arguments: &CompareArguments) -> Result<()> {
    let out = program.folder(arguments.out.as_deref(), "compare");
    // Read and check all input first, so that errors don't come after minutes of measuring.
    let except = Except::new(arguments.baseline_except.iter().cloned());
    let baseline = match &arguments.baseline {
        Some(path) => Some(read_baseline(path, &out, &except).map_err(|e| Usage(e.to_string()))?),
        None => None,
    };
    let stability = verdicts::of_run(
        program,
        arguments.stability.as_deref(),
        arguments.deterministic,
    )?;
    let options = options_of(program, arguments)?;
    let inputs = scenes(program, arguments)?;
    let places = places(inputs.len(), arguments.shard)?;
    let mut backends = inputs::open(arguments.backend, arguments.adapter.as_ref())?;
    if !arguments.fresh {
        backends.kept_truth = Some(KeptTruth::in_folder(program.folder(None, "truth")));
    }
    for line in &backends.notices {
        println!("{line}");
    }
    for backend in &backends.backends {
        println!("{}", device_line(&**backend));
    }
    // The report has what readers of files left aside, and `verdict` prints it.
    for notice in inputs.iter().flat_map(|input| &input.scene.notices) {
        if !backends.notices.contains(notice) {
            backends.notices.push(notice.clone());
        }
    }
    // Measure the scenes, and write the report.
    let plan = ComparisonPlan::new(&inputs, &options);
    let report = Report::create(&out, plan, &places, arguments.arrays)?;
    measure(
        &inputs,
        &places,
        &options,
        &mut backends,
        &report,
        arguments.fresh,
    )?;
    let (comparison, page) = report.finish(stability.as_ref())?;
    conclude(&comparison, stability.as_ref(), &page);
    let guarded = match baseline {
        Some(old) => {
            let old = of_shard(old, &inputs, &places);
            let mut changes = changes(&old, &comparison, &except);
            let own: Vec<SceneInput> = places.iter().map(|&place| inputs[place].clone()).collect();
            time_suspects_again(&mut changes, &own, &options, &mut backends)
                .and_then(|()| guard(&changes))
        }
        None => Ok(()),
    };
    let named = arguments.scenes.iter().zip(&inputs);
    let of_files: Vec<&str> = named
        .filter(|(name, _)| umbrage_scenes::find(name).is_none())
        .map(|(_, input)| input.scene.name.as_str())
        .collect();
    let limit = |name: &str| limit_of(name, &of_files, arguments.max_left_out);
    let enough = check_left_out(&comparison, limit);
    // All are printed; the first error is returned.
    verdict(&comparison).and(enough).and(guarded)
}

/// Maximum number of scenes for which tables are printed.
const MAX_TABLES: usize = 3;

/// Prints tables if there are few scenes, a recommendation, and the path of the report.
pub(crate) fn conclude(comparison: &Comparison, stability: Option<&StabilitySource>, page: &Path) {
    if comparison.scenes.len() <= MAX_TABLES {
        table::print(&comparison.scenes);
    }
    println!();
    for line in summary::lines(comparison, stability) {
        println!("{line}");
    }
    println!("report: {}", page.display());
}

/// Reads a baseline. Checks that the report doesn't overwrite it and that all exceptions occur in
/// it.
fn read_baseline(path: &Path, out: &Path, except: &Except) -> Result<Comparison, Invalid> {
    check_not_overwritten(path, out)?;
    let baseline = read(path)?;
    except.check(&baseline)?;
    Ok(baseline)
}

fn time_suspects_again(
    changes: &mut Changes,
    inputs: &[SceneInput],
    options: &CompareOptions,
    backends: &mut Backends,
) -> Result<()> {
    if !changes.suspects.is_empty() {
        println!(
            "timing {} rows or techniques again that look slower than in the baseline",
            changes.suspects.len()
        );
    }
    time_again(changes, inputs, options, backends)?;
    Ok(())
}

/// Returns a line with a backend's name and the rounding of its device.
fn device_line(backend: &dyn Backend) -> String {
    match backend.kind() {
        "cpu" => format!("on {}", backend.name()),
        _ => format!("on {}: {}", backend.name(), backend.snapping()),
    }
}

/// Returns the baseline without the scenes that belong to other shards.
fn of_shard(mut old: Comparison, inputs: &[SceneInput], places: &[usize]) -> Comparison {
    let mut own: Vec<&str> = Vec::new();
    let mut others: Vec<&str> = Vec::new();
    for (place, input) in inputs.iter().enumerate() {
        if places.contains(&place) {
            own.push(&input.scene.name);
        } else {
            others.push(&input.scene.name);
        }
    }
    old.scenes.retain(|scene| {
        let name = scene.name.as_str();
        own.contains(&name) || !others.contains(&name)
    });
    old
}

/// Returns the indices of this run's scenes among all scenes. Errors if there are none.
fn places(scenes: usize, shard: Option<Shard>) -> Result<Vec<usize>> {
    let places: Vec<usize> = (0..scenes)
        .filter(|&i| shard.is_none_or(|s| s.takes(i)))
        .collect();
    if places.is_empty() {
        return Err(Usage(format!(
            "--shard: this shard is empty, as there are only {scenes} scenes; use fewer shards"
        ))
        .into());
    }
    Ok(places)
}

/// Measures the scenes that the folder doesn't have yet. Each one is written when it is done.
fn measure(
    inputs: &[SceneInput],
    places: &[usize],
    options: &CompareOptions,
    backends: &mut Backends,
    report: &Report,
    fresh: bool,
) -> Result<()> {
    let environment = backends.environment(options);
    let mut done: Vec<usize> = Vec::new();
    let mut todo: Vec<usize> = Vec::new();
    for &place in places {
        let is_done = if fresh {
            Ok(false)
        } else {
            report.has(place, &environment)
        };
        match is_done {
            Ok(true) => done.push(place),
            Ok(false) => todo.push(place),
            // Measure damaged results again, and report it.
            Err(why) => {
                println!("note: {why} (measuring it again)");
                todo.push(place);
            }
        }
    }
    if !done.is_empty() {
        println!(
            "{} of {} scenes are reused from an earlier run (--fresh measures them again)",
            done.len(),
            places.len()
        );
    }
    let pending: Vec<SceneInput> = todo.iter().map(|&place| inputs[place].clone()).collect();
    cost::announce(&pending, options, backends)?;
    let notices = backends.notices.clone();
    let mut next = todo.into_iter();
    let progress = Progress::new();
    let measured = run(
        &pending,
        options,
        backends,
        &mut |result, images| {
            let place = next.next().unwrap_or_default();
            report.scene(place, &environment, &notices, result, images)
        },
        &|event| progress.note(event),
    );
    progress.note(CompareEvent::Writing);
    progress.finish();
    measured?;
    Ok(())
}

/// Prints the changes since the baseline. Errors if anything is worse or missing.
fn guard(changes: &Changes) -> Result<()> {
    println!("\nagainst the baseline:");
    for note in &changes.notes {
        println!("note: {note}");
    }
    for (word, lines) in [("better", &changes.better), ("new", &changes.new)] {
        if !lines.is_empty() {
            println!("{} {word}:\n  {}", lines.len(), some(lines));
        }
    }
    let mut faults = Vec::new();
    if changes.compared == 0 {
        faults.push(
            "no row of the baseline could be compared; use the scenes and options of the baseline"
                .to_owned(),
        );
    }
    if !changes.worse.is_empty() {
        let count = changes.worse.len();
        let lines = changes.worse.join("\n  ");
        faults.push(format!(
            "{count} figures are worse than in the baseline:\n  {lines}"
        ));
    }
    if !changes.lost.is_empty() {
        let lines = some(&changes.lost);
        let exceptions: Vec<String> = changes
            .except
            .iter()
            .map(|name| format!("--baseline-except '{name}'"))
            .collect();
        let help = format!("if this is intended, add {}", exceptions.join(" "));
        faults.push(format!(
            "parts of the baseline are missing:\n  {lines}\n{help}"
        ));
    }
    if faults.is_empty() {
        println!(
            "no regression in {} rows, {} of them timed",
            changes.compared, changes.timed
        );
        return Ok(());
    }
    bail!("{}", faults.join("\n"))
}

/// Returns the first lines and the number of omitted ones.
fn some(lines: &[String]) -> String {
    let shown = lines[..lines.len().min(MAX_LINES)].join("\n  ");
    let rest = lines.len().saturating_sub(MAX_LINES);
    if rest == 0 {
        shown
    } else {
        format!("{shown}\n  and {rest} more")
    }
}

/// Maximum number of printed lines of one kind: a new technique alone may have hundreds.
const MAX_LINES: usize = 20;

/// Prints the notices. Errors if there are faults.
pub(crate) fn verdict(comparison: &Comparison) -> Result<()> {
    for notice in &comparison.notices {
        println!("note: {notice}");
    }
    let faults = comparison.faults();
    if faults.is_empty() {
        return Ok(());
    }
    bail!(
        "{} results are invalid:\n  {}",
        faults.len(),
        faults.join("\n  ")
    )
}

/// Returns the named scenes, or the suite: full-size scenes, then checks.
fn scenes(program: &Program, arguments: &CompareArguments) -> Result<Vec<SceneInput>> {
    let content = Box::new(content_options(program, arguments)?);
    if !arguments.scenes.is_empty() {
        let own = CompareOptions {
            knows_receivers: false,
            ..options_of(program, arguments)?
        };
        let named = arguments.scenes.iter();
        return named
            .map(|name| scene(program, name, &content, &own))
            .collect();
    }
    let is_content = |entry: &&SceneEntry| entry.kind == Kind::Content;
    let all = umbrage_scenes::all().iter();
    let checks = all.clone().filter(|entry| entry.suite);
    if arguments.quick {
        println!(
            "--quick: four scenes in small images with representative settings; without it there \
             are more scenes and settings. To measure your own scene: cargo xtask compare model.glb"
        );
    }
    if let Some(techniques) = left_out(program, arguments) {
        println!(
            "quick runs and the suite's checks omit {techniques}; name them by --technique, or \
             name a scene, to include them"
        );
    }
    let mut suite = Vec::new();
    for entry in all.filter(is_content).chain(checks) {
        if !arguments.quick || entry.quick {
            suite.push(of_entry((entry.build)(), entry, &content));
        }
    }
    Ok(suite)
}

/// Returns a scene by name or path. `content` are the options of built-in full-size scenes, `own`
/// those of the user's scenes.
fn scene(
    program: &Program,
    name: &str,
    content: &CompareOptions,
    own: &CompareOptions,
) -> Result<SceneInput> {
    let scene = inputs::load(program, name, color_side(own))?;
    Ok(match umbrage_scenes::find(name) {
        Some(entry) => of_entry(scene, entry, content),
        None => SceneInput {
            section: Section::Content,
            options: Some(Box::new(own.clone())),
            ..SceneInput::new(scene, "")
        },
    })
}

/// Returns the greatest side of textures that only colour surfaces, texels.
fn color_side(options: &CompareOptions) -> u32 {
    /// Texels for each pixel, along a side. A frame may show a part of a texture: an atlas, or a
    /// wall that the camera is close to.
    const TEXELS_A_PIXEL: u32 = 4;
    /// Width of the images of models. The width of a scene file's images is known only after its
    /// textures are read: files up to 2560 pixels wide still have one texel per pixel.
    const USUAL_WIDTH: u32 = 640;
    if !options.color {
        return 0;
    }
    let width = options.size.map_or(USUAL_WIDTH, UVec2::max_element);
    TEXELS_A_PIXEL.saturating_mul(width)
}

/// Returns the names of techniques that quick runs and the suite's checks omit. `None` if the user
/// named techniques or nothing is omitted.
fn left_out(program: &Program, arguments: &CompareArguments) -> Option<String> {
    if arguments.full || !arguments.techniques.is_empty() {
        return None;
    }
    let all = program.catalogue.all().iter();
    let names: Vec<&str> = all
        .filter(|entry| !entry.is_previewed)
        .map(|entry| entry.technique.name)
        .collect();
    (!names.is_empty()).then(|| names.join(", "))
}

/// Returns a built-in scene with the data of its entry. Full-size scenes have their own options.
fn of_entry(scene: Scene, entry: &SceneEntry, content: &CompareOptions) -> SceneInput {
    let check = SceneInput {
        fit: entry.fit,
        ..SceneInput::new(scene, entry.summary)
    };
    if !entry.kind.is_full_size() {
        return check;
    }
    SceneInput {
        section: Section::Content,
        options: Some(Box::new(content.clone())),
        ..check
    }
}

/// Returns the options of the built-in full-size scenes.
fn content_options(program: &Program, arguments: &CompareArguments) -> Result<CompareOptions> {
    let mut out = if arguments.quick {
        CompareOptions::quick_content()
    } else {
        CompareOptions::content()
    };
    if arguments.full {
        out.truth.block_side = 1;
        out.truth.samples = 256;
        out.map_sizes = vec![1024, 2048, 4096];
    }
    // If a scene is named, show all its settings.
    out.headline = !arguments.full && arguments.scenes.is_empty();
    set_common(&mut out, program, arguments)?;
    Ok(out)
}

fn options_of(program: &Program, arguments: &CompareArguments) -> Result<CompareOptions> {
    let known: Vec<&str> = program
        .catalogue
        .all()
        .iter()
        .map(|e| e.technique.name)
        .collect();
    let unknown = arguments
        .techniques
        .iter()
        .find(|name| !known.contains(&name.as_str()));
    if let Some(unknown) = unknown {
        return Err(Usage(format!(
            "there is no technique `{unknown}`; use some of {}",
            known.join(", ")
        ))
        .into());
    }
    let is_suite = arguments.scenes.is_empty();
    let mut out = if arguments.quick || (is_suite && !arguments.full) {
        CompareOptions::quick()
    } else {
        CompareOptions::default()
    };
    out.headline = is_suite && arguments.quick;
    if is_suite && arguments.full {
        // 1024 rays in penumbrae: a standard error well below that of any technique, in a quarter
        // of the time.
        out.truth.samples = 256;
    }
    set_common(&mut out, program, arguments)?;
    Ok(out)
}

/// Sets the options that apply to all scenes.
fn set_common(
    out: &mut CompareOptions,
    program: &Program,
    arguments: &CompareArguments,
) -> Result<()> {
    out.catalogue = program.catalogue.clone();
    out.techniques.clone_from(&arguments.techniques);
    // If a scene is named, measure all techniques in it.
    out.is_preview &= arguments.scenes.is_empty();
    out.presets = presets::read(program, &arguments.presets)?;
    if let Some(error) = arguments.max_error {
        presets::add_soft(&mut out.presets, error)?;
    }
    out.color = arguments.color;
    out.size = arguments.size.map(UVec2::from_array).or(out.size);
    out.runs = if arguments.deterministic {
        None
    } else {
        arguments.runs.map(Runs::exactly).or(out.runs)
    };
    out.prices = inputs::prices(arguments.prices.as_deref())?;
    out.motion = match arguments {
        _ if arguments.still => FrameMotion::Still,
        _ if arguments.all_moves => FrameMotion::AllMoves,
        _ => FrameMotion::CameraMoves,
    };
    out.truth.samples = arguments.samples.unwrap_or(out.truth.samples);
    if !arguments.map_sizes.is_empty() {
        out.map_sizes = sort_sizes(&arguments.map_sizes);
    }
    Ok(())
}

/// Returns the sides in rising order without duplicates. Sweeps over other settings use the middle
/// one.
fn sort_sizes(sizes: &[u32]) -> Vec<u32> {
    let mut out = sizes.to_vec();
    out.sort_unstable();
    out.dedup();
    out
}

#[cfg(test)]
mod tests {
    use super::sort_sizes;

    #[test]
    fn map_sizes_may_come_in_any_order() {
        assert_eq!(sort_sizes(&[2048, 512, 1024, 512]), [512, 1024, 2048]);
    }
}
