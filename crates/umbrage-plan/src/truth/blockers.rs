//! Distances of the blockers that cast shadows.

use super::{points::PointTruth, tracer::FARTHEST};
use glam::Vec2;
use rayon::prelude::*;
use umbrage_core::{
    Aabb, Geometry, Light, Receivers,
    light_sample::{LightSampler, segment},
    metrics::CONTACT,
};

/// Returns the distance from each receiver to the blocker nearest to the light, towards the light's
/// centre, metres. Returns infinity without a blocker, or if the whole light is visible.
pub(super) fn find(
    light: &Light,
    geometry: &Geometry,
    receivers: &Receivers,
    seen: &[PointTruth],
) -> Vec<f32> {
    let sampler = LightSampler::new(light);
    // Receivers are within the bounds, so this exceeds the bounds from every receiver.
    let reach = (2.0 * geometry.bounds().diagonal()).min(FARTHEST);
    (0..seen.len())
        .into_par_iter()
        .map(|i| {
            let is_dark = receivers.receives[i] && !seen[i].unlit && seen[i].visibility < 1.0;
            if is_dark {
                distance(&sampler, geometry, receivers, i, reach)
            } else {
                f32::INFINITY
            }
        })
        .collect()
}

/// Returns the distance from receiver `i`, metres, or infinity without a blocker. `reach` is the
/// length of rays to directional lights, metres.
fn distance(
    light: &LightSampler,
    geometry: &Geometry,
    receivers: &Receivers,
    i: usize,
    reach: f32,
) -> f32 {
    let o = receivers.position(i);
    let d = segment(light, o, Vec2::splat(0.5), reach);
    // Trace from the light, so that the first blocker is the one that a map stores.
    let from_light = geometry
        .bvh()
        .nearest(geometry, o + d, -d, receivers.triangle[i]);
    from_light.map_or(f32::INFINITY, |t| (1.0 - t) * d.length())
}

/// Returns the distance below which blockers touch their shadows, metres.
pub(super) fn contact(receivers: &Receivers) -> f32 {
    let bounds = Aabb::from_points(receivers.positions());
    if bounds.is_empty() {
        0.0
    } else {
        CONTACT * bounds.extent().length()
    }
}
