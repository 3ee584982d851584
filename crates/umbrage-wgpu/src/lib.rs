//! Plays umbrage's recipes on wgpu.
//!
//! * [`ShadowRenderer`] is middleware: the caller's device, the caller's encoder, no submission.
//! * [`Gpu`] is a [`Backend`](umbrage_core::Backend) with a device of its own: upload, render, read back, time.
//!
//! Recipes whose casts count ([`CastMode::Count`](umbrage_core::CastMode::Count)) need a device with the feature
//! `DEPTH32FLOAT_STENCIL8`; [`Gpu`] asks for it where the adapter has it, and for `TIMESTAMP_QUERY`, without which
//! there are no timings. All else is in every WebGPU device that can draw into images of 32-bit floats ([`check_adapter`]).
//!
//! wgpu is re-exported, so that callers can name the version used here.

mod bindings;
mod casts;
mod counters;
mod counts;
mod draws;
mod faces;
mod filters;
mod frame;
mod from_depth;
mod gpu;
mod images;
mod kernels;
mod lookup;
mod matrices;
mod pipelines;
mod prefix;
mod probe;
mod renderer;
mod resources;
mod scopes;
mod shading;
mod stamps;
mod submissions;
mod tables;
mod targets;
mod wgsl;

pub use counters::Counters;
pub use frame::{Drawable, Frame, GBuffer, Indices, VertexLayout};
pub use from_depth::{DepthBuffer, GBufferFromDepth};
pub use gpu::{AdapterChoice, Gpu, Software, check_adapter};
pub use images::texture_format;
pub use probe::probe_snapping;
pub use renderer::{Options, ShadowRenderer};
pub use stamps::Stamps;
pub use targets::CastTarget;
pub use wgpu;
pub use wgsl::receive_wgsl;
