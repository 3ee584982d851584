//! One receiver's question to the hierarchy.

use super::{PointTruth, ReceiverPoint, TruthOptions};
use glam::{Vec2, Vec3};
use std::sync::Arc;
use umbrage_core::{
    Aabb, Bvh, Geometry, Invalid, Light,
    light_sample::{
        LightSampler, bitangent, kind, origin_offset, scrambled, segment, sobol_bits, tangent,
    },
    math::dot3,
};

/// Blocks of samples whose scatter gives the standard error.
const BLOCKS: u32 = 16;

/// Greatest length of rays towards directional lights, metres: within the range of 32 bits after a division.
pub(super) const FARTHEST: f32 = 1e38;

/// A light and the casters before it.
pub(super) struct Tracer<'a> {
    bvh: Arc<Bvh>,
    geometry: &'a Geometry,
    light: LightSampler,
    /// A spot's place, unit axis and cosine of its outer angle.
    cone: Option<(Vec3, Vec3, f32)>,
    /// A ball around the casters: rays to directional lights leave it.
    center: Vec3,
    radius: f32,
    /// The sequence before scrambling.
    sequence: Vec<[u32; 2]>,
    samples: u32,
    all_samples: u32,
}

/// What is remembered from one ray to the next: whatever hid the last one most likely hides this one.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Memory {
    occluder: Option<u32>,
}

/// Counts over a run of samples.
#[derive(Clone, Copy, Debug, Default)]
struct Count {
    /// Whether nothing can come between: then no ray is traced.
    clear: bool,
    above: u32,
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
        let samples = if sampler.is_ideal() {
            1
        } else {
            options.samples.max(1)
        };
        let all_samples = if sampler.is_ideal() {
            1
        } else {
            samples.saturating_mul(options.penumbra_factor.max(1))
        };
        let bounds = geometry.caster_bounds();
        let empty = bounds.is_empty();
        Ok(Self {
            bvh: geometry.bvh().clone(),
            geometry,
            light: sampler,
            cone: match *light {
                Light::Spot {
                    position,
                    direction,
                    outer,
                    ..
                } => Some((
                    position,
                    direction.as_dvec3().normalize().as_vec3(),
                    outer.cos(),
                )),
                _ => None,
            },
            center: if empty { Vec3::ZERO } else { bounds.center() },
            radius: if empty { 1.0 } else { bounds.diagonal() },
            sequence: (0..all_samples).map(sobol_bits).collect(),
            samples,
            all_samples,
        })
    }

    /// The fraction of the light that a point sees. `lift` multiplies the ray offset.
    pub(super) fn ask(&self, point: &ReceiverPoint, lift: f32, memory: &mut Memory) -> PointTruth {
        let n = point.normal;
        let o = point.position + n * (lift * origin_offset(point.position, point.reach));
        let to_center = Aabb::around([o, self.center]).diagonal();
        let far = (1.01 * (to_center + self.radius)).min(FARTHEST);
        let mut blocks = Vec::new();
        let first = self.run(0..self.samples, point, o, far, memory, &mut blocks);
        let whole = if first.seen == 0 || first.seen == self.samples {
            (first, self.samples)
        } else {
            blocks.clear();
            (
                self.run(0..self.all_samples, point, o, far, memory, &mut blocks),
                self.all_samples,
            )
        };
        let visibility = whole.0.seen as f32 / whole.1 as f32;
        PointTruth {
            visibility,
            error: standard_error(&blocks, visibility),
            unlit: whole.0.above == 0 || self.outside_cone(o),
        }
    }

    /// Traces a range of samples; `blocks` gets the fraction seen by each of [`BLOCKS`] equal parts.
    fn run(
        &self,
        range: std::ops::Range<u32>,
        point: &ReceiverPoint,
        o: Vec3,
        far: f32,
        memory: &mut Memory,
        blocks: &mut Vec<f32>,
    ) -> Count {
        let mut count = Count {
            clear: self.is_clear(point, o),
            ..Count::default()
        };
        let size = (range.len() as u32).div_ceil(BLOCKS);
        for start in range.clone().step_by(size as usize) {
            let (before, end) = (count.seen, (start + size).min(range.end));
            for i in start..end {
                let uv = scrambled(self.sequence[i as usize], point.seed);
                self.sample(uv, point, o, far, memory, &mut count);
            }
            blocks.push((count.seen - before) as f32 / (end - start) as f32);
        }
        count
    }

    #[inline(always)]
    fn sample(
        &self,
        uv: Vec2,
        point: &ReceiverPoint,
        o: Vec3,
        far: f32,
        memory: &mut Memory,
        count: &mut Count,
    ) {
        let d = segment(&self.light, o, uv, far);
        if dot3(point.normal, d) <= 0.0 {
            return;
        }
        count.above += 1;
        if count.clear {
            count.seen += 1;
            return;
        }
        if memory
            .occluder
            .is_some_and(|i| self.bvh.hits(i, o, d, point.triangle))
        {
            return;
        }
        match self.bvh.occluder(o, d, point.triangle) {
            Some(i) => memory.occluder = Some(i),
            None => count.seen += 1,
        }
    }

    /// Whether no caster reaches between a point and a light with an extent: into the pyramid from the point over a
    /// parallelogram around the light, above the point's tangent plane, before the light.
    fn is_clear(&self, point: &ReceiverPoint, o: Vec3) -> bool {
        let (n, s) = (point.normal, &self.light);
        let axes = [s.half_u.truncate(), s.half_v.truncate()];
        let (center, [u, v]) = match s.shape.x {
            kind::RECT | kind::DISC => (s.center.truncate() - o, axes),
            kind::BALL => {
                let c = s.center.truncate() - o;
                let across = c.normalize_or_zero();
                (
                    c,
                    [tangent(across), bitangent(across)].map(|a| a * s.half_u.w),
                )
            }
            // Beyond 1 radian the pyramid would be too blunt to be of use.
            kind::CAP if s.half_u.w < 0.46 => {
                let tan = (1.0 / (1.0 - s.half_u.w).powi(2) - 1.0).sqrt() * 1.000_1;
                (s.center.truncate(), axes.map(|a| a * tan))
            }
            _ => return false,
        };
        let corners = [
            center + u + v,
            center - u + v,
            center - u - v,
            center + u - v,
        ];
        let mut planes = [(n, n.dot(o)); 6];
        for k in 0..4 {
            let side = corners[k].cross(corners[(k + 1) % 4]);
            // A light that is seen edge-on has no inside.
            if side.dot(center).abs() <= 1e-4 * side.length() * center.length() {
                return false;
            }
            let inward = if side.dot(center) < 0.0 { -side } else { side };
            planes[k] = (inward, inward.dot(o));
        }
        if s.shape.x != kind::CAP {
            let back = u.cross(v) * -u.cross(v).dot(center).signum();
            planes[5] = (back, back.dot(o + center));
        }
        self.bvh.is_clear(self.geometry, &planes)
    }

    fn outside_cone(&self, p: Vec3) -> bool {
        self.cone.is_some_and(|(position, axis, cosine)| {
            let to_point = (p - position).as_dvec3().normalize_or_zero().as_vec3();
            dot3(to_point, axis) < cosine
        })
    }
}

/// Scatter of the blocks' means over the root of their number: an upper estimate, as the whole is stratified better than
/// its parts.
fn standard_error(blocks: &[f32], mean: f32) -> f32 {
    let n = blocks.len() as f32;
    if blocks.len() < 2 {
        return 0.0;
    }
    let variance = blocks.iter().map(|b| (b - mean) * (b - mean)).sum::<f32>() / (n - 1.0);
    (variance / n).sqrt()
}
