//! The vocabulary of umbrage, a shadow library: scenes, light-space math, recipes, kernels, and the two traits that
//! techniques and backends implement. No GPU and no file access here.
//!
//! Every shadow algorithm **casts** geometry into images, **filters** images, and **receives**: asks, for a visible
//! point, how much light arrives. A [`ShadowTechnique`] turns a [`View`] into a [`Recipe`] that says so as plain data; a
//! [`Backend`] plays recipes and knows no technique by name.

mod aabb;
mod backend;
pub mod bvh;
mod camera;
pub mod depth_range;
mod fit;
mod geometry;
mod hit;
mod image;
pub mod invalid;
mod kernel;
mod light;
pub mod light_sample;
pub mod light_space;
pub mod math;
pub mod metrics;
mod receivers;
mod recipe;
pub mod resolve;
mod scene;
mod shader;
mod simd;
mod technique;
mod twin;

pub use aabb::Aabb;
pub use backend::{Backend, BackendError, Shadows, Timings};
pub use bvh::Bvh;
pub use camera::{Camera, CameraRays, MAX_SIDE};
pub use encase;
pub use fit::Fit;
pub use geometry::Geometry;
pub use glam;
pub use image::{Format, Image, ImageDesc, ImageView};
pub use invalid::Invalid;
pub use kernel::{FilterKernel, Inputs, Kernel, ReceiveKernel};
pub use light::Light;
pub use light_space::{Extents, LightSpace};
pub use math::MATH;
pub use receivers::{NO_TRIANGLE, Receivers, Span};
pub use recipe::{Cast, Cull, Filter, ImageId, Limits, RasterBias, Receive, Recipe, Table, TableId};
pub use scene::{Instance, Mesh, Scene};
pub use shader::{Module, UniformLayout, Uniforms, join};
pub use simd::{Simd, SimdTask};
pub use technique::{PlanError, ShadowTechnique, View};
pub use twin::{Twin, Words};
