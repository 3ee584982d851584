//! What may come out of no cell: numbers outside 0..=1, panics, errors of the graphics API, a backend left changed.

use crate::LabError;
use std::panic::{AssertUnwindSafe, catch_unwind};
use umbrage_core::{
    Backend, BackendError, Geometry, Recipe, RecipeError, ShadowTechnique, Shadows, View,
};
use umbrage_techniques::{Bias, Pcf, ShadowMap};

/// Why a cell has no mask.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum NoMask {
    /// Told beforehand: a value, not a fault.
    Unsupported(String),
    /// Must not be.
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
            // What a backend can't hold it says before it plays.
            BackendError::Invalid(e) => Self::Unsupported(e.to_string()),
            e => Self::Fault(e.to_string()),
        }
    }
}

/// Runs something that must not panic.
pub(super) fn guarded<T>(f: impl FnOnce() -> Result<T, NoMask>) -> Result<T, NoMask> {
    catch_unwind(AssertUnwindSafe(f)).unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        let text = text
            .or(panic.downcast_ref::<&str>().copied())
            .unwrap_or("without a message");
        Err(NoMask::Fault(format!("panicked: {text}")))
    })
}

/// A technique's recipe.
pub(super) fn plan(technique: &dyn ShadowTechnique, view: &View<'_>) -> Result<Recipe, NoMask> {
    guarded(|| Ok(technique.recipe(view)?))
}

/// A recipe's mask, checked.
pub(super) fn render(
    backend: &mut dyn Backend,
    view: &View<'_>,
    recipe: &Recipe,
) -> Result<Shadows, NoMask> {
    guarded(|| {
        let shadows = backend.render(view, recipe)?;
        check(&shadows.mask).map_err(NoMask::Fault)?;
        Ok(shadows)
    })
}

/// Objects to the first value that is no visibility.
pub(super) fn check(mask: &[f32]) -> Result<(), String> {
    match mask.iter().position(|v| !(0.0..=1.0).contains(v)) {
        None => Ok(()),
        Some(i) => Err(format!(
            "visibility {} at pixel {i} is not within 0..=1",
            mask[i]
        )),
    }
}

/// Whether a backend that has been through a lot gives, to the bit, what a fresh one gives: a control render of cubes
/// under a filter.
///
/// # Errors
/// When either can't play it.
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
    let recipe = Pcf { map, radius: 1 }.recipe(&view)?;
    let masks = [
        used.render(&view, &recipe)?.mask,
        fresh.render(&view, &recipe)?.mask,
    ];
    let bits = |mask: &[f32]| mask.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    Ok(bits(&masks[0]) == bits(&masks[1]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panics_and_bad_numbers_become_faults() {
        let fault = guarded::<()>(|| panic!("on purpose {}", 7)).expect_err("panicked");
        assert_eq!(fault, NoMask::Fault("panicked: on purpose 7".to_owned()));
        assert_eq!(check(&[0.0, 1.0]), Ok(()));
        for bad in [f32::NAN, f32::INFINITY, -1e-6, 1.000_001] {
            assert!(check(&[1.0, bad]).expect_err("spoilt").contains("pixel 1"));
        }
    }

    /// The comparison of a used with a fresh backend notices one that isn't.
    #[test]
    fn a_changed_backend_is_noticed() {
        #[derive(Debug)]
        struct Tired(umbrage_cpu::Cpu);
        impl Backend for Tired {
            fn name(&self) -> &str {
                "tired"
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
        assert!(is_as_new(&mut umbrage_cpu::Cpu::new(), &mut fresh).expect("plays"));
        assert!(!is_as_new(&mut Tired(umbrage_cpu::Cpu::new()), &mut fresh).expect("plays"));
    }
}
