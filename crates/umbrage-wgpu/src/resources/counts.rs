//! Counting casts. The counts and their depth image are two aspects of one texture, since a pass
//! has one depth-stencil attachment.

use umbrage_core::{BackendError, CastMode, ImageId, Invalid, Recipe};
use wgpu::Features;

/// Two images of a recipe that share a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct CountingPair {
    pub(crate) depth: ImageId,
    pub(crate) counts: ImageId,
}

/// The device feature that counting requires.
pub(crate) const COUNTING: Features = Features::DEPTH32FLOAT_STENCIL8;

/// Returns the images of a valid recipe that share a texture.
///
/// # Errors
/// Errors if an image would have to share with two others.
pub(crate) fn pairs(recipe: &Recipe) -> Result<Vec<CountingPair>, Invalid> {
    let mut pairs: Vec<CountingPair> = Vec::new();
    for cast in &recipe.casts {
        let CastMode::StencilDepthFail { depth } = cast.mode else {
            continue;
        };
        let pair = CountingPair {
            depth,
            counts: cast.image,
        };
        let has_rival = pairs
            .iter()
            .any(|p| *p != pair && (p.depth == depth || p.counts == cast.image));
        if has_rival {
            let why = format!(
                "uses image {} with image {depth}, but another cast uses one of the two with a different image",
                cast.image
            );
            let help = "use a separate depth image for each image of counts, and draw into both";
            return Err(Invalid::new("counting cast", why, help));
        }
        if !pairs.contains(&pair) {
            pairs.push(pair);
        }
    }
    Ok(pairs)
}

/// Errors if the recipe counts, but a device or adapter with these features can't.
pub(crate) fn check_counting(recipe: &Recipe, features: Features) -> Result<(), BackendError> {
    let counts = recipe
        .casts
        .iter()
        .any(|c| matches!(c.mode, CastMode::StencilDepthFail { .. }));
    if !counts || features.contains(COUNTING) {
        return Ok(());
    }
    let help = "request the feature `DEPTH32FLOAT_STENCIL8` when the device is made; if its adapter hasn't got it, \
                choose another adapter, another technique or the CPU backend";
    Err(Invalid::new(
        "counting cast",
        "needs a format that this device doesn't support",
        help,
    )
    .into())
}
