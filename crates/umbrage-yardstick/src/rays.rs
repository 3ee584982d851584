//! Any-hit rays, traced by umbrage's own triangle test in obvhs's hierarchy and by obvhs alone.

use obvhs::{ray::Ray, rt_triangle::RtTriangle};
use rayon::prelude::*;
use std::{
    hint::black_box,
    time::{Duration, Instant},
};
use umbrage_core::{
    Bvh, Geometry,
    glam::{Vec3, Vec3A},
};

/// A ray for an any-hit test.
#[derive(Clone, Copy, Debug)]
pub struct AnyHitRay {
    /// Origin, world space.
    pub origin: Vec3,
    /// Vector from the origin to the end, metres.
    pub segment: Vec3,
    /// Triangle of the origin, which doesn't count as a hit.
    pub skip: u32,
}

/// Number of rays per task.
const TASK: usize = 4096;

/// Traces all rays through umbrage's hierarchy with its crack-free triangle test, and returns the
/// time that this takes.
pub fn time_own_rays(bvh: &Bvh, rays: &[AnyHitRay]) -> Duration {
    time(rays, |ray| {
        bvh.is_occluded(ray.origin, ray.segment, ray.skip)
    })
}

/// A geometry for obvhs.
pub struct ObvhsScene {
    hierarchy: obvhs::cwbvh::CwBvh,
    /// Triangles in the order of the hierarchy's leaves.
    triangles: Vec<RtTriangle>,
}

impl ObvhsScene {
    /// Returns the casters of a geometry in obvhs's own hierarchy.
    pub fn new(geometry: &Geometry) -> Self {
        let (hierarchy, ids) = Bvh::obvhs_alone(geometry).unwrap_or_default();
        let mut triangles = Vec::with_capacity(ids.len());
        for id in ids {
            let [a, b, c] = geometry.corners(id).map(Vec3A::from);
            triangles.push(RtTriangle::new(a, b, c));
        }
        Self {
            hierarchy,
            triangles,
        }
    }

    /// Traces all rays with obvhs's traversal and triangle test, and returns the time that this
    /// takes.
    pub fn time_rays(&self, rays: &[AnyHitRay]) -> Duration {
        time(rays, |ray| {
            let obvhs_ray = Ray::new(ray.origin.into(), ray.segment.into(), 0.0, 1.0);
            let misses = self
                .hierarchy
                .ray_traverse_miss(obvhs_ray, |ray, i| self.triangles[i].intersect(ray));
            !misses
        })
    }
}

/// Traces all rays and returns the time that this takes.
fn time(rays: &[AnyHitRay], hits: impl Fn(&AnyHitRay) -> bool + Sync) -> Duration {
    let start = Instant::now();
    let count: usize = rays
        .par_chunks(TASK)
        .map(|task| task.iter().filter(|ray| hits(ray)).count())
        .sum();
    black_box(count);
    start.elapsed()
}
