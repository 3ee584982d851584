//! Where in the image there is something to learn: a pilot of few rays tells where visibility varies, and maps that differ
//! from it where techniques may fail.

use super::scene::PlanScene;
use crate::MeasureError;
use glam::UVec2;
use umbrage_core::RecipeError;
use umbrage_techniques::{Bias, Hard, ShadowMap, TechniquePreset, Traced};

/// The share of the sample that is spread over all receivers alike: what no pilot foresees must be met, too.
const EVEN_SHARE: f64 = 0.3;
/// How far from a change of the pilot's visibility techniques are most often wrong, pixels.
const RADIUS: usize = 2;
/// What a difference between a map and the pilot counts, of what a change within the pilot does: some are this map's own.
const MAP_DIFFERENCE_WEIGHT: f64 = 0.5;

/// A few rays of every receiver.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pilot {
    /// The share that reached the light, one a pixel, 0..=1.
    pub(crate) mask: Vec<f32>,
    /// How many they were a receiver.
    pub(crate) rays: u32,
    /// Whether they are all that there is to know: under ideal lights.
    pub(crate) is_exact: bool,
}

/// Rays under lights with an extent.
const RAYS: u32 = 2;

impl Pilot {
    /// None where the scene's hierarchy is too deep for rays.
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

/// How much is to be learned from each pixel; 0 where nothing receives.
pub(crate) fn density(
    scene: &mut PlanScene<'_>,
    pilot: Option<&Pilot>,
) -> Result<Vec<f64>, MeasureError> {
    let receives = scene.receivers.receives.clone();
    let pilot = pilot.map_or_else(|| vec![1.0; receives.len()], |pilot| pilot.mask.clone());
    let mut interest: Vec<f64> = local_range(scene.camera.size, &pilot, &receives)
        .into_iter()
        .map(f64::from)
        .collect();
    for (size, bias) in [(256, Bias::ADAPTIVE), (1024, Bias::NORMAL_OFFSET)] {
        let hard = Hard {
            map: ShadowMap {
                size,
                bias,
                ..ShadowMap::default()
            },
        };
        let Some(mask) = mask(scene, hard.into())? else {
            continue;
        };
        let differences = interest.iter_mut().zip(mask.iter().zip(&pilot));
        differences
            .for_each(|(out, (a, b))| *out += MAP_DIFFERENCE_WEIGHT * f64::from((a - b).abs()));
    }
    Ok(normalized(interest, &receives))
}

/// A technique's mask of the whole image; none where it isn't supported.
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

/// Turns interest into shares that add up to 1: a part for all receivers alike, the rest in proportion to their interest.
pub(crate) fn normalized(mut interest: Vec<f64>, receives: &[bool]) -> Vec<f64> {
    interest
        .iter_mut()
        .zip(receives)
        .filter(|(_, receives)| !**receives)
        .for_each(|(i, _)| *i = 0.0);
    let sum: f64 = interest.iter().sum();
    let count = receives.iter().filter(|r| **r).count().max(1) as f64;
    let evenly = if sum > 0.0 { EVEN_SHARE } else { 1.0 } / count;
    let of_rest = if sum > 0.0 {
        (1.0 - EVEN_SHARE) / sum
    } else {
        0.0
    };
    let density = |(i, &receives): (f64, &bool)| if receives { evenly + i * of_rest } else { 0.0 };
    interest.into_iter().zip(receives).map(density).collect()
}

/// Returns for each pixel the range of visibility over the receivers within [`RADIUS`] pixels along both axes, 0..=1. Rows
/// are reduced first, then columns.
fn local_range(size: UVec2, mask: &[f32], receives: &[bool]) -> Vec<f32> {
    let (width, height) = (size.x as usize, size.y as usize);
    let rows: Vec<Range> = (0..width * height)
        .map(|i| {
            let row = i - i % width;
            neighbours(i % width, width)
                .map(|x| Range::at(mask[row + x], receives[row + x]))
                .fold(Range::EMPTY, Range::union)
        })
        .collect();
    (0..width * height)
        .map(|i| {
            let column = i % width;
            neighbours(i / width, height)
                .map(|y| rows[y * width + column])
                .fold(Range::EMPTY, Range::union)
                .width()
        })
        .collect()
}

/// The places within [`RADIUS`] of a place, out of `count` places.
fn neighbours(place: usize, count: usize) -> std::ops::Range<usize> {
    place.saturating_sub(RADIUS)..(place + RADIUS + 1).min(count)
}

/// The least and the greatest of some values.
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

    /// One value, or none where nothing receives.
    fn at(value: f32, receives: bool) -> Self {
        if receives {
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

    /// 0 for the empty range.
    fn width(self) -> f32 {
        (self.max - self.min).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_are_of_interest_and_what_is_no_receiver_is_not() {
        let size = UVec2::new(12, 3);
        let mask: Vec<f32> = (0..36)
            .map(|i| if i % 12 < 6 { 1.0 } else { 0.0 })
            .collect();
        let mut receives = vec![true; 36];
        receives[23] = false;
        let range = local_range(size, &mask, &receives);
        let expected = |x: usize| if (4..8).contains(&x) { 1.0 } else { 0.0 };
        assert!((0..36).all(|i| range[i] == expected(i % 12)), "{range:?}");
        let density = normalized(range.iter().map(|&s| f64::from(s)).collect(), &receives);
        assert!((density.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert_eq!(density[23], 0.0);
        assert!(density[5] > 5.0 * density[0] && density[0] > 0.0);
    }

    #[test]
    fn where_nothing_varies_all_are_alike() {
        assert_eq!(
            normalized(vec![0.0; 4], &[true, true, false, true]),
            [1.0 / 3.0, 1.0 / 3.0, 0.0, 1.0 / 3.0]
        );
        assert_eq!(normalized(vec![0.0; 2], &[false, false]), [0.0, 0.0]);
    }
}
