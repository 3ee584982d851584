//! Filters: positions, weights and compared depths of samples, and the filter width that a light's
//! extent requires.

pub mod bilinear_weights;
pub(crate) mod comparison_sampler;
pub(crate) mod depth_in_reach;
pub(crate) mod horizon;
pub(crate) mod least_depth;
pub(crate) mod light_extent;
pub(crate) mod moments;
pub(crate) mod pattern_taps;
pub mod sample_pattern;
