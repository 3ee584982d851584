//! Peter-panning: how far a shadow starts from where its caster touches the ground.

use super::open::share;
use glam::Vec3;
use umbrage_core::{Receivers, metrics::ERROR_THRESHOLD};

/// Where a caster stands on the ground: a segment, and the way that its shadow falls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// One end, world space, metres.
    pub from: Vec3,
    /// The other end.
    pub to: Vec3,
    /// Unit vector along the ground, across the segment, into the shadow.
    pub along: Vec3,
}

/// Strips that a contact is cut into along its length.
const STRIPS: usize = 16;

/// The ground's height is met within this part of the contact's length.
const LEVEL: f32 = 1e-4;

impl Contact {
    /// Strip and distance from the contact, metres, of a point on the ground behind it; none elsewhere.
    fn place(&self, p: Vec3) -> Option<(usize, f32)> {
        let edge = self.to - self.from;
        let s = (p - self.from).dot(edge) / edge.length_squared();
        let t = (p - self.from).dot(self.along);
        let level = (p.y - self.from.y).abs() < LEVEL * edge.length();
        (level && t > 0.0 && (0.0..1.0).contains(&s)).then_some(((s * STRIPS as f32) as usize, t))
    }

    /// Pixels on the ground behind the contact: index, strip, distance.
    fn pixels<'a>(
        &'a self,
        receivers: &'a Receivers,
        counts: impl Fn(usize) -> bool + 'a,
    ) -> impl Iterator<Item = (usize, usize, f32)> + 'a {
        let here = move |i: &usize| receivers.receives[*i] && counts(*i);
        (0..receivers.len()).filter(here).filter_map(|i| {
            let (strip, t) = self.place(receivers.position(i))?;
            Some((i, strip, t))
        })
    }

    /// The gap: distance on the ground, metres, from the contact to the first dark pixel (below half), the mean over 16
    /// strips along the contact, less the same of truth. Where a strip has no dark pixel, the gap is as long as the true
    /// shadow there.
    pub fn gap(
        &self,
        mask: &[f32],
        truth: &[f32],
        receivers: &Receivers,
        counts: impl Fn(usize) -> bool,
    ) -> f64 {
        let mut first = [[f32::MAX; 2]; STRIPS];
        let mut last = [0.0_f32; STRIPS];
        for (i, strip, t) in self.pixels(receivers, counts) {
            for (slot, v) in first[strip].iter_mut().zip([mask[i], truth[i]]) {
                *slot = if v < 0.5 { slot.min(t) } else { *slot };
            }
            last[strip] = if truth[i] < 0.5 {
                last[strip].max(t)
            } else {
                last[strip]
            };
        }
        let seen = || (0..STRIPS).filter(|&s| first[s][1] < f32::MAX);
        let gap = |s: usize| f64::from((first[s][0].min(last[s]) - first[s][1]).max(0.0));
        seen().map(gap).sum::<f64>() / seen().count().max(1) as f64
    }

    /// Percent of the truly dark pixels within `reach` metres of the contact that the mask lights by more than [`ERROR_THRESHOLD`].
    pub fn leak(
        &self,
        mask: &[f32],
        truth: &[f32],
        receivers: &Receivers,
        reach: f32,
        counts: impl Fn(usize) -> bool,
    ) -> f64 {
        let dark = self
            .pixels(receivers, counts)
            .filter(|(i, _, t)| *t <= reach && truth[*i] < 0.5);
        share(dark.map(|(i, ..)| mask[i] - truth[i] > ERROR_THRESHOLD))
    }

    /// How far apart rows of pixels lie on the ground within `reach` of the contact, metres: what a gap can be told by.
    pub fn pixel(&self, receivers: &Receivers, reach: f32, counts: impl Fn(usize) -> bool) -> f64 {
        let width = receivers.size.x as usize;
        let near = self
            .pixels(receivers, counts)
            .filter(|(_, _, t)| *t <= reach);
        let rows: std::collections::BTreeSet<usize> = near.map(|(i, ..)| i / width).collect();
        f64::from(reach) / rows.len().max(1) as f64
    }
}

/// Percent of the truly dark ground pixels within `reach` metres (along the ground, at height `y`) of any of the places
/// that the mask lights by more than [`ERROR_THRESHOLD`].
pub fn leak_around(
    places: &[Vec3],
    reach: f32,
    mask: &[f32],
    truth: &[f32],
    receivers: &Receivers,
    counts: impl Fn(usize) -> bool,
) -> f64 {
    let near = |i: &usize| {
        let p = receivers.position(*i);
        places
            .iter()
            .any(|c| (p.y - c.y).abs() < LEVEL && (p - *c).length() <= reach)
    };
    let dark = (0..mask.len())
        .filter(|&i| counts(i) && truth[i] < 0.5)
        .filter(near);
    share(dark.map(|i| mask[i] - truth[i] > ERROR_THRESHOLD))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::UVec2;

    /// A plate of a metre along x, seen on 160 rows of ground of 1 cm each behind it; its shadow is .5 m long.
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
