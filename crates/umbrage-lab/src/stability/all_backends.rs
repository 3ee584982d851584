//! One recipe on every backend: figures are the first's, the others must agree with it where they serve the recipe.

use super::guard::{self, NoMask};
use crate::compare::agree;
use umbrage_core::{Backend, Recipe, Shadows, View};

/// The first backend's answer, and how far the others are from it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Played {
    pub(super) mask: Vec<f32>,
    /// On how many decided pixels the others differ from it; none if no other serves the recipe.
    pub(super) disagreeing: Option<u64>,
}

/// Plays a recipe on each of these backends. What the first doesn't serve has no figure; others that don't are left out.
pub(super) fn render(
    playing: &mut [Box<dyn Backend>],
    view: &View<'_>,
    recipe: &Recipe,
) -> Result<Played, NoMask> {
    let [first, others @ ..] = playing else {
        return Err(NoMask::Unsupported("there is no backend".to_owned()));
    };
    let shadows = guard::render(&mut **first, view, recipe)?;
    let mut disagreeing = None;
    for other in others {
        let of_other = match guard::render(&mut **other, view, recipe) {
            Err(NoMask::Unsupported(_)) => continue,
            rendered => rendered?,
        };
        disagreeing = sum(
            disagreeing,
            Some(differing(
                [&**first, &**other],
                view,
                recipe,
                [&shadows, &of_other],
            )?),
        );
    }
    Ok(Played {
        mask: shadows.mask,
        disagreeing,
    })
}

/// All backends, or the first alone.
pub(super) fn select(playing: &mut [Box<dyn Backend>], all: bool) -> &mut [Box<dyn Backend>] {
    let count = if all {
        playing.len()
    } else {
        playing.len().min(1)
    };
    &mut playing[..count]
}

/// Adds what [`Played::disagreeing`] tells of two renderings.
pub(super) fn sum(a: Option<u64>, b: Option<u64>) -> Option<u64> {
    a.into_iter().chain(b).reduce(|a, b| a + b)
}

/// Decided pixels on which two backends differ. Equal masks need no search for what is undecided.
fn differing(
    [first, other]: [&dyn Backend; 2],
    view: &View<'_>,
    recipe: &Recipe,
    [a, b]: [&Shadows; 2],
) -> Result<u64, NoMask> {
    let equal = a
        .mask
        .iter()
        .zip(&b.mask)
        .all(|(a, b)| a.to_bits() == b.to_bits());
    if equal || first.kind() != "cpu" {
        return Ok(if equal { 0 } else { a.mask.len() as u64 });
    }
    let found =
        agree(view, recipe, a, b, other.snapping()).map_err(|e| NoMask::Fault(e.to_string()))?;
    Ok(found.violations)
}
