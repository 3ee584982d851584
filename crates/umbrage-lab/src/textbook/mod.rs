//! The textbooks' effects as presets: each a scene and settings that show a fault, and settings that cure it, with the
//! numbers that the textbooks use. [`play`] measures and pictures both; [`gallery`] makes one page of all.

mod effects;
mod gallery;
mod play;

pub use effects::all;
pub use gallery::html;
pub use play::{Played, Side, play};

use umbrage_core::{Scene, ShadowTechnique};

/// A scene with a technique.
#[derive(Clone, Copy, Debug)]
pub struct Preset {
    /// What is chosen here, in a few words: `constant bias .05`.
    pub label: &'static str,
    /// Builds the scene.
    pub scene: fn() -> Scene,
    /// Makes the technique.
    pub technique: fn() -> Box<dyn ShadowTechnique>,
}

/// A fault and its cure.
#[derive(Clone, Copy, Debug)]
pub struct Effect {
    /// For file names: `peter-panning`.
    pub name: &'static str,
    /// For people.
    pub title: &'static str,
    /// What is seen and why.
    pub text: &'static str,
    /// With the fault.
    pub fault: Preset,
    /// Without it, or with less of it.
    pub cure: Preset,
}

/// The effect of this name.
pub fn find(name: &str) -> Option<&'static Effect> {
    all().iter().find(|e| e.name == name)
}
