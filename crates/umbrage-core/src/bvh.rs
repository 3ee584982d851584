//! Ray queries against the casters. Building and traversal are `obvhs`'s; the triangle test is ours, because truth needs
//! one without cracks, and because it has a twin on the GPU.

use crate::{Geometry, Module, Twin, twin};
use glam::{Vec3, Vec3A};
use obvhs::{
    BvhBuildParams,
    aabb::Aabb,
    bvh2::{Bvh2, reinsertion::ReinsertionOptimizer},
    cwbvh::{CwBvh, bvh2_to_cwbvh::bvh2_to_cwbvh},
    ploc::PlocBuilder,
    ray::Ray,
};

/// The WGSL half of the triangle test.
pub const HIT: Module = Module { name: "hit", text: include_str!("hit.wgsl") };

/// Whether the segment from `o` to `o + d` meets the triangle, edges included. The edge functions of a shared edge are
/// exact negatives of each other (no rounding depends on the order of its ends), so no ray slips between neighbours:
/// Davis, Hagen et al.'s signed volumes as in Woop, Benthin, Wald 2013, "Watertight Ray/Triangle Intersection", without
/// their change of axes.
#[inline(always)]
pub fn segment_hits(o: Vec3, d: Vec3, a: Vec3, b: Vec3, c: Vec3) -> bool {
    use crate::math::{cross3, dot3};
    let (a, b, c) = (a - o, b - o, c - o);
    let u = dot3(d, cross3(c, b));
    let v = dot3(d, cross3(a, c));
    let w = dot3(d, cross3(b, a));
    let inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
    if !inside {
        return false;
    }
    let n = cross3(b - a, c - a);
    let (den, num) = (dot3(n, d), dot3(n, a));
    // 0 <= num/den <= 1, without the division.
    if den > 0.0 { num >= 0.0 && num <= den } else { den < 0.0 && num <= 0.0 && num >= den }
}

/// The pairs, for the lockstep tests.
pub const TWINS: &[Twin] =
    &[twin!(HIT, hit_word(o: Vec3, d: Vec3, a: Vec3, b: Vec3, c: Vec3) -> u32, needs [crate::MATH])];

fn hit_word(o: Vec3, d: Vec3, a: Vec3, b: Vec3, c: Vec3) -> u32 {
    u32::from(segment_hits(o, d, a, b, c))
}

/// A hierarchy over the casters of a [`Geometry`].
#[derive(Clone)]
pub struct Bvh {
    wide: CwBvh,
    narrow: Bvh2,
    corners: Vec<[Vec3A; 3]>,
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
        let corners: Vec<[Vec3A; 3]> = ids.iter().map(|&i| geometry.corners(i).map(Vec3A::from)).collect();
        if ids.is_empty() {
            let (wide, narrow) = (CwBvh::default(), Bvh2::default());
            return Self { wide, narrow, corners, ids, narrow_order: Vec::new() };
        }
        let boxes: Vec<Aabb> = corners.iter().map(padded_box).collect();
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
            corners: order.iter().map(|&i| corners[i as usize]).collect(),
            narrow_order: narrow_order.iter().map(|&i| ids[i as usize]).collect(),
        }
    }

    /// Whether any caster but triangle `skip` meets the segment from `o` to `o + d`.
    #[inline]
    pub fn occluded(&self, o: Vec3, d: Vec3, skip: u32) -> bool {
        if self.ids.is_empty() {
            return false;
        }
        let ray = Ray::new(o.into(), d.into(), 0.0, 1.0);
        !self.wide.ray_traverse_miss(ray, |_, i| {
            let [a, b, c] = self.corners[i];
            let hit = segment_hits(o, d, a.into(), b.into(), c.into()) && self.ids[i] != skip;
            if hit { 0.0 } else { f32::INFINITY }
        })
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

/// A triangle's box, grown by 2^-20 of its distance from the origin: box tests round, and truth must not lose a hit.
fn padded_box(corners: &[Vec3A; 3]) -> Aabb {
    let [a, b, c] = *corners;
    let (min, max) = (a.min(b).min(c), a.max(b).max(c));
    let pad = Vec3A::splat(min.abs().max(max.abs()).max_element() / 1_048_576.0 + f32::MIN_POSITIVE);
    Aabb { min: min - pad, max: max + pad }
}
