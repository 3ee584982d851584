//! A floor, and a square plate above it, under a light straight from above.

use crate::kernels::{Compare, Numbers};
use glam::{Affine3A, UVec2, Vec3, Vec4};
use std::sync::Arc;
use umbrage_core::{
    Backend, Camera, Cast, Extents, Format, Geometry, ImageDesc, Instance, Light, LightSpace, Mesh,
    Receive, ReceiveKernel, Recipe, Scene, Shadows, View,
    light_space::{look_along, orthographic},
};
use umbrage_wgpu::{AdapterChoice, Gpu};

/// Returns the adapter that all tests use.
pub(crate) fn gpu() -> Gpu {
    Gpu::new(&AdapterChoice::from_env()).unwrap_or_else(|e| panic!("{e}"))
}

/// The scene to render.
pub(crate) struct BackendScene {
    pub(crate) geometry: Geometry,
    pub(crate) camera: Camera,
    pub(crate) light: Light,
}

fn square(name: &str, half: f32, y: f32) -> Mesh {
    // Counter-clockwise seen from above.
    let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)];
    let positions = corners
        .map(|(x, z)| Vec3::new(x * half, y, z * half))
        .to_vec();
    Mesh::new(name, positions, vec![[0, 1, 2], [0, 2, 3]]).expect("a square is a mesh")
}

impl BackendScene {
    pub(crate) fn new() -> Self {
        let place = |mesh, casts, receives| Instance {
            casts,
            receives,
            ..Instance::new(mesh, Affine3A::IDENTITY)
        };
        let scene = Scene {
            name: "plate".to_owned(),
            meshes: vec![square("floor", 4.0, 0.0), square("plate", 1.0, 1.0)],
            instances: vec![place(0, true, true), place(1, true, false)],
            ..Scene::default()
        };
        let eye = Vec3::new(3.0, 5.0, 6.0);
        let size = UVec2::new(97, 61);
        Self {
            geometry: Geometry::bake(&scene).expect("the scene is valid"),
            camera: Camera::perspective(eye, Vec3::ZERO, Vec3::Y, 0.9, [0.5, 50.0], size)
                .expect("so is the camera"),
            light: Light::Directional {
                direction: Vec3::NEG_Y,
                angular_diameter: 0.0,
            },
        }
    }

    pub(crate) fn view(&self) -> View<'_> {
        View::new(&self.camera, &self.light, &self.geometry)
    }

    pub(crate) fn space(&self) -> LightSpace {
        let extents = Extents {
            left: -5.0,
            right: 5.0,
            bottom: -5.0,
            top: 5.0,
            near: 1.0,
            far: 9.0,
        };
        LightSpace {
            view_from_world: look_along(Vec3::Y * 5.0, Vec3::NEG_Y, Vec3::Y)
                .expect("down is a direction"),
            clip_from_view: orthographic(extents).expect("the extents are in order"),
        }
    }

    /// Returns a tilted light space for the same scene: depth changes from texel to texel.
    pub(crate) fn tilted_space(&self) -> LightSpace {
        let extents = Extents {
            left: -6.0,
            right: 6.0,
            bottom: -6.0,
            top: 6.0,
            near: 1.0,
            far: 15.0,
        };
        let eye = Vec3::new(3.0, 6.0, 2.0);
        LightSpace {
            view_from_world: look_along(eye, -eye, Vec3::Y).expect("the eye is not at the origin"),
            clip_from_view: orthographic(extents).expect("the extents are in order"),
        }
    }

    pub(crate) fn numbers(&self, numbers: Vec4) -> Numbers {
        Numbers {
            clip_from_world: self.space().clip_from_world(),
            numbers,
        }
    }

    pub(crate) fn compare(&self) -> Compare {
        // A tenth of the gap between floor and plate, which is 1 m of 8 m.
        Compare(self.numbers(Vec4::splat(0.0125)))
    }

    /// Returns a recipe with one map of this side and one comparison.
    pub(crate) fn recipe(&self, side: u32) -> Recipe {
        self.recipe_with(side, Arc::new(self.compare()))
    }

    pub(crate) fn recipe_with(&self, side: u32, kernel: Arc<dyn ReceiveKernel>) -> Recipe {
        Recipe {
            images: vec![ImageDesc {
                label: "map",
                size: UVec2::splat(side),
                layers: 1,
                format: Format::Depth32,
            }],
            tables: Vec::new(),
            casts: vec![Cast::nearest(0, 0, self.space())],
            filters: Vec::new(),
            receive: Receive {
                kernel,
                inputs: vec![0],
                tables: Vec::new(),
            },
            shade: None,
            hierarchy: None,
            keep_images: true,
        }
    }

    pub(crate) fn render(&self, gpu: &mut Gpu, recipe: &Recipe) -> Shadows {
        gpu.render(&self.view(), recipe)
            .unwrap_or_else(|e| panic!("{e}"))
    }
}
