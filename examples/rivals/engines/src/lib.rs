//! Comparison of other renderers' shadows with ray-traced visibility: the command line, the table
//! and the images.

#[path = "../../../judge.rs"]
pub mod judge;

use anyhow::{Context as _, Result};
use clap::Parser;
use judge::{JudgedMask, JudgedScene};
use std::{
    fmt::Write as _,
    fs,
    path::{Path, PathBuf},
};
use umbrage::{Geometry, Light, Scene, glam::Vec3, metrics::Pixel};
use umbrage_plan::truth::TruthOptions;

/// A renderer under test, in a program that shows one scene.
pub trait Rival: Sized {
    /// One of the compared settings.
    type Setting;

    /// Name of the table's file.
    const NAME: &'static str;
    /// Heads of the columns for the figures of [`Rival::measure`].
    const COLUMNS: &'static [&'static str];
    /// Threshold for pixels without shadows: darker ones are excluded, since the light doesn't
    /// reach them.
    const DARK: f32;

    /// Starts the program without shadows.
    ///
    /// # Errors
    /// Returns an error if the renderer can't show the scene.
    fn start(judged: &JudgedScene) -> Result<Self>;

    /// Returns an image without shadows, linear, rows from the top.
    ///
    /// # Errors
    /// Returns an error if the renderer does.
    fn lit_fractions(&mut self) -> Result<Vec<f32>>;

    /// Returns the settings with their names in the table.
    fn settings(judged: &JudgedScene) -> Vec<(String, Self::Setting)>;

    /// Returns an image with shadows and the figures of the columns, from this number of timed
    /// frames.
    ///
    /// # Errors
    /// Returns an error if the renderer does.
    fn measure(
        &mut self,
        judged: &JudgedScene,
        setting: Self::Setting,
        frames: usize,
    ) -> Result<(Vec<f32>, Vec<f64>)>;
}

/// Compares a renderer's shadows, and this library's in the same renderer, with ray-traced
/// visibility.
#[derive(Parser)]
struct Arguments {
    /// Built-in scenes whose first light is a sun.
    #[arg(required = true)]
    scenes: Vec<String>,
    /// Number of timed frames for each setting, alternating with frames without shadows.
    #[arg(long, default_value_t = 7, value_parser = clap::value_parser!(u16).range(1..))]
    frames: u16,
    /// Only run settings whose names contain one of these texts. Can be repeated.
    #[arg(long)]
    only: Vec<String>,
    /// Write masks and the table into this folder.
    #[arg(long)]
    out: Option<PathBuf>,
}

/// Runs the program.
///
/// # Errors
/// Returns an error if a scene is unknown, the renderer fails, or a file can't be written.
pub fn run<R: Rival>() -> Result<()> {
    let arguments = Arguments::parse();
    let mut table = String::from("| scene | shadows | RMSE | false shadow % | false light % |");
    for column in R::COLUMNS {
        write!(table, " {column} |")?;
    }
    let figures = "--:|".repeat(3 + R::COLUMNS.len());
    write!(table, "\n|---|---|{figures}\n")?;
    print!("{table}");
    if let Some(folder) = &arguments.out {
        fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    }
    let options = TruthOptions {
        samples: 256,
        ..TruthOptions::default()
    };
    for name in &arguments.scenes {
        let judged = JudgedScene::by_argument(name, None, &options)?;
        let mut rival = R::start(&judged)?;
        let lit = rival.lit_fractions()?;
        for (label, setting) in R::settings(&judged) {
            let is_wanted = arguments.only.iter().any(|text| label.contains(text));
            if !arguments.only.is_empty() && !is_wanted {
                continue;
            }
            let what = || format!("{name}: {label}");
            let frames = usize::from(arguments.frames);
            let (shadowed, figures) = rival.measure(&judged, setting, frames).with_context(what)?;
            let mask = judged.judge_image(&lit, &shadowed, R::DARK)?;
            if let Some(folder) = &arguments.out {
                save(&judged, &mask, &label, folder)?;
            }
            let line = row(name, &label, &mask, &figures);
            print!("{line}");
            table.push_str(&line);
        }
    }
    if let Some(folder) = &arguments.out {
        fs::write(folder.join(R::NAME).with_extension("md"), table)?;
    }
    Ok(())
}

fn row(scene: &str, label: &str, mask: &JudgedMask, figures: &[f64]) -> String {
    let errors = &mask.errors;
    let mut line = format!(
        "| `{scene}` | {label} | {:.3} | {:.2} | {:.2} |",
        errors.rmse, errors.false_shadow, errors.false_light
    );
    for figure in figures {
        line.push_str(&format!(" {figure:.0} |"));
    }
    line.push('\n');
    line
}

/// Returns the median.
pub fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// Colours of shadow that should be light, and of light that should be shadow.
const FALSE_SHADOW: [f32; 3] = [0.0, 90.0, 220.0];
const FALSE_LIGHT: [f32; 3] = [230.0, 120.0, 0.0];
/// Colour of excluded pixels.
const NOT_COUNTED: [u8; 3] = [150, 150, 150];

/// Writes the reference and a mask, each with an image of its differences from the reference.
fn save(judged: &JudgedScene, judged_mask: &JudgedMask, label: &str, folder: &Path) -> Result<()> {
    let name = &judged.scene.name;
    let label = label.replace(", ", "-").replace(' ', "-");
    let visibility = &judged.truth.visibility;
    for (label, mask) in [(label.as_str(), &judged_mask.mask), ("truth", visibility)] {
        let path = folder.join(format!("{name}.{label}.png"));
        let mut shown = Vec::with_capacity(3 * mask.len());
        let mut errors = Vec::with_capacity(3 * mask.len());
        for (i, &lit) in mask.iter().enumerate() {
            if judged_mask.pixels[i] != Pixel::Counted {
                shown.extend(NOT_COUNTED);
                errors.extend(NOT_COUNTED);
                continue;
            }
            shown.extend([(lit * 255.0).round() as u8; 3]);
            let difference = lit - visibility[i];
            let colour = if difference < 0.0 {
                FALSE_SHADOW
            } else {
                FALSE_LIGHT
            };
            errors.extend(colour.map(|channel| {
                let faded = 255.0 + (channel - 255.0) * difference.abs();
                faded.round() as u8
            }));
        }
        let size = judged.truth.size;
        let rgb = image::ColorType::Rgb8;
        image::save_buffer(&path, &shown, size.x, size.y, rgb)?;
        image::save_buffer(
            path.with_extension("error.png"),
            &errors,
            size.x,
            size.y,
            rgb,
        )?;
    }
    Ok(())
}

/// Greatest number of triangles of a [`MeshPart`].
const PART_TRIANGLES: usize = 4096;

/// A part of a scene's triangles that a renderer can cull. Triangles have separate corners with
/// flat normals.
pub struct MeshPart {
    /// Positions, three for each triangle.
    pub positions: Vec<Vec3>,
    /// Normals, one for each position.
    pub normals: Vec<Vec3>,
    /// `true` if it casts shadows.
    pub casts: bool,
    /// `true` if it receives shadows.
    pub receives: bool,
}

/// Returns all triangles of a scene, in parts.
pub fn mesh_parts(geometry: &Geometry) -> Vec<MeshPart> {
    let casters = geometry.casters();
    let receivers = geometry.receivers();
    let count = geometry.triangles().len() as u32;
    let mut ends = [
        0,
        casters.start,
        casters.end,
        receivers.start,
        receivers.end,
        count,
    ];
    ends.sort_unstable();
    let mut parts = Vec::new();
    for pair in ends.windows(2) {
        for first in (pair[0]..pair[1]).step_by(PART_TRIANGLES) {
            let mut part = MeshPart {
                positions: Vec::new(),
                normals: Vec::new(),
                casts: casters.contains(&first),
                receives: receivers.contains(&first),
            };
            for triangle in first..pair[1].min(first + PART_TRIANGLES as u32) {
                let corners = geometry.corners(triangle);
                let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
                part.positions.extend(corners);
                part.normals.extend([normal.normalize_or(Vec3::Y); 3]);
            }
            parts.push(part);
        }
    }
    parts
}

/// Returns the direction of the first light and its angular diameter, radians.
///
/// # Errors
/// Returns an error if that light is not a sun.
pub fn sun(scene: &Scene) -> Result<(Vec3, f32)> {
    match scene.lights.first() {
        Some(Light::Directional {
            direction,
            angular_diameter,
        }) => Ok((direction.normalize(), *angular_diameter)),
        _ => anyhow::bail!("scene `{}`: its first light is not a sun", scene.name),
    }
}
