//! Ray queries against the casters. Building and traversal are `obvhs`'s; the triangle test is ours, because truth needs
//! one without cracks, and because it has a twin on the GPU.

pub use crate::hit::{HIT, Segment, TWINS, segment_hits};

use crate::{Geometry, hit::Corners};
use glam::{Vec3, Vec3A};
use obvhs::{
    BvhBuildParams,
    aabb::Aabb,
    bvh2::{Bvh2, reinsertion::ReinsertionOptimizer},
    cwbvh::{CwBvh, bvh2_to_cwbvh::bvh2_to_cwbvh},
    ploc::PlocBuilder,
    ray::{Ray, RayHit},
};

/// A hierarchy over the casters of a [`Geometry`].
#[derive(Clone)]
pub struct Bvh {
    wide: CwBvh,
    narrow: Bvh2,
    corners: Vec<Corners>,
    ids: Vec<u32>,
    narrow_order: Vec<u32>,
}

impl std::fmt::Debug for Bvh {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Bvh").field("triangles", &self.ids.len()).finish_non_exhaustive()
    }
}

impl Bvh {
    /// Builds the hierarchy.
    pub fn build(geometry: &Geometry) -> Self {
        let ids: Vec<u32> = geometry.casters().collect();
        if ids.is_empty() {
            let (wide, narrow) = (CwBvh::default(), Bvh2::default());
            return Self { wide, narrow, corners: Vec::new(), ids, narrow_order: Vec::new() };
        }
        let bounds = geometry.bounds();
        let reach = bounds.min.abs().max(bounds.max.abs()).max_element();
        let boxes: Vec<Aabb> = ids.iter().map(|&i| padded_box(geometry.corners(i), reach)).collect();
        let p = BvhBuildParams::medium_build();
        let indices = (0..ids.len() as u32).collect();
        let mut narrow = PlocBuilder::with_capacity(boxes.len()).build(
            p.ploc_search_distance,
            &boxes,
            indices,
            p.sort_precision,
            p.search_depth_threshold,
        );
        ReinsertionOptimizer::default().run(&mut narrow, p.reinsertion_batch_ratio, None);
        let wide = bvh2_to_cwbvh(&narrow, p.max_prims_per_leaf.clamp(1, 3), true, false);
        // Triangles in the order in which leaves name them: one indirection less a test.
        let order = wide.primitive_indices.clone();
        let narrow_order = narrow.primitive_indices.clone();
        Self {
            wide,
            narrow,
            ids: order.iter().map(|&i| ids[i as usize]).collect(),
            corners: order.iter().map(|&i| Corners::new(geometry.corners(ids[i as usize]))).collect(),
            narrow_order: narrow_order.iter().map(|&i| ids[i as usize]).collect(),
        }
    }

    /// Whether any caster but triangle `skip` meets the segment from `o` to `o + d`.
    #[inline]
    pub fn occluded(&self, o: Vec3, d: Vec3, skip: u32) -> bool {
        self.occluder(o, d, skip).is_some()
    }

    /// A caster other than triangle `skip` that meets the segment from `o` to `o + d`, to be asked first about similar
    /// segments by [`Bvh::hits`]. The number is the hierarchy's own, not a triangle id.
    #[inline]
    pub fn occluder(&self, o: Vec3, d: Vec3, skip: u32) -> Option<u32> {
        if self.ids.is_empty() {
            return None;
        }
        let (segment, mut found) = (Segment::new(o, d), None);
        self.wide.ray_traverse_miss(box_ray(o, d), |_, i| {
            if segment.hits(&self.corners[i]) && self.ids[i] != skip {
                found = Some(i as u32);
                return 0.0;
            }
            f32::INFINITY
        });
        found
    }

    /// Where the segment from `o` to `o + d` first meets a caster other than triangle `skip`: a fraction of `d`, 0..=1.
    pub fn nearest(&self, geometry: &Geometry, o: Vec3, d: Vec3, skip: u32) -> Option<f32> {
        if self.ids.is_empty() {
            return None;
        }
        let (segment, ray, mut hit) = (Segment::new(o, d), box_ray(o, d), RayHit::none());
        self.wide.ray_traverse(ray, &mut hit, |_, i| {
            if !segment.hits(&self.corners[i]) || self.ids[i] == skip {
                return f32::INFINITY;
            }
            let [a, b, c] = geometry.corners(self.ids[i]).map(|corner| corner.as_dvec3());
            let normal = (b - a).cross(c - a);
            let t = normal.dot(a - o.as_dvec3()) / normal.dot(d.as_dvec3());
            t.clamp(0.0, 1.0) as f32 * ray.tmax
        });
        (hit.t <= ray.tmax).then(|| hit.t / ray.tmax)
    }

    /// Whether the caster that [`Bvh::occluder`] gave meets the segment, too, unless it is triangle `skip`.
    ///
    /// # Panics
    /// If it came from another hierarchy with more triangles.
    #[inline]
    pub fn hits(&self, occluder: u32, o: Vec3, d: Vec3, skip: u32) -> bool {
        let i = occluder as usize;
        self.ids[i] != skip && Segment::new(o, d).hits(&self.corners[i])
    }

    /// Whether no caster reaches into the convex region `normal.dot(x) >= distance` of all these planes (normals of any
    /// length). Cautious: it may say no where one comes near. One such question can spare a thousand rays.
    pub fn is_clear(&self, geometry: &Geometry, planes: &[(Vec3, f32)]) -> bool {
        // Of a box the corner that is farthest along the normal decides.
        let outside = |low: Vec3, high: Vec3| {
            planes.iter().any(|&plane| is_outside(plane, Vec3::select(plane.0.cmpge(Vec3::ZERO), high, low)))
        };
        let mut stack = if self.ids.is_empty() { Vec::new() } else { vec![0] };
        while let Some(i) = stack.pop() {
            let node = &self.narrow.nodes[i];
            if outside(node.aabb.min.into(), node.aabb.max.into()) {
                continue;
            }
            let first = node.first_index as usize;
            if node.prim_count == 0 {
                stack.extend([first, first + 1]);
                continue;
            }
            let clear = |&id: &u32| {
                let corners = geometry.corners(id);
                planes.iter().any(|&plane| corners.iter().all(|&c| is_outside(plane, c)))
            };
            if !self.narrow_order[first..first + node.prim_count as usize].iter().all(clear) {
                return false;
            }
        }
        true
    }

    /// Greatest number of nodes from the root of the two-way hierarchy to a leaf: what a shader's stack must hold.
    pub fn depth(&self) -> usize {
        let nodes = &self.narrow.nodes;
        let mut deepest = 0;
        let mut open = if nodes.is_empty() { Vec::new() } else { vec![(0_usize, 1_usize)] };
        while let Some((node, depth)) = open.pop() {
            deepest = deepest.max(depth);
            if nodes[node].prim_count == 0 {
                let first = nodes[node].first_index as usize;
                open.extend([(first, depth + 1), (first + 1, depth + 1)]);
            }
        }
        deepest
    }

    /// The two-way hierarchy as rows of four words, for shaders: row 2i is node i's least corner and its first child or
    /// triangle, row 2i + 1 its greatest corner and its triangle count (0 for an inner node, whose children are
    /// adjacent). One row of zeros when nothing casts.
    pub fn node_rows(&self) -> Vec<[u32; 4]> {
        let row = |v: Vec3A, w: u32| [v.x.to_bits(), v.y.to_bits(), v.z.to_bits(), w];
        let nodes = self.narrow.nodes.iter();
        let rows: Vec<_> =
            nodes.flat_map(|n| [row(n.aabb.min, n.first_index), row(n.aabb.max, n.prim_count)]).collect();
        if rows.is_empty() { vec![[0; 4]; 2] } else { rows }
    }

    /// The triangles in the order in which [`Bvh::node_rows`] names them, three rows each: corners, and the id in the
    /// first row's fourth word.
    pub fn triangle_rows(&self, geometry: &Geometry) -> Vec<[u32; 4]> {
        let row = |v: Vec3, w: u32| [v.x.to_bits(), v.y.to_bits(), v.z.to_bits(), w];
        let rows: Vec<_> = self.narrow_order.iter().flat_map(|&id| geometry.corners(id).map(|v| row(v, id))).collect();
        if rows.is_empty() { vec![[0; 4]; 3] } else { rows }
    }

    /// The hierarchy that `obvhs` made, and each of its primitives' triangle id: to time it by itself.
    pub fn parts(&self) -> (&CwBvh, &[u32]) {
        (&self.wide, &self.ids)
    }
}

/// Whether a point lies outside a half space, whatever rounding (two units in the last place) does to it.
fn is_outside((n, distance): (Vec3, f32), p: Vec3) -> bool {
    n.dot(p) < distance - 2.0 * f32::EPSILON * (n.abs().dot(p.abs()) + distance.abs())
}

/// The segment as `obvhs`'s box test wants it. That test ignores boxes that end before t = 1e-4, a centimetre of a
/// segment of 100 m: so t runs to 2^30 here, which leaves the box test's other numbers as they are.
#[inline(always)]
fn box_ray(o: Vec3, d: Vec3) -> Ray {
    const LENGTH: f32 = 1_073_741_824.0;
    // A component of zero gets a huge inverse of finite products instead of an infinite one, whose products may be NaN;
    // and -0 a positive one, as the box test takes "negative" to be "less than 0".
    let inverse = |x: f32| if x.abs() >= 1e-20 { 1.0 / x } else { 1e20_f32.copysign(if x < 0.0 { x } else { 0.0 }) };
    let inv_direction = Vec3A::new(inverse(d.x), inverse(d.y), inverse(d.z)) * LENGTH;
    Ray { origin: o.into(), direction: d.into(), inv_direction, tmin: 0.0, tmax: LENGTH }
}

/// A triangle's box, grown, because box tests round and truth must not lose a hit: by 2^-21 of the greatest coordinate in
/// the scene (box tests err by about 2^-22 of the distance between ray origin and box), but not by more than an eighth of
/// the box's size, so that tiny triangles amid a vast plain stay quick to search.
fn padded_box([a, b, c]: [Vec3; 3], reach: f32) -> Aabb {
    let (min, max) = (a.min(b).min(c), a.max(b).max(c));
    let rounding = min.abs().max(max.abs()).max_element() / 1_048_576.0;
    let pad = (reach / 2_097_152.0).min((max - min).max_element() / 8.0).max(rounding) + f32::MIN_POSITIVE;
    Aabb { min: (min - pad).into(), max: (max + pad).into() }
}

#[cfg(test)]
mod tests;
