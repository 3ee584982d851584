//! Eight-way hierarchy with uncompressed boxes. `obvhs` computes its topology (Ylitie et al. 2017,
//! "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs"); the boxes and the
//! search are part of umbrage.
//!
//! `obvhs` stores boxes as bytes relative to their parent's. Its box test also rounds differently
//! from the triangle test, so it may skip a triangle that is hit. Here boxes are tested as in
//! `ray_box.rs`, four at once.

use crate::geometry::{
    aabb::Aabb,
    ray_box::EXIT_SLACK,
    ray_triangle::Segment,
    shaft::{Shaft, ShaftLanes, ShaftSearch},
};
use glam::{Vec3, Vec4};
use obvhs::cwbvh::CwBvh;

/// The eight children of a node: their boxes, and their nodes or triangles.
#[derive(Clone, Copy, Debug)]
struct Node {
    /// Six planes of the children's boxes: least x, y, z, then greatest x, y, z. Each is an array
    /// of two: those of children 0 to 3, and those of children 4 to 7.
    planes: [[Vec4; 2]; 6],
    /// For an inner child its node index, for a leaf its first triangle.
    first: [u32; 8],
    /// Number of a leaf's triangles; 0 for inner children and unused slots.
    count: [u8; 8],
    /// Bit i is set if child i is an inner node.
    inner: u32,
}

impl Node {
    const EMPTY: Self = Self {
        planes: [[Vec4::ZERO; 2]; 6],
        first: [0; 8],
        count: [0; 8],
        inner: 0,
    };

    fn set_box(&mut self, child: usize, bounds: &Aabb) {
        let half = child / 4;
        let lane = child % 4;
        for axis in 0..3 {
            self.planes[axis][half][lane] = bounds.min[axis];
            self.planes[axis + 3][half][lane] = bounds.max[axis];
        }
    }
}

/// The hierarchy.
#[derive(Clone, Debug, Default)]
pub(super) struct Wide {
    /// Children come after their parents.
    nodes: Vec<Node>,
    /// Number of nodes from the root to the deepest leaf.
    pub(super) depth: usize,
}

/// Greatest depth of a hierarchy whose traversal stack is a fixed array rather than on the heap.
pub(super) const SHALLOW: usize = 24;

/// Children still to be visited: their parent's index, and a bit for each in the order of visits.
type NodeGroup = (u32, u32);

impl Wide {
    /// Builds a hierarchy with a tree's topology. `boxes` are those of its triangles, in leaf
    /// order.
    pub(super) fn new(tree: &CwBvh, boxes: &[Aabb]) -> Self {
        let mut nodes = vec![Node::EMPTY; tree.nodes.len()];
        // The box around each node, and the number of nodes from it to its deepest leaf.
        let mut node_boxes = vec![Aabb::EMPTY; nodes.len()];
        let mut depths = vec![1; nodes.len()];
        // Iterate from the last node to the first, as children come after their parents.
        for (i, node) in tree.nodes.iter().enumerate().rev() {
            nodes[i].inner = u32::from(node.imask);
            for child in 0..8 {
                if node.is_child_empty(child) {
                    continue;
                }
                let child_box = if node.is_leaf(child) {
                    let (first, count) = node.child_primitives(child);
                    nodes[i].first[child] = first;
                    nodes[i].count[child] = count as u8;
                    let triangles = &boxes[first as usize..(first + count) as usize];
                    triangles.iter().fold(Aabb::EMPTY, |all, b| all.union(b))
                } else {
                    let inner = node.child_node_index(child);
                    nodes[i].first[child] = inner;
                    depths[i] = depths[i].max(depths[inner as usize] + 1);
                    node_boxes[inner as usize]
                };
                nodes[i].set_box(child, &child_box);
                node_boxes[i] = node_boxes[i].union(&child_box);
            }
        }
        let depth = depths.first().copied().unwrap_or(0);
        Self { nodes, depth }
    }

    /// Calls `visit` with the triangles of leaves whose boxes the segment enters, roughly front to
    /// back, until it returns true. `visit` may lower its second argument, the fraction of the
    /// segment at which the search ends, initially 1.
    #[inline(always)]
    pub(super) fn search(&self, segment: &Segment, visit: impl FnMut(usize, &mut f32) -> bool) {
        if self.nodes.is_empty() {
            return;
        }
        if self.depth <= SHALLOW {
            self.search_with(&mut [(0, 0); SHALLOW], segment, visit);
        } else {
            self.search_with(&mut vec![(0, 0); self.depth], segment, visit);
        }
    }

    /// Passes on the casters in boxes that a shaft enters, roughly front to back, until the search
    /// has enough. `caster` returns a triangle's id and corners.
    #[inline(always)]
    pub(super) fn search_shaft(
        &self,
        shaft: &Shaft,
        caster: impl Fn(usize) -> (u32, [Vec3; 3]),
        search: &mut impl ShaftSearch,
    ) {
        // Each node on the path leaves seven siblings.
        const MOST_WAITING: usize = 7 * SHALLOW + 1;
        if self.nodes.is_empty() {
            return;
        }
        if self.depth <= SHALLOW {
            self.search_shaft_with(&mut [0; MOST_WAITING], shaft, caster, search);
        } else {
            self.search_shaft_with(&mut vec![0; 7 * self.depth + 1], shaft, caster, search);
        }
    }

    #[inline(always)]
    fn search_shaft_with(
        &self,
        stack: &mut [u32],
        shaft: &Shaft,
        caster: impl Fn(usize) -> (u32, [Vec3; 3]),
        search: &mut impl ShaftSearch,
    ) {
        let lanes = ShaftLanes::new(shaft);
        let octant = lanes.octant();
        stack[0] = 0;
        let mut waiting = 1;
        while waiting > 0 {
            waiting -= 1;
            let node = &self.nodes[stack[waiting] as usize];
            let mut entered = 0;
            for half in 0..2 {
                let low = [0, 1, 2].map(|axis: usize| node.planes[axis][half]);
                let high = [3, 4, 5].map(|axis: usize| node.planes[axis][half]);
                let mut bits = lanes.entered_lanes(low, high);
                if bits != 0 {
                    bits &= search.keep(bits, low, high);
                }
                entered |= bits << (4 * half);
            }
            let mut leaves = entered & !node.inner;
            while leaves != 0 {
                let child = leaves.trailing_zeros() as usize;
                leaves &= leaves - 1;
                // An unused slot has a count of 0.
                let first = node.first[child] as usize;
                for triangle in first..first + usize::from(node.count[child]) {
                    let (id, corners) = caster(triangle);
                    if search.visit(id, corners) {
                        return;
                    }
                }
            }
            // Child slots are ordered by octants; push the nearest one last.
            let mut inner = turn_slots(entered & node.inner, octant);
            while inner != 0 {
                let place = inner.trailing_zeros();
                inner &= inner - 1;
                stack[waiting] = node.first[(place ^ octant) as usize];
                waiting += 1;
            }
        }
    }

    #[inline(always)]
    fn search_with(
        &self,
        stack: &mut [NodeGroup],
        segment: &Segment,
        mut visit: impl FnMut(usize, &mut f32) -> bool,
    ) {
        let lanes = RayLanes::new(segment);
        let mut limit = 1.0;
        // Number of groups on the stack.
        let mut waiting = 0;
        // The group being visited, and its node.
        let mut parent = 0;
        let mut group = 0;
        let mut current = 0;
        loop {
            let node = &self.nodes[current as usize];
            let entered = lanes.entered_children(node, limit);
            let mut leaves = entered & !node.inner;
            while leaves != 0 {
                let child = leaves.trailing_zeros() as usize;
                leaves &= leaves - 1;
                let first = node.first[child] as usize;
                for triangle in first..first + usize::from(node.count[child]) {
                    if visit(triangle, &mut limit) {
                        return;
                    }
                }
            }
            let inner = entered & node.inner;
            if inner != 0 {
                if group != 0 {
                    stack[waiting] = (parent, group);
                    waiting += 1;
                }
                parent = current;
                group = turn_slots(inner, lanes.octant);
            } else if group == 0 {
                if waiting == 0 {
                    return;
                }
                waiting -= 1;
                (parent, group) = stack[waiting];
            }
            let next = 31 - group.leading_zeros();
            group &= !(1 << next);
            current = self.nodes[parent as usize].first[(next ^ lanes.octant) as usize];
        }
    }
}

/// A segment, for the slab test of four boxes at once.
struct RayLanes {
    origin: [Vec4; 3],
    inverse: [Vec4; 3],
    /// Indices of the planes at which a segment enters and leaves boxes, along x, y, z.
    near: [usize; 3],
    far: [usize; 3],
    /// Pattern of the slot bits that are far. Children occupy slots by the octants of their
    /// parent's box.
    octant: u32,
}

impl RayLanes {
    #[inline(always)]
    fn new(s: &Segment) -> Self {
        let o = s.origin;
        let inverse = s.inverse;
        let backward = [inverse.x < 0.0, inverse.y < 0.0, inverse.z < 0.0];
        Self {
            origin: [Vec4::splat(o.x), Vec4::splat(o.y), Vec4::splat(o.z)],
            inverse: [
                Vec4::splat(inverse.x),
                Vec4::splat(inverse.y),
                Vec4::splat(inverse.z),
            ],
            near: [0, 1, 2].map(|axis| if backward[axis] { axis + 3 } else { axis }),
            far: [0, 1, 2].map(|axis| if backward[axis] { axis } else { axis + 3 }),
            octant: u32::from(!backward[0]) << 2
                | u32::from(!backward[1]) << 1
                | u32::from(!backward[2]),
        }
    }

    /// Returns a bit for each child whose box is entered. Bit-equal to `enters_box` of
    /// `ray_box.rs`, as the product with the near plane is the lesser one.
    #[inline(always)]
    fn entered_children(&self, node: &Node, limit: f32) -> u32 {
        let mut out = 0;
        for half in 0..2 {
            // Fraction of the segment at which it meets a plane of four boxes.
            let crossing = |axis: usize, plane: usize| {
                (node.planes[plane][half] - self.origin[axis]) * self.inverse[axis]
            };
            let near = [0, 1, 2].map(|axis| crossing(axis, self.near[axis]));
            let far = [0, 1, 2].map(|axis| crossing(axis, self.far[axis]));
            let entry = near[0].max(near[1]).max(near[2].max(Vec4::ZERO));
            let exit = far[0].min(far[1]).min(far[2].min(Vec4::splat(limit)));
            out |= entry.cmple(exit * EXIT_SLACK).bitmask() << (4 * half);
        }
        out
    }
}

/// Moves the bits of slots to the order of visits, the first in the highest position: bit `i` to
/// position `i ^ octant`.
#[inline(always)]
fn turn_slots(slots: u32, octant: u32) -> u32 {
    let mut bits = slots;
    if octant & 1 != 0 {
        bits = (bits & 0x55) << 1 | bits >> 1 & 0x55;
    }
    if octant & 2 != 0 {
        bits = (bits & 0x33) << 2 | bits >> 2 & 0x33;
    }
    if octant & 4 != 0 {
        bits = (bits & 0x0f) << 4 | bits >> 4;
    }
    bits
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{random::Random, ray_box::enters_box};
    use glam::Vec3A;

    /// The test of four boxes at once agrees with the test of one box.
    #[test]
    fn lanes_say_what_the_test_of_one_box_says() {
        let mut random = Random(17);
        let mut entered = 0;
        for i in 0..40_000_u32 {
            let distance = [0.0, 10.0, 1e6][i as usize % 3];
            let mut node = Node::EMPTY;
            let boxes = [0; 8].map(|_| {
                let p = random.vector() + distance;
                let q = random.vector() + distance;
                [p.min(q), p.max(q)]
            });
            for (child, &[min, max]) in boxes.iter().enumerate() {
                node.set_box(child, &Aabb { min, max });
            }
            // Aim along an edge of one of the boxes, or past it by a few roundings.
            let [low, high] = boxes[i as usize % 8];
            let o = low.with_x(high.x) + random.vector();
            let target = low.with_x(high.x).lerp(high, random.signed_unit().abs());
            let d = if i % 4 == 0 {
                Vec3::Y.into()
            } else {
                Vec3A::from(target - o) * 2.0
            };
            let segment = Segment::new(o, d.into());
            let bits = RayLanes::new(&segment).entered_children(&node, 1.0);
            for (child, corners) in boxes.iter().enumerate() {
                let expected =
                    enters_box(segment.origin, segment.inverse, corners.map(Vec3A::from));
                assert_eq!(
                    bits >> child & 1 == 1,
                    expected,
                    "{corners:?} from {o} along {d}"
                );
                entered += u32::from(expected);
            }
        }
        assert!(
            (40_000..300_000).contains(&entered),
            "too few hits to be meaningful: {entered}"
        );
    }
}
