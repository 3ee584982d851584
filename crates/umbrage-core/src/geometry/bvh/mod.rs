//! Ray queries against the casters. `obvhs` finds the hierarchies' shape; the tests of boxes and triangles are ours,
//! because truth needs answers that have no cracks and don't depend on the order of the search (`ray_triangle.rs` says why
//! they don't), and because they have twins on the GPU.

mod build;
mod wide;

pub use crate::{
    Aabb,
    geometry::{
        ray_box::RAY_BOX,
        ray_triangle::{RAY_TRIANGLE, Segment, TWINS, segment_hits},
    },
};

use crate::{
    Geometry,
    geometry::{
        bvh::wide::Wide,
        ray_box::{enters_box, slab_inverse, span},
        ray_triangle::Corners,
    },
};
use glam::{Vec3, Vec3A};
use obvhs::{bvh2::Bvh2, cwbvh::CwBvh};

/// A hierarchy over the casters of a [`Geometry`].
#[derive(Clone)]
pub struct Bvh {
    wide: Wide,
    narrow: Bvh2,
    corners: Vec<Corners>,
    ids: Vec<u32>,
    narrow_order: Vec<u32>,
}

impl std::fmt::Debug for Bvh {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Bvh")
            .field("triangles", &self.ids.len())
            .finish_non_exhaustive()
    }
}

impl Bvh {
    /// Builds the hierarchy.
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
            };
        }
        let boxes = boxes_of(geometry, &ids);
        let (narrow, tree) = build::trees(&boxes);
        // Triangles in the order in which leaves name them: one indirection less a test.
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
        let segment = Segment::new(o, d);
        let mut found = None;
        self.wide.search(&segment, |i, _| {
            let hit = segment.hits(&self.corners[i]) && self.ids[i] != skip;
            if hit {
                found = Some(i as u32);
            }
            hit
        });
        found
    }

    /// Where the segment from `o` to `o + d` first meets a caster other than triangle `skip`: a fraction of `d`, 0..=1.
    pub fn nearest(&self, geometry: &Geometry, o: Vec3, d: Vec3, skip: u32) -> Option<f32> {
        let segment = Segment::new(o, d);
        let mut nearest = None;
        self.wide.search(&segment, |i, limit| {
            if segment.hits(&self.corners[i]) && self.ids[i] != skip {
                let [a, b, c] = geometry
                    .corners(self.ids[i])
                    .map(|corner| corner.as_dvec3());
                let normal = (b - a).cross(c - a);
                let t = normal.dot(a - o.as_dvec3()) / normal.dot(d.as_dvec3());
                // Within the triangle's box, so that no box around it is passed over that is entered before.
                let [entry, exit] = span(
                    segment.origin,
                    segment.inverse,
                    self.corners[i].padded_box(),
                );
                *limit = (t as f32).max(entry).min(exit).min(*limit);
                nearest = Some(*limit);
            }
            false
        });
        nearest
    }

    /// Appends the triangle ids of the casters that may come within `radius` of the segment from `o` to `o + d`, measured
    /// along each axis. Cautious: it may name others, too.
    pub fn near(&self, o: Vec3, d: Vec3, radius: f32, out: &mut Vec<u32>) {
        let inverse = slab_inverse(d);
        // The sums below round, once more than the boxes allow for.
        let grown = |low: Vec3A, high: Vec3A| {
            let by = radius + low.abs().max(high.abs()).max_element() * f32::EPSILON;
            [low - by, high + by]
        };
        let mut stack = if self.ids.is_empty() {
            Vec::new()
        } else {
            vec![0]
        };
        while let Some(i) = stack.pop() {
            let node = &self.narrow.nodes[i];
            if !enters_box(o.into(), inverse, grown(node.aabb.min, node.aabb.max)) {
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

    /// Whether the caster that [`Bvh::occluder`] gave meets the segment, too, unless it is triangle `skip`.
    ///
    /// # Panics
    /// Panics if it came from another hierarchy with more triangles.
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
            planes
                .iter()
                .any(|&plane| is_outside(plane, Vec3::select(plane.0.cmpge(Vec3::ZERO), high, low)))
        };
        let mut stack = if self.ids.is_empty() {
            Vec::new()
        } else {
            vec![0]
        };
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
                planes
                    .iter()
                    .any(|&plane| corners.iter().all(|&c| is_outside(plane, c)))
            };
            if !self.narrow_order[first..first + node.prim_count as usize]
                .iter()
                .all(clear)
            {
                return false;
            }
        }
        true
    }

    /// Greatest number of nodes from the root of the two-way hierarchy to a leaf: what a shader's stack must hold.
    pub fn depth(&self) -> usize {
        let nodes = &self.narrow.nodes;
        let mut deepest = 0;
        let mut open = if nodes.is_empty() {
            Vec::new()
        } else {
            vec![(0_usize, 1_usize)]
        };
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
        let rows: Vec<_> = nodes
            .flat_map(|n| {
                [
                    row(n.aabb.min, n.first_index),
                    row(n.aabb.max, n.prim_count),
                ]
            })
            .collect();
        if rows.is_empty() {
            vec![[0; 4]; 2]
        } else {
            rows
        }
    }

    /// The triangles in the order in which [`Bvh::node_rows`] names them, three rows each: corners, and the id in the
    /// first row's fourth word.
    pub fn triangle_rows(&self, geometry: &Geometry) -> Vec<[u32; 4]> {
        let row = |v: Vec3, w: u32| [v.x.to_bits(), v.y.to_bits(), v.z.to_bits(), w];
        let rows: Vec<_> = self
            .narrow_order
            .iter()
            .flat_map(|&id| geometry.corners(id).map(|v| row(v, id)))
            .collect();
        if rows.is_empty() {
            vec![[0; 4]; 3]
        } else {
            rows
        }
    }

    /// The eight-way hierarchy as `obvhs` makes it of the casters, and each of its primitives' triangle id: to time `obvhs` by
    /// itself. None if nothing casts.
    pub fn obvhs_alone(geometry: &Geometry) -> Option<(CwBvh, Vec<u32>)> {
        let ids: Vec<u32> = geometry.casters().collect();
        let boxes = boxes_of(geometry, &ids);
        let (narrow, _) = (!ids.is_empty()).then(|| build::trees(&boxes))?;
        let tree = build::eight_way(&narrow);
        let order = tree
            .primitive_indices
            .iter()
            .map(|&i| ids[i as usize])
            .collect();
        Some((tree, order))
    }
}

/// Returns whether a point lies outside a half space (its inner normal and distance), whatever rounding (eight units in the
/// last place) does to it and to the hit of a triangle that has it as a corner (`ray_triangle.rs`).
fn is_outside(half_space: (Vec3, f32), p: Vec3) -> bool {
    let (n, distance) = half_space;
    n.dot(p) < distance - 8.0 * f32::EPSILON * (n.abs().dot(p.abs()) + distance.abs())
}

#[cfg(test)]
mod order_tests;

/// Returns the boxes of triangles, as large as the triangle test needs them (`ray_triangle.rs`).
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
mod tests;
