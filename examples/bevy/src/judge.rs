//! How far the shadows in a renderer's picture are from ray-traced truth. `examples/three_d` has this file, too.

use anyhow::{Context as _, Result};
use std::{fs, path::Path};
use umbrage::{
    Geometry, Scene,
    cpu::Cpu,
    metrics::{Errors, Pixel, ReferenceMask},
};
use umbrage_plan::truth::{Truth, TruthOptions, trace};

/// The heads of the columns that [`JudgedPicture::row`] begins with.
pub const COLUMNS: &str = "| scene | shadows | RMSE | false shadow % | false light % |";

/// A scene with what is known of it.
pub struct Judged {
    /// Its first camera and its first light count.
    pub scene: Scene,
    /// All its triangles.
    pub geometry: Geometry,
    /// What rays say.
    pub truth: Truth,
}

/// What a renderer's picture says of the sun's visibility, and how far that is from truth.
pub struct JudgedPicture {
    mask: Vec<f32>,
    /// Truth's, less what the sun doesn't reach in the renderer's picture.
    pixels: Vec<Pixel>,
    errors: Errors,
}

impl Judged {
    /// Traces the truth of a built-in scene.
    ///
    /// # Errors
    /// Errors if there is no such scene.
    pub fn new(name: &str) -> Result<Self> {
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

    /// Judges a picture with shadows by one without, both linear. Pixels that are darker than `dark` without shadows count nowhere: what
    /// the sun doesn't reach at all tells nothing of shadows.
    ///
    /// # Errors
    /// Errors if the pictures' sizes are not truth's.
    pub fn judge(&self, lit: &[f32], shadowed: &[f32], dark: f32) -> Result<JudgedPicture> {
        let truth = &self.truth;
        let mut pixels = truth.pixels.clone();
        anyhow::ensure!(
            lit.len() == pixels.len() && shadowed.len() == pixels.len(),
            "pictures of {} and {} pixels, truth of {}: give all the same size",
            lit.len(),
            shadowed.len(),
            pixels.len()
        );
        let mut mask = vec![1.0; lit.len()];
        for i in 0..lit.len() {
            if lit[i] < dark {
                if pixels[i] == Pixel::Counted {
                    pixels[i] = Pixel::Elsewhere;
                }
                continue;
            }
            mask[i] = (shadowed[i] / lit[i]).clamp(0.0, 1.0);
        }
        let reference = ReferenceMask::new(truth.size, &truth.visibility, &truth.pixels)?;
        let errors = reference.with_pixels(&pixels)?.errors(&mask)?;
        Ok(JudgedPicture {
            mask,
            pixels,
            errors,
        })
    }

    /// Writes truth and the mask of a judged picture into a folder, and beside them where they differ.
    ///
    /// # Errors
    /// Errors if a file can't be written.
    pub fn save(&self, judged_picture: &JudgedPicture, label: &str, folder: &Path) -> Result<()> {
        let name = &self.scene.name;
        let label = label.replace(", ", "-").replace(' ', "-");
        let file = folder.join(format!("{name}.{label}.png"));
        save(
            &file,
            &self.truth,
            &judged_picture.pixels,
            &judged_picture.mask,
        )?;
        let file = folder.join(format!("{name}.truth.png"));
        save(
            &file,
            &self.truth,
            &judged_picture.pixels,
            &self.truth.visibility,
        )
    }
}

impl JudgedPicture {
    /// Returns the beginning of a table's row: see [`COLUMNS`].
    pub fn row(&self, scene: &str, label: &str) -> String {
        let errors = &self.errors;
        format!(
            "| `{scene}` | {label} | {:.3} | {:.2} | {:.2} |",
            errors.rmse, errors.false_shadow, errors.false_light
        )
    }
}

/// Makes a folder for what is written.
///
/// # Errors
/// Errors if it can't be made.
pub fn make_folder(folder: &Path) -> Result<()> {
    fs::create_dir_all(folder).with_context(|| format!("{}", folder.display()))
}

/// Lit and in shadow, and where the difference lies.
const SHADOW_TOO_MUCH: [f32; 3] = [0.0, 90.0, 220.0];
const LIGHT_TOO_MUCH: [f32; 3] = [230.0, 120.0, 0.0];
/// Pixels that don't count.
const NOT_COUNTED: [u8; 3] = [150, 150, 150];

/// Writes a mask, and beside it where it differs from truth: blue is shadow too much, orange light too much, grey counts nowhere.
fn save(path: &Path, truth: &Truth, pixels: &[Pixel], mask: &[f32]) -> Result<()> {
    let mut shown = Vec::with_capacity(3 * mask.len());
    let mut errors = Vec::with_capacity(3 * mask.len());
    for (i, &lit) in mask.iter().enumerate() {
        if pixels[i] != Pixel::Counted {
            shown.extend(NOT_COUNTED);
            errors.extend(NOT_COUNTED);
            continue;
        }
        let grey = (lit * 255.0).round() as u8;
        shown.extend([grey; 3]);
        let difference = lit - truth.visibility[i];
        let colour = if difference < 0.0 {
            SHADOW_TOO_MUCH
        } else {
            LIGHT_TOO_MUCH
        };
        let share = difference.abs();
        for channel in colour {
            errors.push((255.0 + (channel - 255.0) * share).round() as u8);
        }
    }
    let size = truth.size;
    image::save_buffer(path, &shown, size.x, size.y, image::ColorType::Rgb8)?;
    let beside = path.with_extension("error.png");
    image::save_buffer(beside, &errors, size.x, size.y, image::ColorType::Rgb8)?;
    Ok(())
}
