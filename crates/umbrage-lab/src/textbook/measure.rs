//! Measures an effect and renders its images.

use super::effect::{Effect, Preset};
use crate::{
    color::{self, ColorScene},
    error::LabError,
    output::png,
};
use glam::UVec2;
use umbrage_core::{Backend, Invalid, RecipeError, Scene, Shadows, metrics::Errors};
use umbrage_cpu::Cpu;
use umbrage_plan::truth::{self, Truth, TruthOptions};

/// Both halves of an effect.
#[derive(Clone, Debug)]
pub struct MeasuredEffect {
    /// Result with the artefact.
    pub fault: Side,
    /// Result with the fix.
    pub cure: Side,
}

/// One half of an effect.
#[derive(Clone, Debug)]
pub struct Side {
    /// Image size, pixels.
    pub size: UVec2,
    /// Color image of the first backend, a PNG.
    pub picture: Vec<u8>,
    /// Error image of the first backend's mask against truth, a PNG: see [`png::error`].
    pub error: Vec<u8>,
    /// Kind of each backend, and its mask's errors against truth.
    pub errors: Vec<(&'static str, Errors)>,
    /// Number of mask pixels whose value differs between backends.
    pub differing: u64,
}

/// Renders both halves on all backends.
///
/// # Errors
/// Errors if a preset's scene is missing, its technique doesn't support it, or a backend fails.
pub fn measure(
    effect: &Effect,
    backends: &mut [Box<dyn Backend + Send>],
) -> Result<MeasuredEffect, LabError> {
    let [fault_scene, cure_scene] = [&effect.fault, &effect.cure].map(|preset| (preset.scene)());
    let has_own_scene = cure_scene != fault_scene;
    let of_fault = TracedScene::new(fault_scene, &effect.fault)?;
    let own = has_own_scene.then(|| TracedScene::new(cure_scene, &effect.cure));
    let own = own.transpose()?;
    let of_cure = own.as_ref().unwrap_or(&of_fault);
    Ok(MeasuredEffect {
        fault: side(&effect.fault, &of_fault, backends)?,
        cure: side(&effect.cure, of_cure, backends)?,
    })
}

/// A scene with its ray-traced truth.
struct TracedScene {
    stage: ColorScene,
    truth: Truth,
}

impl TracedScene {
    fn new(scene: Scene, preset: &Preset) -> Result<Self, LabError> {
        let fit = umbrage_scenes::find(&scene.name).and_then(|entry| entry.fit);
        let stage = ColorScene::new(scene, fit)?;
        let view = stage.view()?;
        // Trace truth with fewer samples than a comparison: the gallery shows artefacts, not
        // thousandths.
        let options = TruthOptions {
            samples: 256,
            ..TruthOptions::default()
        };
        let geometry = view
            .geometry
            .ok_or_else(|| unusable_preset(preset, "has no triangles"))?;
        let mut finder = Cpu::new();
        let truth = truth::trace(
            view.camera,
            view.light,
            geometry,
            &options,
            &mut |camera, geometry| finder.receivers(camera, geometry),
            &|_, _| {},
        )?;
        Ok(Self { stage, truth })
    }
}

/// Renders one half on all backends.
fn side(
    preset: &Preset,
    scene: &TracedScene,
    backends: &mut [Box<dyn Backend + Send>],
) -> Result<Side, LabError> {
    let TracedScene { stage, truth } = scene;
    let view = stage.view()?;
    // Render the recipe on every backend, and measure each mask.
    let recipe = match stage.recipe(&(preset.technique)(), &truth.receivers) {
        Err(RecipeError::Unsupported(why)) => return Err(unusable_preset(preset, &why).into()),
        planned => planned?,
    };
    let mut rendered: Vec<Shadows> = Vec::new();
    let mut errors = Vec::new();
    for backend in backends {
        let shadows = backend.render(&view, &recipe)?;
        let of_mask = Errors::measure(truth.size, &shadows.mask, &truth.visibility, &truth.pixels)?;
        errors.push((backend.kind(), of_mask));
        rendered.push(shadows);
    }
    let Some(first) = rendered.first() else {
        return Err(Invalid::new("gallery", "has no backend", "pass at least one").into());
    };
    let color = color::png(truth.size, first)
        .ok_or_else(|| unusable_preset(preset, "returned no image"))?;
    Ok(Side {
        size: truth.size,
        picture: color?,
        error: png::error(truth.size, &first.mask, &truth.visibility, &truth.pixels)?,
        errors,
        differing: count_differing(first, &rendered),
    })
}

fn unusable_preset(preset: &Preset, why: &str) -> Invalid {
    Invalid::new(
        format!("preset `{}`", preset.label),
        why,
        "choose another scene or technique",
    )
}

/// Returns the number of pixels on which any mask differs in any bit from the first.
fn count_differing(first: &Shadows, rendered: &[Shadows]) -> u64 {
    let mut count = 0;
    for (i, visibility) in first.mask.iter().enumerate() {
        let differs = rendered
            .iter()
            .any(|shadows| shadows.mask[i].to_bits() != visibility.to_bits());
        count += u64::from(differs);
    }
    count
}
