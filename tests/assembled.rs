//! The WGSL of every technique as it is pasted into a user's shader, kept in `shaders/assembled` to be read.

use crate::stage;
use naga::valid::{Capabilities, ValidationFlags, Validator};
use std::{fs, path::PathBuf};
use umbrage_core::{Light, ShadowTechnique, View, glam::Vec3};
use umbrage_techniques::TechniquePreset;
use umbrage_wgpu::receive_wgsl;

/// Stands before every name of the kept texts.
pub const PREFIX: &str = "shadow_";

/// A technique's kept text.
#[derive(Clone, Debug)]
pub struct Assembled {
    /// The technique's name.
    pub name: String,
    /// The text as it is assembled now.
    pub text: String,
}

/// Returns the texts of all built-in techniques with their default settings.
///
/// # Panics
/// Panics if a technique serves neither the sun nor a lamp.
pub fn all() -> Vec<Assembled> {
    TechniquePreset::defaults()
        .into_iter()
        .map(|preset| {
            let technique = preset.technique();
            Assembled {
                name: technique.name().to_owned(),
                text: assemble(&*technique, PREFIX),
            }
        })
        .collect()
}

/// Returns the text of a technique, whose names begin with `prefix`.
///
/// # Panics
/// Panics if the technique serves neither the sun nor a lamp, and if the prefix begins no name.
pub fn assemble(technique: &dyn ShadowTechnique, prefix: &str) -> String {
    let geometry = stage::geometry(1.0, Vec3::ZERO);
    let camera = stage::camera();
    let lights = [
        Light::Directional {
            direction: Vec3::new(1.0, -3.0, 1.0),
            angular_diameter: 0.0093,
        },
        Light::Point {
            position: Vec3::new(0.5, 4.0, 1.0),
            radius: 0.1,
        },
    ];
    let recipe = lights
        .iter()
        .find_map(|light| technique.recipe(&View::new(&camera, light, &geometry)).ok())
        .unwrap_or_else(|| panic!("{} serves neither light", technique.name()));
    let text = receive_wgsl(&recipe, 0, prefix).expect("the prefix begins a name");
    // Files end with one line break.
    format!("{}\n", text.trim_end())
}

/// Checks that a text is a valid WGSL module.
///
/// # Errors
/// Errors with what naga objects to.
pub fn validate(text: &str) -> Result<(), String> {
    let module = naga::front::wgsl::parse_str(text).map_err(|e| e.emit_to_string(text))?;
    Validator::new(ValidationFlags::all(), Capabilities::all())
        .validate(&module)
        .map_err(|e| e.emit_to_string(text))?;
    Ok(())
}

impl Assembled {
    /// Returns where the text is kept.
    pub fn path(&self) -> PathBuf {
        PathBuf::from(env!("CARGO_MANIFEST_DIR"))
            .join("../shaders/assembled")
            .join(format!("{}.wgsl", self.name))
    }

    /// Checks that the kept text is the one assembled now.
    ///
    /// # Errors
    /// Errors with the first line that differs.
    pub fn check(&self) -> Result<(), String> {
        let path = self.path();
        let kept = fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        compare(&kept, &self.text).map_err(|why| format!("{}: {why}", path.display()))
    }

    /// Keeps the text as it is assembled now.
    ///
    /// # Errors
    /// Errors if it can't be written.
    pub fn bless(&self) -> Result<(), String> {
        fs::write(self.path(), &self.text).map_err(|e| format!("{}: {e}", self.path().display()))
    }
}

/// Checks that two texts are equal.
///
/// # Errors
/// Errors with the first line that differs.
pub fn compare(kept: &str, now: &str) -> Result<(), String> {
    if kept == now {
        return Ok(());
    }
    let differs = kept.lines().zip(now.lines()).position(|(a, b)| a != b);
    let line = differs.unwrap_or_else(|| kept.lines().count().min(now.lines().count()));
    Err(format!("line {} differs", line + 1))
}
