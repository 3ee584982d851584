//! Coloured shadows of panes with maps, compared with rays through the panes.
//!
//! `cargo run --release --example panes [FOLDER]` prints errors, times and bytes, and writes images
//! of red, green and blue light together. The default folder is `docs/others`.

use anyhow::Result;
use image::RgbImage;
use std::{path::PathBuf, time::Duration};
use umbrage::{
    Backend, BackendChoice, Scene, ShadowTechnique,
    cpu::Cpu,
    glam::{UVec2, Vec3},
    metrics::{Errors, Pixel},
    techniques::{MapFilter as _, Pcf, ShadowMap},
};
use umbrage_examples::{
    judge::JudgedScene,
    rivals::panes::{
        FULLY_TRANSPARENT, Glass, Panes,
        scenes::{self, GLASS},
        transmitted_light,
    },
    sheet::{Sheet, color_image},
};
use umbrage_plan::truth::TruthOptions;

const SIZE: UVec2 = UVec2::new(1280, 720);
/// Size of the images, which show a subset of pixels of the area with the shadows.
const SHOWN: UVec2 = UVec2::new(300, 170);
/// Number of runs, of which the least time counts.
const RUNS: usize = 5;
/// Side of the maps in images, texels.
const SHOWN_MAP: u32 = 1024;

/// A method of drawing the shadows of panes.
struct PaneMethod {
    label: &'static str,
    radius: u32,
    glass: PaneGlass,
}

/// The treatment of panes by a map.
#[derive(Clone, Copy, PartialEq)]
enum PaneGlass {
    Opaque,
    LeftOut,
    WithHoles,
    Shares,
}

const METHODS: [PaneMethod; 5] = [
    method("opaque, 3x3", 1, PaneGlass::Opaque),
    method("left out, 3x3", 1, PaneGlass::LeftOut),
    method("holes, 3x3", 1, PaneGlass::WithHoles),
    method("holes, 9x9", 4, PaneGlass::WithHoles),
    method("shares, 3x3", 1, PaneGlass::Shares),
];

const fn method(label: &'static str, radius: u32, glass: PaneGlass) -> PaneMethod {
    PaneMethod {
        label,
        radius,
        glass,
    }
}

impl PaneMethod {
    /// Returns the technique of one colour.
    fn technique(&self, map: ShadowMap, colour: usize) -> Box<dyn ShadowTechnique> {
        let radius = self.radius;
        if self.glass == PaneGlass::Opaque {
            return Box::new(Pcf::new(radius).on(map));
        }
        let gone = GLASS.map(|glass| Glass {
            transmittance: FULLY_TRANSPARENT,
            ..glass
        });
        let is_left_out = self.glass == PaneGlass::LeftOut;
        Box::new(Panes {
            map,
            radius,
            glass: if is_left_out { gone } else { GLASS },
            colour,
            dithered: self.glass == PaneGlass::WithHoles,
        })
    }
}

/// A scene with the light that arrives at each pixel.
struct LitPanes {
    judged: JudgedScene,
    /// Red, green and blue.
    light: Vec<Vec3>,
    /// The first pixel of the image.
    corner: UVec2,
    /// Step between the pixels of the image, along rows and columns.
    step: u32,
}

fn main() -> Result<()> {
    let folder = std::env::args()
        .nth(1)
        .map_or_else(|| PathBuf::from("docs/others"), PathBuf::from);
    println!("| scene | panes | map | RMSE | CPU: map + lookup, ms | wgpu | MiB |");
    println!("|---|---|--:|--:|--:|--:|--:|");
    let window = LitPanes::new(scenes::window(SIZE)?, UVec2::new(400, 230), 2)?;
    window.measure()?.save(&folder.join("panes.png"))?;
    let shards = LitPanes::new(scenes::shards(SIZE)?, UVec2::new(170, 90), 3)?;
    shards.measure()?.save(&folder.join("shards.png"))
}

impl LitPanes {
    fn new(scene: Scene, corner: UVec2, step: u32) -> Result<Self> {
        let judged = JudgedScene::new(scene, &TruthOptions::default())?;
        let light = transmitted_light(&judged.scene, &judged.truth.receivers, &GLASS)?;
        Ok(Self {
            judged,
            light,
            corner,
            step,
        })
    }

    /// Prints a row for each map and method, and returns images of the reference and all methods.
    fn measure(&self) -> Result<Sheet> {
        let mut sheet = Sheet::new(3);
        sheet.push(self.image(&self.light));
        for size in [512, 1024, 2048] {
            let map = ShadowMap {
                size,
                ..ShadowMap::default()
            };
            for method in &METHODS {
                let colours = self.row(method, map)?;
                if size == SHOWN_MAP {
                    sheet.push(self.image(&colours));
                }
            }
        }
        Ok(sheet)
    }

    /// Prints a row of the table, and returns the light of all colours.
    fn row(&self, method: &PaneMethod, map: ShadowMap) -> Result<Vec<Vec3>> {
        let mut colours = vec![Vec3::ZERO; self.light.len()];
        let mut square = 0.0;
        for colour in 0..3 {
            let technique = method.technique(map, colour);
            let mask = self.judged.render(&mut Cpu::new(), &*technique)?.mask;
            for (pixel, lit) in colours.iter_mut().zip(&mask) {
                pixel[colour] = *lit;
            }
            let truth: Vec<f32> = self.light.iter().map(|share| share[colour]).collect();
            let errors = Errors::measure(SIZE, &mask, &truth, &self.judged.truth.pixels)?;
            square += errors.rmse * errors.rmse / 3.0;
        }
        let technique = method.technique(map, 0);
        let cpu = self.time(&mut Cpu::new(), &*technique)?;
        let mut wgpu = umbrage::backend(BackendChoice::Wgpu)?;
        let wgpu = self.time(&mut *wgpu, &*technique)?;
        let bytes = technique.recipe(&self.judged.view())?.image_bytes();
        println!(
            "| {} | {} | {} | {:.3} | {:.1} + {:.1} | {:.1} + {:.1} | {:.0} |",
            self.judged.scene.name,
            method.label,
            map.size,
            square.sqrt(),
            cpu[0],
            cpu[1],
            wgpu[0],
            wgpu[1],
            bytes as f64 / (1 << 20) as f64
        );
        Ok(colours)
    }

    /// Returns the least times of the maps and of the lookup, milliseconds.
    fn time(&self, backend: &mut dyn Backend, technique: &dyn ShadowTechnique) -> Result<[f64; 2]> {
        let mut least = [f64::INFINITY; 2];
        for _ in 0..RUNS {
            let timings = self.judged.render(backend, technique)?.timings;
            let parts = [timings.cast, timings.receive];
            for (least, part) in least.iter_mut().zip(parts) {
                let milliseconds = part.unwrap_or(Duration::ZERO).as_secs_f64() * 1e3;
                *least = least.min(milliseconds);
            }
        }
        Ok(least)
    }

    /// Returns an image of the arriving light. Pixels that face away from the light or show nothing
    /// are grey.
    fn image(&self, colours: &[Vec3]) -> RgbImage {
        color_image(SHOWN, |i| {
            let i = i as u32;
            let at = self.corner + self.step * UVec2::new(i % SHOWN.x, i / SHOWN.x);
            let pixel = (at.y * SIZE.x + at.x) as usize;
            let colour = match self.judged.truth.pixels[pixel] {
                Pixel::Counted => colours[pixel],
                _ => Vec3::splat(0.6),
            };
            colour.to_array().map(|v| (v * 255.0).round() as u8)
        })
    }
}
