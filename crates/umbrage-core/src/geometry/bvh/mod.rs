//! Ray queries against the casters. `obvhs` computes the topology of the hierarchies. The box and
//! triangle tests are part of umbrage: truth requires results without cracks that don't depend on
//! the order of the search (see `ray_triangle.rs`). The tests also need GPU twins.

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
