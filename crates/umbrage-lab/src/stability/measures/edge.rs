//! Displacement of shadow edges.

use glam::UVec2;
use umbrage_core::metrics::{Pixel, edges};

/// Returns the mean displacement of shadow edges, pixels; 0 without edges and errors.
///
/// It is the area on which mask and truth are on different sides of 0.5, over the length of truth's
/// edges. That length is half the number of pixels along both sides of them.
pub fn displacement(size: UVec2, mask: &[f32], truth: &[f32], pixels: &[Pixel]) -> f64 {
    let sharp: Vec<f32> = truth
        .iter()
        .map(|v| if *v < 0.5 { 0.0 } else { 1.0 })
        .collect();
    let on_edge = edges(size, &sharp, pixels);
    let mut wrong_side = 0_u64;
    let mut adjacent_edge = 0_u64;
    for i in (0..mask.len()).filter(|&i| pixels[i] == Pixel::Counted) {
        let is_wrong_side = (mask[i] < 0.5) != (truth[i] < 0.5);
        wrong_side += u64::from(is_wrong_side);
        adjacent_edge += u64::from(on_edge[i]);
    }
    let edge_length = 0.5 * adjacent_edge as f64;
    wrong_side as f64 / edge_length.max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_edge_moved_by_three_pixels_is_displaced_by_three() {
        let size = UVec2::new(64, 32);
        let edge_at = |x: usize| -> Vec<f32> {
            (0..64 * 32)
                .map(|i| if i % 64 < x { 0.0 } else { 1.0 })
                .collect()
        };
        let truth = edge_at(30);
        for (x, expected) in [(30, 0.0), (33, 3.0), (28, 2.0)] {
            assert_eq!(
                displacement(size, &edge_at(x), &truth, &[Pixel::Counted; 64 * 32]),
                expected
            );
        }
        // A ramp about the edge blurs, but displaces nothing.
        let ramp: Vec<f32> = (0..64 * 32)
            .map(|i| ((i % 64) as f32 - 25.0).clamp(0.0, 9.0) / 9.0)
            .collect();
        assert_eq!(
            displacement(size, &ramp, &truth, &[Pixel::Counted; 64 * 32]),
            0.0
        );
    }
}
