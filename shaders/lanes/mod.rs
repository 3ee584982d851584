//! Lookups of many receivers at once on the CPU, in vector lanes.

pub mod batch;
pub(crate) mod square;
