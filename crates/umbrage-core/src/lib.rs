//! Core types of umbrage, a shadow library: scenes, light-space math, recipes, kernels, and the
//! traits of techniques and backends. This crate accesses no GPU and no files.
//!
//! Every shadow algorithm **casts** geometry into images, **filters** images, and **receives**: it
//! computes the light that reaches each visible point. A [`ShadowTechnique`] turns a [`View`] into
//! a [`Recipe`] that describes these steps as plain data. A [`Backend`] executes recipes and
//! depends on no particular technique.

mod backend;
mod fusing;
pub mod gbuffer;
pub mod geometry;
pub mod invalid;
pub mod light_space;
pub mod math;
pub mod metrics;
#[doc(hidden)]
pub mod parallel;
pub mod picture;
pub mod recipe;
mod recipe_error;
pub mod scene;
mod simd;
mod snapping;
mod technique;
mod view;

pub use backend::{Backend, BackendError, Shadows, Timings};
pub use encase;
pub use fusing::Fusing;
pub use gbuffer::{
    points::PointReceivers,
    receivers::{NO_TRIANGLE, Receivers, Span},
    resolve,
};
#[cfg(feature = "rays")]
pub use geometry::bvh::Bvh;
pub use geometry::{
    Geometry, NO_MATERIAL, TRIANGLES_A_RUN,
    aabb::Aabb,
    bvh,
    cut_out::{self, CutOuts},
    displacement, hashed_alpha,
    subdivide::MAX_SUBDIVIDED_TRIANGLES,
    weld::WeldedVertices,
};
pub use glam;
pub use invalid::Invalid;
#[cfg(feature = "testing")]
pub use light_space::fit::relevant_casters;
pub use light_space::{
    Extents, LightSpace,
    cascades::{Cascades, MAX_CASCADES, SliceEnds, Split},
    caster_set::CasterSet,
    depth_range,
    fit::{Fit, FitMemory},
    footprint,
    layers::{Arrangement, CascadePick, LayerPicker, Layout, LightSpaces},
};
pub use math::MATH;
pub use recipe::device_hierarchy::DeviceHierarchy;
#[cfg(feature = "testing")]
pub use recipe::twin::{Twin, Words};
pub use recipe::{
    BackendLimits, Cast, CastMode, Cull, Faces, Filter, ImageId, RasterBias, Receive, Recipe,
    Shade, Source, Table, TableId,
    image::{Format, Image, ImageDesc, ImageView},
    kernel::{FilterKernel, Inputs, Kernel, ReceiveKernel, ShadeKernel},
    shader::{Module, UniformBlock, UniformLayout, Uniforms, join},
    table_rows::TableRows,
};
pub use recipe_error::RecipeError;
pub use scene::{
    Instance, MAX_NAME_BYTES, Mesh, Scene,
    anchor::Anchor,
    camera::{Camera, CameraRays, MAX_SIDE},
    light::Light,
    light_marker::LightMarker,
    light_sample,
    material::{
        AlphaCutout, AlphaFilter, Displacement, MAX_SHININESS_LOG2, MAX_SUBDIVISIONS, Material,
        Texels, Texture,
    },
};
pub use simd::{Simd, SimdTask};
pub use snapping::{DepthPlanes, OffsetUnit, Snapping};
pub use technique::ShadowTechnique;
pub use view::View;
