//! Density of samples over the image. It is high where the visibility of a pilot with few rays
//! varies, and where maps differ from the pilot, so techniques may fail.

use super::scene::PlanScene;
use crate::error::MeasureError;
use glam::UVec2;
use umbrage_core::RecipeError;
use umbrage_techniques::{Bias, Hard, MapFilter as _, ShadowMap, TechniquePreset, Traced};

/// Share of the sample spread evenly over all lit receivers, to find errors that the pilot doesn't
/// show.
const EVEN_SHARE: f64 = 0.3;
/// Distance from a change of the pilot's visibility within which techniques are most often wrong,
/// pixels.
const RADIUS: usize = 2;
/// Weight of a difference between a map and the pilot; a change within the pilot has 1. Some
/// differences are errors of this map only.
const MAP_DIFFERENCE_WEIGHT: f64 = 0.5;

/// Result of a few rays from every receiver.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pilot {
    /// Share of rays that reached the light, for each pixel, 0..=1.
    pub(crate) mask: Vec<f32>,
    /// Number of rays from each receiver.
    pub(crate) rays: u32,
    /// True if the mask is truth: under ideal lights.
    pub(crate) is_exact: bool,
}

/// Number of rays from each receiver under lights with an extent.
const RAYS: u32 = 2;

impl Pilot {
    /// Traces the rays. Returns `None` if the scene's hierarchy is too deep for rays.
    pub(crate) fn new(scene: &mut PlanScene<'_>) -> Result<Option<Self>, MeasureError> {
        let is_exact = scene.light.is_ideal();
        let rays = if is_exact { 1 } else { RAYS };
        let mask = mask(scene, Traced { samples: rays }.into())?;
        Ok(mask.map(|mask| Self {
            mask,
            rays,
            is_exact,
        }))
    }
}

/// Returns the density of samples at each pixel: shares that add up to 1, and 0 outside the
/// [lit](PlanScene::lit_pixels) receivers. Unlit receivers count in no error, and under a spot they
/// may be most of the image.
pub(crate) fn density(
    scene: &mut PlanScene<'_>,
    pilot: Option<&Pilot>,
    lit: &[bool],
) -> Result<Vec<f64>, MeasureError> {
    let pilot = match pilot {
        Some(pilot) => pilot.mask.clone(),
        None => vec![1.0; lit.len()],
    };
    let mut interest: Vec<f64> = local_range(scene.camera.size, &pilot, lit)
        .into_iter()
        .map(f64::from)
        .collect();
    // Add the differences of two maps from the pilot.
    for (size, bias) in [(256, Bias::ADAPTIVE), (1024, Bias::NORMAL_OFFSET)] {
        let hard = Hard {}.on(ShadowMap {
            size,
            bias,
            ..ShadowMap::default()
        });
        let Some(mask) = mask(scene, hard.into())? else {
            continue;
        };
        for (i, interest) in interest.iter_mut().enumerate() {
            let difference = (mask[i] - pilot[i]).abs();
            *interest += MAP_DIFFERENCE_WEIGHT * f64::from(difference);
        }
    }
    for (interest, weight) in interest.iter_mut().zip(&scene.weights) {
        *interest *= weight;
    }
    Ok(normalize_interest(interest, lit))
}

/// Renders a technique's mask of the whole image. Returns `None` if it is not supported.
fn mask(
    scene: &mut PlanScene<'_>,
    preset: TechniquePreset,
) -> Result<Option<Vec<f32>>, MeasureError> {
    match scene.preset_mask(&preset) {
        Ok(mask) => Ok(Some(mask)),
        Err(MeasureError::Plan(RecipeError::Unsupported(_))) => Ok(None),
        Err(e) => Err(e),
    }
}

/// Converts weights to shares that add up to 1: [`EVEN_SHARE`] is spread evenly over all lit
/// receivers, the rest in proportion to `interest`.
pub(crate) fn normalize_interest(mut interest: Vec<f64>, lit: &[bool]) -> Vec<f64> {
    for (interest, lit) in interest.iter_mut().zip(lit) {
        if !lit {
            *interest = 0.0;
        }
    }
    let sum: f64 = interest.iter().sum();
    let count = lit.iter().filter(|lit| **lit).count().max(1) as f64;
    // If all weights are 0, spread everything evenly.
    let mut even = 1.0 / count;
    let mut for_interest = 0.0;
    if sum > 0.0 {
        even = EVEN_SHARE / count;
        for_interest = (1.0 - EVEN_SHARE) / sum;
    }
    let mut density = vec![0.0; interest.len()];
    for i in (0..density.len()).filter(|&i| lit[i]) {
        density[i] = even + interest[i] * for_interest;
    }
    density
}

/// Returns the range of visibility of each pixel over the lit receivers within [`RADIUS`] pixels
/// along both axes, 0..=1. Reduces rows first, then columns.
fn local_range(size: UVec2, mask: &[f32], lit: &[bool]) -> Vec<f32> {
    let width = size.x as usize;
    let height = size.y as usize;
    let mut rows = Vec::with_capacity(width * height);
    for y in 0..height {
        for x in 0..width {
            let mut range = Range::EMPTY;
            for neighbor in neighbors(x, width) {
                let i = y * width + neighbor;
                range = range.union(Range::sample_at(mask[i], lit[i]));
            }
            rows.push(range);
        }
    }
    let mut out = Vec::with_capacity(width * height);
    for y in 0..height {
        for x in 0..width {
            let mut range = Range::EMPTY;
            for neighbor in neighbors(y, height) {
                range = range.union(rows[neighbor * width + x]);
            }
            out.push(range.width());
        }
    }
    out
}

/// Returns the indices within [`RADIUS`] of an index, out of `count`.
fn neighbors(place: usize, count: usize) -> std::ops::Range<usize> {
    place.saturating_sub(RADIUS)..(place + RADIUS + 1).min(count)
}

/// Least and greatest of a set of values.
#[derive(Clone, Copy)]
struct Range {
    min: f32,
    max: f32,
}

impl Range {
    const EMPTY: Self = Self {
        min: f32::INFINITY,
        max: f32::NEG_INFINITY,
    };

    /// Returns the range of one value, or the empty range if it is not lit.
    fn sample_at(value: f32, lit: bool) -> Self {
        if lit {
            Self {
                min: value,
                max: value,
            }
        } else {
            Self::EMPTY
        }
    }

    fn union(self, other: Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    /// Returns the width, or 0 for the empty range.
    fn width(self) -> f32 {
        (self.max - self.min).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_are_of_interest_and_what_is_not_lit_is_not() {
        let size = UVec2::new(12, 3);
        let mask: Vec<f32> = (0..36)
            .map(|i| if i % 12 < 6 { 1.0 } else { 0.0 })
            .collect();
        let mut lit = vec![true; 36];
        lit[23] = false;
        let range = local_range(size, &mask, &lit);
        let expected = |x: usize| if (4..8).contains(&x) { 1.0 } else { 0.0 };
        assert!((0..36).all(|i| range[i] == expected(i % 12)), "{range:?}");
        let density = normalize_interest(range.iter().map(|&s| f64::from(s)).collect(), &lit);
        assert!((density.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert_eq!(density[23], 0.0);
        assert!(density[5] > 5.0 * density[0] && density[0] > 0.0);
    }

    #[test]
    fn where_nothing_varies_all_are_alike() {
        assert_eq!(
            normalize_interest(vec![0.0; 4], &[true, true, false, true]),
            [1.0 / 3.0, 1.0 / 3.0, 0.0, 1.0 / 3.0]
        );
        assert_eq!(
            normalize_interest(vec![0.0; 2], &[false, false]),
            [0.0, 0.0]
        );
    }
}
