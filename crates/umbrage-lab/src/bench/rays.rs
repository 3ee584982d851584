//! Times any-hit rays. Compares umbrage's traversal, with the crack-free triangle test and the
//! skipped triangle, with obvhs's own traversal and triangles, over the same rays.

use super::paired::{Pair, Repetitions, measure_pairs};
use std::convert::Infallible;
use umbrage_core::{
    Geometry, Receivers,
    light_sample::{LightSampler, origin_offset, segment, unit_square},
};
use umbrage_yardstick::{AnyHitRay, ObvhsScene, time_own_rays};

/// Rays per receiver.
const RAYS: u32 = 4;

/// Returns rays to the light from each receiver.
fn rays_to_light(receivers: &Receivers, light: &LightSampler, far: f32) -> Vec<AnyHitRay> {
    let mut out = Vec::new();
    for i in (0..receivers.len()).filter(|&i| receivers.receives[i]) {
        let position = receivers.position(i);
        let offset = receivers.normal(i) * origin_offset(position, far);
        let origin = position + offset;
        for s in 0..RAYS {
            out.push(AnyHitRay {
                origin,
                segment: segment(light, origin, unit_square(s, i as u32), far),
                skip: receivers.triangle[i],
            });
        }
    }
    out
}

/// Times both programs over all rays.
pub(super) fn compare(
    name: &str,
    geometry: &Geometry,
    receivers: &Receivers,
    light: &umbrage_core::Light,
    repetitions: Repetitions,
) -> Pair {
    let far = 2.0 * geometry.bounds().extent().length();
    let rays = rays_to_light(receivers, &LightSampler::new(light), far);
    let bvh = geometry.bvh();
    let obvhs = ObvhsScene::new(geometry);
    let paired = measure_pairs(
        repetitions,
        || Ok::<_, Infallible>(time_own_rays(bvh, &rays)),
        || Ok(obvhs.time_rays(&rays)),
    )
    .unwrap_or_else(|never| match never {});
    Pair {
        work: format!("{:.1} M any-hit rays, {name}", rays.len() as f64 / 1e6),
        who: [
            "umbrage's test in obvhs's hierarchy".into(),
            "obvhs alone".into(),
        ],
        ours: paired.ours,
        theirs: paired.theirs,
        ratio: paired.ratio,
        bar: Some(0.9),
        runs: repetitions.runs,
        fault: None,
    }
}
