//! Figures of a side's mask against truth, and pictures of them.

use super::{places::Places, truth::TruthSoFar};

/// Errors of a mask over the pixels that are traced and count.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct MaskError {
    /// Root of the mean square.
    pub rmse: f64,
    /// Share of pixels that are off by more than a sixteenth.
    pub wrong: f64,
    pub pixels: usize,
    /// Pixels left out since truth itself hangs on rounding there; none before that is known.
    pub ambiguous: Option<usize>,
}

/// What is laid over the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) enum Picture {
    Nothing,
    /// Where the shadow is too dark, and where too light.
    Error,
    /// What rays say.
    Truth,
    /// What the technique says.
    Mask,
    /// Texels of the map.
    Texels,
    /// The map's layers: cascades, faces of a cube.
    Layers,
    /// How many casters a lookup in lists asks.
    Lists,
    /// How long lookups take.
    Heat,
}

impl Picture {
    /// All, with their names. Clocks of browsers are too coarse to time lookups.
    pub(crate) const ALL: &[(Self, &'static str)] = &[
        (Self::Nothing, "nothing"),
        (Self::Error, "error"),
        (Self::Truth, "truth"),
        (Self::Mask, "mask"),
        (Self::Texels, "texels"),
        (Self::Layers, "cascades"),
        (Self::Lists, "lists"),
        #[cfg(not(target_arch = "wasm32"))]
        (Self::Heat, "heat"),
    ];

    /// What is shown of the lookups, if it is that.
    pub(crate) const fn places(self) -> Option<Places> {
        match self {
            Self::Texels => Some(Places::Texels),
            Self::Layers => Some(Places::Layers),
            Self::Lists => Some(Places::Lists),
            Self::Heat => Some(Places::Heat),
            Self::Nothing | Self::Error | Self::Truth | Self::Mask => None,
        }
    }
}

/// Compares a mask with truth.
pub(crate) fn mask_error(truth: &TruthSoFar, mask: &[f32]) -> MaskError {
    let mut squares = 0.0;
    let mut wrong = 0_usize;
    let mut pixels = 0_usize;
    let mut ambiguous = 0_usize;
    for (i, &value) in mask.iter().enumerate() {
        if !truth.is_traced[i] || truth.is_left_out[i] {
            continue;
        }
        if truth.is_ambiguous[i] {
            ambiguous += 1;
            continue;
        }
        let off = f64::from(value - truth.visibility[i]);
        squares += off * off;
        wrong += usize::from(off.abs() > 1.0 / 16.0);
        pixels += 1;
    }
    let count = pixels.max(1) as f64;
    MaskError {
        rmse: (squares / count).sqrt(),
        wrong: wrong as f64 / count,
        pixels,
        ambiguous: truth.is_checked.then_some(ambiguous),
    }
}

/// Returns a picture of values as sRGB and opacity, a byte each; none if there is nothing to lay over.
pub(crate) fn picture(kind: Picture, truth: &TruthSoFar, mask: Option<&[f32]>) -> Option<Vec<u8>> {
    let count = truth.visibility.len();
    let gray = |value: f32| {
        let level = umbrage::picture::encode(value);
        [level, level, level, 255]
    };
    let texel = |i: usize| -> [u8; 4] {
        if truth.is_left_out[i] {
            return [0, 0, 0, 0];
        }
        match (kind, mask) {
            (Picture::Truth, _) => gray(truth.visibility[i]),
            (Picture::Mask, Some(mask)) => gray(mask[i]),
            (Picture::Error, _) if truth.is_ambiguous[i] => [0, 0, 0, 0],
            (Picture::Error, Some(mask)) => error_color(mask[i] - truth.visibility[i]),
            _ => [0, 0, 0, 0],
        }
    };
    let is_there = match kind {
        Picture::Nothing | Picture::Texels | Picture::Layers | Picture::Lists | Picture::Heat => {
            false
        }
        Picture::Truth => true,
        Picture::Error | Picture::Mask => mask.is_some(),
    };
    is_there.then(|| (0..count).flat_map(texel).collect())
}

/// Too light (light leaks in) is red, too dark (acne) is blue, and what is right lets the picture through.
fn error_color(off: f32) -> [u8; 4] {
    // Small errors show, too.
    let strength = off.abs().min(1.0).sqrt();
    let opacity = (255.0 * strength).round() as u8;
    if off > 0.0 {
        [255, 40, 20, opacity]
    } else {
        [30, 90, 255, opacity]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage::{Receivers, glam::UVec2};

    fn truth() -> TruthSoFar {
        TruthSoFar {
            number: 0,
            receivers: Receivers::empty(UVec2::new(4, 1)).into(),
            visibility: vec![0.0, 1.0, 0.5, 1.0],
            is_traced: vec![true, true, true, false],
            is_left_out: vec![false, false, false, false],
            is_ambiguous: vec![false, false, false, false],
            is_checked: false,
            progress: 1.0,
        }
    }

    #[test]
    fn the_same_mask_has_no_error_and_another_has() {
        let truth = truth();
        let same = mask_error(&truth, &[0.0, 1.0, 0.5, 0.0]);
        assert_eq!((same.rmse, same.wrong, same.pixels), (0.0, 0.0, 3));
        let other = mask_error(&truth, &[1.0, 1.0, 0.5, 0.0]);
        assert!((other.rmse - (1.0_f64 / 3.0).sqrt()).abs() < 1e-9);
        assert!((other.wrong - 1.0 / 3.0).abs() < 1e-9);
    }

    #[test]
    fn ambiguous_pixels_count_in_no_error() {
        let mut truth = truth();
        truth.is_ambiguous[0] = true;
        truth.is_checked = true;
        let error = mask_error(&truth, &[1.0, 1.0, 0.5, 0.0]);
        assert_eq!(
            (error.rmse, error.pixels, error.ambiguous),
            (0.0, 2, Some(1))
        );
        let over = picture(Picture::Error, &truth, Some(&[1.0, 1.0, 0.5, 0.0])).expect("there");
        assert_eq!(over[3], 0);
    }

    #[test]
    fn errors_are_coloured_by_their_sign() {
        let picture =
            picture(Picture::Error, &truth(), Some(&[1.0, 0.0, 0.5, 1.0])).expect("there");
        assert_eq!(picture[..4], [255, 40, 20, 255]);
        assert_eq!(picture[4..8], [30, 90, 255, 255]);
        assert_eq!(picture[11], 0);
    }
}
