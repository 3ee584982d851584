//! Masks and errors as PNG images.

use crate::error::LabError;
use glam::{UVec2, Vec3};
use image::{ExtendedColorType, ImageEncoder, codecs::png};
use umbrage_core::metrics::{Cause, Pixel};
use umbrage_plan::truth::Truth;

/// Colour of false shadow (darker than truth): blue. With orange it is the pair of hues that is
/// most distinguishable with all kinds of colour vision (Okabe, Ito 2008, "Color Universal
/// Design").
const FALSE_SHADOW: Vec3 = Vec3::new(0.0, 0.35, 0.80);
/// Colour of false light (lighter than truth): orange.
pub(crate) const FALSE_LIGHT: Vec3 = Vec3::new(0.93, 0.40, 0.0);
/// Colour of pixels excluded as ambiguous.
const AMBIGUOUS: Vec3 = Vec3::new(0.66, 0.25, 0.70);
/// Colour of pixels without geometry or without a receiver.
const EMPTY: Vec3 = Vec3::new(0.80, 0.84, 0.89);
/// Colour of pixels that face away from the light.
const UNLIT: Vec3 = Vec3::splat(0.70);

/// Number of pixels from which on images are compressed fast rather than well.
const REAL_SIZE: u32 = 640 * 480;

/// Returns a mask as an image: white where lit, bluish where nothing receives.
///
/// # Errors
/// Errors if the encoder fails.
pub fn mask(size: UVec2, mask: &[f32], pixels: &[Pixel]) -> Result<Vec<u8>, LabError> {
    encode(size, mask_colors(mask, pixels).into_iter())
}

/// Returns the colours of [`mask`].
pub(crate) fn mask_colors(mask: &[f32], pixels: &[Pixel]) -> Vec<Vec3> {
    let mut colors = Vec::with_capacity(mask.len());
    for (visibility, pixel) in mask.iter().zip(pixels) {
        colors.push(match pixel {
            Pixel::Empty => EMPTY,
            _ => Vec3::splat(*visibility),
        });
    }
    colors
}

/// Returns an image of a mask's errors: blue for false shadow, orange for false light, over a faint
/// image of truth.
///
/// # Errors
/// Errors if the encoder fails.
pub fn error(
    size: UVec2,
    mask: &[f32],
    truth: &[f32],
    pixels: &[Pixel],
) -> Result<Vec<u8>, LabError> {
    encode(size, error_colors(mask, truth, pixels).into_iter())
}

/// Returns the colours of [`error`].
pub(crate) fn error_colors(mask: &[f32], truth: &[f32], pixels: &[Pixel]) -> Vec<Vec3> {
    let mut colors = Vec::with_capacity(mask.len());
    for (i, pixel) in pixels.iter().enumerate() {
        colors.push(match pixel {
            Pixel::Empty => EMPTY,
            Pixel::Unlit => UNLIT,
            Pixel::Ambiguous | Pixel::Elsewhere => AMBIGUOUS,
            // Truth is a preview at unsampled pixels, which is good enough for images.
            Pixel::Counted | Pixel::Unsampled => error_color(mask[i], truth[i]),
        });
    }
    colors
}

fn error_color(visibility: f32, truth: f32) -> Vec3 {
    let difference = visibility - truth;
    let hue = if difference < 0.0 {
        FALSE_SHADOW
    } else {
        FALSE_LIGHT
    };
    // Use the square root to make small errors visible.
    faint(truth).lerp(hue, difference.abs().sqrt())
}

/// Returns the grey of truth in images of errors: light, so that hues stand out.
fn faint(truth: f32) -> Vec3 {
    Vec3::splat(0.80 + 0.18 * truth)
}

/// Returns an image of the error's causes: acne blue, gaps orange, leaks yellow, edges black,
/// penumbrae green, over a faint image of truth (hues of Okabe and Ito).
///
/// # Errors
/// Errors if the encoder fails.
pub fn causes(truth: &Truth, causes: &[Option<Cause>]) -> Result<Vec<u8>, LabError> {
    let mut colors = Vec::with_capacity(causes.len());
    for (i, cause) in causes.iter().enumerate() {
        colors.push(match (truth.pixels[i], cause) {
            (Pixel::Empty, _) => EMPTY,
            (Pixel::Unlit, _) => UNLIT,
            (_, None) => faint(truth.visibility[i]),
            (_, Some(cause)) => hue(*cause),
        });
    }
    encode(truth.size, colors.into_iter())
}

fn hue(cause: Cause) -> Vec3 {
    match cause {
        Cause::Acne => FALSE_SHADOW,
        Cause::Gap => FALSE_LIGHT,
        Cause::Leak => Vec3::new(0.94, 0.89, 0.26),
        Cause::Edge => Vec3::ZERO,
        Cause::Penumbra => Vec3::new(0.0, 0.62, 0.45),
    }
}

/// Encodes colours with components in 0..=1, rows from the top, as a PNG.
pub(crate) fn encode(size: UVec2, colors: impl Iterator<Item = Vec3>) -> Result<Vec<u8>, LabError> {
    let pixels = size.x as usize * size.y as usize;
    // Use a plain loop: this package is not optimised, and chains of closures would take longer
    // than the encoder.
    let mut texels = vec![0; 3 * pixels];
    let mut at = 0;
    for color in colors.take(pixels) {
        texels[at] = to_byte(color.x);
        texels[at + 1] = to_byte(color.y);
        texels[at + 2] = to_byte(color.z);
        at += 3;
    }
    encode_rgb(size, &texels)
}

/// Returns the nearest of 256 steps. Casts saturate at both ends.
fn to_byte(component: f32) -> u8 {
    (component * 255.0 + 0.5) as u8
}

/// Encodes three bytes per pixel, rows from the top, as a PNG.
pub(crate) fn encode_rgb(size: UVec2, texels: &[u8]) -> Result<Vec<u8>, LabError> {
    // Compress large images fast: a report has hundreds of them, and good compression took a
    // twentieth of its total time.
    let compression = if size.x * size.y >= REAL_SIZE {
        png::CompressionType::Fast
    } else {
        png::CompressionType::Default
    };
    let mut bytes = Vec::new();
    let encoder =
        png::PngEncoder::new_with_quality(&mut bytes, compression, png::FilterType::Adaptive);
    encoder
        .write_image(texels, size.x, size.y, ExtendedColorType::Rgb8)
        .map_err(|e| LabError::write("image", e))?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_kind_of_error_has_its_hue() {
        let size = UVec2::new(3, 1);
        let bytes = error(
            size,
            &[0.0, 1.0, 1.0],
            &[1.0, 0.0, 1.0],
            &[Pixel::Counted; 3],
        )
        .expect("memory");
        let picture = image::load_from_memory(&bytes)
            .expect("a picture")
            .to_rgb8();
        let shadow = picture.get_pixel(0, 0).0;
        let light = picture.get_pixel(1, 0).0;
        let right = picture.get_pixel(2, 0).0;
        assert!(shadow[2] > 180 && shadow[0] < 20, "{shadow:?}");
        assert!(light[0] > 220 && light[2] < 20, "{light:?}");
        assert!(right[0] == right[2] && right[0] > 240, "{right:?}");
    }

    #[test]
    fn masks_are_grey_and_left_out_pixels_are_not() {
        let bytes = mask(
            UVec2::new(2, 1),
            &[0.5, 1.0],
            &[Pixel::Counted, Pixel::Empty],
        )
        .expect("memory");
        let picture = image::load_from_memory(&bytes)
            .expect("a picture")
            .to_rgb8();
        assert_eq!(picture.get_pixel(0, 0).0, [128; 3]);
        assert_ne!(picture.get_pixel(1, 0).0[0], picture.get_pixel(1, 0).0[2]);
    }
}
