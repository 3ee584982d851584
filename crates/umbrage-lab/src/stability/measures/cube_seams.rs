//! Errors at the seams between the faces of a cube map.

use super::open::share;
use glam::Vec3;

/// Reports whether a direction from the light passes within `texels` texels of a seam, on a cube
/// whose faces have sides of `size` texels.
///
/// The direction meets the face of its greatest coordinate a. The next greatest, b, is at b / a of
/// the half side there.
pub fn is_on_seam(from_light: Vec3, size: u32, texels: f32) -> bool {
    let mut lengths = from_light.abs().to_array();
    lengths.sort_by(f32::total_cmp);
    let second = lengths[1];
    let greatest = lengths[2];
    let half_side = 0.5 * size as f32;
    greatest > 0.0 && (1.0 - second / greatest) * half_side <= texels
}

/// Returns the percentage of the marked pixels on which mask and truth are on different sides of
/// 0.5.
pub fn wrong_within(mask: &[f32], truth: &[f32], marked: impl Fn(usize) -> bool) -> f64 {
    share(
        (0..mask.len())
            .filter(|&i| marked(i))
            .map(|i| (mask[i] < 0.5) != (truth[i] < 0.5)),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seams_are_where_two_coordinates_are_equal() {
        let texel = 2.0 / 512.0;
        for (direction, expected) in [
            (Vec3::new(1.0, 1.0, 0.2), true),
            (Vec3::new(-3.0, 0.0, 3.0), true),
            (Vec3::new(1.0, 1.0 - 1.9 * texel, 0.0), true),
            (Vec3::new(1.0, 1.0 - 2.1 * texel, 0.0), false),
            (Vec3::X, false),
            (Vec3::ZERO, false),
        ] {
            assert_eq!(is_on_seam(direction, 512, 2.0), expected, "{direction}");
        }
    }

    #[test]
    fn only_marked_pixels_count() {
        let mask = [1.0, 0.0, 0.0, 1.0];
        let truth = [1.0; 4];
        assert_eq!(wrong_within(&mask, &truth, |i| i < 2), 50.0);
        assert_eq!(wrong_within(&mask, &truth, |i| i == 3), 0.0);
    }
}
