//! Tests of the metrics with corrupted inputs: each must change the right figure.

use super::*;

const SIZE: UVec2 = UVec2::new(40, 30);
const N: usize = 1200;

/// Returns a mask that is dark left of column 20.
fn truth() -> Vec<f32> {
    (0..N)
        .map(|i| if i % 40 < 20 { 0.0 } else { 1.0 })
        .collect()
}

fn measure(mask: &[f32]) -> Errors {
    Errors::measure(SIZE, mask, &truth(), &[Pixel::Counted; N]).expect("valid")
}

#[test]
fn truth_has_no_error() {
    assert_eq!(
        measure(&truth()),
        Errors {
            counted: 1200,
            ..Errors::default()
        }
    );
}

#[test]
fn one_flipped_pixel_far_from_the_edge_is_acne() {
    let mut mask = truth();
    mask[15 * 40 + 35] = 0.0;
    let e = measure(&mask);
    let share = 100.0 / 1200.0;
    assert_eq!((e.false_shadow, e.false_light, e.acne), (share, 0.0, share));
    assert!((e.rmse - (1.0_f64 / 1200.0).sqrt()).abs() < 1e-12);
    assert!((e.mean - 1.0 / 1200.0).abs() < 1e-12 && (e.bias + 1.0 / 1200.0).abs() < 1e-12);
    assert_eq!(e.largest, 1.0);
}

#[test]
fn acne_begins_beyond_its_distance_from_the_edge() {
    // Column 20 is an edge pixel, so column 20 + ACNE_DISTANCE is still near, the next one is not.
    for (column, acne) in [
        (20 + ACNE_DISTANCE as usize, 0.0),
        (21 + ACNE_DISTANCE as usize, 100.0 / 1200.0),
    ] {
        let mut mask = truth();
        mask[15 * 40 + column] = 0.0;
        assert_eq!(measure(&mask).acne, acne, "column {column}");
    }
}

#[test]
fn one_lit_pixel_in_shadow_is_false_light() {
    let mut mask = truth();
    mask[3] = 1.0;
    let e = measure(&mask);
    assert_eq!(
        (e.false_shadow, e.false_light, e.acne),
        (0.0, 100.0 / 1200.0, 0.0)
    );
    assert!(e.bias > 0.0);
}

#[test]
fn small_differences_count_in_rmse_alone() {
    let mask: Vec<f32> = truth().iter().map(|v| v * 0.9).collect();
    let e = measure(&mask);
    assert_eq!((e.false_shadow, e.false_light), (0.0, 0.0));
    assert!((e.rmse - 0.1 * 0.5_f64.sqrt()).abs() < 1e-6);
}

#[test]
fn left_out_pixels_are_counted_but_not_measured() {
    let mut pixels = [Pixel::Counted; N];
    (pixels[0], pixels[1], pixels[2]) = (Pixel::Ambiguous, Pixel::Unlit, Pixel::Empty);
    let mut mask = truth();
    (mask[0], mask[1], mask[2]) = (1.0, 1.0, 1.0);
    let e = Errors::measure(SIZE, &mask, &truth(), &pixels).expect("valid");
    assert_eq!((e.rmse, e.counted, e.ambiguous, e.unlit), (0.0, 1197, 1, 1));
}

#[test]
fn nothing_counted_gives_zeros() {
    let e = Errors::measure(SIZE, &[1.0; N], &truth(), &[Pixel::Empty; N]).expect("valid");
    assert_eq!(e, Errors::default());
}

#[test]
fn distance_is_euclidean() {
    let mut set = vec![false; N];
    set[15 * 40 + 20] = true;
    let near = pixels_near(SIZE, &set, 5);
    for i in 0..N as i64 {
        let (dx, dy) = (i % 40 - 20, i / 40 - 15);
        assert_eq!(near[i as usize], dx * dx + dy * dy <= 25, "({dx}, {dy})");
    }
}

#[test]
fn empty_pixels_make_no_edges() {
    let mut pixels = [Pixel::Counted; N];
    for y in 0..30 {
        pixels[y * 40 + 19] = Pixel::Empty;
    }
    assert!(edges(SIZE, &truth(), &pixels).iter().all(|&e| !e));
    assert_eq!(
        edges(SIZE, &truth(), &[Pixel::Counted; N])
            .iter()
            .filter(|&&e| e)
            .count(),
        60
    );
}

#[test]
fn spoilt_masks_are_refused() {
    let pixels = [Pixel::Counted; N];
    for bad in [f32::NAN, f32::INFINITY, -0.001, 1.001] {
        let mut mask = truth();
        mask[41] = bad;
        let e = Errors::measure(SIZE, &mask, &truth(), &pixels).expect_err("spoilt");
        assert!(e.to_string().contains("pixel (1, 1)"), "{e}");
        assert!(
            Errors::measure(SIZE, &truth(), &mask, &pixels).is_err(),
            "corrupted truth"
        );
        assert!(Agreement::measure(SIZE, &mask, &truth(), &[Doubt::None; N], 0.0).is_err());
        assert!(Agreement::measure(SIZE, &truth(), &mask, &[Doubt::None; N], 0.0).is_err());
    }
}

#[test]
fn wrong_sizes_are_refused() {
    let t = truth();
    assert!(Errors::measure(SIZE, &t[1..], &t, &[Pixel::Counted; N]).is_err());
    assert!(Errors::measure(SIZE, &t, &t[1..], &[Pixel::Counted; N]).is_err());
    assert!(Errors::measure(SIZE, &t, &t, &[Pixel::Counted; N - 1]).is_err());
    assert!(Errors::measure(UVec2::new(0, 30), &[], &[], &[]).is_err());
    assert!(Agreement::measure(SIZE, &t[1..], &t, &[Doubt::None; N], 0.0).is_err());
    assert!(Agreement::measure(SIZE, &t, &t[1..], &[Doubt::None; N], 0.0).is_err());
    assert!(Agreement::measure(SIZE, &t, &t, &[Doubt::None; 3], 0.0).is_err());
}

#[test]
fn equal_masks_agree() {
    let a = Agreement::measure(SIZE, &truth(), &truth(), &[Doubt::None; N], 0.0).expect("valid");
    assert_eq!(
        a,
        Agreement {
            compared: 1200,
            ..Agreement::default()
        }
    );
    assert!(a.holds());
}

#[test]
fn one_decided_pixel_breaks_agreement_and_an_undecided_one_does_not() {
    let mut mask = truth();
    mask[7] = 0.5;
    let a = Agreement::measure(SIZE, &mask, &truth(), &[Doubt::None; N], 0.0).expect("valid");
    assert_eq!(
        (a.differing, a.largest, a.violations, a.holds()),
        (1, 0.5, 1, false)
    );
    let mut doubts = [Doubt::None; N];
    // Doubts at pixels where the masks agree excuse nothing.
    (doubts[7], doubts[8]) = (Doubt::Rounding, Doubt::Rounding);
    let a = Agreement::measure(SIZE, &mask, &truth(), &doubts, 0.0).expect("valid");
    assert_eq!(
        (
            a.differing,
            a.undecided,
            a.elsewhere,
            a.violations,
            a.holds()
        ),
        (1, 1, 0, 0, true)
    );
    doubts[7] = Doubt::Triangle;
    let a = Agreement::measure(SIZE, &mask, &truth(), &doubts, 0.0).expect("valid");
    assert_eq!(
        (
            a.differing,
            a.undecided,
            a.elsewhere,
            a.violations,
            a.holds()
        ),
        (1, 0, 1, 0, true)
    );
}

#[test]
fn rounding_excuses_one_pixel_in_a_thousand() {
    let mut mask = truth();
    let decided = |mask: &[f32]| {
        Agreement::measure(SIZE, mask, &truth(), &[Doubt::Rounding; N], 0.0)
            .expect("valid")
            .is_decided()
    };
    mask[7] = 0.5;
    assert!(decided(&mask), "1 of 1200");
    mask[8] = 0.5;
    assert!(!decided(&mask), "2 of 1200");
}

#[test]
fn a_tiny_difference_is_reported_but_tolerated() {
    let mut mask = truth();
    mask[7] = 0.5 / 255.0;
    let a = Agreement::measure(SIZE, &mask, &truth(), &[Doubt::None; N], 0.0).expect("valid");
    assert_eq!((a.differing, a.violations), (1, 0));
}

/// A kernel's tolerance is added to one 8-bit step.
#[test]
fn a_tolerance_excuses_differences() {
    let mut mask = truth();
    mask[0] = (mask[0] - 0.01).abs();
    let violations = |tolerance| {
        Agreement::measure(SIZE, &mask, &truth(), &[Doubt::None; N], tolerance)
            .expect("valid")
            .violations
    };
    assert_eq!([0.0, 0.005, 0.008].map(violations), [1, 1, 0]);
}

/// The reported standard error equals the spread of the RMSE over samples.
#[test]
#[cfg_attr(miri, ignore = "200 draws of 16,384 pixels take hours there")]
fn samples_tell_their_own_error() {
    let side = 128_u32;
    let size = UVec2::splat(side);
    let count = (side * side) as usize;
    let truth = vec![1.0; count];
    // Wrong at one pixel in eight, by amounts between 0 and 1.
    let random = |i: u32| crate::scene::light_sample::seed(i, 7) as f32 / u32::MAX as f32;
    let mask: Vec<f32> = (0..count as u32)
        .map(|i| if i % 8 == 0 { random(i) } else { 1.0 })
        .collect();
    let all = Errors::measure(size, &mask, &truth, &vec![Pixel::Counted; count]).expect("valid");
    assert_eq!((all.rmse_error, all.unsampled), (0.0, 0));
    let mut label = 0.0;
    let mut squared_errors = 0.0;
    let draws = 200;
    for draw in 0..draws {
        let pixels: Vec<Pixel> = (0..count as u32)
            .map(|i| {
                let is_drawn = crate::scene::light_sample::seed(i, 1000 + draw).is_multiple_of(16);
                if is_drawn {
                    Pixel::Counted
                } else {
                    Pixel::Unsampled
                }
            })
            .collect();
        let errors = Errors::measure(size, &mask, &truth, &pixels).expect("valid");
        assert_eq!(errors.counted + errors.unsampled, count as u64);
        label += errors.rmse_error / f64::from(draws);
        squared_errors += (errors.rmse - all.rmse).powi(2) / f64::from(draws);
    }
    let found = squared_errors.sqrt();
    // 200 draws estimate a standard deviation within 5 %, at one standard deviation.
    assert!(
        (label / found - 1.0).abs() < 0.2,
        "reported {label}, found {found}"
    );
}
