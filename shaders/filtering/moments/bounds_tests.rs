//! Tests the bounds with known distributions.

use super::*;
use crate::filtering::moments::of_depth::{power_moments, variance_moments};
use crate::filtering::moments::{hamburger::hamburger, hausdorff::hausdorff};
use glam::Vec4;
use umbrage_core::light_sample::hash;

/// Clip depths, each with its fraction; fractions add up to 1.
type Distribution = Vec<(f32, f32)>;

/// Returns the mean of the four moments.
fn mean_powers(distribution: &Distribution) -> Vec4 {
    let weighed = distribution
        .iter()
        .map(|&(depth, share)| power_moments(depth) * share);
    weighed.sum()
}

fn mean_pair(distribution: &Distribution) -> Vec2 {
    let weighed = distribution
        .iter()
        .map(|&(depth, share)| variance_moments(depth) * share);
    weighed.sum()
}

/// Returns the fraction of a distribution at a clip depth or beyond: the result of filtering
/// comparisons.
fn lit_share(distribution: &Distribution, depth: f32) -> f32 {
    let lit = distribution.iter().filter(|&&(d, _)| d >= depth);
    lit.map(|&(_, share)| share).sum()
}

fn random(i: u32) -> f32 {
    hash(i) as f32 / u32::MAX as f32
}

/// Returns `count` random depths with random fractions.
fn random_distribution(seed: u32, count: u32) -> Distribution {
    let mut out: Distribution = (0..count)
        .map(|i| {
            (
                random(seed * 64 + 2 * i),
                0.05 + random(seed * 64 + 2 * i + 1),
            )
        })
        .collect();
    let total: f32 = out.iter().map(|&(_, share)| share).sum();
    for (_, share) in &mut out {
        *share /= total;
    }
    out
}

/// No bound is darker than filtered comparisons. Four moments leak less than two, and less again
/// with a bounded depth range.
#[test]
fn bounds_are_bounds_and_better_ones_leak_less() {
    let mut leaks = [0.0_f64; 3];
    for seed in 0..4000 {
        let distribution = random_distribution(seed, 2 + seed % 7);
        // Skip depths of the distribution, where fractions are discontinuous.
        let depth = random(1_000_000 + seed);
        if distribution.iter().any(|&(d, _)| (d - depth).abs() < 0.01) {
            continue;
        }
        let expected = lit_share(&distribution, depth);
        let z = 2.0 * depth - 1.0;
        let moments = mean_powers(&distribution);
        let found = [
            lit_by_variance(mean_pair(&distribution), z, 0.0),
            hamburger(moments, z),
            hausdorff(moments, z),
        ];
        for (leak, lit) in leaks.iter_mut().zip(found) {
            assert!(
                lit > expected - 0.01,
                "{lit} of {expected}: {distribution:?} at {depth}"
            );
            *leak += f64::from(lit - expected);
        }
        assert!(
            found[2] <= found[1] + 0.01,
            "{found:?}: {distribution:?} at {depth}"
        );
    }
    assert!(
        leaks[0] > 2.0 * leaks[1] && leaks[1] > 1.05 * leaks[2],
        "{leaks:?}"
    );
}

/// Mixing weights of the technique's own biases, for 32 and 16 bits.
const MOMENT_BIASES: [f32; 2] = [3e-6, 6e-5];

/// Returns the moments mixed with the fixed distribution, as in the kernel.
fn biased_moments(moments: Vec4, bias: f32) -> Vec4 {
    moments + (Vec4::new(0.0, 0.375, 0.0, 0.375) - moments) * bias
}

/// Tests maps of one depth, and empty ones (whose depth is 1). They may darken nearer receivers and
/// light those behind only as far as the bias allows, at any depth. This includes depths where the
/// result is ill-conditioned: those around the depth of everything that isn't at the map's ends. In
/// an empty map, and in one whose depth is -1, this is the bias' depth 0.
///
/// The fraction of a distribution that is d or more from a depth c is at most the mean of (z - c)²
/// over d² (Markov). For a map of depth c, that mean is the bias times (c² + 3/8). Rounding adds
/// 5/4 of a float's epsilon. In the mean of squares, the power and the sum with the bias are
/// rounded to half of 2^-24 each. In the mean's square, the mean is rounded likewise and the square
/// once, so the total is five times 2^-25. Results are 1 minus a quotient, whose six operations
/// round by half an epsilon each.
#[test]
fn maps_of_one_depth_err_by_their_bias_alone() {
    let epsilon = f64::from(f32::EPSILON);
    for bias in MOMENT_BIASES {
        for depth in [1.0_f32, -1.0, 0.0, 0.001, -0.3, 0.5, 0.95] {
            let moments = biased_moments(power_moments(0.5 * depth + 0.5), bias);
            let mean_square = f64::from(bias) * (f64::from(depth).powi(2) + 0.375);
            let mut worst = 0.0_f64;
            let mut check = |z: f32| {
                let distance = f64::from(z) - f64::from(depth);
                let expected = if z > depth { 0.0 } else { 1.0 };
                let most = |distance: f64| {
                    (mean_square + 1.25 * epsilon) / (distance * distance) + 3.0 * epsilon
                };
                let mut check = |bound: fn(Vec4, f32) -> f32, most: f64| {
                    let error = (f64::from(bound(moments, z)) - expected).abs();
                    worst = worst.max(error / most);
                };
                check(hamburger, most(distance));
                // Nothing is behind the depth of an empty map. So the darkness of its neighbours is
                // bounded by the distribution at half the distance of the bias' depths.
                let is_empty = depth == 1.0;
                check(
                    hausdorff,
                    most(if is_empty {
                        distance.abs().max(0.5)
                    } else {
                        distance
                    }),
                );
            };
            // Test the whole range, and every multiple of 2^-25 around 0 up to 2^-6.
            (-(1 << 18)..=1 << 18).for_each(|i| check(i as f32 / (1 << 18) as f32));
            (-(1 << 19)..1 << 19).for_each(|i| check(i as f32 / (1 << 25) as f32));
            // Test every float next to the far plane.
            (0..1 << 16).for_each(|i| check(1.0 - i as f32 / (1 << 24) as f32));
            assert!(worst <= 1.0, "{worst} with bias {bias} at depth {depth}");
        }
    }
}

/// Receivers nearer than two depths are lit, and those behind both are dark, except for the bias.
/// This holds up to the map's planes, where one of the four depths of the bound meets the
/// receiver's.
///
/// Let q(z) = ((z - a) (z - b))². The fraction that is no nearer to a and b than z is at most the
/// mean of q over q(z) (Markov). The bias contributes to that mean. Rounding changes it by the
/// moments' error times q's coefficients, whose absolute values add up to ((1 + |a|) (1 + |b|))². A
/// moment is rounded six times (power, fraction, sum and bias), and six times again in the
/// variances. Each rounding is at most half of 2^-24: three epsilons.
#[test]
fn maps_of_two_depths_err_by_their_bias_alone() {
    let epsilon = f64::from(f32::EPSILON);
    for bias in MOMENT_BIASES {
        for [a, b] in [
            [0.0_f32, 1.0],
            [-0.5, 1.0],
            [0.3, 0.95],
            [-1.0, 0.0],
            [-0.9, 0.25],
        ] {
            for share in [0.02, 0.1, 0.5, 0.9] {
                let distribution = vec![(0.5 * a + 0.5, share), (0.5 * b + 0.5, 1.0 - share)];
                let moments = biased_moments(mean_powers(&distribution), bias);
                let [a, b] = [a, b].map(f64::from);
                let q = |z: f64| ((z - a) * (z - b)).powi(2);
                let of_bias = 0.1875 * (q(-1.0) + q(1.0)) + 0.625 * q(0.0);
                let coefficients = ((1.0 + a.abs()) * (1.0 + b.abs())).powi(2);
                let mean = f64::from(bias) * of_bias + 3.0 * epsilon * coefficients;
                let mut reported = 0;
                for i in -(1 << 15)..=1 << 15 {
                    let z = i as f32 / (1 << 15) as f32;
                    let expected = if f64::from(z) < a { 1.0 } else { 0.0 };
                    let is_outside = f64::from(z) < a || f64::from(z) > b;
                    if !is_outside {
                        continue;
                    }
                    let most = mean / q(f64::from(z)) + 3.0 * epsilon;
                    reported += u32::from(most < 1e-3);
                    for bound in [hamburger, hausdorff] {
                        let lit = f64::from(bound(moments, z));
                        let error = (lit - expected).abs();
                        assert!(
                            error <= most,
                            "{lit}, not {expected} by {most}: {z} of {a}, {b}, {share}"
                        );
                    }
                }
                assert!(reported > 1000, "{reported}");
            }
        }
    }
}

/// Four moments determine two depths exactly; two moments don't.
#[test]
fn four_moments_tell_two_depths_exactly() {
    for (near, far, share) in [(0.2, 0.7, 0.3), (0.4, 0.5, 0.9), (0.05, 0.95, 0.5)] {
        let distribution = vec![(near, share), (far, 1.0 - share)];
        let moments = biased_moments(mean_powers(&distribution), MOMENT_BIASES[0]);
        for bound in [hamburger, hausdorff] {
            let dark = bound(moments, 2.0 * (far - 1e-3) - 1.0);
            let lit = bound(moments, 2.0 * (near - 0.01) - 1.0);
            assert!(
                (dark - (1.0 - share)).abs() < 0.02,
                "{dark}: {distribution:?}"
            );
            assert!(lit > 0.98, "{lit}: {distribution:?}");
        }
    }
}

/// The result is a fraction for any moments, even impossible ones.
#[test]
fn impossible_moments_have_an_answer() {
    for i in 0..20_000 {
        let b = |k: u32| 2.0 * random(5 * i + k) - 1.0;
        let moments = Vec4::new(b(0), b(1), b(2), b(3));
        for lit in [hamburger(moments, b(4)), hausdorff(moments, b(4))] {
            assert!((0.0..=1.0).contains(&lit), "{lit}: {moments} at {}", b(4));
        }
    }
    for moments in [
        Vec4::ZERO,
        Vec4::ONE,
        Vec4::NEG_ONE,
        Vec4::new(1.0, 1.0, 1.0, 0.0),
    ] {
        for depth in [-1.0, 0.0, 1.0] {
            for lit in [hamburger(moments, depth), hausdorff(moments, depth)] {
                assert!((0.0..=1.0).contains(&lit), "{lit}: {moments} at {depth}");
            }
        }
    }
}

#[test]
fn bleeding_is_cut_off_and_the_rest_stretched() {
    assert_eq!(without_bleeding(0.2, 0.25, 4.0 / 3.0), 0.0);
    assert_eq!(without_bleeding(1.0, 0.25, 4.0 / 3.0), 1.0);
    assert_eq!(without_bleeding(0.625, 0.25, 4.0 / 3.0), 0.5);
    assert_eq!(without_bleeding(0.3, 0.0, 1.0), 0.3);
}

/// Half of a plane's depths, distributed around their mean, are in shadow at the mean. None are a
/// standard deviation nearer.
#[test]
fn a_plane_is_lit_from_a_standard_deviation_before_its_mean() {
    for half_width in [0.02_f32, 0.1] {
        let count = 64;
        let plane: Distribution = (0..count)
            .map(|i| {
                let place = (2 * i + 1) as f32 / count as f32 - 1.0;
                (0.6 + half_width * place, 1.0 / count as f32)
            })
            .collect();
        let moments = mean_powers(&plane);
        let deviation = half_width / 3.0_f32.sqrt();
        for bound in [hamburger, hausdorff] {
            let at_mean = bound(moments, 2.0 * 0.6 - 1.0);
            let before = bound(moments, 2.0 * (0.6 - 1.02 * deviation) - 1.0);
            assert!(at_mean > 0.5 && at_mean < 0.8, "{at_mean}");
            assert!(before > 0.99, "{before}");
        }
    }
}
