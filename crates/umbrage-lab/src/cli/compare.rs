//! `compare`: compares scenes, prints a table and writes the report.

use crate::{
    baseline::{Changes, Except, apart, changes, read, time_again},
    cli::{
        args::shared::{BackendName, Shard, parse_shard, parse_size},
        cost, inputs, presets,
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
  cargo xtask compare                                        the built-in suite: frames of real size, then checks
  cargo xtask compare --full                                 the same with every setting, every pixel judged: hours
  cargo xtask compare street nave-soft --all-moves           two frames; charts count what is made anew if all moves
  cargo xtask compare --list                                 what there is to compare
  cargo xtask compare cubes --technique pcf --backend cpu    one scene, technique and backend
  cargo xtask compare lamp.toml model.obj --quick            scenes of your own, small and fast
  cargo xtask compare 'model.glb#night'                      one of a glTF file's scenes, by its name or number
  cargo xtask compare cubes --preset mine.toml               settings of your own, or of `plan`
  cargo xtask compare nave-soft --max-error 0.02             `soft` with an error of your own
  cargo xtask compare cubes --size 640x480 --map-sizes 512,2048 --arrays --out report
  cargo xtask compare figure --color --map-sizes 1024        with shaded pictures
  cargo xtask compare --deterministic --shard 2/8 --out s2   an eighth of the suite, for `cargo xtask merge`
  cargo xtask compare --stability target/stability           and what each setting fails there
  cargo xtask compare --baseline old/results.json            fail if anything got slower or less accurate")]
pub(crate) struct CompareArguments {
    /// Built-in scenes by name, scene files (.toml) or models (.obj, .glb, .gltf); none: the
    /// built-in suite
    #[arg(value_name = "SCENE")]
    pub(crate) scenes: Vec<String>,
    /// Only these techniques; may be repeated, or separated by commas
    #[arg(long = "technique", value_name = "NAME", value_delimiter = ',')]
    pub(crate) techniques: Vec<String>,
    /// A technique with settings of your own, as `plan` writes it (.preset.toml), played beside the
    /// others under its file's name; may be repeated. `--technique none,hard` leaves these beside
    /// it
    #[arg(long = "preset", value_name = "FILE")]
    pub(crate) presets: Vec<PathBuf>,
    /// `soft` with this root mean square error at straight edges, 0.002 to 0.2, played beside the
    /// others as `soft-E`
    #[arg(long, value_name = "E", value_parser = parse_soft_error)]
    pub(crate) max_error: Option<f32>,
    /// Which backends play
    #[arg(long, value_name = "NAME", default_value = "available")]
    pub(crate) backend: BackendName,
    /// Graphics adapter by part of its name, such as llvmpipe
    #[arg(long, value_name = "NAME")]
    pub(crate) adapter: Option<String>,
    /// Image size in pixels; else each scene's own (1280x720 for frames of real size)
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub(crate) size: Option<[u32; 2]>,
    /// Sides of the shadow maps, texels, in any order; every setting is compared at the middle one,
    /// each technique's first at all; else 512, 1024 and 2048 (1024 and 2048, with --full 4096,
    /// too, for frames of real size), or one with --quick
    #[arg(long, value_name = "SIDE", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(1..=16_384))]
    pub(crate) map_sizes: Vec<u32>,
    /// Prices of work, as `bench --costs --write` or `card` (.json) measures them; else the
    /// built-in ones
    #[arg(long, value_name = "FILE")]
    pub(crate) prices: Option<PathBuf>,
    /// Truth's rays a pixel for lights with an extent
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u32).range(1..=65_536))]
    pub(crate) samples: Option<u32>,
    /// Timed runs of each row; their median is kept
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) runs: Option<u32>,
    /// Folder for the report; else target/compare in the repository
    #[arg(long, value_name = "FOLDER")]
    pub(crate) out: Option<PathBuf>,
    /// Small images, few samples, few runs, without techniques that take long: a look rather than a
    /// measurement
    #[arg(long)]
    pub(crate) quick: bool,
    /// Every setting of every technique, and truth at every pixel, on frames of real size, too
    #[arg(long, conflicts_with = "quick")]
    pub(crate) full: bool,
    /// Frames in which nothing moves: charts and tables count the lookup alone
    #[arg(long, conflicts_with_all = ["camera_moves", "all_moves"])]
    pub(crate) still: bool,
    /// Frames in which the camera moves: charts and tables count what is made anew for it (the
    /// default)
    #[arg(long, conflicts_with = "all_moves")]
    pub(crate) camera_moves: bool,
    /// Frames in which casters, lights and camera move: charts and tables count all, hierarchies
    /// over the triangles included
    #[arg(long)]
    pub(crate) all_moves: bool,
    /// Write NumPy arrays of truth, distance and every mask, too
    #[arg(long)]
    pub(crate) arrays: bool,
    /// Shade every row in colour, too, and compare the colours between backends
    #[arg(long)]
    pub(crate) color: bool,
    /// No wall-clock times and no date, so that the report is the same, byte for byte, whenever it
    /// is made
    #[arg(long, conflicts_with = "runs")]
    pub(crate) deterministic: bool,
    /// Compare with the results.json of an earlier run, kept in another folder than this report's,
    /// and fail if anything got slower or less accurate beyond the noise, is missing or can't be
    /// compared any more
    #[arg(long, value_name = "RESULTS.JSON")]
    pub(crate) baseline: Option<PathBuf>,
    /// What may be missing or changed since the baseline: a scene, technique, backend or
    /// `technique (settings)`; may be repeated
    #[arg(long, value_name = "NAME", requires = "baseline")]
    pub(crate) baseline_except: Vec<String>,
    /// Folder of a `stability` run, or its results.json: the report says beside each setting which
    /// rows it fails; else target/stability in the repository, if it is there (but not with
    /// --deterministic)
    #[arg(long, value_name = "FOLDER")]
    pub(crate) stability: Option<PathBuf>,
    /// Only every N-th scene, from the K-th on; `cargo xtask merge` joins the shards
    #[arg(long, value_name = "K/N", value_parser = parse_shard)]
    pub(crate) shard: Option<Shard>,
    /// Measure every scene again, even if the folder has it from a run that was stopped
    #[arg(long)]
    pub(crate) fresh: bool,
    /// List scenes and techniques, and end
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

/// Compares, prints and reports; errors if backends disagree, a control has no effect, or something
/// got worse.
pub(crate) fn compare(program: &Program, arguments: &CompareArguments) -> Result<()> {
    let out = program.folder(arguments.out.as_deref(), "compare");
    // Before anything is measured: errors must not come after minutes of measuring.
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
    for backend in &backends.playing {
        println!("{}", on(&**backend));
    }
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
    // Both are printed; the first error is returned.
    verdict(&comparison).and(guarded)
}

/// Scenes up to which each gets a table: those of more would scroll by.
const MAX_TABLES: usize = 3;

/// Prints the tables of a few scenes, what to use, and where the report is.
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

/// Reads a baseline, and checks that the report doesn't overwrite it and that it has all that is
/// excepted.
fn read_baseline(path: &Path, out: &Path, except: &Except) -> Result<Comparison, Invalid> {
    apart(path, out)?;
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
            "timing {} rows or techniques again, which look slower than the baseline's",
            changes.suspects.len()
        );
    }
    time_again(changes, inputs, options, backends)?;
    Ok(())
}

/// Returns a line about a backend: its name, and how its device rounds.
fn on(backend: &dyn Backend) -> String {
    match backend.kind() {
        "cpu" => format!("on {}", backend.name()),
        _ => format!("on {}: {}", backend.name(), backend.snapping()),
    }
}

/// Returns the baseline without the scenes that only other shards measure, as this one can't have
/// them.
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

/// Returns the places of this run's scenes among all; errors if there are none.
fn places(scenes: usize, shard: Option<Shard>) -> Result<Vec<usize>> {
    let places: Vec<usize> = (0..scenes)
        .filter(|&i| shard.is_none_or(|s| s.takes(i)))
        .collect();
    if places.is_empty() {
        return Err(Usage(format!(
            "this shard is empty: there are only {scenes} scenes; use fewer shards"
        ))
        .into());
    }
    Ok(places)
}

/// Measures the scenes that the folder doesn't have yet; each is written as soon as it is done.
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
            // Damaged figures are measured again; the reader must know.
            Err(why) => {
                println!("note: {why} (this is done now)");
                todo.push(place);
            }
        }
    }
    if !done.is_empty() {
        println!(
            "{} of {} scenes are there from an earlier run (--fresh measures anew)",
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

/// Prints what has changed since the baseline; errors if anything got worse or was lost.
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
            "not one row of the baseline could be compared: give it the same scenes and options"
                .to_owned(),
        );
    }
    if !changes.worse.is_empty() {
        let count = changes.worse.len();
        let lines = changes.worse.join("\n  ");
        faults.push(format!(
            "{count} figures are worse than the baseline's:\n  {lines}"
        ));
    }
    if !changes.lost.is_empty() {
        let lines = some(&changes.lost);
        let exceptions: Vec<String> = changes
            .except
            .iter()
            .map(|name| format!("--baseline-except '{name}'"))
            .collect();
        let help = format!("if that is meant, add {}", exceptions.join(" "));
        faults.push(format!(
            "the baseline has what is not compared:\n  {lines}\n{help}"
        ));
    }
    if faults.is_empty() {
        println!(
            "nothing got worse in {} rows, {} of them timed",
            changes.compared, changes.timed
        );
        return Ok(());
    }
    bail!("{}", faults.join("\n"))
}

/// Returns the first lines, and how many more there are.
fn some(lines: &[String]) -> String {
    let shown = lines[..lines.len().min(MAX_LINES)].join("\n  ");
    let rest = lines.len().saturating_sub(MAX_LINES);
    if rest == 0 {
        shown
    } else {
        format!("{shown}\n  and {rest} more")
    }
}

/// The most lines that are printed of one kind: a new technique alone may have hundreds.
const MAX_LINES: usize = 20;

/// Prints the notices; errors if there are faults.
pub(crate) fn verdict(comparison: &Comparison) -> Result<()> {
    for notice in &comparison.notices {
        println!("note: {notice}");
    }
    let faults = comparison.faults();
    if faults.is_empty() {
        return Ok(());
    }
    bail!(
        "{} results must not be:\n  {}",
        faults.len(),
        faults.join("\n  ")
    )
}

/// Returns the scenes named, or the suite: frames of real size, then checks.
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
    if let Some(techniques) = left_out(program, arguments) {
        let of_what = if arguments.quick {
            "quick looks at the suite"
        } else {
            "the suite's checks"
        };
        println!(
            "{techniques} are left out of {of_what}: name them by --technique, or name a scene"
        );
    }
    let mut suite = Vec::new();
    for entry in all.filter(is_content).chain(checks) {
        // However small the image is, volumes of millions of triangles take minutes.
        if arguments.quick && !entry.quick {
            println!("{} is left out of quick runs of the suite", entry.name);
            continue;
        }
        suite.push(of_entry((entry.build)(), entry, &content));
    }
    Ok(suite)
}

/// `content` are the options of built-in frames of real size, `own` those of scenes of the user's.
fn scene(
    program: &Program,
    name: &str,
    content: &CompareOptions,
    own: &CompareOptions,
) -> Result<SceneInput> {
    let scene = inputs::scene(program, name)?;
    Ok(match umbrage_scenes::find(name) {
        Some(entry) => of_entry(scene, entry, content),
        None => SceneInput {
            section: Section::Content,
            options: Some(Box::new(own.clone())),
            ..SceneInput::new(scene, "")
        },
    })
}

/// Returns the techniques that quick looks at the suite and its checks leave out; none if they are
/// named, or nothing is left out.
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

/// Returns a built-in scene with what its entry says of it. Frames of real size have options of
/// their own.
fn of_entry(scene: Scene, entry: &SceneEntry, content: &CompareOptions) -> SceneInput {
    let check = SceneInput {
        fit: entry.fit,
        ..SceneInput::new(scene, entry.summary)
    };
    if entry.kind != Kind::Content {
        return check;
    }
    SceneInput {
        section: Section::Content,
        options: Some(Box::new(content.clone())),
        ..check
    }
}

/// Returns the options of the built-in frames of real size.
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
    // Whoever names a scene wants to see all of it.
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
    if is_suite && arguments.full {
        // 1024 rays in penumbra: a standard error well below any technique's, in a quarter of the
        // time.
        out.truth.samples = 256;
    }
    set_common(&mut out, program, arguments)?;
    Ok(out)
}

/// Sets what the command line says of all scenes.
fn set_common(
    out: &mut CompareOptions,
    program: &Program,
    arguments: &CompareArguments,
) -> Result<()> {
    out.catalogue = program.catalogue.clone();
    out.techniques.clone_from(&arguments.techniques);
    // Whoever names a scene wants to see all techniques in it.
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
        out.map_sizes = rising(&arguments.map_sizes);
    }
    Ok(())
}

/// Returns the sides in rising order, each once: sweeps over other settings take the middle one.
fn rising(sizes: &[u32]) -> Vec<u32> {
    let mut out = sizes.to_vec();
    out.sort_unstable();
    out.dedup();
    out
}

#[cfg(test)]
mod tests {
    use super::rising;

    #[test]
    fn map_sizes_may_come_in_any_order() {
        assert_eq!(rising(&[2048, 512, 1024, 512]), [512, 1024, 2048]);
    }
}
