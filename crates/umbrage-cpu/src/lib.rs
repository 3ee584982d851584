//! CPU backend for umbrage's shadow recipes: the reference backend, available on every machine.
//!
//! It rasterises by rules that were measured on Mesa's software rasterisers (clipping, 8-bit
//! sub-pixels, top-left rule, depth plane, polygon offset). A wgpu backend on those produces the
//! same bits. Results don't depend on the number of threads or on the instructions used.
//!
//! ```
//! # use umbrage_core::{Backend, Camera, Geometry, Mesh, Scene, Instance, glam::*};
//! # let mesh = Mesh::new("floor", vec![Vec3::ZERO, Vec3::X, Vec3::Z], vec![[0, 2, 1]])?;
//! # let instances = vec![Instance::new(0, Affine3A::IDENTITY)];
//! # let scene = Scene { meshes: vec![mesh], instances, ..Default::default() };
//! let geometry = Geometry::bake(&scene)?;
//! let (eye, size) = (Vec3::splat(2.0), UVec2::new(32, 24));
//! let camera = Camera::perspective(eye, Vec3::ZERO, Vec3::Y, 0.8, [0.1, 10.0], size)?;
//! let mut cpu = umbrage_cpu::Cpu::new();
//! let receivers = cpu.receivers(&camera, &geometry)?;
//! assert_eq!(receivers.len(), 32 * 24);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod backend;
mod cast;
mod filter;
mod gbuffer;
mod images;
mod lookup_times;
mod options;
mod raster;
mod receive;
#[cfg(feature = "testing")]
mod replay;
mod shade;
mod sparse;

pub use backend::Cpu;
pub use options::CpuOptions;
pub use raster::{Clipping, PlaneShift, VertexSums};
