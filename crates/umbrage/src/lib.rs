//! Shadows for wgpu programs, measured.
//!
//! **In a renderer**, start with `umbrage::gpu::LightSet`. It keeps casters and lights from frame
//! to frame, draws only what changed, and provides one WGSL function,
//! `shadow(light, position, normal, pixel)`, or masks for a G-buffer.
//! `umbrage::gpu::ShadowRenderer` computes the mask of one light. Both work on the device and in
//! the encoder of the caller. The guide is
//! [`docs/add_shadows.md`](https://github.com/umbrage-rs/umbrage/blob/main/docs/add_shadows.md).
//!
//! **Without a renderer**, [`backend`] opens a [`Backend`] at run time. `umbrage::cpu::Cpu` and
//! `umbrage::gpu::Gpu` are backends by type.
//!
//! [`techniques`] has the shadow techniques, each a plain struct with its settings.
//!
//! # Features
//!
//! | feature | what it adds | what it builds |
//! |---|---|---|
//! | `wgpu` (default) | `umbrage::gpu` | wgpu |
//! | `cpu` | `umbrage::cpu`: the CPU backend | rayon, pulp |
//! | `parallel` | threads, where the CPU prepares much | rayon |
//! | `simd` | vector instructions | pulp |
//! | `presets` | settings as TOML | serde, toml |
//! | `rays` | the techniques `traced` and `soft` | obvhs, rdst |
//! | `scenes` | `umbrage::scenes`: built-in scenes, scene files, OBJ models | image, tobj, rstar, toml, serde, rayon, obvhs |
//! | `gltf` | glTF models | gltf, zune-jpeg |
//! | `plan` | `umbrage::auto`: finds the cheapest technique for a scene | rayon, pulp, obvhs, serde, toml |
//!
//! # A mask without a device
//!
#![cfg_attr(all(feature = "cpu", feature = "scenes"), doc = "```")]
#![cfg_attr(not(all(feature = "cpu", feature = "scenes")), doc = "```ignore")]
//! use umbrage::{BackendChoice, Geometry, ShadowTechnique, View};
//! use umbrage::techniques::{MapFilter as _, Pcf, ShadowMap};
//!
//! let scene = umbrage::scenes::by_argument("cubes")?;
//! let geometry = Geometry::bake(&scene)?;
//! let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
//! let recipe = Pcf::new(1).on(ShadowMap::default()).recipe(&view)?;
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
#[doc(hidden)]
#[cfg(feature = "wgpu")]
#[deprecated(since = "0.1.0", note = "renamed to `umbrage::gpu`")]
pub mod wgpu {
    pub use umbrage_wgpu::*;
}
