//! The displayed scene.

use anyhow::{Context as _, Result};
use serde::{Deserialize, Serialize};
use umbrage::{
    Aabb, Camera, Geometry, Light, Material, Scene, Texture,
    glam::{Affine3A, UVec2, Vec3, camera::rh::proj::directx},
    scenes,
};

/// Reports the next step of loading. Returns `false` if loading was cancelled.
pub(crate) type OnStep<'a> = &'a dyn Fn(String) -> bool;

/// A scene with its placed triangles. Workers of a web page transfer it as bytes.
#[derive(Serialize, Deserialize)]
pub(crate) struct ViewerScene {
    /// Name of a built-in scene, or path of a file. Empty for scenes from memory, which can't be
    /// read again.
    pub argument: String,
    pub name: String,
    pub geometry: Geometry,
    pub materials: Vec<Material>,
    pub textures: Vec<Texture>,
    pub lights: Vec<Light>,
    pub camera: Camera,
    /// Bounding box of all triangles, which is never empty.
    pub bounds: Aabb,
}

impl ViewerScene {
    /// Returns the empty stage that is shown until the first scene has been read.
    pub(crate) fn nothing() -> Self {
        Self {
            argument: String::new(),
            name: String::new(),
            bounds: Aabb {
                min: Vec3::ZERO,
                max: Vec3::ONE,
            },
            geometry: Geometry::default(),
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

    /// Reports whether no scene has been read yet.
    pub(crate) fn is_nothing(&self) -> bool {
        self.geometry.triangles().is_empty()
    }

    /// Makes a built-in scene, or reads a file. Returns `None` if it was cancelled.
    ///
    /// # Errors
    /// Returns an error if it can't be read.
    pub(crate) fn of_argument(argument: &str, on_step: OnStep<'_>) -> Result<Option<Self>> {
        on_step("reading".to_owned());
        // Pass only the text to `anyhow`: errors of scenes print their causes themselves, and
        // `anyhow` would repeat them.
        let scene = scenes::by_argument(argument).map_err(anyhow::Error::msg)?;
        if !on_step("placing triangles".to_owned()) {
            return Ok(None);
        }
        Self::of_scene(argument, argument, scene).map(Some)
    }

    /// Reads a scene file or a model in memory, with the files that it names.
    ///
    /// # Errors
    /// Returns an error if it can't be read.
    #[cfg(target_arch = "wasm32")]
    pub(crate) fn read(name: &str, files: &scenes::FilesInMemory) -> Result<Self> {
        let scene = scenes::read(name, files).map_err(anyhow::Error::msg)?;
        Self::of_scene("", name, scene)
    }

    /// Places a scene's triangles.
    ///
    /// # Errors
    /// Returns an error if they can't be placed, or there are none.
    pub(crate) fn of_scene(argument: &str, name: &str, scene: Scene) -> Result<Self> {
        let geometry = Geometry::bake(&scene)?;
        let bounds = geometry.bounds();
        anyhow::ensure!(
            !geometry.triangles().is_empty(),
            "`{name}` has no triangles, and can't be shown"
        );
        Ok(Self {
            argument: argument.to_owned(),
            name: scene.name,
            geometry,
            camera: *scene
                .cameras
                .first()
                .with_context(|| format!("`{name}` has no camera"))?,
            materials: scene.materials,
            textures: scene.textures,
            lights: scene.lights,
            bounds,
        })
    }
}
