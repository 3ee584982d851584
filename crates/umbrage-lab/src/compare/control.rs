//! The negative control: a comparison that doesn't notice missing casters notices nothing.

use super::{Control, scene::View3};
use crate::{
    LabError,
    truth::{Truth, horizon},
};
use umbrage_core::{
    Backend, ShadowTechnique, Shadows,
    metrics::{FALSE, Pixel},
};

/// Plays a technique on the same triangles, none of which casts, and looks at what becomes of its mask at the pixels that
/// count: these, or those that truth says.
pub(super) fn run(
    backend: &mut dyn Backend,
    technique: &dyn ShadowTechnique,
    view: &View3<'_>,
    truth: &Truth,
    pixels: Option<&[Pixel]>,
    with_casters: &Shadows,
) -> Result<Control, LabError> {
    let bare = view.geometry.without_casters();
    let view = View3 { geometry: &bare, ..*view };
    let recipe = technique.plan(&view.core().with_receivers(&truth.receivers))?;
    let without = backend.render(&view.core(), &recipe)?;
    let horizon = horizon(view.camera, view.light, &bare, truth)?;
    // A map without casters says nothing but lit; rays still see the horizon, with noise.
    let least = |i: usize| if recipe.casts.is_empty() { horizon[i] - DARK } else { 1.0 };
    let pixels = pixels.unwrap_or(&truth.pixels);
    let counted = || (0..pixels.len()).filter(|&i| pixels[i] == Pixel::Counted);
    let hidden = || counted().filter(|&i| horizon[i] - truth.visibility[i] > FALSE);
    let shadowed = hidden().count() as u64;
    let changed = hidden().filter(|&i| without.mask[i] - with_casters.mask[i] > FALSE).count() as u64;
    let dark_without = counted().filter(|&i| without.mask[i] < least(i)).count() as u64;
    let holds = dark_without == 0 && (changed > 0 || shadowed == 0);
    let (backend, technique) = (backend.kind().to_owned(), technique.name().to_owned());
    Ok(Control { backend, technique, shadowed, changed, dark_without, holds })
}

/// Without casters a ray-traced mask may be darker than the horizon's truth by this: the noise of four rays.
const DARK: f32 = 0.5;
