//! three-d's own shadow maps and this library's masks in the same scenes, judged by ray-traced truth:
//! `cargo run --release --manifest-path examples/three_d/Cargo.toml -- street thin-plate`.

mod context;
// Bevy is judged by the same code.
#[path = "../../bevy/src/judge.rs"]
mod judge;
mod program;
mod sun;

use anyhow::{Context as _, Result, ensure};
use clap::Parser;
use judge::{COLUMNS, Judged, make_folder};
use program::{INTENSITY, ThreeDProgram};
use std::{fmt::Write as _, fs, path::PathBuf, sync::Arc, time::Instant};
use sun::UmbrageSun;
use three_d::{DirectionalLight, Light, vec3};
use umbrage::{
    Cascades, Geometry, Layout, ShadowTechnique, View,
    techniques::{MapFilter as _, Exact, Pcf, ShadowMap},
};

/// three-d lights what faces away from the sun by a thousandth of what faces it. What is darker than this is such a surface.
const DARK: f32 = 1.1e-3;
/// How much of what is seen has to be seen alike. The rest are edges, which two rasterisers place differently.
const SEEN_ALIKE: f64 = 0.99;
/// Sides of three-d's map, texels.
const SIZES: [u32; 3] = [1024, 2048, 4096];

/// three-d's own shadow maps and this library's masks in the same scenes, judged by rays.
#[derive(Parser)]
struct Arguments {
    /// Built-in scenes whose first light is a sun.
    #[arg(required = true)]
    scenes: Vec<String>,
    /// Frames that are timed for each setting, in turn with frames without shadows.
    #[arg(long, default_value_t = 7)]
    frames: usize,
    /// Only settings whose names contain one of these texts; may be repeated.
    #[arg(long)]
    only: Vec<String>,
    /// Write masks and the table into this folder.
    #[arg(long)]
    out: Option<PathBuf>,
}

/// Where the sun's shadows come from.
enum ShadowSource {
    /// three-d's own map, this many texels on each side.
    ThreeD(u32),
    /// This library's technique.
    Umbrage(Arc<dyn ShadowTechnique>),
}

/// A sun that casts shadows.
enum Sun {
    ThreeD(DirectionalLight, u32),
    Umbrage(UmbrageSun),
}

/// What changes from frame to frame.
#[derive(Clone, Copy, PartialEq)]
enum Moves {
    Camera,
    All,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    ensure!(arguments.frames > 0, "--frames is 0: time at least one");
    if let Some(folder) = &arguments.out {
        make_folder(folder)?;
    }
    let mut table = format!(
        "{COLUMNS} ms without | ms more, all moves | camera moves | MiB |\n|---|---|--:|--:|--:|--:|--:|--:|--:|\n"
    );
    print!("{table}");
    for name in &arguments.scenes {
        let judged = Judged::new(name)?;
        for line in judged.play_all(&arguments)? {
            writeln!(table, "{line}")?;
        }
    }
    if let Some(folder) = &arguments.out {
        fs::write(folder.join("three_d.md"), table)?;
    }
    Ok(())
}

impl Judged {
    /// Plays all settings, and returns the table's lines.
    fn play_all(&self, arguments: &Arguments) -> Result<Vec<String>> {
        let program = ThreeDProgram::start(&self.scene, &self.geometry)?;
        let lit = program.picture(&program.sun())?;
        let alike = program.share_seen_alike(&self.truth.receivers, &self.scene.cameras[0]);
        eprintln!(
            "{}: {:.2} % of what is seen is seen alike; {}; the box of the casters has a diagonal of {:.0} m",
            self.scene.name,
            100.0 * alike,
            program.renderer_name(),
            self.geometry.caster_bounds().diagonal()
        );
        ensure!(
            alike >= SEEN_ALIKE,
            "three-d's picture of `{}` shows something else than umbrage sees, so its shadows can't be judged",
            self.scene.name
        );
        let mut lines = Vec::new();
        for (label, source) in settings() {
            let is_wanted = arguments.only.iter().any(|text| label.contains(text));
            if !arguments.only.is_empty() && !is_wanted {
                continue;
            }
            let line = self
                .play(&label, source, &program, &lit, arguments)
                .with_context(|| format!("{}: {label}", self.scene.name))?;
            println!("{line}");
            lines.push(line);
        }
        Ok(lines)
    }

    fn play(
        &self,
        label: &str,
        source: ShadowSource,
        program: &ThreeDProgram,
        lit: &[f32],
        arguments: &Arguments,
    ) -> Result<String> {
        let without = program.sun();
        let mut sun = Sun::new(source, program, &self.geometry, self)?;
        let shadowed = program.picture(sun.light())?;
        let judged_picture = self.judge(lit, &shadowed, DARK)?;
        let mut bare = Vec::new();
        let mut all_move = Vec::new();
        let mut camera_moves = Vec::new();
        for _ in 0..arguments.frames {
            let start = Instant::now();
            program.frame(&without);
            let bare_milliseconds = milliseconds_since(start);
            bare.push(bare_milliseconds);
            for (moves, more) in [
                (Moves::All, &mut all_move),
                (Moves::Camera, &mut camera_moves),
            ] {
                // A program whose casters move has their triangles anew, and nothing that was made for them before.
                let fresh = (moves == Moves::All).then(|| self.geometry.without_hierarchies());
                let geometry = fresh.as_ref().unwrap_or(&self.geometry);
                let start = Instant::now();
                sun.update(moves, program, geometry, self)?;
                program.frame(sun.light());
                more.push(milliseconds_since(start) - bare_milliseconds);
            }
        }
        if let Some(folder) = &arguments.out {
            self.save(&judged_picture, label, folder)?;
        }
        Ok(format!(
            "{} {:.0} | {:.0} | {:.0} | {:.0} |",
            judged_picture.row(&self.scene.name, label),
            median(bare),
            median(all_move),
            median(camera_moves),
            sun.bytes() as f64 / (1 << 20) as f64
        ))
    }
}

impl Sun {
    fn new(
        source: ShadowSource,
        program: &ThreeDProgram,
        geometry: &Geometry,
        judged: &Judged,
    ) -> Result<Self> {
        let mut sun = match source {
            ShadowSource::ThreeD(size) => Self::ThreeD(program.sun(), size),
            ShadowSource::Umbrage(technique) => {
                let color = vec3(INTENSITY, INTENSITY, INTENSITY);
                let size = judged.truth.size.to_array();
                Self::Umbrage(UmbrageSun::new(
                    program.context(),
                    technique,
                    color,
                    program.direction(),
                    size,
                ))
            }
        };
        sun.update(Moves::All, program, geometry, judged)?;
        Ok(sun)
    }

    /// Makes the shadows for a frame. A map of three-d's is the same for every camera.
    fn update(
        &mut self,
        moves: Moves,
        program: &ThreeDProgram,
        geometry: &Geometry,
        judged: &Judged,
    ) -> Result<()> {
        match self {
            Self::ThreeD(light, size) => {
                if moves == Moves::All {
                    program.draw_map(light, *size)?;
                }
                Ok(())
            }
            Self::Umbrage(sun) => {
                let scene = &judged.scene;
                sun.update(&View::new(&scene.cameras[0], &scene.lights[0], geometry))
            }
        }
    }

    fn light(&self) -> &dyn Light {
        match self {
            Self::ThreeD(light, _) => light,
            Self::Umbrage(sun) => sun,
        }
    }

    /// Returns the bytes of maps and masks.
    fn bytes(&self) -> u64 {
        match self {
            Self::ThreeD(_, size) => 4 * u64::from(*size).pow(2),
            Self::Umbrage(sun) => sun.bytes(),
        }
    }
}

/// Returns the settings that are played, with their names in the table.
fn settings() -> Vec<(String, ShadowSource)> {
    let mut all = Vec::new();
    for size in SIZES {
        all.push((format!("three-d, {size}"), ShadowSource::ThreeD(size)));
    }
    let one = |size| ShadowMap {
        size,
        ..ShadowMap::default()
    };
    let cascades = ShadowMap {
        layout: Layout::Cascades(Cascades::default()),
        ..one(2048)
    };
    let umbrage: [(&str, Arc<dyn ShadowTechnique>); 3] = [
        (
            "pcf 3x3, 2048",
            Arc::new(Pcf { radius: 1 }.on(one(2048))),
        ),
        (
            "pcf 3x3, 4 cascades of 2048",
            Arc::new(Pcf { radius: 1 }.on(cascades)),
        ),
        ("exact", Arc::new(Exact::default())),
    ];
    for (label, technique) in umbrage {
        all.push((
            format!("umbrage, {label}"),
            ShadowSource::Umbrage(technique),
        ));
    }
    all
}

fn milliseconds_since(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1000.0
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
