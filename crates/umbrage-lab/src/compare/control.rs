//! The negative control: a comparison that doesn't notice missing casters notices nothing.

use super::{Control, scene::View3};
use crate::{LabError, truth::Truth};
use umbrage_core::{
    Backend, ShadowTechnique, Shadows,
    metrics::{FALSE, Pixel},
};

/// Plays a technique on the same triangles, none of which casts, and looks at what becomes of its mask.
pub(super) fn run(
    backend: &mut dyn Backend,
    technique: &dyn ShadowTechnique,
    view: &View3<'_>,
    truth: &Truth,
    with_casters: &Shadows,
) -> Result<Control, LabError> {
    let bare = view.geometry.without_casters();
    let view = View3 { geometry: &bare, ..*view };
    let recipe = technique.plan(&view.core().with_receivers(&truth.receivers))?;
    let without = backend.render(&view.core(), &recipe)?;
    let shadowed = truth.visibility.iter().zip(&truth.pixels).filter(|(v, p)| **v < 1.0 && **p == Pixel::Counted);
    let shadowed = shadowed.count() as u64;
    let changed = with_casters.mask.iter().zip(&without.mask).filter(|(a, b)| (*a - *b).abs() > FALSE).count() as u64;
    let dark_without = dark(&without.mask, truth);
    let holds = dark_without == 0 && (changed > 0 || shadowed == 0);
    let (backend, technique) = (backend.kind().to_owned(), technique.name().to_owned());
    Ok(Control { backend, technique, shadowed, changed, dark_without, holds })
}

/// Pixels that are not fully lit although nothing casts. Those that face away from the light don't count: some techniques
/// darken them by themselves.
fn dark(mask: &[f32], truth: &Truth) -> u64 {
    mask.iter().zip(&truth.pixels).filter(|(v, p)| **v < 1.0 && **p != Pixel::Unlit).count() as u64
}
