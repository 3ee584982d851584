//! Builder of built-in scenes.

use crate::{
    framing::Shot,
    looks::{Look, PALETTE, matte},
};
use umbrage_core::glam::{Affine3A, UVec2, Vec3};
use umbrage_core::{Geometry, Instance, Light, Material, Mesh, Scene};

/// A scene under construction.
#[derive(Clone, Debug)]
pub(crate) struct Stage {
    scene: Scene,
}

impl Stage {
    pub(crate) fn new(name: &str) -> Self {
        Self {
            scene: Scene {
                name: name.to_owned(),
                ..Scene::default()
            },
        }
    }

    /// Adds a mesh without a transform, which casts and receives.
    pub(crate) fn put(self, mesh: Mesh) -> Self {
        self.put_many(mesh, [Affine3A::IDENTITY])
    }

    /// Adds copies of one mesh, which cast and receive.
    pub(crate) fn put_many(
        mut self,
        mesh: Mesh,
        places: impl IntoIterator<Item = Affine3A>,
    ) -> Self {
        let index = self.scene.meshes.len();
        self.scene.meshes.push(mesh);
        self.scene
            .instances
            .extend(places.into_iter().map(|place| Instance::new(index, place)));
        self
    }

    /// Sets the roles of everything added so far.
    pub(crate) fn roles(mut self, casts: bool, receives: bool) -> Self {
        for instance in &mut self.scene.instances {
            instance.casts = casts;
            instance.receives = receives;
        }
        self
    }

    /// Sets the roles of the last mesh.
    pub(crate) fn last_roles(mut self, casts: bool, receives: bool) -> Self {
        for instance in self.last() {
            instance.casts = casts;
            instance.receives = receives;
        }
        self
    }

    /// Sets the look of the last mesh.
    pub(crate) fn look(mut self, look: Look) -> Self {
        let first = self.scene.textures.len();
        let id = self.scene.materials.len();
        self.scene.textures.extend(look.textures);
        self.scene
            .materials
            .push(offset_textures(look.material, first));
        self.last().for_each(|i| i.material = Some(id));
        self
    }

    fn last(&mut self) -> impl Iterator<Item = &mut Instance> {
        let meshes = self.scene.meshes.len();
        self.scene
            .instances
            .iter_mut()
            .filter(move |i| i.mesh + 1 == meshes)
    }

    pub(crate) fn light(mut self, light: Light) -> Self {
        self.scene.lights.push(light);
        self
    }

    /// Adds the camera with fitted near and far planes, and returns the scene.
    ///
    /// # Panics
    /// Panics if the scene is invalid. Scenes are defined in this crate, and a test builds each.
    pub(crate) fn shoot(
        self,
        eye: impl Into<Vec3>,
        target: impl Into<Vec3>,
        fov_y_degrees: f32,
        size: [u32; 2],
    ) -> Scene {
        let shot = Shot {
            eye: eye.into(),
            target: target.into(),
            up: Vec3::Y,
            fov_y: fov_y_degrees.to_radians(),
            size: UVec2::from(size),
        };
        self.shoot_from(&shot, None)
    }

    /// [`Stage::shoot`] with an explicit near plane.
    ///
    /// # Panics
    /// Panics if [`Stage::shoot`] does.
    pub(crate) fn shoot_from(mut self, shot: &Shot, near: Option<f32>) -> Scene {
        self.paint_the_rest();
        let geometry = Geometry::bake(&self.scene).expect("built-in scenes are valid");
        self.scene.cameras.push(
            shot.camera(&geometry, [near, None])
                .expect("built-in cameras are valid"),
        );
        self.scene
    }

    /// Assigns colours in turn to objects without a look. The first object is nearly always a
    /// floor.
    fn paint_the_rest(&mut self) {
        let first = self.scene.materials.len();
        let colors = PALETTE.len();
        let mut paints_any = false;
        for (n, instance) in self.scene.instances.iter_mut().enumerate() {
            if instance.material.is_some() {
                continue;
            }
            // Don't use the floor's colour again.
            let color = if n == 0 {
                0
            } else {
                1 + (n - 1) % (colors - 1)
            };
            instance.material = Some(first + color);
            paints_any = true;
        }
        if paints_any {
            let palette = PALETTE.map(|color| matte(color).material);
            self.scene.materials.extend(palette);
        }
    }
}

/// Returns the material with its textures numbered from `first`.
fn offset_textures(mut material: Material, first: usize) -> Material {
    if let Some(id) = &mut material.diffuse_texture {
        *id += first;
    }
    if let Some(id) = &mut material.normal_map {
        *id += first;
    }
    if let Some(displacement) = &mut material.displacement {
        displacement.texture += first;
    }
    if let Some(alpha) = &mut material.alpha {
        alpha.texture += first;
    }
    material
}

/// A sun without extent.
pub(crate) fn sun(x: f32, y: f32, z: f32) -> Light {
    Light::Directional {
        direction: Vec3::new(x, y, z),
        angular_diameter: 0.0,
    }
}

/// A point light without extent.
pub(crate) fn bulb(x: f32, y: f32, z: f32) -> Light {
    Light::Point {
        position: Vec3::new(x, y, z),
        radius: 0.0,
    }
}
