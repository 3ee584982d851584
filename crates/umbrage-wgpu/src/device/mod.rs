//! The graphics device: adapter choice, capabilities, rounding, errors, and readback.

pub(crate) mod adapter;
pub(crate) mod convert;
pub(crate) mod device_errors;
pub(crate) mod error_scopes;
pub(crate) mod later_errors;
pub(crate) mod probe;
pub(crate) mod probe_fusing;
pub(crate) mod probe_image;
pub(crate) mod probe_offset;
pub(crate) mod readback;
pub(crate) mod requirements;
pub(crate) mod results;
pub(crate) mod timestamp_queries;
