//! Heat maps of lookups.

use super::png::encode_rgb;
use crate::error::LabError;
use umbrage_core::glam::{UVec2, Vec3};
use umbrage_plan::footprint::Heat;

/// Colour of texels without lookups: dark grey.
const UNTOUCHED: Vec3 = Vec3::splat(0.12);
/// Colour of the gaps between maps: light grey.
const BETWEEN: Vec3 = Vec3::splat(0.6);
/// Colours of texels from few to many lookups: blue, green, yellow, white.
const RAMP: [Vec3; 4] = [
    Vec3::new(0.13, 0.25, 0.65),
    Vec3::new(0.1, 0.6, 0.45),
    Vec3::new(0.95, 0.85, 0.2),
    Vec3::new(1.0, 1.0, 1.0),
];

/// Returns an image of the maps' lookups as a PNG. Texels without lookups are dark grey, the others
/// blue to white by the logarithm of the number of lookups.
///
/// # Errors
/// Errors if the encoder fails.
pub fn heat_map(heat: &Heat) -> Result<Vec<u8>, LabError> {
    let most = heat
        .lookups
        .iter()
        .copied()
        .filter(|&n| n != Heat::GAP)
        .max()
        .unwrap_or(0)
        .max(1);
    let log_most = f64::from(most).ln().max(f64::MIN_POSITIVE);
    let bytes: Vec<u8> = heat
        .lookups
        .iter()
        .flat_map(|&n| color(n, log_most))
        .collect();
    encode_rgb(UVec2::from_array(heat.size), &bytes)
}

fn color(lookups: u32, log_most: f64) -> [u8; 3] {
    let c = match lookups {
        0 => UNTOUCHED,
        Heat::GAP => BETWEEN,
        n => ramp((f64::from(n).ln() / log_most) as f32),
    };
    c.to_array().map(|v| (v * 255.0).round() as u8)
}

/// Returns the colour of [`RAMP`] at `t`, 0..=1.
fn ramp(t: f32) -> Vec3 {
    let position = t.clamp(0.0, 1.0) * (RAMP.len() - 1) as f32;
    let i = (position as usize).min(RAMP.len() - 2);
    RAMP[i].lerp(RAMP[i + 1], position - i as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_show_what_is_unused() {
        // Two of four texels have lookups, one of them the most.
        let heat = Heat {
            size: [2, 2],
            lookups: vec![0, 1, 9, 0],
        };
        let image = image::load_from_memory(&heat_map(&heat).expect("memory"))
            .expect("a picture")
            .into_rgb8();
        assert_eq!(image.dimensions(), (2, 2));
        let is_dark_grey = |p: &image::Rgb<u8>| p.0[0] == p.0[1] && p.0[0] < 60;
        let dark: Vec<bool> = image.pixels().map(is_dark_grey).collect();
        assert_eq!(dark, [true, false, false, true]);
        assert_eq!(image.get_pixel(0, 1).0, [255, 255, 255]);
    }
}
