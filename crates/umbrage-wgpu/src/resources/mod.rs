//! Cached GPU objects: images, tables, pipelines, bindings.

pub(crate) mod bindings;
pub(crate) mod counters;
pub(crate) mod counts;
pub(crate) mod cut_out_buffers;
pub(crate) mod cut_outs;
pub(crate) mod draws;
pub(crate) mod faces;
pub(crate) mod geometry;
pub(crate) mod images;
pub(crate) mod kernel_stage;
pub(crate) mod late_read;
pub(crate) mod matrices;
pub(crate) mod pipelines;
pub(crate) mod query_pairs;
pub(crate) mod renderer_state;
pub(crate) mod submissions;
pub(crate) mod tables;
pub(crate) mod timestamps;
pub(crate) mod waiting;
pub(crate) mod windows;
