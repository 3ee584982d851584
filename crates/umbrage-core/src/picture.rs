//! Conversion between linear colours and the sRGB bytes of a PNG file. Kernels, backends and
//! textures are linear throughout.
//!
//! The transfer function is that of IEC 61966-2-1: `12.92 l` up to 0.0031308,
//! `1.055 l^(1/2.4) - 0.055` above.

use crate::backend::Shadows;
use std::sync::LazyLock;

/// Returns the linear value, 0 to 1, of an sRGB byte.
pub fn decode(byte: u8) -> f32 {
    DECODED[usize::from(byte)]
}

/// Returns the linear value, 0 to 1, of a 16-bit sRGB channel.
pub fn decode_16(word: u16) -> f32 {
    linear(f64::from(word) / 257.0) as f32
}

/// Returns the sRGB byte nearest to a linear value (nearest among encoded values). Values below 0
/// and NaN give 0, values above 1 give 255.
pub fn encode(linear: f32) -> u8 {
    // Search the borders of bytes: exact, and without a power function that differs between
    // machines.
    BORDERS.partition_point(|&border| border <= linear) as u8
}

/// Converts linear colours to sRGB bytes, three a pixel. Values outside 0..=1 are clamped.
pub fn rgb_bytes(picture: &[[f32; 4]]) -> Vec<u8> {
    picture
        .iter()
        .flat_map(|&[r, g, b, _]| [r, g, b].map(encode))
        .collect()
}

impl Shadows {
    /// Returns the colour image as sRGB bytes, three a pixel, rows from the top. `None` if the
    /// recipe doesn't shade.
    pub fn picture_bytes(&self) -> Option<Vec<u8>> {
        self.picture.as_deref().map(rgb_bytes)
    }
}

/// Inverse transfer function of a byte, which may have a fraction.
fn linear(byte: f64) -> f64 {
    let encoded = byte / 255.0;
    if encoded <= 12.92 * 0.003_130_8 {
        encoded / 12.92
    } else {
        ((encoded + 0.055) / 1.055).powf(2.4)
    }
}

/// Linear values of bytes: a power for each texel would take longer than reading a file.
static DECODED: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|byte| linear(byte as f64) as f32));

/// Borders between bytes: entry k is the least value of byte k + 1.
static BORDERS: LazyLock<[f32; 255]> =
    LazyLock::new(|| std::array::from_fn(|k| linear(k as f64 + 0.5) as f32));

#[cfg(test)]
mod tests {
    use super::*;

    /// Values computed by hand from the standard's formula. 18 % grey is the photographic standard:
    /// 118 of 255 in sRGB.
    #[test]
    fn known_values() {
        for (linear, byte) in [
            (0.0, 0),
            (1.0, 255),
            (0.18, 118),
            (0.5, 188),
            (0.215_861, 128),
            (0.003_130_8, 10),
        ] {
            assert_eq!(encode(linear), byte, "{linear}");
        }
        assert!((decode(128) - 0.215_861).abs() < 1e-6, "{}", decode(128));
        assert!((decode(10) - 0.003_035).abs() < 1e-6, "{}", decode(10));
    }

    #[test]
    fn bytes_come_back() {
        (0..=255).for_each(|byte| assert_eq!(encode(decode(byte)), byte));
    }

    /// The search agrees with the forward formula, which it doesn't use.
    #[test]
    fn the_search_follows_the_formula() {
        for i in 0..=20_000 {
            let l = f64::from(i) / 20_000.0;
            let encoded = if l <= 0.003_130_8 {
                12.92 * l
            } else {
                1.055 * l.powf(1.0 / 2.4) - 0.055
            };
            let away = (encoded * 255.0 - f64::from(encode(l as f32))).abs();
            // Half a byte, plus the rounding of a 32-bit float where the curve is steepest (12.92 *
            // 255).
            assert!(away <= 0.5 + 1e-4, "{l}: {away}");
        }
    }

    #[test]
    fn what_is_out_of_range_is_cut_off() {
        assert_eq!(
            [-1.0, f32::NAN, f32::NEG_INFINITY, 1.5, f32::INFINITY].map(encode),
            [0, 0, 0, 255, 255]
        );
        assert_eq!(rgb_bytes(&[[0.0, 0.18, 2.0, 0.3]]), [0, 118, 255]);
    }
}
