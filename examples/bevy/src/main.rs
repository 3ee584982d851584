//! Bevy's own shadows and this library's in the same Bevy scenes, judged by ray-traced truth:
//! `cargo run --release --ignore-rust-version --manifest-path examples/bevy/Cargo.toml -- street forest`.

mod app;
mod judge;
mod plugin;

use anyhow::{Context as _, Result};
use app::{BevyProgram, BevyShadows, ShadowSource};
use bevy::light::ShadowFilteringMethod as Filter;
use clap::Parser;
use judge::{COLUMNS, Judged, make_folder};
use std::{fmt::Write as _, fs, path::PathBuf, sync::Arc};
use umbrage::{
    Cascades, Fit, Layout, ShadowTechnique,
    techniques::{MapFilter as _, Exact, Pcf, Pcss, ShadowMap},
};

/// What Bevy's picture shows where the sun doesn't reach is less.
const DARK: f32 = 1e-4;

/// Bevy's own shadows and this library's in the same scenes, judged by rays.
#[derive(Parser)]
struct Arguments {
    /// Built-in scenes whose first light is a sun.
    #[arg(required = true)]
    scenes: Vec<String>,
    /// Frames that are timed for each setting, in turn with frames without shadows.
    #[arg(long, default_value_t = 7, value_parser = clap::value_parser!(u16).range(1..))]
    frames: u16,
    /// Only settings whose names contain one of these texts; may be repeated.
    #[arg(long)]
    only: Vec<String>,
    /// Write masks and the table into this folder.
    #[arg(long)]
    out: Option<PathBuf>,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let mut table =
        format!("{COLUMNS} ms | ms without shadows | MiB |\n|---|---|--:|--:|--:|--:|--:|--:|\n");
    if let Some(folder) = &arguments.out {
        make_folder(folder)?;
    }
    print!("{table}");
    for name in &arguments.scenes {
        let judged = Judged::new(name)?;
        for line in judged.play_all(&arguments)? {
            writeln!(table, "{line}")?;
        }
    }
    if let Some(folder) = &arguments.out {
        fs::write(folder.join("bevy.md"), table)?;
    }
    Ok(())
}

impl Judged {
    /// Plays all settings, and returns the table's lines.
    fn play_all(&self, arguments: &Arguments) -> Result<Vec<String>> {
        let mut without = BevyProgram::start(&self.scene, &self.geometry, &ShadowSource::Nothing)?;
        let lit = without.picture()?;
        let mut lines = Vec::new();
        for (label, source) in self.settings() {
            let is_wanted = arguments.only.iter().any(|text| label.contains(text));
            if !arguments.only.is_empty() && !is_wanted {
                continue;
            }
            let line = self
                .play(&label, &source, &lit, &mut without, arguments)
                .with_context(|| format!("{}: {label}", self.scene.name))?;
            println!("{line}");
            lines.push(line);
        }
        Ok(lines)
    }

    fn play(
        &self,
        label: &str,
        source: &ShadowSource,
        lit: &[f32],
        without: &mut BevyProgram,
        arguments: &Arguments,
    ) -> Result<String> {
        let mut program = BevyProgram::start(&self.scene, &self.geometry, source)?;
        let shadowed = program.picture()?;
        let judged_picture = self.judge(lit, &shadowed, DARK)?;
        let mut with_shadows = Vec::new();
        let mut without_shadows = Vec::new();
        for _ in 0..arguments.frames {
            without_shadows.push(without.frame()?);
            with_shadows.push(program.frame()?);
        }
        let milliseconds = median(with_shadows);
        let bare_milliseconds = median(without_shadows);
        if let Some(folder) = &arguments.out {
            self.save(&judged_picture, label, folder)?;
        }
        Ok(format!(
            "{} {milliseconds:.0} | {bare_milliseconds:.0} | {:.0} |",
            judged_picture.row(&self.scene.name, label),
            program.bytes() as f64 / (1 << 20) as f64
        ))
    }

    /// Returns the settings that are played, with their names in the table.
    fn settings(&self) -> Vec<(String, ShadowSource)> {
        let distances = self.truth.receivers.distance.iter().copied();
        let farthest = distances.fold(0.0, f32::max);
        let is_soft = !self.scene.lights[0].is_ideal();
        let mut all = vec![(
            "none, but a prepass".to_owned(),
            ShadowSource::NothingButPrepass,
        )];
        for (label, settings) in bevy_settings(farthest, is_soft) {
            all.push((format!("Bevy, {label}"), ShadowSource::Bevy(settings)));
        }
        for (label, technique) in umbrage_settings(farthest, is_soft) {
            let anew = ShadowSource::Umbrage(Arc::clone(&technique), true);
            all.push((format!("umbrage, {label}"), anew));
            let kept = ShadowSource::Umbrage(technique, false);
            all.push((format!("umbrage, {label}, nothing moves"), kept));
        }
        all
    }
}

/// Returns the middle one of some times.
fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// Returns Bevy's default, and the settings that might better it in a view that ends `farthest` metres away.
fn bevy_settings(farthest: f32, is_soft: bool) -> Vec<(String, BevyShadows)> {
    let default = BevyShadows {
        size: 2048,
        cascades: 4,
        far: 150.0,
        filter: Filter::Gaussian,
        soft: None,
        contact: false,
    };
    let reaching = BevyShadows {
        far: farthest,
        ..default
    };
    let mut all = vec![
        ("default".to_owned(), default),
        ("as far as is seen".to_owned(), reaching),
    ];
    if is_soft {
        // The unit of Bevy's setting is none of length or angle, so several values are tried.
        for soft in [3.0, 10.0, 30.0] {
            let settings = BevyShadows {
                soft: Some(soft),
                ..reaching
            };
            all.push((format!("as far as is seen, soft {soft}"), settings));
        }
        return all;
    }
    let two_by_two = BevyShadows {
        filter: Filter::Hardware2x2,
        ..reaching
    };
    let temporal = BevyShadows {
        filter: Filter::Temporal,
        ..reaching
    };
    let small = BevyShadows {
        size: 1024,
        ..reaching
    };
    let contact = BevyShadows {
        contact: true,
        ..reaching
    };
    all.push(("as far as is seen, hardware 2x2".to_owned(), two_by_two));
    all.push(("as far as is seen, temporal".to_owned(), temporal));
    all.push(("as far as is seen, 1024".to_owned(), small));
    all.push(("as far as is seen, contact shadows".to_owned(), contact));
    all
}

/// Returns the library's settings: cascades as Bevy's, which don't shimmer while the camera moves, the same fitted tightly, and `exact`.
fn umbrage_settings(farthest: f32, is_soft: bool) -> Vec<(&'static str, Arc<dyn ShadowTechnique>)> {
    let tight = ShadowMap {
        size: 2048,
        layout: Layout::Cascades(Cascades::default()),
        ..ShadowMap::default()
    };
    let stable = ShadowMap {
        fit: Fit::Stable { range: farthest },
        ..tight
    };
    if is_soft {
        let pcss = |map| -> Arc<dyn ShadowTechnique> {
            Arc::new(Pcss::default().on(map))
        };
        return vec![
            ("pcss, 4 stable cascades of 2048", pcss(stable)),
            ("pcss, 4 cascades of 2048", pcss(tight)),
        ];
    }
    let pcf = |map| -> Arc<dyn ShadowTechnique> { Arc::new(Pcf { radius: 1 }.on(map)) };
    let small = ShadowMap {
        size: 1024,
        ..tight
    };
    vec![
        ("pcf 3x3, 4 stable cascades of 2048", pcf(stable)),
        ("pcf 3x3, 4 cascades of 2048", pcf(tight)),
        ("pcf 3x3, 4 cascades of 1024", pcf(small)),
        ("exact", Arc::new(Exact::default())),
    ]
}
