//! Lookups of many receivers at once on the CPU, in vector lanes.

pub(crate) mod batch;
pub(crate) mod plane;
pub(crate) mod square;
