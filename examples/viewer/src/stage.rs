//! The scene that is shown.

use anyhow::Result;
use umbrage::{Aabb, Camera, Geometry, Light, Material, Texture, scenes};

/// A scene with its triangles placed.
pub(crate) struct Stage {
    /// How it was asked for: a built-in scene's name, or a file.
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
        let scene = scenes::by_argument(argument)?;
        let geometry = Geometry::bake(&scene)?;
        let bounds = geometry.bounds();
        let camera = scene.cameras.first().copied();
        anyhow::ensure!(
            !geometry.triangles().is_empty(),
            "`{argument}` has no triangles; there is nothing to see"
        );
        Ok(Self {
            argument: argument.to_owned(),
            name: scene.name,
            geometry,
            camera: match camera {
                Some(camera) => camera,
                None => anyhow::bail!("`{argument}` has no camera"),
            },
            materials: scene.materials,
            textures: scene.textures,
            lights: scene.lights,
            bounds,
        })
    }
}
