//! Renders one recipe on every backend. Figures are the first backend's; the others must agree
//! with it if they support the recipe.

use super::guard::{self, NoMask};
use crate::compare::agreement::agree;
use umbrage_core::{Backend, Recipe, Shadows, Snapping, View};

/// The first backend's mask, and the number of pixels on which other backends differ from it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct RenderedOnAll {
    pub(super) mask: Vec<f32>,
    /// Number of decided pixels on which others differ; `None` if no other supports the recipe.
    pub(super) disagreeing: Option<u64>,
}

/// Renders a recipe on each of these backends. The first one must support it; others that don't are
/// skipped.
pub(super) fn render(
    own_backends: &mut [Box<dyn Backend + Send>],
    view: &View<'_>,
    recipe: &Recipe,
) -> Result<RenderedOnAll, NoMask> {
    let [first, others @ ..] = own_backends else {
        return Err(NoMask::Unsupported("there is no backend".to_owned()));
    };
    let shadows = guard::render(&mut **first, view, recipe)?;
    let mut disagreeing = None;
    for other in others {
        let of_other = match guard::render(&mut **other, view, recipe) {
            Err(NoMask::Unsupported(_)) => continue,
            rendered => rendered?,
        };
        let count = if first.kind() == "cpu" {
            disagreeing_pixels(view, recipe, &shadows, &of_other, other.snapping())?
        } else {
            differing_masks(&shadows, &of_other)
        };
        disagreeing = sum(disagreeing, Some(count));
    }
    Ok(RenderedOnAll {
        mask: shadows.mask,
        disagreeing,
    })
}

/// Returns all backends, or only the first.
pub(super) fn select(
    own_backends: &mut [Box<dyn Backend + Send>],
    all: bool,
) -> &mut [Box<dyn Backend + Send>] {
    let count = if all {
        own_backends.len()
    } else {
        own_backends.len().min(1)
    };
    &mut own_backends[..count]
}

/// Adds [`RenderedOnAll::disagreeing`] of two renderings; `None` if neither was compared.
pub(super) fn sum(a: Option<u64>, b: Option<u64>) -> Option<u64> {
    a.into_iter().chain(b).reduce(|a, b| a + b)
}

/// Returns the number of decided pixels on which a backend differs from the CPU; `snapping` is the
/// other backend's.
fn disagreeing_pixels(
    view: &View<'_>,
    recipe: &Recipe,
    of_cpu: &Shadows,
    of_other: &Shadows,
    snapping: Snapping,
) -> Result<u64, NoMask> {
    // Equal masks need no search for undecided pixels.
    if have_equal_masks(of_cpu, of_other) {
        return Ok(0);
    }
    let agreement = agree(view, recipe, of_cpu, of_other, snapping)
        .map_err(|e| NoMask::Fault(e.to_string()))?;
    Ok(agreement.violations)
}

/// Returns the number of pixels on which masks differ if the first backend is not the CPU: none or
/// all. Only the CPU backend reports which pixels are decided by rounding.
fn differing_masks(of_first: &Shadows, of_other: &Shadows) -> u64 {
    if have_equal_masks(of_first, of_other) {
        0
    } else {
        of_first.mask.len() as u64
    }
}

/// Reports whether two masks are equal bit by bit.
fn have_equal_masks(a: &Shadows, b: &Shadows) -> bool {
    a.mask
        .iter()
        .zip(&b.mask)
        .all(|(a, b)| a.to_bits() == b.to_bits())
}
