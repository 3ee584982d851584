//! Coloured shadows of panes by maps, against rays through the panes.
//!
//! `cargo run --release --example panes [FOLDER]` prints errors, times and bytes, and writes pictures of red, green and blue light together;
//! the folder is `docs/others` if none is given.

use anyhow::Context as _;
use std::{
    fs,
    path::{Path, PathBuf},
    time::Duration,
};
use umbrage::{
    Backend, BackendChoice, Geometry, Scene, ShadowTechnique, View,
    cpu::Cpu,
    glam::{UVec2, Vec3},
    metrics::{Errors, Pixel},
    techniques::{MapFilter as _, Pcf, ShadowMap},
};
use umbrage_examples::panes::{FULLY_TRANSPARENT, Glass, Panes, shards, transmitted, window};

const SIZE: UVec2 = UVec2::new(1280, 720);
/// Pictures show some pixels of the part with the shadows.
const SHOWN: UVec2 = UVec2::new(300, 170);
/// Times are the least of so many runs.
const RUNS: usize = 5;

/// A scene, and which part of it pictures show.
struct Stage {
    /// What names of pictures begin with.
    stem: &'static str,
    scene: Scene,
    /// The first pixel that is shown.
    corner: UVec2,
    /// One in so many pixels of a row is shown, and one in so many rows.
    step: u32,
}

/// What is known of a scene.
struct Judged {
    stage: Stage,
    geometry: Geometry,
    /// Red, green and blue light at each pixel.
    truth: Vec<Vec3>,
    pixels: Vec<Pixel>,
}

/// A way to draw the shadows of panes: the technique of one colour.
type OfColour<'a> = Box<dyn Fn(usize) -> Box<dyn ShadowTechnique> + 'a>;

fn main() -> anyhow::Result<()> {
    let folder = std::env::args()
        .nth(1)
        .map_or_else(|| PathBuf::from("docs/others"), PathBuf::from);
    fs::create_dir_all(&folder).with_context(|| format!("{}", folder.display()))?;
    let stages = [
        Stage {
            stem: "panes",
            scene: window::scene(SIZE)?,
            corner: UVec2::new(400, 230),
            step: 2,
        },
        Stage {
            stem: "shards",
            scene: shards::scene(SIZE)?,
            corner: UVec2::new(170, 90),
            step: 3,
        },
    ];
    println!("| scene | panes | map | RMSE | CPU: map + lookup, ms | wgpu | MiB |");
    println!("|---|---|--:|--:|--:|--:|--:|");
    for stage in stages {
        let judged = Judged::new(stage)?;
        judged.save(&folder, "truth", &judged.truth)?;
        for size in [512, 1024, 2048] {
            let map = ShadowMap {
                size,
                ..ShadowMap::default()
            };
            for (label, technique) in ways(map) {
                judged.play(&folder, label, &map, &technique)?;
            }
        }
    }
    Ok(())
}

fn ways<'a>(map: ShadowMap) -> Vec<(&'static str, OfColour<'a>)> {
    let panes = move |colour, radius, dithered, glass| Panes {
        map,
        radius,
        glass,
        colour,
        dithered,
    };
    let glass = window::GLASS;
    let gone = glass.map(|glass| Glass {
        transmittance: FULLY_TRANSPARENT,
        ..glass
    });
    vec![
        (
            "opaque, 3x3",
            Box::new(move |_| Box::new(Pcf { radius: 1 }.on(map))),
        ),
        (
            "left out, 3x3",
            Box::new(move |colour| Box::new(panes(colour, 1, false, gone))),
        ),
        (
            "holes, 3x3",
            Box::new(move |colour| Box::new(panes(colour, 1, true, glass))),
        ),
        (
            "holes, 9x9",
            Box::new(move |colour| Box::new(panes(colour, 4, true, glass))),
        ),
        (
            "shares, 3x3",
            Box::new(move |colour| Box::new(panes(colour, 1, false, glass))),
        ),
    ]
}

impl Judged {
    fn new(stage: Stage) -> anyhow::Result<Self> {
        let scene = &stage.scene;
        let geometry = Geometry::bake(scene)?;
        let camera = &scene.cameras[0];
        let receivers = Cpu::new().receivers(camera, &geometry)?;
        let truth = transmitted(scene, &receivers, &window::GLASS)?;
        let towards_light = scene.lights[0].direction_from(Vec3::ZERO);
        let mut pixels = Vec::with_capacity(truth.len());
        for i in 0..truth.len() {
            let normal = Vec3::new(receivers.nx[i], receivers.ny[i], receivers.nz[i]);
            pixels.push(if !receivers.receives[i] {
                Pixel::Empty
            } else if normal.dot(towards_light) <= 0.0 {
                Pixel::Unlit
            } else {
                Pixel::Counted
            });
        }
        Ok(Self {
            stage,
            geometry,
            truth,
            pixels,
        })
    }

    fn play(
        &self,
        folder: &Path,
        label: &str,
        map: &ShadowMap,
        technique: &OfColour<'_>,
    ) -> anyhow::Result<()> {
        let mut colours = vec![Vec3::ZERO; self.truth.len()];
        let mut square = 0.0;
        for colour in 0..3 {
            let mask = self.mask(&mut Cpu::new(), &*technique(colour))?;
            for (pixel, lit) in colours.iter_mut().zip(&mask) {
                pixel[colour] = *lit;
            }
            let truth: Vec<f32> = self.truth.iter().map(|share| share[colour]).collect();
            let errors = Errors::measure(SIZE, &mask, &truth, &self.pixels)?;
            square += errors.rmse * errors.rmse / 3.0;
        }
        let cpu = self.time(&mut Cpu::new(), technique)?;
        let mut wgpu = umbrage::backend(BackendChoice::Wgpu)?;
        let wgpu = self.time(&mut *wgpu, technique)?;
        let bytes = self.recipe(&*technique(0))?.image_bytes();
        println!(
            "| {} | {label} | {} | {:.3} | {:.1} + {:.1} | {:.1} + {:.1} | {:.0} |",
            self.stage.scene.name,
            map.size,
            square.sqrt(),
            cpu[0],
            cpu[1],
            wgpu[0],
            wgpu[1],
            bytes as f64 / (1 << 20) as f64
        );
        if map.size == 1024 {
            let name = label.replace(", ", "-").replace(' ', "-");
            self.save(folder, &name, &colours)?;
        }
        Ok(())
    }

    fn recipe(&self, technique: &dyn ShadowTechnique) -> anyhow::Result<umbrage::Recipe> {
        let scene = &self.stage.scene;
        let view = View::new(&scene.cameras[0], &scene.lights[0], &self.geometry);
        Ok(technique.recipe(&view)?)
    }

    fn mask(
        &self,
        backend: &mut dyn Backend,
        technique: &dyn ShadowTechnique,
    ) -> anyhow::Result<Vec<f32>> {
        let scene = &self.stage.scene;
        let view = View::new(&scene.cameras[0], &scene.lights[0], &self.geometry);
        let recipe = technique.recipe(&view)?;
        Ok(backend.render(&view, &recipe)?.mask)
    }

    /// Returns the least times of the maps and of one colour's lookup, milliseconds.
    fn time(
        &self,
        backend: &mut dyn Backend,
        technique: &OfColour<'_>,
    ) -> anyhow::Result<[f64; 2]> {
        let scene = &self.stage.scene;
        let view = View::new(&scene.cameras[0], &scene.lights[0], &self.geometry);
        let recipe = self.recipe(&*technique(0))?;
        let mut least = [f64::INFINITY; 2];
        for _ in 0..RUNS {
            let timings = backend.render(&view, &recipe)?.timings;
            let parts = [timings.cast, timings.receive];
            for (least, part) in least.iter_mut().zip(parts) {
                let milliseconds = part.unwrap_or(Duration::ZERO).as_secs_f64() * 1e3;
                *least = least.min(milliseconds);
            }
        }
        Ok(least)
    }

    /// Writes a picture of the light that arrives. What faces away from the light, or shows nothing, is grey.
    fn save(&self, folder: &Path, name: &str, colours: &[Vec3]) -> anyhow::Result<()> {
        let path = folder.join(format!("{}.{name}.png", self.stage.stem));
        let mut bytes = Vec::new();
        for y in 0..SHOWN.y {
            for x in 0..SHOWN.x {
                let at = self.stage.corner + self.stage.step * UVec2::new(x, y);
                let pixel = (at.y * SIZE.x + at.x) as usize;
                let colour = match self.pixels[pixel] {
                    Pixel::Counted => colours[pixel],
                    _ => Vec3::splat(0.6),
                };
                bytes.extend(colour.to_array().map(|v| (v * 255.0).round() as u8));
            }
        }
        image::save_buffer(path, &bytes, SHOWN.x, SHOWN.y, image::ColorType::Rgb8)?;
        Ok(())
    }
}
