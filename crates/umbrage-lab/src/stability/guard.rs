//! Catches events that must never happen in a cell: visibilities outside 0..=1, panics, errors of
//! the graphics API, and backends whose state a rendering has changed.

use crate::error::LabError;
use std::panic::{AssertUnwindSafe, catch_unwind};
use umbrage_core::{
    Backend, BackendError, Geometry, Recipe, RecipeError, ShadowTechnique, Shadows, View,
};
use umbrage_techniques::{Bias, MapFilter as _, Pcf, ShadowMap};

/// Reason for a missing mask.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum NoMask {
    /// The technique or the backend rejects the scene before rendering, with this reason: a result,
    /// not a fault.
    Unsupported(String),
    /// An event that must never happen, with its description.
    Fault(String),
}

impl From<RecipeError> for NoMask {
    fn from(e: RecipeError) -> Self {
        match e {
            RecipeError::Unsupported(reason) => Self::Unsupported(reason),
            RecipeError::Invalid(e) => Self::Fault(e.to_string()),
        }
    }
}

impl From<BackendError> for NoMask {
    fn from(e: BackendError) -> Self {
        match e {
            // A backend rejects what is too large for it before it renders.
            BackendError::Invalid(e) => Self::Unsupported(e.to_string()),
            e => Self::Fault(e.to_string()),
        }
    }
}

/// Runs a function that must not panic. A panic becomes a fault with its message.
pub(super) fn catch_panics<T>(f: impl FnOnce() -> Result<T, NoMask>) -> Result<T, NoMask> {
    let panic = match catch_unwind(AssertUnwindSafe(f)) {
        Ok(result) => return result,
        Err(panic) => panic,
    };
    // `panic!` holds a `String` if its message is formatted, else a `&str`.
    let message = if let Some(text) = panic.downcast_ref::<String>() {
        text
    } else if let Some(text) = panic.downcast_ref::<&str>() {
        text
    } else {
        "without a message"
    };
    Err(NoMask::Fault(format!("panicked: {message}")))
}

/// Returns a technique's recipe.
pub(super) fn plan(technique: &dyn ShadowTechnique, view: &View<'_>) -> Result<Recipe, NoMask> {
    catch_panics(|| Ok(technique.recipe(view)?))
}

/// Renders a recipe and checks its mask.
pub(super) fn render(
    backend: &mut dyn Backend,
    view: &View<'_>,
    recipe: &Recipe,
) -> Result<Shadows, NoMask> {
    catch_panics(|| {
        let shadows = backend.render(view, recipe)?;
        check(&shadows.mask).map_err(NoMask::Fault)?;
        Ok(shadows)
    })
}

/// Errors on the first value that is not a visibility (outside 0..=1, or NaN), with its index.
pub(super) fn check(mask: &[f32]) -> Result<(), String> {
    match mask.iter().position(|v| !(0.0..=1.0).contains(v)) {
        None => Ok(()),
        Some(i) => Err(format!(
            "visibility {} at pixel {i} is not within 0..=1",
            mask[i]
        )),
    }
}

/// Reports whether a used backend renders the same mask as a fresh one, bit by bit. It renders a
/// small built-in scene, `cubes`, with a 3x3 PCF.
///
/// # Errors
/// Errors if either backend can't render it.
pub fn is_as_new(used: &mut dyn Backend, fresh: &mut dyn Backend) -> Result<bool, LabError> {
    let Some(entry) = umbrage_scenes::find("cubes") else {
        return Ok(true);
    };
    let scene = (entry.build)();
    let geometry = Geometry::bake(&scene)?;
    let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
    let map = ShadowMap {
        size: 512,
        bias: Bias::ADAPTIVE,
        ..ShadowMap::default()
    };
    let recipe = Pcf::new(1).on(map).recipe(&view)?;
    let used_bits = bits(&used.render(&view, &recipe)?.mask);
    let fresh_bits = bits(&fresh.render(&view, &recipe)?.mask);
    Ok(used_bits == fresh_bits)
}

fn bits(mask: &[f32]) -> Vec<u32> {
    mask.iter().map(|v| v.to_bits()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panics_and_bad_numbers_become_faults() {
        let fault = catch_panics::<()>(|| panic!("on purpose {}", 7)).expect_err("panicked");
        assert_eq!(fault, NoMask::Fault("panicked: on purpose 7".to_owned()));
        assert_eq!(check(&[0.0, 1.0]), Ok(()));
        for bad in [f32::NAN, f32::INFINITY, -1e-6, 1.000_001] {
            assert!(check(&[1.0, bad]).expect_err("spoilt").contains("pixel 1"));
        }
    }

    #[test]
    fn a_changed_backend_is_noticed() {
        #[derive(Debug)]
        struct Changed(umbrage_cpu::Cpu);
        impl Backend for Changed {
            fn name(&self) -> &str {
                "changed"
            }
            fn kind(&self) -> &'static str {
                "cpu"
            }
            fn render(
                &mut self,
                view: &View<'_>,
                recipe: &Recipe,
            ) -> Result<Shadows, BackendError> {
                let mut shadows = self.0.render(view, recipe)?;
                shadows.mask[0] = 0.25;
                Ok(shadows)
            }
        }
        let mut fresh = umbrage_cpu::Cpu::new();
        assert!(is_as_new(&mut umbrage_cpu::Cpu::new(), &mut fresh).expect("renders"));
        assert!(!is_as_new(&mut Changed(umbrage_cpu::Cpu::new()), &mut fresh).expect("renders"));
    }
}
