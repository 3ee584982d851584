//! Where samples of four texels each lie, what they weigh, and which depth they compare.
//!
//! # Merging texels into samples
//!
//! A filter over texels is a row of weights k₀ .. k₂ᵣ (and its product with itself in y), made
//! continuous by a tent one texel wide: at the fraction s between two texel centres, texel i weighs
//! aᵢ = (1 - s) kᵢ + s kᵢ₋₁, i from 0 to 2r + 1. A bilinear sample at the fraction f between texels
//! i and i + 1 answers (1 - f) cᵢ + f cᵢ₊₁. With f = aᵢ₊₁/(aᵢ + aᵢ₊₁) and the weight aᵢ + aᵢ₊₁ it
//! stands for both texels exactly; f lies within 0..=1, since no aᵢ is negative. The row has an
//! even count of texels, so r + 1 samples make it up; in two dimensions, where weights are
//! products, (r + 1)² samples stand for (2r + 2)² texels. Castaño 2013, "Shadow mapping summary,
//! part 1" (The Witness), has 3x3 in four samples and 5x5 in nine this way.
//!
//! The rows here: 1 2 1, a box three texels wide over it, 1 3 4 3 1, and once more, 1 4 8 10 8 4 1:
//! ever closer to a Gaussian (boxes of boxes), with standard deviations of .71, 1.08 and 1.35
//! texels (and .41 more, added in squares, from the tent).

use glam::{Vec2, Vec4};
use umbrage_core::{Module, module};

/// The WGSL half.
pub const BILINEAR_WEIGHTS: Module = module!("bilinear_weights");

/// Returns the clip depth that a sample `step` texels from the receiver compares, given the
/// receiver's `depth` and its change per texel. One depth serves four texels, whose centres lie up
/// to one texel from the sample along each axis: the receiver's plane may gain |gx| + |gy| up to
/// there, of which `share` is taken off (all of it in Isidoro 2006, "Shadow mapping: GPU-based tips
/// and techniques"; nothing where casters move away by as much). Never beyond `deepest`.
#[inline(always)]
pub fn reference_depth(depth: f32, gradient: Vec2, deepest: f32, share: f32, step: Vec2) -> f32 {
    let gain = share * (gradient.x.abs() + gradient.y.abs());
    let moved = depth + gradient.x * step.x + gradient.y * step.y - gain;
    moved.min(deepest)
}

/// Returns the weight of the sample that stands for two texels, and where it lies between them
/// (0..=1 from the first one's centre). `row` holds each texel's weight kᵢ and its change kᵢ₋₁ -
/// kᵢ, the first one's before the second one's; `s` is 0..=1. (Changes are handed in ready-made,
/// since drivers know `(1 - s) a + s b` as a blend and put their own in its place.)
#[inline(always)]
pub fn merged_sample(row: Vec4, s: f32) -> Vec2 {
    let first = row.x + s * row.y;
    let second = row.z + s * row.w;
    let weight = first + second;
    Vec2::new(weight, second / weight)
}

/// Returns the row of weights of 2 `reach` + 1 texels: 1 2 1, widened by a box of three for each
/// further texel of reach.
pub fn filter_row(reach: usize) -> Vec<f32> {
    let mut row = vec![1.0, 2.0, 1.0];
    for _ in 1..reach {
        row = widened(&row);
    }
    row
}

/// Returns the convolution of a row of weights with a box three texels wide.
fn widened(row: &[f32]) -> Vec<f32> {
    let mut wider = Vec::with_capacity(row.len() + 2);
    for i in 0..row.len() + 2 {
        let mut sum = 0.0;
        for j in i.saturating_sub(2)..=i {
            sum += row.get(j).copied().unwrap_or(0.0);
        }
        wider.push(sum);
    }
    wider
}

/// Returns what [`merged_sample`] takes for each of `reach` + 1 samples (up to four), and zeros
/// after them.
pub fn merged_rows(reach: usize) -> [Vec4; 4] {
    let row = filter_row(reach);
    std::array::from_fn(|sample| {
        let first = row.get(2 * sample).copied().unwrap_or(0.0);
        let second = row.get(2 * sample + 1).copied().unwrap_or(0.0);
        let before = match sample {
            0 => 0.0,
            _ => row.get(2 * sample - 1).copied().unwrap_or(0.0),
        };
        Vec4::new(first, before - first, second, first - second)
    })
}

/// All twins of this module, for the tests that compare them.
#[cfg(feature = "testing")]
pub const TWINS: &[umbrage_core::Twin] = &[
    umbrage_core::twin!(BILINEAR_WEIGHTS, reference_depth(depth: f32, gradient: Vec2, deepest: f32, share: f32, step: Vec2) -> f32, needs [umbrage_core::MATH]),
    umbrage_core::twin!(BILINEAR_WEIGHTS, merged_sample(row: Vec4, s: f32) -> Vec2, needs [umbrage_core::MATH]),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_what_the_page_says() {
        assert_eq!(filter_row(1), [1.0, 2.0, 1.0]);
        assert_eq!(filter_row(2), [1.0, 3.0, 4.0, 3.0, 1.0]);
        assert_eq!(filter_row(3), [1.0, 4.0, 8.0, 10.0, 8.0, 4.0, 1.0]);
    }

    /// Samples stand for the tent between the row and the row shifted by a texel.
    #[test]
    fn samples_stand_for_all_texels() {
        for reach in 1..=3 {
            let row = filter_row(reach);
            let at = |i: i32| {
                usize::try_from(i)
                    .ok()
                    .and_then(|i| row.get(i))
                    .copied()
                    .unwrap_or(0.0)
            };
            for s in [0.0, 0.125, 0.5, 0.71, 1.0] {
                for (j, sample) in merged_rows(reach).iter().take(reach + 1).enumerate() {
                    let merged = merged_sample(*sample, s);
                    let texels =
                        [2 * j as i32, 2 * j as i32 + 1].map(|i| (1.0 - s) * at(i) + s * at(i - 1));
                    let parts = [merged.x * (1.0 - merged.y), merged.x * merged.y];
                    // Weights up to 18, a few roundings each.
                    assert!(
                        (texels[0] - parts[0]).abs() < 4e-6 && (texels[1] - parts[1]).abs() < 4e-6,
                        "{reach} {s}"
                    );
                    assert!((0.0..=1.0).contains(&merged.y), "{reach} {s}");
                }
            }
        }
    }

    #[test]
    fn depth_follows_the_plane_but_not_beyond_the_far_plane() {
        let gradient = Vec2::new(0.02, -0.01);
        let moved = reference_depth(0.5, gradient, 1.0, 1.0, Vec2::new(2.0, 1.0));
        assert!((moved - (0.5 + 0.04 - 0.01 - 0.03)).abs() < 1e-7, "{moved}");
        assert_eq!(
            reference_depth(0.99, gradient, 1.0, 1.0, Vec2::new(9.0, 0.0)),
            1.0
        );
        assert_eq!(reference_depth(1.5, Vec2::ZERO, 1.5, 1.0, Vec2::ONE), 1.5);
    }
}
