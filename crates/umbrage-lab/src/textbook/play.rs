//! Measuring and picturing an effect.

use super::{Effect, Preset};
use crate::{LabError, color, output::png};
use glam::UVec2;
use umbrage_core::{
    Backend, Invalid, RecipeError, Shadows,
    metrics::{Errors, Pixel},
};
use umbrage_cpu::Cpu;
use umbrage_plan::truth::{self, TruthOptions};

/// Both halves of an effect.
#[derive(Clone, Debug)]
pub struct PlayedEffect {
    /// With the fault.
    pub fault: Side,
    /// With the cure.
    pub cure: Side,
}

/// One half of an effect.
#[derive(Clone, Debug)]
pub struct Side {
    /// Image size, pixels.
    pub size: UVec2,
    /// The colour picture of the first backend, a PNG.
    pub picture: Vec<u8>,
    /// Its error against truth, a PNG: see [`png::error`].
    pub error: Vec<u8>,
    /// For each backend its kind, and its mask's errors against truth.
    pub errors: Vec<(&'static str, Errors)>,
    /// Pixels of the mask whose value differs between backends.
    pub differing: u64,
}

/// Plays both halves on all backends.
///
/// # Errors
/// Errors if a preset's scene is missing or its technique doesn't serve it, or a backend fails.
pub fn play(effect: &Effect, backends: &mut [Box<dyn Backend>]) -> Result<PlayedEffect, LabError> {
    Ok(PlayedEffect {
        fault: side(&effect.fault, backends)?,
        cure: side(&effect.cure, backends)?,
    })
}

fn side(preset: &Preset, backends: &mut [Box<dyn Backend>]) -> Result<Side, LabError> {
    let fault = |why: String| {
        Invalid::new(
            format!("preset `{}`", preset.label),
            why,
            "choose another scene or technique",
        )
    };
    let scene = (preset.scene)();
    let stage = color::Stage::new(
        &scene,
        umbrage_scenes::find(&scene.name).and_then(|entry| entry.fit),
    )?;
    let view = stage.view()?;
    // Coarser than a comparison's truth: the gallery shows faults, not thousandths.
    let options = TruthOptions {
        samples: 256,
        ..TruthOptions::default()
    };
    let geometry = view
        .geometry
        .ok_or_else(|| fault("has no triangles".to_owned()))?;
    let mut finder = Cpu::new();
    let truth = truth::trace(
        view.camera,
        view.light,
        geometry,
        &options,
        &mut |c, g| finder.receivers(c, g),
        &|_, _| {},
    )?;
    let recipe = match stage.recipe(&*(preset.technique)(), &truth.receivers) {
        Err(RecipeError::Unsupported(why)) => return Err(fault(why).into()),
        planned => planned?,
    };
    let played: Vec<(&'static str, Shadows)> = backends
        .iter_mut()
        .map(|b| Ok((b.kind(), b.render(&view, &recipe)?)))
        .collect::<Result<_, LabError>>()?;
    let measure =
        |s: &Shadows| Errors::measure(truth.size, &s.mask, &truth.visibility, &truth.pixels);
    let errors = played
        .iter()
        .map(|(kind, s)| Ok((*kind, measure(s)?)))
        .collect::<Result<_, LabError>>()?;
    let Some((_, first)) = played.first() else {
        return Err(Invalid::new("gallery", "has no backend", "open at least one").into());
    };
    let color = color::png(truth.size, first).ok_or_else(|| fault("gave no picture".to_owned()))?;
    Ok(Side {
        size: truth.size,
        picture: color?,
        error: png::error(truth.size, &first.mask, &truth.visibility, &truth.pixels)?,
        errors,
        differing: differing(&played, &truth.pixels),
    })
}

/// Pixels on which not all backends agree to the bit.
fn differing(played: &[(&'static str, Shadows)], pixels: &[Pixel]) -> u64 {
    let masks = || played.iter().map(|(_, s)| &s.mask);
    let differs = |i: &usize| masks().any(|m| masks().any(|n| m[*i].to_bits() != n[*i].to_bits()));
    (0..pixels.len()).filter(differs).count() as u64
}
