//! The scene that is shown.

use anyhow::Result;
use umbrage::{Aabb, Camera, Geometry, Light, Material, Scene, Texture, scenes};

/// A scene with its triangles placed.
pub(crate) struct Stage {
    /// How it was asked for: a built-in scene's name, or a file. Empty for what was read from memory, which can't be asked for again.
    pub argument: String,
    pub name: String,
    pub geometry: Geometry,
    pub materials: Vec<Material>,
    pub textures: Vec<Texture>,
    pub lights: Vec<Light>,
    pub camera: Camera,
    /// Around all triangles.
    pub bounds: Aabb,
}

impl Stage {
    /// Loads a built-in scene, a scene file or a model.
    ///
    /// # Errors
    /// Errors if there is no such scene, or the file can't be read.
    pub(crate) fn load(argument: &str) -> Result<Self> {
        Self::of_scene(argument, argument, scenes::by_argument(argument)?)
    }

    /// Reads a scene file or a model that is in memory.
    ///
    /// # Errors
    /// Errors if it can't be read.
    #[cfg(target_arch = "wasm32")]
    pub(crate) fn read(name: &str, bytes: &[u8]) -> Result<Self> {
        Self::of_scene("", name, scenes::read(name, bytes)?)
    }

    fn of_scene(argument: &str, name: &str, scene: Scene) -> Result<Self> {
        let geometry = Geometry::bake(&scene)?;
        let bounds = geometry.bounds();
        let camera = scene.cameras.first().copied();
        anyhow::ensure!(
            !geometry.triangles().is_empty(),
            "`{name}` has no triangles; there is nothing to see"
        );
        Ok(Self {
            argument: argument.to_owned(),
            name: scene.name,
            geometry,
            camera: match camera {
                Some(camera) => camera,
                None => anyhow::bail!("`{name}` has no camera"),
            },
            materials: scene.materials,
            textures: scene.textures,
            lights: scene.lights,
            bounds,
        })
    }
}
