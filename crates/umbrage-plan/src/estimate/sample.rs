//! Samples of pixels for estimates of sums over the whole image.
//!
//! Each pixel has its own chance to be drawn, in proportion to a density, and counts as the inverse
//! of its chance. Sums over the sample are then unbiased estimates of sums over the image, for any
//! chances (Horvitz and Thompson 1952, "A generalization of sampling without replacement from a
//! finite universe"). The draw is systematic (Madow 1949, "On the theory of systematic sampling,
//! II") along a curve that fills the image, so the sample is also spread evenly.

use glam::UVec2;
use umbrage_core::light_sample::hash;

/// Pixels drawn from an image.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct PixelSample {
    /// Indices of the pixels.
    pub(crate) pixels: Vec<u32>,
    /// Chance with which each was drawn, above 0 up to 1.
    pub(crate) chances: Vec<f64>,
    /// Weight of each pixel's error, 0 or more:
    /// [`PlanScene::weights`](super::scene::PlanScene::weights).
    pub(crate) weights: Vec<f64>,
}

impl PixelSample {
    /// Draws about `count` pixels of an image with chances in proportion to `density`, each at most
    /// once. Densities are 0 or more; pixels of density 0 are never drawn.
    pub(crate) fn draw(size: UVec2, density: &[f64], count: usize, seed: u32) -> Self {
        let scale = scale(density, count);
        let mut out = Self::default();
        // Add up the chances along the curve, and draw a pixel if the sum passes a whole number.
        // The random start decides the position in each interval of length 1.
        let mut sum = f64::from(hash(seed)) / f64::from(u32::MAX);
        for i in along_curve(size) {
            if density[i as usize] <= 0.0 {
                continue;
            }
            let chance = (density[i as usize] * scale).min(1.0);
            let before = sum.floor();
            sum += chance;
            if sum.floor() > before {
                out.pixels.push(i);
                out.chances.push(chance);
                out.weights.push(1.0);
            }
        }
        out
    }

    /// Returns the sample with its errors weighted by the weights of the whole image.
    pub(crate) fn with_weights(mut self, weights: &[f64]) -> Self {
        self.weights = self.pixels.iter().map(|&i| weights[i as usize]).collect();
        self
    }

    /// Returns the sample's pixels at these indices.
    pub(crate) fn keep_places(&self, places: &[usize]) -> Self {
        Self {
            pixels: places.iter().map(|&k| self.pixels[k]).collect(),
            chances: places.iter().map(|&k| self.chances[k]).collect(),
            weights: places.iter().map(|&k| self.weights[k]).collect(),
        }
    }
}

/// Returns the factor that converts densities to chances that add up to `count`, none above 1.
/// Returns infinity if all are certain to be drawn.
fn scale(density: &[f64], count: usize) -> f64 {
    let mut sorted: Vec<f64> = density.iter().copied().filter(|d| *d > 0.0).collect();
    sorted.sort_by(|a, b| b.total_cmp(a));
    if sorted.len() <= count {
        return f64::INFINITY;
    }
    let mut rest: f64 = sorted.iter().sum();
    // The greatest densities have chance 1, until the next does not reach it.
    for (sure, greatest) in sorted.iter().enumerate().take(count) {
        let scale = (count - sure) as f64 / rest;
        if greatest * scale <= 1.0 {
            return scale;
        }
        rest -= greatest;
    }
    f64::INFINITY
}

/// Returns all pixels in Z-order, which keeps neighbours close to each other (Morton 1966, "A
/// computer oriented geodetic data base").
fn along_curve(size: UVec2) -> Vec<u32> {
    let mut pixels: Vec<u32> = (0..size.x * size.y).collect();
    pixels.sort_by_cached_key(|i| {
        let x = i % size.x;
        let y = i / size.x;
        spread_bits(x) | spread_bits(y) << 1
    });
    pixels
}

/// Moves bit k of 16 bits to bit 2k; the odd bits are 0.
fn spread_bits(v: u32) -> u32 {
    let mut out = 0;
    for bit in 0..16 {
        out |= ((v >> bit) & 1) << (2 * bit);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Over many draws, each pixel is drawn as often as its chance states, and the chances add up.
    #[test]
    fn chances_are_kept() {
        let size = UVec2::new(8, 4);
        let density: Vec<f64> = (0..32).map(|i| f64::from(i % 5)).collect();
        let mut drawn = [0_u32; 32];
        let mut chances = [0.0; 32];
        for seed in 0..4000 {
            let sample = PixelSample::draw(size, &density, 10, seed);
            assert!(
                (9..=11).contains(&sample.pixels.len()),
                "{}",
                sample.pixels.len()
            );
            for (&i, &chance) in sample.pixels.iter().zip(&sample.chances) {
                drawn[i as usize] += 1;
                chances[i as usize] = chance;
            }
        }
        assert!((chances.iter().sum::<f64>() - 10.0).abs() < 1e-9);
        for i in 0..32 {
            let share = f64::from(drawn[i]) / 4000.0;
            // Five standard deviations of 4,000 trials.
            assert!(
                (share - chances[i]).abs() < 5.0 * 0.5 / 4000.0_f64.sqrt(),
                "{i}: {share} for {}",
                chances[i]
            );
        }
    }

    #[test]
    fn small_images_are_drawn_whole() {
        let sample = PixelSample::draw(UVec2::new(3, 2), &[1.0, 0.0, 0.1, 3.0, 1e-9, 1.0], 100, 7);
        let mut pixels = sample.pixels.clone();
        pixels.sort_unstable();
        assert_eq!(pixels, [0, 2, 3, 4, 5]);
        assert!(sample.chances.iter().all(|c| *c == 1.0));
    }

    #[test]
    fn what_is_sure_to_be_drawn_counts_once() {
        let density = [100.0, 1.0, 1.0, 1.0, 1.0];
        let sample = PixelSample::draw(UVec2::new(5, 1), &density, 2, 3);
        assert_eq!(sample.pixels.len(), 2);
        assert_eq!(
            sample.chances[sample.pixels.iter().position(|&i| i == 0).unwrap()],
            1.0
        );
    }
}
