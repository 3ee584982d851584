//! Errors at the seams between cascades: where one map ends and the next, coarser one begins.

use glam::UVec2;

/// A pair of neighbouring pixels, by the offset of the second from the first.
struct Neighbour {
    right: usize,
    down: usize,
}

const NEIGHBOURS: [Neighbour; 2] = [
    Neighbour { right: 1, down: 0 },
    Neighbour { right: 0, down: 1 },
];

/// Returns the excess contrast at seams between cascades, percent; `None` without a seam.
///
/// A pair of neighbouring pixels has the contrast of the mask minus that of truth, at least 0. The
/// excess is the mean over pairs across a seam minus the mean over the pairs next to them, at least
/// 0.
///
/// Edges cross seams as they cross the rest of the image, and every map displaces them by part of a
/// texel. So only the excess over the pairs one pixel to either side is due to the seam.
///
/// `layers` holds the cascade of each pixel of an image of this size; `counts` returns whether a
/// pixel counts.
pub fn excess(
    size: UVec2,
    mask: &[f32],
    truth: &[f32],
    layers: &[u32],
    counts: impl Fn(usize) -> bool,
) -> Option<f64> {
    let width = size.x as usize;
    let mut seam = Mean::default();
    let mut adjacent = Mean::default();
    for step in &NEIGHBOURS {
        let offset = step.down * width + step.right;
        // Visit rows of four pixels across the seam, which is between the middle ones.
        for y in step.down..(size.y as usize).saturating_sub(2 * step.down) {
            for x in step.right..width.saturating_sub(2 * step.right) {
                let second = y * width + x;
                let pixels = [
                    second - offset,
                    second,
                    second + offset,
                    second + 2 * offset,
                ];
                let is_seam = layers[pixels[1]] != layers[pixels[2]];
                if !is_seam || !pixels.into_iter().all(&counts) {
                    continue;
                }
                seam.add(jump(mask, truth, pixels[1], pixels[2]));
                adjacent.add(jump(mask, truth, pixels[0], pixels[1]));
                adjacent.add(jump(mask, truth, pixels[2], pixels[3]));
            }
        }
    }
    let at_seam = seam.value()?;
    let at_sides = adjacent.value()?;
    Some(100.0 * (at_seam - at_sides).max(0.0))
}

/// Returns the contrast of two pixels in the mask minus that in truth, 0..=1.
fn jump(mask: &[f32], truth: &[f32], a: usize, b: usize) -> f64 {
    let answered = f64::from((mask[a] - mask[b]).abs());
    let true_one = f64::from((truth[a] - truth[b]).abs());
    (answered - true_one).max(0.0)
}

#[derive(Default)]
struct Mean {
    sum: f64,
    count: usize,
}

impl Mean {
    fn add(&mut self, value: f64) {
        self.sum += value;
        self.count += 1;
    }

    fn value(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / self.count as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: UVec2 = UVec2::new(8, 3);

    /// Returns the cascades of an image whose left half belongs to the first one.
    fn halves() -> Vec<u32> {
        (0..24).map(|i| u32::from(i % 8 >= 4)).collect()
    }

    fn of_columns(columns: [f32; 8]) -> Vec<f32> {
        columns.into_iter().cycle().take(24).collect()
    }

    #[test]
    fn a_step_at_the_seam_counts_and_one_elsewhere_does_not() {
        let lit = vec![1.0; 24];
        let darker = of_columns([1.0, 1.0, 1.0, 1.0, 0.75, 0.75, 0.75, 0.75]);
        let excess_of =
            |mask: &[f32], truth: &[f32]| excess(SIZE, mask, truth, &halves(), |_| true);
        assert_eq!(excess_of(&darker, &lit), Some(25.0));
        // Truth has the same step.
        assert_eq!(excess_of(&darker, &darker), Some(0.0));
        assert_eq!(excess_of(&lit, &darker), Some(0.0));
        // Steps next to the seam are as large as at it.
        let stripes = of_columns([1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0]);
        assert_eq!(excess_of(&stripes, &lit), Some(0.0));
    }

    #[test]
    fn without_a_seam_there_is_nothing_to_measure() {
        let lit = vec![1.0; 24];
        assert_eq!(excess(SIZE, &lit, &lit, &[0; 24], |_| true), None);
        assert_eq!(excess(SIZE, &lit, &lit, &halves(), |_| false), None);
    }
}
