//! Light bleeding between two blockers, compared with the bounds of moment maps.

use super::*;
use glam::Vec3;
use umbrage_techniques::{Evsm, EvsmMoments, MapFilter as _, Msm, Reconstruction, ShadowMap, Vsm};

/// Returns the greatest visibility that Chebyshev's bound allows for a receiver behind two
/// blockers, for any shares of theirs in the filter. `depths` are the nearer blocker's, the other's
/// and the receiver's.
///
/// With b = `middle` - `near`, a = `receiver` - `middle`, and a share p of the nearer blocker, the
/// variance is p (1 - p) b², and the receiver is a + p b from the mean. So the bound is p (1 - p)
/// b² / (p (1 - p) b² + (a + p b)²), whose maximum, at p = a / (2 a + b), is b² / (b + 2 a)² (the
/// bound is that of Donnelly and Lauritzen 2006, "Variance shadow maps").
fn most_bleeding(depths: [f32; 3]) -> f32 {
    let [near, middle, receiver] = depths;
    let between = middle - near;
    let behind = receiver - middle;
    (between / (between + 2.0 * behind)).powi(2)
}

/// Returns where the light meets both plates of `two-plates` and the floor: clip depths of its map.
fn clip_depths(case_truth: &CaseTruth, technique: &dyn ShadowTechnique) -> [f32; 3] {
    let view = case_truth
        .view(&case_truth.lights[0])
        .with_receivers(&case_truth.truth.receivers);
    let recipe = technique.recipe(&view).expect("supported");
    let clip_from_world = recipe.casts[0].space.clip_from_world();
    // The sun is 45 degrees high; its light falls along +x.
    let depth = |height: f32| {
        let place = Vec3::new(0.1 - height, height, 0.0);
        clip_from_world.project_point3(place).z
    };
    [5.0, 1.0, 0.0].map(depth)
}

/// Returns the greatest visibility of a technique on the floor in the lower plate's shadow, .2 m
/// inside of its outline, which is farther than the tests' filters reach. The shadow extends from
/// -0.6 to 1 m along x, and 0.9 m to each side along z.
fn brightest(case_truth: &CaseTruth, technique: &dyn ShadowTechnique) -> f32 {
    let mask = mask(case_truth, technique);
    let receivers = &case_truth.truth.receivers;
    let is_inside = |p: Vec3| p.y.abs() < 0.01 && p.x > -0.4 && p.x < 0.8 && p.z.abs() < 0.7;
    let inside = (0..mask.len())
        .filter(|&i| case_truth.counts(i))
        .filter(|&i| is_inside(receivers.position(i)));
    inside.map(|i| mask[i]).fold(0.0, f32::max)
}

#[test]
fn light_bleeds_as_much_as_the_bounds_allow() {
    let case = case("two-plates");
    let case_truth = case_truth_of(case, &small());
    let map = ShadowMap {
        size: 512,
        ..ShadowMap::default()
    };
    let variance = Vsm {
        blur: 3,
        least_deviation: Some(0.0),
        bleeding_reduction: 0.0,
        ..Vsm::default()
    }
    .on(map);
    // Small enough that light still bleeds.
    let exponent = 2.0;
    let exponential = Evsm {
        blur: 3,
        moments: EvsmMoments::Two,
        positive_exponent: exponent,
        least_deviation: Some(0.0),
        bleeding_reduction: 0.0,
        ..Evsm::default()
    }
    .on(map);
    let depths = clip_depths(&case_truth, &variance);
    let warped = depths.map(|depth| (exponent * (2.0 * depth - 1.0)).exp());
    let of_variance = most_bleeding(depths);
    let of_exponential = most_bleeding(warped);
    // The expected bound, from the heights of the plates.
    assert!((of_variance - 4.0 / 9.0).abs() < 1e-3, "{of_variance}");
    assert!(of_exponential < 0.8 * of_variance, "{of_exponential}");
    let expected: [(&dyn ShadowTechnique, f32); 2] =
        [(&variance, of_variance), (&exponential, of_exponential)];
    for (technique, expected) in expected {
        let found = brightest(&case_truth, technique);
        // It may be less, as pixels are not exactly where the shares are worst. It may be more, as
        // the light meets the plates at a slope: within the filter, depths of one plate differ by
        // up to a hundredth of the distance between the plates.
        assert!(
            found > 0.95 * expected && found < 1.02 * expected,
            "{}: {found} for {expected}",
            technique.name()
        );
    }
    let mask = mask(&case_truth, &variance);
    assert_eq!(verdict(case, &case_truth, &mask), Verdict::Fails);
}

/// Two blockers and a receiver are three depths, which four moments separate.
#[test]
fn four_moments_tell_two_blockers_from_light() {
    let case = case("two-plates");
    let case_truth = case_truth_of(case, &small());
    let map = ShadowMap {
        size: 512,
        ..ShadowMap::default()
    };
    for reconstruction in [Reconstruction::Hamburger, Reconstruction::Hausdorff] {
        let technique = Msm {
            reconstruction,
            bleeding_reduction: 0.0,
            ..Msm::default()
        }
        .on(map);
        let found = brightest(&case_truth, &technique);
        assert!(found < 0.02, "{reconstruction:?}: {found}");
        let mask = mask(&case_truth, &technique);
        assert_eq!(verdict(case, &case_truth, &mask), Verdict::Pass);
    }
    let four_exponentials = Evsm {
        bleeding_reduction: 0.0,
        ..Evsm::default()
    }
    .on(map);
    assert!(brightest(&case_truth, &four_exponentials) < 0.02);
}
