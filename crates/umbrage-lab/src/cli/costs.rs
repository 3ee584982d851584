//! Measures the cost of work on this machine.

use crate::cli::{bench::BenchArguments, inputs, progress::LoggedBar};
use anyhow::{Context, Result};
use comfy_table::{CellAlignment, Table, presets::UTF8_FULL_CONDENSED};
use umbrage_core::{Backend, Fit, Scene, glam::UVec2};
use umbrage_plan::catalogue::all;
use umbrage_plan::cost::{Calibration, CostSample, KIND_NAMES, PriceList, fit, time_work};
use umbrage_techniques::TechniquePreset;

/// Scenes that are timed with the same image and map sizes.
struct CostsScene {
    /// Their names.
    scenes: &'static [&'static str],
    /// Image sizes, pixels.
    sizes: &'static [UVec2],
    /// Sides of maps, texels.
    maps: [u32; 2],
}

/// Small scenes of 100 to 40,000 triangles with well used, badly used and cube maps, then large
/// scenes.
///
/// The large ones have 170,000 to 1.7 million triangles: a triangle of a large mesh costs less than
/// one of a small mesh.
const STAGES: [CostsScene; 2] = [
    CostsScene {
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
    CostsScene {
        scenes: &["night-room", "dancer-soft", "nave", "valley", "leaf-cards"],
        sizes: &[UVec2::new(1280, 720)],
        maps: [1024, 2048],
    },
];

/// Times techniques of all kinds, fits prices to the times, and prints the prices.
pub(crate) fn costs(options: &BenchArguments) -> Result<()> {
    if let Some(path) = &options.write {
        // Check the output file first: errors must not come after minutes of measuring.
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
    let mut backends = backends.backends;
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
                println!("prices of {kind} are the built-in ones, as it was not timed");
            }
        }
    }
    Ok(())
}

/// Times all stages, and shows the progress.
pub(crate) fn time_stages(backend: &mut dyn Backend, runs: u32) -> Result<Vec<CostSample>> {
    let count: usize = STAGES.iter().map(CostsScene::count).sum();
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

impl CostsScene {
    /// Returns the number of settings to time.
    fn count(&self) -> usize {
        self.scenes.len() * self.sizes.len() * settings(&self.maps).len()
    }
}

/// Returns the first, middle and last setting of each technique: all kinds of work, few duplicates.
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
        .set_header(["unit of work", "nanoseconds"]);
    for (kind, price) in KIND_NAMES.iter().zip(found.model.nanoseconds) {
        table.add_row([(*kind).to_owned(), format!("{price:.3}")]);
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    println!("\n{name}: {} recipes timed\n{table}", found.samples.len());
    println!(
        "half of the times are predicted within a factor of {:.2}, 90 % within {:.2}",
        found.typical_factor, found.factor_of_nine_in_ten
    );
    let mut predicted: Vec<(f64, &CostSample)> = Vec::new();
    for sample in &found.samples {
        let ratio = found.model.milliseconds(&sample.work) / sample.milliseconds.max(1e-6);
        predicted.push((ratio, sample));
    }
    // Sort by deviation: factors of 2 and 1/2 deviate equally.
    predicted.sort_by(|a, b| b.0.ln().abs().total_cmp(&a.0.ln().abs()));
    for (ratio, sample) in predicted.iter().take(5) {
        println!(
            "  largest deviation: {} takes {:.3} ms, predicted {ratio:.2} times as much",
            sample.label, sample.milliseconds
        );
    }
}
