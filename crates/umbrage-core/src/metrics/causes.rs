//! Attribution of errors to causes.
//!
//! The |mask - truth| of each counted pixel is attributed to one cause, so the causes' means add up
//! to [`Errors::mean`](super::Errors::mean). The first matching rule applies:
//!
//! 1. **gap** (peter-panning): too light where truth is dark and the blocker is in
//!    [contact](CONTACT), since a bias lets light under it. The gap includes the light connected to
//!    such pixels, except edges.
//! 2. **penumbra**: wrong within [`ACNE_DISTANCE`] of a true penumbra: too hard, too wide, noisy or
//!    banded.
//! 3. **edge**: wrong within [`ACNE_DISTANCE`] of a true hard edge: visible texels, or a displaced
//!    or blurred edge.
//! 4. **acne**: too dark elsewhere, as surfaces shadow themselves.
//! 5. **leak**: too light elsewhere, where a distant blocker should hide the light.

use crate::{
    invalid::Invalid,
    metrics::{
        ACNE_DISTANCE, ERROR_THRESHOLD, PENUMBRA, Pixel, check, check_len, edges, pixels_near,
    },
};
use glam::UVec2;

/// Greatest distance of a contact between a blocker and its shadow, as a fraction (1/32) of the
/// diagonal of the box around the visible geometry. It determines where a gap begins, not its size.
/// It must be longer than a few pixels (about fifteen in an image 480 wide), and much shorter than
/// the distance between objects.
pub const CONTACT: f32 = 1.0 / 32.0;

/// Error by cause. The first five are means of |mask - truth| over all counted pixels, 0..=1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Causes {
    /// Surfaces that shadow themselves.
    pub acne: f64,
    /// Shadows detached from their casters.
    pub gap: f64,
    /// Light through blockers.
    pub leak: f64,
    /// Hard edges that are displaced, or show a map's texels.
    pub edge: f64,
    /// Soft edges of the wrong width or with noise.
    pub penumbra: f64,
    /// Width of the gap between blocker and shadow, metres: the 95th percentile of the distances to
    /// the blocker of false light ([`ERROR_THRESHOLD`]) in a gap. `None` without any.
    pub gap_metres: Option<f64>,
    /// Ratio of the mask's penumbra pixels to truth's, around true penumbrae: 1 is correct, 0 hard.
    /// `None` if truth has no penumbra.
    pub penumbra_width: Option<f64>,
}

/// One of the causes in [`Causes`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Cause {
    /// [`Causes::acne`].
    Acne,
    /// [`Causes::gap`].
    Gap,
    /// [`Causes::leak`].
    Leak,
    /// [`Causes::edge`].
    Edge,
    /// [`Causes::penumbra`].
    Penumbra,
}

/// Truth of an image, prepared for the attribution of many masks' errors.
#[derive(Clone, Debug)]
pub struct TruthImage<'a> {
    size: UVec2,
    visibility: &'a [f32],
    pixels: &'a [Pixel],
    blocker: &'a [f32],
    contact: f32,
    /// Pixels within [`ACNE_DISTANCE`] of true penumbrae.
    is_near_soft: Vec<bool>,
    /// Pixels near any true edge.
    is_near_edge: Vec<bool>,
}

impl<'a> TruthImage<'a> {
    /// Prepares truth. All slices have one entry per pixel. `blocker` is the distance, metres, from
    /// the receiver to the blocker nearest to the light, towards the light's centre; infinite if
    /// there is none. `contact` is the distance, metres, below which blockers are in contact:
    /// [`CONTACT`] times the diagonal of the box around the visible geometry.
    ///
    /// # Errors
    /// Errors if sizes differ or a visibility is not within 0..=1.
    pub fn new(
        size: UVec2,
        visibility: &'a [f32],
        pixels: &'a [Pixel],
        blocker: &'a [f32],
        contact: f32,
    ) -> Result<Self, Invalid> {
        check("truth", size, visibility)?;
        check_len("pixel classes", size, pixels.len())?;
        check_len("blockers", size, blocker.len())?;
        let soft = penumbrae(visibility, pixels);
        let is_near_soft = pixels_near(size, &soft, ACNE_DISTANCE);
        let is_near_edge = pixels_near(size, &edges(size, visibility, pixels), ACNE_DISTANCE);
        Ok(Self {
            size,
            visibility,
            pixels,
            blocker,
            contact,
            is_near_soft,
            is_near_edge,
        })
    }
}

impl TruthImage<'_> {
    /// Returns the same truth with other pixel classes, for another backend; shadow edges are kept.
    ///
    /// # Errors
    /// Errors if the number of classes is not the number of pixels.
    pub fn with_pixels<'b>(&'b self, pixels: &'b [Pixel]) -> Result<TruthImage<'b>, Invalid> {
        check_len("pixel classes", self.size, pixels.len())?;
        Ok(TruthImage {
            pixels,
            ..self.clone()
        })
    }
}

impl Causes {
    /// Splits a mask's error by its causes.
    ///
    /// # Errors
    /// Errors if sizes differ or a value is not within 0..=1.
    pub fn measure(mask: &[f32], truth: &TruthImage<'_>) -> Result<Self, Invalid> {
        let causes = attribute(mask, truth)?;
        let mut out = Self::default();
        // Distances to the blocker, metres, of pixels with false light in a gap.
        let mut gaps = Vec::new();
        for (i, cause) in causes.iter().enumerate() {
            let Some(cause) = cause else { continue };
            let difference = mask[i] - truth.visibility[i];
            *out.share(*cause) += f64::from(difference.abs());
            if *cause == Cause::Gap && difference > ERROR_THRESHOLD {
                gaps.push(truth.blocker[i]);
            }
        }
        // Convert the sums to means.
        let counted = truth
            .pixels
            .iter()
            .filter(|p| **p == Pixel::Counted)
            .count()
            .max(1) as f64;
        for cause in [
            Cause::Acne,
            Cause::Gap,
            Cause::Leak,
            Cause::Edge,
            Cause::Penumbra,
        ] {
            *out.share(cause) /= counted;
        }
        // Compute the 95th percentile of the gaps.
        gaps.sort_by(f32::total_cmp);
        out.gap_metres = gaps
            .get(gaps.len() * 19 / 20)
            .map(|&metres| f64::from(metres));
        out.penumbra_width = penumbra_width(mask, truth);
        Ok(out)
    }

    fn share(&mut self, cause: Cause) -> &mut f64 {
        match cause {
            Cause::Acne => &mut self.acne,
            Cause::Gap => &mut self.gap,
            Cause::Leak => &mut self.leak,
            Cause::Edge => &mut self.edge,
            Cause::Penumbra => &mut self.penumbra,
        }
    }
}

/// Returns the cause of each pixel's error; `None` for pixels without error or not counted.
///
/// # Errors
/// Errors if sizes differ or a value is not within 0..=1.
pub fn attribute(mask: &[f32], truth: &TruthImage<'_>) -> Result<Vec<Option<Cause>>, Invalid> {
    check("mask", truth.size, mask)?;
    // Include pixels outside the judged sample: gaps spread over them.
    let is_too_light = |i: usize| {
        truth.pixels[i].is_candidate()
            && mask[i] > truth.visibility[i]
            && truth.visibility[i] < PENUMBRA
    };
    // Grow gaps from the pixels in contact with the blocker, over connected false light, except
    // edges.
    let gap = flood(
        truth.size,
        |i| is_too_light(i) && truth.blocker[i] <= truth.contact,
        |i| is_too_light(i) && !truth.is_near_soft[i] && !truth.is_near_edge[i],
    );
    let mut causes = vec![None; mask.len()];
    for (i, cause) in causes.iter_mut().enumerate() {
        let difference = mask[i] - truth.visibility[i];
        if truth.pixels[i] != Pixel::Counted || difference == 0.0 {
            continue;
        }
        *cause = Some(if gap[i] {
            Cause::Gap
        } else if truth.is_near_soft[i] {
            Cause::Penumbra
        } else if truth.is_near_edge[i] {
            Cause::Edge
        } else if difference < 0.0 {
            Cause::Acne
        } else {
            Cause::Leak
        });
    }
    Ok(causes)
}

/// Returns the pixels for which `start` is true, and those connected to them by pixels for which
/// `spread` is true (4-connectivity).
fn flood(size: UVec2, start: impl Fn(usize) -> bool, spread: impl Fn(usize) -> bool) -> Vec<bool> {
    let width = size.x as usize;
    let count = width * size.y as usize;
    let mut reached: Vec<bool> = (0..count).map(start).collect();
    let mut open: Vec<usize> = (0..count).filter(|&i| reached[i]).collect();
    while let Some(i) = open.pop() {
        let x = i % width;
        let neighbours = [
            (x > 0).then(|| i - 1),
            (x + 1 < width).then(|| i + 1),
            i.checked_sub(width),
            Some(i + width).filter(|&below| below < count),
        ];
        for neighbour in neighbours.into_iter().flatten() {
            if !reached[neighbour] && spread(neighbour) {
                reached[neighbour] = true;
                open.push(neighbour);
            }
        }
    }
    reached
}

/// Returns whether a visibility counts as penumbra, see [`PENUMBRA`].
pub fn is_penumbra(visibility: f32) -> bool {
    (PENUMBRA..=1.0 - PENUMBRA).contains(&visibility)
}

fn penumbrae(visibility: &[f32], pixels: &[Pixel]) -> Vec<bool> {
    visibility
        .iter()
        .zip(pixels)
        .map(|(&v, &p)| p.is_candidate() && is_penumbra(v))
        .collect()
}

/// Returns the ratio of the mask's penumbra pixels to truth's, around true penumbrae; `None` if
/// truth has none.
fn penumbra_width(mask: &[f32], truth: &TruthImage<'_>) -> Option<f64> {
    let mut in_mask = 0_usize;
    let mut in_truth = 0_usize;
    for (i, &visibility) in mask.iter().enumerate() {
        if truth.pixels[i] == Pixel::Counted && truth.is_near_soft[i] {
            in_mask += usize::from(is_penumbra(visibility));
            in_truth += usize::from(is_penumbra(truth.visibility[i]));
        }
    }
    (in_truth > 0).then(|| in_mask as f64 / in_truth as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: UVec2 = UVec2::new(60, 10);
    const N: usize = 600;

    /// Dark left of column 20, with a blocker in contact up to column 4. Lit elsewhere, except for
    /// a penumbra in columns 40 to 44.
    struct Truth {
        visibility: Vec<f32>,
        blocker: Vec<f32>,
    }

    fn truth() -> Truth {
        let column = |i: usize| i % 60;
        let visibility = |i| match column(i) {
            0..20 => 0.0,
            40..45 => 0.5,
            _ => 1.0,
        };
        let blocker = |i| match column(i) {
            0..4 => 0.25,
            4..20 => 3.0,
            _ => f32::INFINITY,
        };
        Truth {
            visibility: (0..N).map(visibility).collect(),
            blocker: (0..N).map(blocker).collect(),
        }
    }

    fn measure_with(mask: &[f32], pixels: &[Pixel]) -> Causes {
        let t = truth();
        let truth = TruthImage::new(SIZE, &t.visibility, pixels, &t.blocker, 0.5).expect("valid");
        Causes::measure(mask, &truth).expect("valid")
    }

    /// Returns the causes when one pixel of truth is replaced.
    fn spoilt_causes(column: usize, value: f32) -> Causes {
        let mut mask = truth().visibility;
        mask[5 * 60 + column] = value;
        measure_with(&mask, &[Pixel::Counted; N])
    }

    #[test]
    fn truth_has_no_cause() {
        let causes = measure_with(&truth().visibility, &[Pixel::Counted; N]);
        assert_eq!(
            causes,
            Causes {
                penumbra_width: Some(1.0),
                ..Causes::default()
            }
        );
    }

    #[test]
    #[cfg_attr(miri, ignore = "measures seven images, which takes many minutes there")]
    fn each_place_has_its_cause() {
        let one = 1.0 / N as f64;
        let right = Causes {
            penumbra_width: Some(1.0),
            ..Causes::default()
        };
        assert_eq!(
            spoilt_causes(2, 1.0),
            Causes {
                gap: one,
                gap_metres: Some(0.25),
                ..right
            }
        );
        assert_eq!(spoilt_causes(6, 1.0), Causes { leak: one, ..right });
        assert_eq!(spoilt_causes(18, 1.0), Causes { edge: one, ..right });
        assert_eq!(spoilt_causes(22, 0.0), Causes { edge: one, ..right });
        assert_eq!(spoilt_causes(30, 0.0), Causes { acne: one, ..right });
        assert_eq!(spoilt_causes(56, 0.0), Causes { acne: one, ..right });
    }

    /// False light that begins at the contact belongs to the gap as far as it is connected, except
    /// along the edge.
    #[test]
    fn a_gap_spreads_from_the_contact() {
        let mut mask = truth().visibility;
        mask[5 * 60 + 2..5 * 60 + 10].fill(1.0);
        (mask[8 * 60 + 8], mask[5 * 60 + 15]) = (1.0, 1.0);
        let causes = measure_with(&mask, &[Pixel::Counted; N]);
        let one = 1.0 / N as f64;
        assert!((causes.gap - 8.0 * one).abs() < 1e-12, "{causes:?}");
        assert_eq!(
            (causes.leak, causes.edge, causes.gap_metres),
            (one, one, Some(3.0))
        );
    }

    #[test]
    fn a_hard_edge_where_it_should_be_soft_has_no_width() {
        let hard: Vec<f32> = truth().visibility.iter().map(|v| v.round()).collect();
        let causes = measure_with(&hard, &[Pixel::Counted; N]);
        assert_eq!(causes.penumbra_width, Some(0.0));
        assert!(
            causes.penumbra > 0.0 && causes.acne + causes.gap + causes.leak + causes.edge == 0.0
        );
    }

    #[test]
    fn a_penumbra_twice_as_wide_measures_two() {
        let mut wide = truth().visibility;
        (0..N)
            .filter(|i| (45..50).contains(&(i % 60)))
            .for_each(|i| wide[i] = 0.8);
        assert_eq!(
            measure_with(&wide, &[Pixel::Counted; N]).penumbra_width,
            Some(2.0)
        );
    }

    #[test]
    fn causes_add_up_to_the_mean_error() {
        let noise = |i: usize| (i * 7919 % 1000) as f32 / 999.0;
        let mask: Vec<f32> = (0..N).map(noise).collect();
        let mut pixels = [Pixel::Counted; N];
        (0..N).step_by(7).for_each(|i| pixels[i] = Pixel::Ambiguous);
        let causes = measure_with(&mask, &pixels);
        let errors = super::super::Errors::measure(SIZE, &mask, &truth().visibility, &pixels)
            .expect("valid");
        let sum = causes.acne + causes.gap + causes.leak + causes.edge + causes.penumbra;
        assert!(
            (sum - errors.mean).abs() < 1e-12,
            "{sum} for {}",
            errors.mean
        );
    }

    #[test]
    fn spoilt_masks_are_refused() {
        let t = truth();
        let pixels = [Pixel::Counted; N];
        assert!(TruthImage::new(SIZE, &t.visibility, &pixels, &t.blocker[1..], 0.5).is_err());
        assert!(TruthImage::new(SIZE, &[f32::NAN; N], &pixels, &t.blocker, 0.5).is_err());
        let truth = TruthImage::new(SIZE, &t.visibility, &pixels, &t.blocker, 0.5).expect("valid");
        assert!(Causes::measure(&[f32::NAN; N], &truth).is_err());
    }
}
