//! Ray queries against the casters. `obvhs` finds the hierarchies' shape; the tests of boxes and
//! triangles are ours, because truth needs answers that have no cracks and don't depend on the
//! order of the search (`ray_triangle.rs` says why they don't), and because they have twins on the
//! GPU.

#[cfg(feature = "rays")]
mod build;
#[cfg(feature = "rays")]
mod tree;
#[cfg(feature = "rays")]
mod wide;

#[cfg(feature = "rays")]
pub use tree::Bvh;

#[cfg(feature = "rays")]
pub use crate::geometry::shaft::{SHAFT, SHAFT_LANES, Shaft, ShaftSearch, Shafts};

#[cfg(feature = "testing")]
pub use crate::geometry::ray_triangle::TWINS;
pub use crate::geometry::{
    aabb::Aabb,
    ray_box::RAY_BOX,
    ray_triangle::{RAY_TRIANGLE, Segment, segment_hits},
    segment_lanes::{FourSegments, SEGMENT_LANES, SegmentArrays, longest_axis},
};
