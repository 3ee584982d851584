//! Textbook effects: settings that show an artefact, and settings that fix it.

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

/// An artefact and its fix.
#[derive(Clone, Copy, Debug)]
pub struct Effect {
    /// Name for files: `peter-panning`.
    pub name: &'static str,
    /// Title for readers.
    pub title: &'static str,
    /// Description of the artefact and its cause.
    pub text: &'static str,
    /// Settings that show the artefact.
    pub fault: Preset,
    /// Settings that fix or reduce it.
    pub cure: Preset,
    /// Reason, in one sentence for the page, if the fix increases the mask's error; else `None`.
    pub worse: Option<&'static str>,
}
