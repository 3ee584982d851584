//! Times any-hit rays: umbrage's traversal with the crack-free triangle test and the skipped triangle against obvhs's own
//! traversal with its own triangles, over the same rays.

use super::paired::{Pair, Repetitions, paired};
use obvhs::{ray::Ray, rt_triangle::RtTriangle};
use rayon::prelude::*;
use std::{
    convert::Infallible,
    hint::black_box,
    time::{Duration, Instant},
};
use umbrage_core::{
    Bvh, Geometry, Receivers,
    glam::{Vec3, Vec3A},
    light_sample::{LightSampler, origin_offset, segment, unit_square},
};

/// One ray.
#[derive(Clone, Copy)]
struct Shot {
    origin: Vec3,
    /// From the origin to the end, metres.
    segment: Vec3,
    /// The triangle that it starts on, which doesn't count as hit.
    skip: u32,
}

/// Rays a task.
const TASK: usize = 4096;
/// Rays from each receiver.
const RAYS: u32 = 4;

/// Returns rays to the light from each receiver.
fn shots(receivers: &Receivers, light: &LightSampler, far: f32) -> Vec<Shot> {
    let mut out = Vec::new();
    for i in (0..receivers.len()).filter(|&i| receivers.receives[i]) {
        let position = receivers.position(i);
        let offset = receivers.normal(i) * origin_offset(position, far);
        let origin = position + offset;
        for s in 0..RAYS {
            out.push(Shot {
                origin,
                segment: segment(light, origin, unit_square(s, i as u32), far),
                skip: receivers.triangle[i],
            });
        }
    }
    out
}

/// Times both over all rays.
pub(super) fn compare(
    name: &str,
    geometry: &Geometry,
    receivers: &Receivers,
    light: &umbrage_core::Light,
    repetitions: Repetitions,
) -> Pair {
    let far = 2.0 * geometry.bounds().extent().length();
    let shots = shots(receivers, &LightSampler::new(light), far);
    let bvh = geometry.bvh();
    let (wide, ids) = Bvh::obvhs_alone(geometry).unwrap_or_default();
    let triangles: Vec<RtTriangle> = ids
        .iter()
        .map(|&id| {
            let [a, b, c] = geometry.corners(id).map(Vec3A::from);
            RtTriangle::new(a, b, c)
        })
        .collect();
    let ours_hits = |shot: &Shot| bvh.occluded(shot.origin, shot.segment, shot.skip);
    let obvhs_hits = |shot: &Shot| {
        let ray = Ray::new(shot.origin.into(), shot.segment.into(), 0.0, 1.0);
        !wide.ray_traverse_miss(ray, |ray, i| triangles[i].intersect(ray))
    };
    let paired = paired(
        repetitions,
        || Ok::<_, Infallible>(time(&shots, ours_hits)),
        || Ok(time(&shots, obvhs_hits)),
    )
    .unwrap_or_else(|never| match never {});
    Pair {
        work: format!("{:.1} M any-hit rays, {name}", shots.len() as f64 / 1e6),
        who: [
            "umbrage's test in obvhs's hierarchy".into(),
            "obvhs alone".into(),
        ],
        ours: paired.ours,
        theirs: paired.theirs,
        ratio: paired.ratio,
        bar: Some(0.9),
        runs: repetitions.runs,
    }
}

/// Traces all rays and returns how long that takes.
fn time(shots: &[Shot], hits: impl Fn(&Shot) -> bool + Sync) -> Duration {
    let start = Instant::now();
    let count: usize = shots
        .par_chunks(TASK)
        .map(|task| task.iter().filter(|s| hits(s)).count())
        .sum();
    black_box(count);
    start.elapsed()
}
