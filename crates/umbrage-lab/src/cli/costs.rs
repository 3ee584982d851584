//! Measures what work costs on this machine.

use crate::cli::{bench::BenchArguments, inputs, progress::LoggedBar};
use anyhow::{Context, Result};
use comfy_table::{CellAlignment, Table, presets::UTF8_FULL_CONDENSED};
use umbrage_core::{Backend, Fit, Scene, glam::UVec2};
use umbrage_plan::catalogue::all;
use umbrage_plan::cost::{Calibration, CostSample, KIND_NAMES, PriceList, fit, time_work};
use umbrage_techniques::TechniquePreset;

/// Scenes that are timed alike.
struct Stage {
    /// Their names.
    scenes: &'static [&'static str],
    /// Image sizes, pixels.
    sizes: &'static [UVec2],
    /// Sides of maps, texels.
    maps: [u32; 2],
}

/// Scenes of 100 to 40,000 triangles with maps that are used well and badly, and with a cube of
/// maps; then frames of 170,000 to 1.7 million triangles, since a triangle of a large mesh costs
/// less than one of a small one.
const STAGES: [Stage; 2] = [
    Stage {
        scenes: &[
            "cubes",
            "teapot-lamp",
            "lamp-in-room",
            "ten-thousand-boxes",
            "figure",
        ],
        sizes: &[UVec2::new(320, 180), UVec2::new(960, 540)],
        maps: [256, 1024],
    },
    Stage {
        scenes: &["night-room", "dancer-soft", "nave", "valley", "leaf-cards"],
        sizes: &[UVec2::new(1280, 720)],
        maps: [1024, 2048],
    },
];

/// Times techniques of all kinds, fits prices to the times, and prints them.
pub(crate) fn costs(options: &BenchArguments) -> Result<()> {
    if let Some(path) = &options.write {
        // An error must not come after minutes of measuring.
        let opened = std::fs::File::options()
            .create(true)
            .append(true)
            .open(path);
        opened.with_context(|| format!("`{}`", path.display()))?;
    }
    let backends = inputs::open(options.backend, None)?;
    for notice in &backends.notices {
        println!("{notice}");
    }
    let mut backends = backends.playing;
    let mut prices = PriceList::default();
    let mut names = Vec::new();
    for backend in &mut backends {
        let found = fit(time_stages(&mut **backend, options.runs)?);
        print(backend.name(), &found);
        names.push(backend.name().to_owned());
        if backend.kind() == "cpu" {
            prices.cpu = found.model;
        } else {
            prices.wgpu = found.model;
        }
    }
    prices.measured_on = names.join("; ");
    if let Some(path) = &options.write {
        let text = prices.to_toml()?;
        std::fs::write(path, text).with_context(|| format!("`{}`", path.display()))?;
        println!("\nprices: {}", path.display());
        let timed: Vec<&str> = backends.iter().map(|b| b.kind()).collect();
        for kind in ["cpu", "wgpu"] {
            if !timed.contains(&kind) {
                println!("those of {kind} are the built-in ones, as it was not timed");
            }
        }
    }
    Ok(())
}

/// Times all stages, and reports progress.
pub(crate) fn time_stages(backend: &mut dyn Backend, runs: u32) -> Result<Vec<CostSample>> {
    let count: usize = STAGES.iter().map(Stage::count).sum();
    let bar = LoggedBar::of_steps(format!("timing {}", backend.name()), count as u64);
    let mut samples = Vec::new();
    for stage in &STAGES {
        let scenes: Vec<Scene> = stage
            .scenes
            .iter()
            .filter_map(|name| umbrage_scenes::find(name))
            .map(|e| (e.build)())
            .collect();
        let settings = settings(&stage.maps);
        let more = time_work(backend, &scenes, stage.sizes, &settings, runs, &mut || {
            bar.bar.inc(1)
        })?;
        samples.extend(more);
    }
    bar.finish();
    Ok(samples)
}

impl Stage {
    /// Returns how many settings are played in it.
    fn count(&self) -> usize {
        self.scenes.len() * self.sizes.len() * settings(&self.maps).len()
    }
}

/// Returns the first, middle and last setting of each technique: all kinds of work, few alike.
fn settings(maps: &[u32]) -> Vec<TechniquePreset> {
    let mut out = Vec::new();
    for entry in all() {
        let of_entry = (entry.settings)(maps, Fit::Tight);
        let last = of_entry.len().saturating_sub(1);
        for (i, setting) in of_entry.into_iter().enumerate() {
            if i == 0 || i == last / 2 || i == last {
                out.push(setting);
            }
        }
    }
    out
}

fn print(name: &str, found: &Calibration) {
    let mut table = Table::new();
    table
        .load_style(UTF8_FULL_CONDENSED)
        .set_header(["a piece of", "nanoseconds"]);
    for (kind, price) in KIND_NAMES.iter().zip(found.model.nanoseconds) {
        table.add_row([(*kind).to_owned(), format!("{price:.3}")]);
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    println!("\n{name}: {} recipes timed\n{table}", found.samples.len());
    println!(
        "half of the times are predicted within x{:.2}, nine of ten within x{:.2}",
        found.typical_factor, found.factor_of_nine_in_ten
    );
    let mut predicted: Vec<(f64, &CostSample)> = Vec::new();
    for sample in &found.samples {
        let ratio = found.model.milliseconds(&sample.work) / sample.milliseconds.max(1e-6);
        predicted.push((ratio, sample));
    }
    // Farthest off first: a factor of 2 is as far off as one of 1/2.
    predicted.sort_by(|a, b| b.0.ln().abs().total_cmp(&a.0.ln().abs()));
    for (ratio, sample) in predicted.iter().take(5) {
        println!(
            "  farthest off: {} takes {:.3} ms, predicted x{ratio:.2}",
            sample.label, sample.milliseconds
        );
    }
}
