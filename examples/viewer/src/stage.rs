//! The scene that is shown.

use crate::loading::GoesOn;
use anyhow::Result;
use serde::{Deserialize, Serialize};
use umbrage::{
    Aabb, Camera, Geometry, Light, Material, Scene, Texture,
    glam::{Affine3A, UVec2, camera::rh::proj::directx},
    scenes,
};

/// A scene with its triangles placed. Workers of a web page hand it over as bytes.
#[derive(Serialize, Deserialize)]
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
    /// Returns a stage without anything on it: what is shown until the first scene has been read.
    pub(crate) fn nothing() -> Self {
        let geometry = Geometry::default();
        Self {
            argument: String::new(),
            name: String::new(),
            bounds: geometry.bounds(),
            geometry,
            materials: Vec::new(),
            textures: Vec::new(),
            lights: Vec::new(),
            camera: Camera {
                world_from_view: Affine3A::IDENTITY,
                clip_from_view: directx::perspective_infinite_reverse(0.8, 1.0, 0.1),
                size: UVec2::ONE,
            },
        }
    }

    /// Whether no scene has been read yet.
    pub(crate) fn is_nothing(&self) -> bool {
        self.geometry.triangles().is_empty()
    }

    /// Makes a built-in scene, or reads a file; none if it was given up.
    ///
    /// # Errors
    /// Errors if it can't be read.
    pub(crate) fn of_argument(argument: &str, goes_on: GoesOn<'_>) -> Result<Option<Self>> {
        goes_on("is read".to_owned());
        // Errors of scenes hold what they come from in their own words: `anyhow` is given the words alone, else it would repeat it.
        let scene = scenes::by_argument(argument).map_err(anyhow::Error::msg)?;
        if !goes_on("its triangles are placed".to_owned()) {
            return Ok(None);
        }
        Self::of_scene(argument, argument, scene).map(Some)
    }

    /// Reads a scene file or a model that is in memory, with what it names.
    ///
    /// # Errors
    /// Errors if it can't be read.
    #[cfg(target_arch = "wasm32")]
    pub(crate) fn read(name: &str, files: &scenes::FilesInMemory) -> Result<Self> {
        let scene = scenes::read(name, files).map_err(anyhow::Error::msg)?;
        Self::of_scene("", name, scene)
    }

    /// Places a scene's triangles.
    ///
    /// # Errors
    /// Errors if they can't be placed, or there is nothing to see.
    pub(crate) fn of_scene(argument: &str, name: &str, scene: Scene) -> Result<Self> {
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
