//! Filters: where samples lie, what they weigh and compare, and how wide a light's extent makes
//! them.

pub mod bilinear_weights;
pub(crate) mod comparison_sampler;
pub(crate) mod depth_in_reach;
pub(crate) mod horizon;
pub(crate) mod least_depth;
pub(crate) mod light_extent;
pub(crate) mod moments;
pub(crate) mod pattern_taps;
pub mod sample_pattern;
