//! Construction of the hierarchies, whose topology is computed by `obvhs`.

use crate::geometry::aabb::Aabb;
use glam::Vec3A;
use obvhs::{
    BvhBuildParams, aabb,
    bvh2::{Bvh2, reinsertion::ReinsertionOptimizer},
    cwbvh::{CwBvh, bvh2_to_cwbvh::bvh2_to_cwbvh},
    ploc::PlocBuilder,
};

/// Builds a two-way tree over at least one box, and the eight-way tree derived from it.
pub(super) fn trees(boxes: &[Aabb]) -> (Bvh2, CwBvh) {
    let p = BvhBuildParams::medium_build();
    let scaled = in_unit_cube(boxes);
    let indices = (0..boxes.len() as u32).collect();
    let mut builder = PlocBuilder::with_capacity(boxes.len());
    let mut narrow = builder.build(
        p.ploc_search_distance,
        &scaled,
        indices,
        p.sort_precision,
        p.search_depth_threshold,
    );
    ReinsertionOptimizer::default().run(&mut narrow, p.reinsertion_batch_ratio, None);
    let wide = eight_way(&narrow);
    refit(&mut narrow, boxes);
    (narrow, wide)
}

/// Converts a two-way tree to an eight-way tree with leaves of up to three triangles.
pub(super) fn eight_way(narrow: &Bvh2) -> CwBvh {
    bvh2_to_cwbvh(narrow, 3, true, false)
}

/// Scales the boxes by a power of two, so that the builder's products neither overflow nor vanish.
fn in_unit_cube(boxes: &[Aabb]) -> Vec<aabb::Aabb> {
    let all = boxes.iter().fold(Aabb::EMPTY, |all, b| all.union(b));
    let reach = all.min.abs().max(all.max.abs()).max_element();
    // The exponent bits alone are a power of two.
    let power =
        f32::from_bits(reach.to_bits() & 0x7f80_0000).clamp(f32::MIN_POSITIVE, 1.701_411_8e38);
    let scaled =
        |v: glam::Vec3| Vec3A::from(v / power).clamp(Vec3A::splat(-4.0), Vec3A::splat(4.0));
    boxes
        .iter()
        .map(|b| aabb::Aabb {
            min: scaled(b.min),
            max: scaled(b.max),
        })
        .collect()
}

/// Sets the box of every node to the exact union of its triangles' boxes.
fn refit(tree: &mut Bvh2, boxes: &[Aabb]) {
    let mut order = vec![0];
    let mut next = 0;
    while let Some(&i) = order.get(next) {
        let node = &tree.nodes[i];
        if node.prim_count == 0 {
            let first = node.first_index as usize;
            order.extend([first, first + 1]);
        }
        next += 1;
    }
    for &i in order.iter().rev() {
        let node = tree.nodes[i];
        let first = node.first_index as usize;
        let around = if node.prim_count == 0 {
            tree.nodes[first].aabb().union(tree.nodes[first + 1].aabb())
        } else {
            let triangles = &tree.primitive_indices[first..first + node.prim_count as usize];
            let all = triangles
                .iter()
                .fold(Aabb::EMPTY, |all, &t| all.union(&boxes[t as usize]));
            aabb::Aabb {
                min: all.min.into(),
                max: all.max.into(),
            }
        };
        tree.nodes[i].aabb = around;
    }
}
