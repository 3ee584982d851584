//! Peter-panning: the distance from a caster's contact with the ground to the start of its shadow.

use super::open::share;
use glam::Vec3;
use std::collections::BTreeSet;
use umbrage_core::{Receivers, metrics::ERROR_THRESHOLD};

/// Contact of a caster with the floor: a segment, and the direction in which its shadow falls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// One end, world space, metres.
    pub from: Vec3,
    /// The other end.
    pub to: Vec3,
    /// Unit vector along the ground, across the segment, into the shadow.
    pub along: Vec3,
}

/// Number of strips that a contact is divided into along its length.
const STRIPS: usize = 16;

/// Greatest height difference between floor pixels and the contact, as a share of the contact's
/// length.
const LEVEL: f32 = 1e-4;

impl Contact {
    /// Returns a pixel's position relative to the contact; `None` unless it shows the floor behind
    /// it.
    fn pixel_behind(&self, receivers: &Receivers, index: usize) -> Option<PixelBehind> {
        let position = receivers.position(index);
        let segment = self.to - self.from;
        let offset = position - self.from;
        // 0 at `from`, 1 at `to`.
        let along_segment = offset.dot(segment) / segment.length_squared();
        let distance = offset.dot(self.along);
        let is_on_floor = (position.y - self.from.y).abs() < LEVEL * segment.length();
        let is_behind = distance > 0.0 && (0.0..1.0).contains(&along_segment);
        (is_on_floor && is_behind).then_some(PixelBehind {
            index,
            strip: (along_segment * STRIPS as f32) as usize,
            distance,
        })
    }

    /// Returns the pixels that count and show the floor behind the contact.
    fn pixels_behind<'a>(
        &'a self,
        receivers: &'a Receivers,
        counts: impl Fn(usize) -> bool + 'a,
    ) -> impl Iterator<Item = PixelBehind> + 'a {
        (0..receivers.len())
            .filter(move |&i| receivers.receives[i] && counts(i))
            .filter_map(|i| self.pixel_behind(receivers, i))
    }

    /// Returns the gap, metres: the distance on the floor from the contact to the first dark pixel
    /// (below 0.5) minus truth's, in the mean over 16 strips along the contact. In a strip without
    /// a dark pixel the gap is as long as the true shadow.
    pub fn gap(
        &self,
        mask: &[f32],
        truth: &[f32],
        receivers: &Receivers,
        counts: impl Fn(usize) -> bool,
    ) -> f64 {
        let mut strips = [StripShadow::NONE; STRIPS];
        for pixel in self.pixels_behind(receivers, counts) {
            let strip = &mut strips[pixel.strip];
            if mask[pixel.index] < 0.5 {
                strip.mask_start = strip.mask_start.min(pixel.distance);
            }
            if truth[pixel.index] < 0.5 {
                strip.true_start = strip.true_start.min(pixel.distance);
                strip.true_end = strip.true_end.max(pixel.distance);
            }
        }
        let with_shadow = strips.iter().filter(|strip| strip.true_start < f32::MAX);
        let count = with_shadow.clone().count();
        with_shadow.map(StripShadow::gap).sum::<f64>() / count.max(1) as f64
    }

    /// Returns the percentage of the truly dark pixels within `reach` metres of the contact that
    /// the mask lights by more than [`ERROR_THRESHOLD`].
    pub fn leak(
        &self,
        mask: &[f32],
        truth: &[f32],
        receivers: &Receivers,
        reach: f32,
        counts: impl Fn(usize) -> bool,
    ) -> f64 {
        let dark = self
            .pixels_behind(receivers, counts)
            .filter(|pixel| pixel.distance <= reach && truth[pixel.index] < 0.5);
        share(dark.map(|pixel| mask[pixel.index] - truth[pixel.index] > ERROR_THRESHOLD))
    }

    /// Returns the mean spacing of pixel rows on the floor within `reach` metres of the contact,
    /// metres: the smallest visible gap.
    pub fn pixel(&self, receivers: &Receivers, reach: f32, counts: impl Fn(usize) -> bool) -> f64 {
        let width = receivers.size.x as usize;
        let near = self
            .pixels_behind(receivers, counts)
            .filter(|pixel| pixel.distance <= reach);
        let rows: BTreeSet<usize> = near.map(|pixel| pixel.index / width).collect();
        f64::from(reach) / rows.len().max(1) as f64
    }
}

/// A pixel that shows the floor behind a contact.
struct PixelBehind {
    index: usize,
    /// Index of the pixel's strip, counted from [`Contact::from`].
    strip: usize,
    /// Distance from the contact, metres.
    distance: f32,
}

/// Start and end of one strip's shadow: distances from the contact, metres.
#[derive(Clone, Copy)]
struct StripShadow {
    /// The first dark pixel of the mask; [`f32::MAX`] without one.
    mask_start: f32,
    /// The first dark pixel of truth; [`f32::MAX`] without one.
    true_start: f32,
    /// The last dark pixel of truth; 0 without one.
    true_end: f32,
}

impl StripShadow {
    const NONE: Self = Self {
        mask_start: f32::MAX,
        true_start: f32::MAX,
        true_end: 0.0,
    };

    fn gap(&self) -> f64 {
        // A mask without a shadow has a gap as long as the true shadow.
        let mask_start = self.mask_start.min(self.true_end);
        f64::from((mask_start - self.true_start).max(0.0))
    }
}

/// Returns the percentage of truly dark floor pixels that the mask lights by more than
/// [`ERROR_THRESHOLD`], within `reach` metres of any of the places and at its height.
pub fn leak_around(
    places: &[Vec3],
    reach: f32,
    mask: &[f32],
    truth: &[f32],
    receivers: &Receivers,
    counts: impl Fn(usize) -> bool,
) -> f64 {
    let dark = (0..mask.len())
        .filter(|&i| counts(i) && truth[i] < 0.5)
        .filter(|&i| is_near(places, reach, receivers.position(i)));
    share(dark.map(|i| mask[i] - truth[i] > ERROR_THRESHOLD))
}

fn is_near(places: &[Vec3], reach: f32, p: Vec3) -> bool {
    places
        .iter()
        .any(|place| (p.y - place.y).abs() < LEVEL && (p - *place).length() <= reach)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::UVec2;

    /// Returns a contact of 1 m along x with 160 rows of ground of 1 cm each behind it, and truth
    /// with a shadow that is .5 m long.
    fn stage() -> (Contact, Receivers, Vec<f32>) {
        let contact = Contact {
            from: Vec3::ZERO,
            to: Vec3::X,
            along: Vec3::Z,
        };
        let size = UVec2::new(32, 160);
        let mut receivers = Receivers::empty(size);
        let mut truth = Vec::new();
        for i in 0..receivers.len() {
            let (x, row) = (i % 32, i / 32);
            receivers.x[i] = (x as f32 + 0.5) / 32.0;
            receivers.z[i] = 0.01 * (row as f32 + 0.5);
            receivers.receives[i] = true;
            truth.push(if receivers.z[i] < 0.5 { 0.0 } else { 1.0 });
        }
        (contact, receivers, truth)
    }

    #[test]
    fn a_shadow_that_starts_late_has_a_gap_and_leaks() {
        let (contact, receivers, truth) = stage();
        let late = |gap: f32| -> Vec<f32> {
            truth
                .iter()
                .zip(&receivers.z)
                .map(|(v, z)| if *z < gap { 1.0 } else { *v })
                .collect()
        };
        for gap in [0.0, 0.1, 0.3] {
            let found = contact.gap(&late(gap), &truth, &receivers, |_| true);
            assert!((found - f64::from(gap)).abs() < 1e-6, "{gap}: {found}");
        }
        assert_eq!(
            contact.leak(&late(0.02), &truth, &receivers, 0.05, |_| true),
            40.0
        );
        assert_eq!(
            contact.leak(&truth, &truth, &receivers, 0.05, |_| true),
            0.0
        );
        assert!((contact.pixel(&receivers, 0.05, |_| true) - 0.01).abs() < 1e-6);
    }

    #[test]
    fn a_lost_shadow_has_a_gap_of_its_length() {
        let (contact, receivers, truth) = stage();
        let found = contact.gap(&vec![1.0; truth.len()], &truth, &receivers, |_| true);
        assert!((found - 0.49).abs() < 1e-6, "{found}");
    }

    #[test]
    fn leaks_count_near_their_places_alone() {
        let (_, receivers, truth) = stage();
        let lit = vec![1.0; truth.len()];
        let leak = |at: Vec3| leak_around(&[at], 0.1, &lit, &truth, &receivers, |_| true);
        assert_eq!([leak(Vec3::ZERO), leak(Vec3::Z * 1.2)], [100.0, 0.0]);
    }
}
