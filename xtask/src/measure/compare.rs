//! `compare`: scenes in, a table and a report out. All the work is the lab's.

use super::{progress::Progress, table};
use crate::{
    cli::{Backend, CompareOptions},
    run::{Usage, root},
};
use anyhow::{Result, bail};
use umbrage_core::glam::UVec2;
use umbrage_lab::{
    compare::{BackendChoice, Backends, Comparison, Event, Options, Runs, SceneInput, compare as run},
    report::Report,
};
use umbrage_scenes::SceneError;
use umbrage_wgpu::AdapterChoice;

/// Compares, prints, reports; fails if backends disagree or a control has no effect.
pub(super) fn compare(options: &CompareOptions) -> Result<()> {
    let inputs = scenes(&options.scenes)?;
    let settings = settings(options)?;
    let mut backends = Backends::open(choice(options.backend), &adapter(options))?;
    for line in backends.notices.iter().cloned().chain(backends.playing.iter().map(|b| format!("on {}", b.name()))) {
        println!("{line}");
    }
    let out = options.out.clone().unwrap_or_else(|| root().join("target/compare"));
    let mut report = Report::create(&out, options.arrays)?;
    let progress = Progress::new();
    let comparison =
        run(&inputs, &settings, &mut backends, &mut |result, images| report.scene(result, images), &|event| {
            progress.note(event)
        });
    progress.note(Event::Writing);
    let comparison = comparison.inspect_err(|_| progress.finish())?;
    let page = report.finish(&comparison);
    progress.finish();
    table::print(&comparison.scenes);
    println!("\nreport: {}", page?.display());
    verdict(&comparison)
}

fn verdict(comparison: &Comparison) -> Result<()> {
    comparison.notices.iter().for_each(|notice| println!("note: {notice}"));
    let faults = comparison.faults();
    if faults.is_empty() {
        return Ok(());
    }
    bail!("{} results must not be:\n  {}", faults.len(), faults.join("\n  "))
}

/// The scenes named, or the suite.
fn scenes(names: &[String]) -> Result<Vec<SceneInput>> {
    if names.is_empty() {
        let suite = umbrage_scenes::all().iter().filter(|e| e.suite);
        return Ok(suite
            .map(|e| SceneInput { scene: (e.build)(), summary: e.summary.to_owned(), fit: e.fit })
            .collect());
    }
    names.iter().map(|name| scene(name)).collect()
}

fn scene(name: &str) -> Result<SceneInput> {
    let entry = umbrage_scenes::find(name);
    let summary = entry.map_or(String::new(), |e| e.summary.to_owned());
    let fit = entry.and_then(|e| e.fit);
    match umbrage_scenes::by_argument(name) {
        Ok(scene) => Ok(SceneInput { scene, summary, fit }),
        Err(e @ SceneError::Unknown { .. }) => Err(Usage(format!("{e} (see `cargo xtask compare --list`)")).into()),
        Err(e) => Err(e.into()),
    }
}

fn settings(options: &CompareOptions) -> Result<Options> {
    let known = umbrage_techniques::all().iter().map(|e| e.name);
    if let Some(unknown) = options.techniques.iter().find(|n| umbrage_techniques::find(n).is_none()) {
        let known: Vec<_> = known.collect();
        return Err(Usage(format!("there is no technique `{unknown}`; use some of {}", known.join(", "))).into());
    }
    let mut out = if options.quick { Options::quick() } else { Options::default() };
    out.techniques.clone_from(&options.techniques);
    out.color = options.color;
    out.size = options.size.map(UVec2::from_array).or(out.size);
    out.runs = options.runs.map_or(out.runs, Runs::exactly);
    if options.scenes.is_empty() && !options.quick {
        // 1024 rays in penumbra: a standard error well below any technique's, in a quarter of the time.
        out.truth.samples = 256;
    }
    out.truth.samples = options.samples.unwrap_or(out.truth.samples);
    if !options.map_sizes.is_empty() {
        out.map_sizes.clone_from(&options.map_sizes);
    } else if options.scenes.is_empty() && !options.quick {
        // Over twenty scenes at one size tell as much as a few at three, in a third of the time.
        out.map_sizes = vec![1024];
    }
    Ok(out)
}

fn choice(backend: Backend) -> BackendChoice {
    match backend {
        Backend::Available => BackendChoice::Available,
        Backend::Cpu => BackendChoice::Cpu,
        Backend::Wgpu => BackendChoice::Wgpu,
        Backend::Both => BackendChoice::Both,
    }
}

fn adapter(options: &CompareOptions) -> AdapterChoice {
    let from_env = AdapterChoice::from_env();
    AdapterChoice { name: options.adapter.clone().or(from_env.name), ..from_env }
}
