//! A textbook's effect: settings that show a fault, and settings that fix it.

use umbrage_core::Scene;
use umbrage_techniques::TechniquePreset;

/// A scene with a technique.
#[derive(Clone, Copy, Debug)]
pub struct Preset {
    /// A short description of the settings: `constant bias .05`.
    pub label: &'static str,
    /// Builds the scene.
    pub scene: fn() -> Scene,
    /// Makes the technique.
    pub technique: fn() -> TechniquePreset,
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
    /// Why the mask errs more with the cure, in a sentence for the page; none where it doesn't.
    pub worse: Option<&'static str>,
}
