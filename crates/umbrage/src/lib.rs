//! Shadows for wgpu programs, measured.
//!
//! This crate re-exports the others: one dependency, with three ways to choose a backend.
//!
//! * by name or at run time: [`backend`] with a [`BackendChoice`], as `Box<dyn Backend>`;
//! * by type: `umbrage::cpu::Cpu` or `umbrage::gpu::Gpu`, both [`Backend`]s, in functions generic
//!   over it;
//! * at compile time: the features `cpu` and `wgpu`, both on by default.
//!
//! Four more are on by default: `presets` (settings as TOML, `serde` for data types), `rays`
//! (`traced` and `soft`), `parallel` (threads) and `simd` (vector instructions). A wgpu renderer
//! can use `default-features = false, features = ["wgpu"]`. It then builds no threads, hierarchies
//! or parsers, and CPU preparation runs on one thread.
//!
//! Three features are off by default. `scenes` adds `umbrage::scenes`: the built-in scenes, and
//! loaders for scene files and OBJ models. `gltf` adds glTF models. `plan` adds `umbrage::auto`,
//! which measures to find the cheapest technique that a scene needs.
//!
//! Programs with their own device and encoder use `umbrage::gpu::ShadowRenderer`.
#![cfg_attr(all(feature = "cpu", feature = "scenes"), doc = "```")]
#![cfg_attr(not(all(feature = "cpu", feature = "scenes")), doc = "```ignore")]
//! use umbrage::{BackendChoice, Geometry, ShadowTechnique, View};
//! use umbrage::techniques::{MapFilter as _, Pcf, ShadowMap};
//!
//! let scene = umbrage::scenes::by_argument("cubes")?;
//! let geometry = Geometry::bake(&scene)?;
//! let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
//! let recipe = Pcf { radius: 1 }.on(ShadowMap::default()).recipe(&view)?;
//! let shadows = umbrage::backend(BackendChoice::Cpu)?.render(&view, &recipe)?;
//! assert!(shadows.mask.iter().any(|&lit| lit < 1.0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`ShadowMap::sized_for`](techniques::ShadowMap::sized_for) chooses a map size that matches the
//! screen resolution on receivers that face the light:
#![cfg_attr(all(feature = "cpu", feature = "scenes"), doc = "```")]
#![cfg_attr(not(all(feature = "cpu", feature = "scenes")), doc = "```ignore")]
//! use umbrage::{Geometry, View, cpu::Cpu, techniques::{MapFilter as _, Pcf, ShadowMap}};
//!
//! let scene = umbrage::scenes::by_argument("cubes")?;
//! let (camera, geometry) = (&scene.cameras[0], Geometry::bake(&scene)?);
//! let view = View::new(camera, &scene.lights[0], &geometry);
//! // For nine in ten of the pixels that face the light, no texel is larger than a pixel.
//! let map = ShadowMap::default()
//!     .sized_for(&view, &Cpu::new().receivers(camera, &geometry)?, 0.9)?;
//! let technique = Pcf::default().on(map);
//! # let small = camera.with_size(camera.size / 2);
//! # let of_small = View::new(&small, &scene.lights[0], &geometry);
//! # let smaller = map.sized_for(&of_small, &Cpu::new().receivers(&small, &geometry)?, 0.9)?;
//! # assert!(smaller.size < technique.map.size && smaller.size > technique.map.size / 3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#[cfg(feature = "plan")]
mod auto;
mod backend_choice;

#[cfg(feature = "plan")]
pub use auto::{AutoError, Budget, auto, auto_with};
pub use backend_choice::{BackendChoice, backend};
pub use umbrage_core::*;
#[cfg(feature = "plan")]
pub use umbrage_plan::RendererData;
pub use umbrage_techniques as techniques;

#[cfg(feature = "cpu")]
pub use umbrage_cpu as cpu;
#[cfg(feature = "plan")]
pub use umbrage_plan as plan;
#[cfg(feature = "scenes")]
pub use umbrage_scenes as scenes;
#[cfg(feature = "wgpu")]
pub use umbrage_wgpu as gpu;
/// The former name of [`gpu`].
#[cfg(feature = "wgpu")]
#[deprecated(since = "0.1.0", note = "renamed to `umbrage::gpu`")]
pub mod wgpu {
    pub use umbrage_wgpu::*;
}
