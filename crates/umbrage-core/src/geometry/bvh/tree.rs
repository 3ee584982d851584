//! The hierarchy over the casters.

use crate::geometry::{
    Geometry,
    aabb::Aabb,
    bvh::{build, wide::Wide},
    cut_out::CutOuts,
    ray_box::{enters_box, slab_inverse, span},
    ray_triangle::{Corners, Segment, hits_in_f64},
    shaft::{Shaft, ShaftSearch},
};
use glam::Vec3;
use obvhs::{bvh2::Bvh2, cwbvh::CwBvh};
use std::sync::{Arc, OnceLock};

/// A hierarchy over the casters of a [`Geometry`].
#[derive(Clone)]
pub struct Bvh {
    wide: Wide,
    narrow: Bvh2,
    corners: Vec<Corners>,
    ids: Vec<u32>,
    narrow_order: Vec<u32>,
    /// Alpha-tested casters.
    cut_outs: Option<Arc<CutOuts>>,
    /// [`Bvh::depth`], computed on first use.
    depth: OnceLock<usize>,
}

impl std::fmt::Debug for Bvh {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Bvh")
            .field("triangles", &self.ids.len())
            .finish_non_exhaustive()
    }
}

impl Bvh {
    /// Builds the hierarchy. Holes don't change its shape: each hit is alpha-tested.
    pub fn build(geometry: &Geometry) -> Self {
        let ids: Vec<u32> = geometry.casters().collect();
        if ids.is_empty() {
            let wide = Wide::default();
            let narrow = Bvh2::default();
            return Self {
                wide,
                narrow,
                corners: Vec::new(),
                ids,
                narrow_order: Vec::new(),
                cut_outs: None,
                depth: OnceLock::new(),
            };
        }
        // Build both hierarchies over the padded boxes.
        let boxes = boxes_of(geometry, &ids);
        let (narrow, tree) = build::trees(&boxes);
        // Store triangles in leaf order: one indirection less per test.
        let order = &tree.primitive_indices;
        let in_order: Vec<_> = order.iter().map(|&i| boxes[i as usize]).collect();
        let narrow_order = narrow
            .primitive_indices
            .iter()
            .map(|&i| ids[i as usize])
            .collect();
        Self {
            wide: Wide::new(&tree, &in_order),
            narrow,
            corners: order
                .iter()
                .map(|&i| Corners::new(geometry.corners(ids[i as usize])))
                .collect(),
            ids: order.iter().map(|&i| ids[i as usize]).collect(),
            narrow_order,
            cut_outs: geometry.cut_outs().cloned(),
            depth: OnceLock::new(),
        }
    }

    /// Returns whether any caster but triangle `skip` occludes the segment from `o` to `o + d`.
    /// Hits in alpha-tested holes don't count.
    #[inline]
    pub fn is_occluded(&self, o: Vec3, d: Vec3, skip: u32) -> bool {
        self.occluder(o, d, skip).is_some()
    }

    /// Returns a caster other than triangle `skip` that occludes the segment from `o` to `o + d`.
    /// Similar segments can be tested against it first with [`Bvh::hits`]. The returned number is
    /// internal to the hierarchy, not a triangle id.
    #[inline]
    pub fn occluder(&self, o: Vec3, d: Vec3, skip: u32) -> Option<u32> {
        let segment = Segment::new(o, d);
        self.first_visited(&segment, |i| {
            segment.hits(&self.corners[i]) && self.ids[i] != skip && !self.is_hole(&segment, i)
        })
    }

    /// Returns an occluder like [`occluder`](Self::occluder), but tests triangles and their holes in
    /// 64 bits. It is slower. Use it if casters are so large that the rounding of the 32-bit test, some 2^-20 of
    /// their extent, exceeds the distance of `o` from them.
    pub fn occluder_in_f64(&self, o: Vec3, d: Vec3, skip: u32) -> Option<u32> {
        let segment = Segment::new(o, d);
        self.first_visited(&segment, |i| self.hits_in_f64(i as u32, o, d, skip))
    }

    /// Returns the first visited caster that `hits` accepts, given its index in the hierarchy.
    #[inline(always)]
    fn first_visited(&self, segment: &Segment, hits: impl Fn(usize) -> bool) -> Option<u32> {
        let mut found = None;
        self.wide.search(segment, |i, _| {
            let hit = hits(i);
            if hit {
                found = Some(i as u32);
            }
            hit
        });
        found
    }

    /// Returns the first hit of the segment from `o` to `o + d` with a caster other than triangle
    /// `skip`, as a fraction of `d`, 0..=1.
    pub fn nearest(&self, geometry: &Geometry, o: Vec3, d: Vec3, skip: u32) -> Option<f32> {
        self.nearest_triangle(geometry, o, d, skip).map(|(t, _)| t)
    }

    /// Returns the first hit like [`nearest`](Self::nearest), with the triangle's id.
    pub fn nearest_triangle(
        &self,
        geometry: &Geometry,
        o: Vec3,
        d: Vec3,
        skip: u32,
    ) -> Option<(f32, u32)> {
        let segment = Segment::new(o, d);
        let mut nearest = None;
        self.wide.search(&segment, |i, limit| {
            if segment.hits(&self.corners[i]) && self.ids[i] != skip && !self.is_hole(&segment, i) {
                let [a, b, c] = geometry
                    .corners(self.ids[i])
                    .map(|corner| corner.as_dvec3());
                let normal = (b - a).cross(c - a);
                let t = normal.dot(a - o.as_dvec3()) / normal.dot(d.as_dvec3());
                // Clamp to the triangle's box, so that no box around it that is entered earlier is
                // skipped.
                let [entry, exit] = span(
                    segment.origin,
                    segment.inverse,
                    self.corners[i].padded_box(),
                );
                *limit = (t as f32).max(entry).min(exit).min(*limit);
                nearest = Some((*limit, self.ids[i]));
            }
            false
        });
        nearest
    }

    /// Returns whether a segment that hits the hierarchy's triangle `i` passes through a hole of
    /// it.
    #[inline(always)]
    fn is_hole(&self, segment: &Segment, i: usize) -> bool {
        match &self.cut_outs {
            None => false,
            Some(cut_outs) => cut_outs.is_hole_met(self.ids[i], &self.corners[i], segment),
        }
    }

    /// Appends the triangle ids of the casters that may come within `radius` of the segment from
    /// `o` to `o + d`, measured along each axis. Conservative: it may append others, too.
    pub fn triangles_near(&self, o: Vec3, d: Vec3, radius: f32, out: &mut Vec<u32>) {
        let inverse = slab_inverse(d);
        let mut stack = self.narrow_root();
        while let Some(i) = stack.pop() {
            let node = &self.narrow.nodes[i];
            let low = node.aabb.min;
            let high = node.aabb.max;
            // Allow for the rounding of the sums below, once more than the boxes do.
            let grow = radius + low.abs().max(high.abs()).max_element() * f32::EPSILON;
            if !enters_box(o.into(), inverse, [low - grow, high + grow]) {
                continue;
            }
            let first = node.first_index as usize;
            if node.prim_count == 0 {
                stack.extend([first, first + 1]);
            } else {
                out.extend(&self.narrow_order[first..first + node.prim_count as usize]);
            }
        }
    }

    /// Passes on all casters that segments of a shaft may meet, roughly front to back, until the
    /// search has enough. Conservative: it may pass on others, too. Alpha tests are not applied.
    #[inline(always)]
    pub fn in_shaft(&self, shaft: &Shaft, search: &mut impl ShaftSearch) {
        let caster = |i: usize| (self.ids[i], self.corners[i].points());
        self.wide.search_shaft(shaft, caster, search);
    }

    /// Returns whether the caster that [`Bvh::occluder`] returned also occludes this segment,
    /// unless it is triangle `skip`.
    ///
    /// # Panics
    /// Panics if the number is from another hierarchy with more triangles.
    #[inline]
    pub fn hits(&self, occluder: u32, o: Vec3, d: Vec3, skip: u32) -> bool {
        let i = occluder as usize;
        let segment = Segment::new(o, d);
        self.ids[i] != skip && segment.hits(&self.corners[i]) && !self.is_hole(&segment, i)
    }

    /// Returns the result of [`hits`](Self::hits) with the triangle test of
    /// [`occluder_in_f64`](Self::occluder_in_f64).
    ///
    /// # Panics
    /// Panics if the number is from another hierarchy with more triangles.
    pub fn hits_in_f64(&self, occluder: u32, o: Vec3, d: Vec3, skip: u32) -> bool {
        let i = occluder as usize;
        let corners = self.corners[i].points();
        let is_hole = |cut_outs: &CutOuts| cut_outs.is_hole_in_f64(self.ids[i], corners, o, d);
        self.ids[i] != skip
            && hits_in_f64(o, d, corners)
            && !self.cut_outs.as_deref().is_some_and(is_hole)
    }

    /// Returns whether no caster reaches into the convex region `normal.dot(x) >= distance` of all
    /// these planes (normals of any length). Conservative: it may return false if a caster only
    /// comes close. One such query can save a thousand rays.
    pub fn is_clear(&self, geometry: &Geometry, planes: &[(Vec3, f32)]) -> bool {
        let mut stack = self.narrow_root();
        while let Some(i) = stack.pop() {
            let node = &self.narrow.nodes[i];
            if is_box_outside(planes, node.aabb.min.into(), node.aabb.max.into()) {
                continue;
            }
            let first = node.first_index as usize;
            if node.prim_count == 0 {
                stack.extend([first, first + 1]);
                continue;
            }
            for &id in &self.narrow_order[first..first + node.prim_count as usize] {
                if !is_triangle_outside(planes, geometry.corners(id)) {
                    return false;
                }
            }
        }
        true
    }

    /// Returns the traversal stack of the two-way hierarchy with its root; empty if there are no
    /// casters.
    fn narrow_root(&self) -> Vec<usize> {
        if self.ids.is_empty() {
            Vec::new()
        } else {
            vec![0]
        }
    }

    /// Returns the greatest number of nodes from the root of the two-way hierarchy to a leaf: the
    /// stack size of a shader.
    pub fn depth(&self) -> usize {
        *self.depth.get_or_init(|| self.find_depth())
    }

    fn find_depth(&self) -> usize {
        let nodes = &self.narrow.nodes;
        let mut deepest = 0;
        // Nodes, each with the number of nodes from the root to it.
        let mut open: Vec<(usize, usize)> = Vec::new();
        if !nodes.is_empty() {
            open.push((0, 1));
        }
        while let Some((node, depth)) = open.pop() {
            deepest = deepest.max(depth);
            if nodes[node].prim_count == 0 {
                let first = nodes[node].first_index as usize;
                open.extend([(first, depth + 1), (first + 1, depth + 1)]);
            }
        }
        deepest
    }

    /// Returns the two-way hierarchy as rows of four words, for shaders. Row 2i is node i's least
    /// corner and its first child or triangle. Row 2i + 1 is its greatest corner and its triangle
    /// count (0 for an inner node, whose children are adjacent). Two rows of zeros if there are no
    /// casters.
    pub fn node_rows(&self) -> Vec<[u32; 4]> {
        let mut rows = Vec::new();
        for node in &self.narrow.nodes {
            rows.push(row(node.aabb.min.into(), node.first_index));
            rows.push(row(node.aabb.max.into(), node.prim_count));
        }
        if rows.is_empty() {
            vec![[0; 4]; 2]
        } else {
            rows
        }
    }

    /// Returns the triangles in the order in which [`Bvh::node_rows`] refers to them, three rows
    /// each: a corner, and the id as the fourth word. Three rows of zeros if there are no casters.
    /// If the geometry has alpha-tested triangles, the second row's fourth word is the row of the
    /// triangle's record in [`CutOuts::rows`], 0 for triangles without holes.
    pub fn triangle_rows(&self, geometry: &Geometry) -> Vec<[u32; 4]> {
        let mut rows = Vec::new();
        for &id in &self.narrow_order {
            let [a, b, c] = geometry.corners(id);
            let second = match geometry.cut_outs() {
                None => id,
                Some(cut_outs) => cut_outs.record_row(id).unwrap_or(0),
            };
            rows.extend([row(a, id), row(b, second), row(c, id)]);
        }
        if rows.is_empty() {
            vec![[0; 4]; 3]
        } else {
            rows
        }
    }

    /// Returns the eight-way hierarchy of the casters as `obvhs` builds it, and the triangle id of
    /// each of its primitives, for benchmarks of `obvhs` alone. `None` if there are no casters.
    pub fn obvhs_alone(geometry: &Geometry) -> Option<(CwBvh, Vec<u32>)> {
        let ids: Vec<u32> = geometry.casters().collect();
        if ids.is_empty() {
            return None;
        }
        let boxes = boxes_of(geometry, &ids);
        let (narrow, _) = build::trees(&boxes);
        let tree = build::eight_way(&narrow);
        let order = tree
            .primitive_indices
            .iter()
            .map(|&i| ids[i as usize])
            .collect();
        Some((tree, order))
    }
}

/// Returns a row of a shader's table.
fn row(v: Vec3, w: u32) -> [u32; 4] {
    [v.x.to_bits(), v.y.to_bits(), v.z.to_bits(), w]
}

/// Returns whether a box is outside one of the half spaces (inner normal, distance).
fn is_box_outside(half_spaces: &[(Vec3, f32)], min: Vec3, max: Vec3) -> bool {
    half_spaces.iter().any(|&half_space| {
        // Test the corner that is farthest along the normal.
        let farthest = Vec3::select(half_space.0.cmpge(Vec3::ZERO), max, min);
        is_outside(half_space, farthest)
    })
}

/// Returns whether a triangle is outside one of the half spaces (inner normal, distance).
fn is_triangle_outside(half_spaces: &[(Vec3, f32)], corners: [Vec3; 3]) -> bool {
    half_spaces
        .iter()
        .any(|&half_space| corners.iter().all(|&c| is_outside(half_space, c)))
}

/// Returns whether a point is outside a half space (its inner normal and distance). Allows for
/// rounding (eight units in the last place) of the point and of a hit on a triangle with this
/// corner (`ray_triangle.rs`).
fn is_outside(half_space: (Vec3, f32), p: Vec3) -> bool {
    let (n, distance) = half_space;
    n.dot(p) < distance - 8.0 * f32::EPSILON * (n.abs().dot(p.abs()) + distance.abs())
}

#[cfg(test)]
#[path = "order_tests.rs"]
mod order_tests;

/// Returns the boxes of triangles, padded for the triangle test (`ray_triangle.rs`).
fn boxes_of(geometry: &Geometry, ids: &[u32]) -> Vec<Aabb> {
    ids.iter()
        .map(|&id| {
            let [min, max] = Corners::new(geometry.corners(id))
                .padded_box()
                .map(Into::into);
            Aabb { min, max }
        })
        .collect()
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
