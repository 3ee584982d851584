//! Shadows for wgpu programs, measured.
//!
//! This crate only gathers the others: one dependency, three ways to choose a backend.
//!
//! * by name or at run time: [`backend`] with a [`BackendChoice`], as `Box<dyn Backend>`;
//! * by type: `umbrage::cpu::Cpu` or `umbrage::wgpu::Gpu`, both [`Backend`]s, in functions generic
//!   over it;
//! * at compile time: the features `cpu` and `wgpu`, both on by default.
//!
//! Four more are on by default: `presets` (settings as TOML, and `serde` for what holds data),
//! `rays` (`traced` and `soft`), `parallel` (threads) and `simd` (vector instructions). A renderer
//! on wgpu may name `default-features = false, features = ["wgpu"]`: it then builds no threads, no
//! hierarchies and no parsers, and what the CPU prepares takes one thread.
//!
//! Three features are off by default. With `scenes`, `umbrage::scenes` loads scene files and OBJ
//! models (with `gltf` glTF, too) and has the built-in scenes. With `plan`, `umbrage::auto` finds
//! the least technique that a scene needs, by measurement.
//!
//! Programs with a device and an encoder of their own use `umbrage::wgpu::ShadowRenderer`.
#![cfg_attr(all(feature = "cpu", feature = "scenes"), doc = "```")]
#![cfg_attr(not(all(feature = "cpu", feature = "scenes")), doc = "```ignore")]
//! use umbrage::{BackendChoice, Geometry, ShadowTechnique, View, techniques::{MapFilter as _, Pcf,
//! ShadowMap}};
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
//! How large should a map be? As fine as the screen is where what it shows faces the light:
#![cfg_attr(all(feature = "cpu", feature = "scenes"), doc = "```")]
#![cfg_attr(not(all(feature = "cpu", feature = "scenes")), doc = "```ignore")]
//! use umbrage::{Geometry, View, cpu::Cpu, techniques::{MapFilter as _, Pcf, ShadowMap}};
//!
//! let scene = umbrage::scenes::by_argument("cubes")?;
//! let (camera, geometry) = (&scene.cameras[0], Geometry::bake(&scene)?);
//! let view = View::new(camera, &scene.lights[0], &geometry);
//! // For nine in ten of the pixels that face the light, no texel is larger than a pixel.
//! let map = ShadowMap::default().sized_for(&view, &Cpu::new().receivers(camera, &geometry)?,
//! 0.9)?; let technique = Pcf::default().on(map);
//! # let small = camera.resized(camera.size / 2);
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
pub use umbrage_wgpu as wgpu;
