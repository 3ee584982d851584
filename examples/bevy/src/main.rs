//! Bevy's own shadows and this library's in the same Bevy scenes, judged by ray-traced truth:
//! `cargo run --release --ignore-rust-version --manifest-path examples/bevy/Cargo.toml -- street forest`.

mod app;
mod plugin;

use anyhow::{Context as _, Result};
use app::{BevyShadows, Program, ShadowSource};
use bevy::light::ShadowFilteringMethod as Filter;
use clap::Parser;
use std::{fmt::Write as _, fs, path::PathBuf, sync::Arc};
use umbrage::{
    Geometry, Layout, Scene, ShadowTechnique,
    cpu::Cpu,
    metrics::{Pixel, ReferenceMask},
    techniques::{Exact, Pcf, Pcss, ShadowMap},
};
use umbrage_plan::truth::{Truth, TruthOptions, trace};

/// Bevy's own shadows and this library's in the same scenes, judged by rays.
#[derive(Parser)]
struct Arguments {
    /// Built-in scenes whose first light is a sun.
    #[arg(required = true)]
    scenes: Vec<String>,
    /// Frames that are timed for each setting, in turn with frames without shadows.
    #[arg(long, default_value_t = 7)]
    frames: usize,
    /// Write masks and the table into this folder.
    #[arg(long)]
    out: Option<PathBuf>,
}

/// A scene with what is known of it.
struct Judged {
    scene: Scene,
    geometry: Geometry,
    truth: Truth,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let mut table = String::from(
        "| scene | shadows | RMSE | false shadow % | false light % | ms more | MiB |\n|---|---|--:|--:|--:|--:|--:|\n",
    );
    if let Some(folder) = &arguments.out {
        fs::create_dir_all(folder).with_context(|| format!("{}", folder.display()))?;
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
    fn new(name: &str) -> Result<Self> {
        let scene = umbrage::scenes::by_argument(name)?;
        let geometry = Geometry::bake(&scene)?;
        let mut cpu = Cpu::new();
        let options = TruthOptions {
            samples: 256,
            ..TruthOptions::default()
        };
        let truth = trace(
            &scene.cameras[0],
            &scene.lights[0],
            &geometry,
            &options,
            &mut |camera, geometry| cpu.receivers(camera, geometry),
            &|_, _| (),
        )?;
        Ok(Self {
            scene,
            geometry,
            truth,
        })
    }

    /// Plays all settings, and returns the table's lines.
    fn play_all(&self, arguments: &Arguments) -> Result<Vec<String>> {
        let mut without = Program::start(&self.scene, &self.geometry, &ShadowSource::Nothing)?;
        let lit = without.picture()?;
        let mut lines = Vec::new();
        for (label, source) in self.settings() {
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
        without: &mut Program,
        arguments: &Arguments,
    ) -> Result<String> {
        let mut program = Program::start(&self.scene, &self.geometry, source)?;
        let shadowed = program.picture()?;
        let mut pixels = self.truth.pixels.clone();
        let mut mask = vec![1.0; lit.len()];
        for i in 0..lit.len() {
            // What the sun doesn't reach at all tells nothing of shadows.
            if lit[i] < 1e-4 {
                if pixels[i] == Pixel::Counted {
                    pixels[i] = Pixel::Elsewhere;
                }
                continue;
            }
            mask[i] = (shadowed[i] / lit[i]).clamp(0.0, 1.0);
        }
        let truth = &self.truth;
        let reference = ReferenceMask::new(truth.size, &truth.visibility, &truth.pixels)?;
        let errors = reference.with_pixels(&pixels)?.errors(&mask)?;
        let mut more = Vec::new();
        for _ in 0..arguments.frames {
            let bare = without.frame()?;
            more.push(program.frame()? - bare);
        }
        more.sort_by(f64::total_cmp);
        let milliseconds = more[more.len() / 2];
        if let Some(folder) = &arguments.out {
            let file = format!(
                "{}.{}.png",
                self.scene.name,
                label.replace([' ', ',', '/'], "-")
            );
            save(folder.join(file), truth, &mask)?;
            let file = format!("{}.truth.png", self.scene.name);
            save(folder.join(file), truth, &truth.visibility)?;
        }
        Ok(format!(
            "| `{}` | {label} | {:.3} | {:.2} | {:.2} | {milliseconds:.0} | {:.0} |",
            self.scene.name,
            errors.rmse,
            errors.false_shadow,
            errors.false_light,
            program.bytes() as f64 / (1 << 20) as f64
        ))
    }

    /// Returns the settings that are played: Bevy's default and what changes it, then the library's.
    fn settings(&self) -> Vec<(String, ShadowSource)> {
        let distances = self.truth.receivers.distance.iter().copied();
        let farthest = distances.fold(0.0, f32::max);
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
        let bevy = |label: &str, settings| (format!("Bevy, {label}"), ShadowSource::Bevy(settings));
        let is_soft = !self.scene.lights[0].is_ideal();
        let mut all = vec![bevy("default", default), bevy("far as seen", reaching)];
        if is_soft {
            for soft in [3.0, 10.0, 30.0] {
                let settings = BevyShadows {
                    soft: Some(soft),
                    ..reaching
                };
                all.push(bevy(&format!("far as seen, soft {soft}"), settings));
            }
        } else {
            let filter = |filter| BevyShadows { filter, ..reaching };
            all.extend([
                bevy("far as seen, hardware 2x2", filter(Filter::Hardware2x2)),
                bevy("far as seen, temporal", filter(Filter::Temporal)),
                bevy(
                    "far as seen, 1024",
                    BevyShadows {
                        size: 1024,
                        ..reaching
                    },
                ),
                bevy(
                    "far as seen, contact shadows",
                    BevyShadows {
                        contact: true,
                        ..reaching
                    },
                ),
            ]);
        }
        let cascades = ShadowMap {
            size: 2048,
            layout: Layout::Cascades(umbrage::Cascades::default()),
            ..ShadowMap::default()
        };
        let pcf = |map| -> Arc<dyn ShadowTechnique> { Arc::new(Pcf { map, radius: 1 }) };
        let mut ours: Vec<(&str, Arc<dyn ShadowTechnique>)> = Vec::new();
        if is_soft {
            ours.push((
                "pcss, 4 cascades of 2048",
                Arc::new(Pcss {
                    map: cascades,
                    ..Pcss::default()
                }),
            ));
        } else {
            ours.push(("pcf 3x3, 4 cascades of 2048", pcf(cascades)));
            ours.push((
                "pcf 3x3, 4 cascades of 1024",
                pcf(ShadowMap {
                    size: 1024,
                    ..cascades
                }),
            ));
            ours.push(("exact", Arc::new(Exact::default())));
        }
        for (label, technique) in ours {
            all.push((
                format!("umbrage, {label}"),
                ShadowSource::Umbrage(Arc::clone(&technique), true),
            ));
            all.push((
                format!("umbrage, {label}, still"),
                ShadowSource::Umbrage(technique, false),
            ));
        }
        all
    }
}

fn save(path: PathBuf, truth: &Truth, mask: &[f32]) -> Result<()> {
    let bytes: Vec<u8> = mask.iter().map(|v| (v * 255.0).round() as u8).collect();
    image::save_buffer(
        path,
        &bytes,
        truth.size.x,
        truth.size.y,
        image::ColorType::L8,
    )?;
    Ok(())
}
