//! Executes umbrage's recipes on wgpu.
//!
//! * [`ShadowRenderer`] is middleware: the caller's device, the caller's encoder, no submission.
//! * [`Gpu`] is a [`Backend`](umbrage_core::Backend) with its own device: upload, render, read
//!   back, time.
//!
//! Recipes with [`CastMode::StencilDepthFail`](umbrage_core::CastMode::StencilDepthFail) need a
//! device with the feature `DEPTH32FLOAT_STENCIL8`. [`Gpu`] requests it if the adapter has it. It
//! also requests `TIMESTAMP_QUERY`, without which there are no timings. Everything else works on
//! every WebGPU device that can draw into 32-bit float images ([`check_adapter`]).
//!
//! wgpu is re-exported, so that callers can use the same version.

mod backend;
mod cast;
mod device;
#[cfg(feature = "testing")]
mod driver_model;
#[cfg(feature = "testing")]
mod drivers;
mod filter;
mod frame;
mod gbuffer;
mod gbuffer_from_depth;
mod hierarchy;
mod light_set;
mod receive;
mod renderer;
#[cfg(feature = "testing")]
mod replay;
mod resources;
mod targets;
mod wgsl;

pub use backend::Gpu;
pub use device::{
    adapter::{AdapterChoice, Software},
    later_errors::ApiErrors,
    probe::probe_snapping,
    probe_fusing::probe_fusing,
    requirements::check_adapter,
};
#[cfg(feature = "testing")]
pub use driver_model::{ShaderRewriter, rewrite_shaders};
#[cfg(feature = "testing")]
pub use drivers::{
    PINNED_DRIVER, PINNED_DRIVER_VARIABLE, SHORT_LOOPS, STEADY_FIRST_WORD, SUM_ORDER, Workaround,
};
pub use frame::{
    Drawable, FrameInputs, GBuffer, Indices, PositionFormat, RendererOptions, VertexLayout,
};
pub use gbuffer_from_depth::{DepthBuffer, GBufferFromDepth};
pub use light_set::{
    CasterId, CasterMesh, FrameGeometry, LightId, LightSet, LightSetOptions, MaskFormat,
    MaskInputs, MaskReceivers, MeshId, NormalCoding, OwnCasterId, PassCasters, SetBudget, SetFrame,
    SetNormals, SetPass, SetReport, SetText, SetTimestamps, ShadowedLight, StillLayers, TimedPass,
    Unserved,
};
#[allow(deprecated, reason = "former names stay for one release")]
pub use light_set::{SetLight, SetReceivers};
pub use renderer::ShadowRenderer;
#[cfg(feature = "testing")]
pub use resources::counters::Counters;
pub use resources::{
    cut_out_buffers::CutOutBuffers, images::texture_format, timestamps::PassTimestamps,
};
pub use targets::{CastTarget, CastTargetKey};
pub use wgpu;
pub use wgsl::kernel::receive_wgsl;
#[cfg(feature = "testing")]
pub use wgsl::stages::placing_shaders;
