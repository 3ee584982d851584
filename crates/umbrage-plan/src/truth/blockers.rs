//! How far the blockers are that shadows come from.

use super::{PointTruth, tracer::FARTHEST};
use glam::Vec2;
use rayon::prelude::*;
use umbrage_core::{
    Aabb, Geometry, Light, Receivers,
    light_sample::{LightSampler, segment},
    metrics::CONTACT,
};

/// From each receiver to the blocker nearest to the light, on the way to the light's middle, metres; infinite where there
/// is none, or where the whole light is seen.
pub(super) fn find(
    light: &Light,
    geometry: &Geometry,
    receivers: &Receivers,
    seen: &[PointTruth],
) -> Vec<f32> {
    let (sampler, bvh) = (LightSampler::new(light), geometry.bvh());
    // Receivers lie within the bounds, so this reaches beyond them from everywhere.
    let reach = (2.0 * geometry.bounds().diagonal()).min(FARTHEST);
    let distance = |i: usize| {
        let o = receivers.position(i);
        let d = segment(&sampler, o, Vec2::splat(0.5), reach);
        // From the light on, so that the first blocker met is the one that a map shows.
        bvh.nearest(geometry, o + d, -d, receivers.triangle[i])
            .map_or(f32::INFINITY, |t| (1.0 - t) * d.length())
    };
    let dark = |i: usize| receivers.receives[i] && !seen[i].unlit && seen[i].visibility < 1.0;
    (0..seen.len())
        .into_par_iter()
        .map(|i| if dark(i) { distance(i) } else { f32::INFINITY })
        .collect()
}

/// Blockers closer than this touch their shadows, metres.
pub(super) fn contact(receivers: &Receivers) -> f32 {
    let bounds = Aabb::around(receivers.positions());
    if bounds.is_empty() {
        0.0
    } else {
        CONTACT * bounds.extent().length()
    }
}
