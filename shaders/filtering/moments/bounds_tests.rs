//! The bounds against distributions that are known.

use super::*;
use crate::filtering::moments::of_depth::{power_moments, variance_moments};
use crate::filtering::moments::{hamburger::hamburger, hausdorff::hausdorff};
use glam::Vec4;
use umbrage_core::light_sample::hash;

/// Clip depths, each with its share; shares add up to 1.
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

/// Returns how much of a distribution is at a clip depth or beyond: what filtering comparisons would give.
fn lit_share(distribution: &Distribution, depth: f32) -> f32 {
    let lit = distribution.iter().filter(|&&(d, _)| d >= depth);
    lit.map(|&(_, share)| share).sum()
}

fn random(i: u32) -> f32 {
    hash(i) as f32 / u32::MAX as f32
}

/// Returns `count` random depths with random shares.
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

/// None is darker than filtered comparisons are. More moments leak less, and so does knowing where depths end.
#[test]
fn bounds_are_bounds_and_better_ones_leak_less() {
    let mut leaks = [0.0_f64; 3];
    for seed in 0..4000 {
        let distribution = random_distribution(seed, 2 + seed % 7);
        // Not at one of the depths, where shares jump.
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

/// Two depths are what four moments know without doubt; two moments don't.
#[test]
fn four_moments_tell_two_depths_exactly() {
    for (near, far, share) in [(0.2, 0.7, 0.3), (0.4, 0.5, 0.9), (0.05, 0.95, 0.5)] {
        let distribution = vec![(near, share), (far, 1.0 - share)];
        let mut moments = mean_powers(&distribution);
        // As much bias as the technique's default has.
        moments = moments * (1.0 - 3e-6) + Vec4::new(0.0, 0.375, 0.0, 0.375) * 3e-6;
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

/// Whatever the moments are, possible or not, the answer is a share.
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

/// A plane's depths, around their mean, are in shadow by half where the mean is asked about, and not at all a standard deviation nearer.
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
