//! Puts built-in scenes together.

use crate::framing::Shot;
use umbrage_core::glam::{Affine3A, UVec2, Vec3};
use umbrage_core::{Geometry, Instance, Light, Mesh, Scene};

/// A scene in the making.
#[derive(Clone, Debug)]
pub(crate) struct Stage {
    scene: Scene,
}

impl Stage {
    pub(crate) fn new(name: &str) -> Self {
        Self { scene: Scene { name: name.to_owned(), ..Scene::default() } }
    }

    /// A mesh as it is, casting and receiving.
    pub(crate) fn put(self, mesh: Mesh) -> Self {
        self.put_many(mesh, [Affine3A::IDENTITY])
    }

    /// Copies of one mesh, casting and receiving.
    pub(crate) fn put_many(mut self, mesh: Mesh, places: impl IntoIterator<Item = Affine3A>) -> Self {
        let index = self.scene.meshes.len();
        self.scene.meshes.push(mesh);
        self.scene.instances.extend(places.into_iter().map(|place| Instance::new(index, place)));
        self
    }

    /// Gives everything so far these roles.
    pub(crate) fn roles(mut self, casts: bool, receives: bool) -> Self {
        self.scene.instances.iter_mut().for_each(|i| (i.casts, i.receives) = (casts, receives));
        self
    }

    pub(crate) fn light(mut self, light: Light) -> Self {
        self.scene.lights.push(light);
        self
    }

    /// Adds the camera, near and far fitted, and hands the scene over.
    ///
    /// # Panics
    /// If the scene is invalid: it is written in this crate, and a test builds each.
    pub(crate) fn shoot(mut self, eye: Vec3, target: Vec3, fov_y_degrees: f32, size: [u32; 2]) -> Scene {
        let geometry = Geometry::bake(&self.scene).expect("built-in scenes are valid");
        let shot = Shot { eye, target, up: Vec3::Y, fov_y: fov_y_degrees.to_radians(), size: UVec2::from(size) };
        self.scene.cameras.push(shot.camera(&geometry, [None, None]).expect("built-in cameras are valid"));
        self.scene
    }
}

/// The sun as an ideal light.
pub(crate) fn sun(x: f32, y: f32, z: f32) -> Light {
    Light::Directional { direction: Vec3::new(x, y, z), angular_diameter: 0.0 }
}

/// A point light without extent.
pub(crate) fn bulb(x: f32, y: f32, z: f32) -> Light {
    Light::Point { position: Vec3::new(x, y, z), radius: 0.0 }
}
