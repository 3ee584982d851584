//! Bilinear samples of four texels each: their positions, weights and compared depths.
//!
//! # Merging texels into samples
//!
//! A filter over texels is a row of weights k₀ .. k₂ᵣ; in two dimensions, the product of two such
//! rows. A tent one texel wide makes it continuous. At the fraction s between two texel centres,
//! texel i has the weight aᵢ = (1 - s) kᵢ + s kᵢ₋₁, i from 0 to 2r + 1. A bilinear sample at the
//! fraction f between texels i and i + 1 returns (1 - f) cᵢ + f cᵢ₊₁. With f = aᵢ₊₁/(aᵢ + aᵢ₊₁) and
//! the weight aᵢ + aᵢ₊₁ it replaces both texels exactly; f is within 0..=1, since no aᵢ is
//! negative. The row has an even number of texels, so r + 1 samples replace it. In two dimensions,
//! where weights are products, (r + 1)² samples replace (2r + 2)² texels. Castaño 2013, "Shadow
//! mapping summary, part 1" (The Witness), computes 3x3 with four samples and 5x5 with nine in this
//! way.
//!
//! The rows here are 1 2 1, then 1 3 4 3 1 (widened by a box of three texels), then 1 4 8 10 8 4 1
//! (widened again). These approach a Gaussian, with standard deviations of .71, 1.08 and 1.35
//! texels. The tent adds .41, in squares.

use glam::{Vec2, Vec4};
use umbrage_core::{Module, module};

/// The WGSL half.
pub const BILINEAR_WEIGHTS: Module = module!("bilinear_weights");

/// Returns the clip depth that a sample `step` texels from the receiver compares. `depth` is the
/// receiver's depth, `gradient` its change per texel.
///
/// One depth is compared with four texels, whose centres are up to one texel from the sample along
/// each axis. The receiver's plane may gain |gx| + |gy| over that distance. The fraction `share` of
/// this gain is subtracted: all of it in Isidoro 2006, "Shadow mapping: GPU-based tips and
/// techniques"; nothing if casters move away by the same amount. The result is never beyond
/// `deepest`.
#[inline(always)]
pub fn reference_depth(depth: f32, gradient: Vec2, deepest: f32, share: f32, step: Vec2) -> f32 {
    let gain = share * (gradient.x.abs() + gradient.y.abs());
    let moved = depth + gradient.x * step.x + gradient.y * step.y - gain;
    moved.min(deepest)
}

/// Returns the weight of the sample that replaces two texels (x), and its position between them
/// (y), 0..=1 from the first one's centre.
///
/// `row` holds each texel's weight kᵢ and its change kᵢ₋₁ - kᵢ, first texel first; `s` is 0..=1.
/// The changes are precomputed, because drivers recognise `(1 - s) a + s b` as a blend and replace
/// it.
#[inline(always)]
pub fn merged_sample(row: Vec4, s: f32) -> Vec2 {
    let first = row.x + s * row.y;
    let second = row.z + s * row.w;
    let weight = first + second;
    Vec2::new(weight, second / weight)
}

/// Returns the weights of 2 `reach` + 1 texels: 1 2 1, widened by a box of three for each further
/// texel of reach.
pub fn filter_row(reach: usize) -> Vec<f32> {
    let mut row = vec![1.0, 2.0, 1.0];
    for _ in 1..reach {
        row = widen_row(&row);
    }
    row
}

/// Returns the convolution of a row of weights with a box three texels wide.
fn widen_row(row: &[f32]) -> Vec<f32> {
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

/// Returns the `row` argument of [`merged_sample`] for each of `reach` + 1 samples (up to four),
/// followed by zeros.
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

    /// The samples must equal the tent between the row and the row shifted by a texel.
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
                    // Weights are up to 18, with a few roundings each.
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
