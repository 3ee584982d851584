//! Tracing of a light's visibility from one receiver at a time.

use super::{
    options::TruthOptions,
    points::{GIANT, PointTruth, ReceiverPoint},
};
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use std::sync::Arc;
use umbrage_core::{
    Aabb, Bvh, Geometry, Invalid, Light,
    light_sample::{LightSampler, bitangent, kind, scramble_bits, segment, sobol_bits, tangent},
    math::dot3,
};

/// Number of blocks of samples whose scatter is the standard error.
const BLOCKS: u32 = 16;

/// Greatest length of rays towards directional lights, metres: within the 32-bit range after a
/// division.
pub(super) const FARTHEST: f32 = 1e38;

/// Light with its casters.
pub(super) struct Tracer<'a> {
    bvh: Arc<Bvh>,
    geometry: &'a Geometry,
    light: LightSampler,
    /// Outer cone of a spot.
    cone: Option<Cone>,
    /// Centre of a sphere around the casters, which rays to directional lights leave.
    center: Vec3,
    /// Radius of the sphere, metres.
    radius: f32,
    /// Greatest extent of a caster's triangle along an axis, metres.
    largest: f32,
    /// Sample sequence before scrambling.
    sequence: Vec<[u32; 2]>,
    /// Number of samples of each receiver.
    samples: u32,
    /// Number of samples of receivers in penumbra.
    all_samples: u32,
}

/// Outer cone of a spot light.
struct Cone {
    apex: Vec3,
    /// Unit direction of the light.
    axis: Vec3,
    /// Cosine of the angle between the axis and the cone.
    cosine: f32,
}

/// Start of a point's rays.
#[derive(Clone, Copy, Debug)]
struct Start {
    /// Origin of the rays.
    o: Vec3,
    /// Length towards directional lights, metres.
    far: f32,
    /// True if casters are so large that they must be tested in 64 bits: see [`GIANT`].
    in_f64: bool,
}

/// Cache between rays: the triangle that hid the last ray most likely hides this one.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Memory {
    occluder: Option<u32>,
}

/// Counts over a range of samples.
#[derive(Clone, Copy, Debug, Default)]
struct Count {
    /// True if no caster can hide the light, so that no ray is traced.
    clear: bool,
    /// Samples of the light above the receiver's tangent plane.
    above: u32,
    /// Samples of the light that are visible.
    seen: u32,
}

impl<'a> Tracer<'a> {
    pub(super) fn new(
        geometry: &'a Geometry,
        light: &Light,
        options: &TruthOptions,
    ) -> Result<Self, Invalid> {
        light.validate()?;
        let sampler = LightSampler::new(light);
        let mut samples = 1;
        let mut all_samples = 1;
        if !sampler.is_ideal() {
            samples = options.samples.max(1);
            all_samples = samples.saturating_mul(options.penumbra_factor.max(1));
        }
        let bounds = geometry.caster_bounds();
        let empty = bounds.is_empty();
        Ok(Self {
            bvh: geometry.bvh().clone(),
            geometry,
            light: sampler,
            cone: cone(light),
            center: if empty { Vec3::ZERO } else { bounds.center() },
            radius: if empty { 1.0 } else { bounds.diagonal() },
            largest: largest_extent(geometry),
            sequence: (0..all_samples).map(sobol_bits).collect(),
            samples,
            all_samples,
        })
    }

    /// Traces the visible fraction of the light from a point. `lift` multiplies the ray's offset.
    pub(super) fn trace_point(
        &self,
        point: &ReceiverPoint,
        lift: f32,
        memory: &mut Memory,
    ) -> PointTruth {
        let start = self.start(point, lift);
        let mut blocks = Vec::new();
        let mut samples = self.samples;
        let mut count = self.run(0..samples, point, start, memory, &mut blocks);
        let is_penumbra = count.seen > 0 && count.seen < samples;
        if is_penumbra {
            blocks.clear();
            samples = self.all_samples;
            count = self.run(0..samples, point, start, memory, &mut blocks);
        }
        let visibility = count.seen as f32 / samples as f32;
        PointTruth {
            visibility,
            error: standard_error(&blocks, visibility),
            unlit: count.above == 0 || self.is_outside_cone(start.o),
        }
    }

    /// Returns whether a point is unlit, with the result of [`Tracer::trace_point`] but without
    /// rays.
    pub(super) fn is_unlit(&self, point: &ReceiverPoint) -> bool {
        let Start { o, far, .. } = self.start(point, 1.0);
        let is_above = |i: u32| {
            let uv = scramble_bits(self.sequence[i as usize], point.seed);
            dot3(point.normal, segment(&self.light, o, uv, far)) > 0.0
        };
        // Only penumbrae use more samples, and some of those are above.
        self.is_outside_cone(o) || !(0..self.samples).any(is_above)
    }

    /// Returns the start of a point's rays. `lift` multiplies their offset.
    fn start(&self, point: &ReceiverPoint, lift: f32) -> Start {
        let offset = lift * point.offset();
        let o = point.position + point.normal * offset;
        let to_center = Aabb::from_points([o, self.center]).diagonal();
        Start {
            o,
            far: (1.01 * (to_center + self.radius)).min(FARTHEST),
            in_f64: self.largest > GIANT * point.position.abs().max_element().max(point.reach),
        }
    }

    /// Traces a range of samples. `blocks` receives the visible fraction of each of [`BLOCKS`]
    /// equal parts.
    fn run(
        &self,
        range: std::ops::Range<u32>,
        point: &ReceiverPoint,
        start: Start,
        memory: &mut Memory,
        blocks: &mut Vec<f32>,
    ) -> Count {
        let mut count = Count {
            clear: self.is_clear(point, start.o),
            ..Count::default()
        };
        let size = (range.len() as u32).div_ceil(BLOCKS);
        for first in range.clone().step_by(size as usize) {
            let before = count.seen;
            let end = (first + size).min(range.end);
            for i in first..end {
                let uv = scramble_bits(self.sequence[i as usize], point.seed);
                self.sample(uv, point, start, memory, &mut count);
            }
            blocks.push((count.seen - before) as f32 / (end - first) as f32);
        }
        count
    }

    /// Traces one sample: the point `uv` of the light.
    #[inline(always)]
    fn sample(
        &self,
        uv: Vec2,
        point: &ReceiverPoint,
        start: Start,
        memory: &mut Memory,
        count: &mut Count,
    ) {
        let Start { o, far, in_f64 } = start;
        let d = segment(&self.light, o, uv, far);
        if dot3(point.normal, d) <= 0.0 {
            return;
        }
        count.above += 1;
        if count.clear {
            count.seen += 1;
            return;
        }
        let hides = |i: u32| {
            if in_f64 {
                self.bvh.hits_in_f64(i, o, d, point.triangle)
            } else {
                self.bvh.hits(i, o, d, point.triangle)
            }
        };
        if memory.occluder.is_some_and(hides) {
            return;
        }
        let occluder = if in_f64 {
            self.bvh.occluder_in_f64(o, d, point.triangle)
        } else {
            self.bvh.occluder(o, d, point.triangle)
        };
        match occluder {
            Some(i) => memory.occluder = Some(i),
            None => count.seen += 1,
        }
    }

    /// Returns whether no caster is between a point and a light with an extent. The tested volume
    /// is the pyramid from the point over a parallelogram around the light, above the point's
    /// tangent plane and before the light.
    fn is_clear(&self, point: &ReceiverPoint, o: Vec3) -> bool {
        let n = point.normal;
        let light = &self.light;
        let half_u = light.half_u.truncate();
        let half_v = light.half_v.truncate();
        // Vector to the parallelogram's centre, and its half axes.
        let center;
        let u;
        let v;
        match light.shape.x {
            kind::RECT | kind::DISC => {
                center = light.center.truncate() - o;
                u = half_u;
                v = half_v;
            }
            kind::BALL => {
                center = light.center.truncate() - o;
                let direction = center.normalize_or_zero();
                u = tangent(direction) * light.half_u.w;
                v = bitangent(direction) * light.half_u.w;
            }
            // Above 1 radian the pyramid would be too wide to be useful.
            kind::CAP if light.half_u.w < 0.46 => {
                // Tangent of the cap's angle, whose cosine is 1 - w, plus a margin for rounding.
                let tan = (1.0 / (1.0 - light.half_u.w).powi(2) - 1.0).sqrt() * 1.000_1;
                center = light.center.truncate();
                u = half_u * tan;
                v = half_v * tan;
            }
            _ => return false,
        }
        let corners = [
            center + u + v,
            center - u + v,
            center - u - v,
            center + u - v,
        ];
        // Half spaces as inward normals with their distances: the four sides, the tangent plane,
        // and one before the light.
        let mut planes = [(n, n.dot(o)); 6];
        for k in 0..4 {
            let side = corners[k].cross(corners[(k + 1) % 4]);
            // A light seen edge-on has no inside.
            if side.dot(center).abs() <= 1e-4 * side.length() * center.length() {
                return false;
            }
            let inward = if side.dot(center) < 0.0 { -side } else { side };
            planes[k] = (inward, inward.dot(o));
        }
        if light.shape.x != kind::CAP {
            let back = u.cross(v) * -u.cross(v).dot(center).signum();
            planes[5] = (back, back.dot(o + center));
        }
        self.bvh.is_clear(self.geometry, &planes)
    }

    fn is_outside_cone(&self, p: Vec3) -> bool {
        let Some(cone) = &self.cone else {
            return false;
        };
        let to_point = (p - cone.apex).as_dvec3().normalize_or_zero().as_vec3();
        dot3(to_point, cone.axis) < cone.cosine
    }
}

/// Returns the greatest extent of a caster's triangle along an axis, metres; 0 without casters.
fn largest_extent(geometry: &Geometry) -> f32 {
    let extents = geometry.casters().into_par_iter().map(|id| {
        let bounds = Aabb::from_points(geometry.corners(id));
        bounds.extent().max_element()
    });
    extents.reduce(|| 0.0, f32::max)
}

/// Returns the outer cone of a spot light, or `None` for other lights.
fn cone(light: &Light) -> Option<Cone> {
    match *light {
        Light::Spot {
            position,
            direction,
            outer,
            ..
        } => Some(Cone {
            apex: position,
            axis: direction.as_dvec3().normalize().as_vec3(),
            cosine: outer.cos(),
        }),
        Light::Directional { .. }
        | Light::Point { .. }
        | Light::Rect { .. }
        | Light::Disc { .. } => None,
    }
}

/// Returns the standard deviation of the blocks' means over the square root of their number. This
/// overestimates the standard error, since the whole is better stratified than its parts.
fn standard_error(blocks: &[f32], mean: f32) -> f32 {
    let n = blocks.len() as f32;
    if blocks.len() < 2 {
        return 0.0;
    }
    let variance = blocks.iter().map(|b| (b - mean) * (b - mean)).sum::<f32>() / (n - 1.0);
    (variance / n).sqrt()
}
