//! The vocabulary of umbrage, a shadow library: scenes, light-space math, recipes, kernels, and the two traits that
//! techniques and backends implement. No GPU and no file access here.
//!
//! Every shadow algorithm **casts** geometry into images, **filters** images, and **receives**: asks, for a visible
//! point, how much light arrives. A [`ShadowTechnique`] turns a [`View`] into a [`Recipe`] that says so as plain data; a
//! [`Backend`] plays recipes and knows no technique by name.

mod aabb;
mod backend;
mod blocks;
pub mod bvh;
mod camera;
mod caster_set;
pub mod depth_range;
pub mod displacement;
mod fit;
pub mod footprint;
mod geometry;
mod hit;
mod image;
pub mod invalid;
mod kernel;
mod layout;
mod light;
mod light_marker;
pub mod light_sample;
pub mod light_space;
mod material;
pub mod math;
pub mod metrics;
pub mod picture;
mod plan_error;
mod receivers;
mod recipe;
mod relief;
pub mod resolve;
mod scene;
mod shader;
mod simd;
mod slab;
mod snapping;
mod subdivide;
mod technique;
mod twin;
mod view;
mod weld;
mod work;

pub use aabb::Aabb;
pub use backend::{Backend, BackendError, Shadows, Timings};
pub use bvh::Bvh;
pub use camera::{Camera, CameraRays, MAX_SIDE};
pub use caster_set::CasterSet;
pub use encase;
pub use fit::{Fit, FitMemory, relevant_casters};
pub use geometry::{Geometry, NO_MATERIAL};
pub use glam;
pub use image::{Format, Image, ImageDesc, ImageView};
pub use invalid::Invalid;
pub use kernel::{FilterKernel, Inputs, Kernel, ReceiveKernel, ShadeKernel};
pub use layout::{Layout, LightSpaces};
pub use light::Light;
pub use light_marker::LightMarker;
pub use light_space::{Extents, LightSpace};
pub use material::{Displacement, MAX_SHININESS_LOG2, MAX_SUBDIVISIONS, Material, Texture};
pub use math::MATH;
pub use plan_error::PlanError;
pub use receivers::{NO_TRIANGLE, Receivers, Span};
pub use recipe::{
    Cast, CastMode, Cull, Faces, Filter, ImageId, Limits, RasterBias, Receive, Recipe, Shade,
    Source, Table, TableId,
};
pub use scene::{Instance, MOST_NAME, Mesh, Scene};
pub use shader::{Module, UniformBlock, UniformLayout, Uniforms, join};
pub use simd::{Simd, SimdTask};
pub use snapping::{DepthPlanes, Snapping};
pub use subdivide::MAX_SUBDIVIDED_TRIANGLES;
pub use technique::ShadowTechnique;
pub use twin::{Twin, Words};
pub use view::View;
pub use weld::Places;
pub use work::{Asks, Work};
