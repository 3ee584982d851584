//! Scenes under ideal lights. Models without lights are placed on a floor under four lights.

use crate::error::LabError;
use glam::{Affine3A, UVec2, Vec3};
use umbrage_core::{Aabb, Camera, Geometry, Instance, Light, Mesh, Scene};

/// A scene and its ideal lights.
#[derive(Clone, Debug)]
pub struct Staged {
    /// The scene, with a camera.
    pub scene: Scene,
    /// Named ideal lights.
    pub lights: Vec<(String, Light)>,
}

/// Image size of models without a camera, pixels.
const SIZE: UVec2 = UVec2::new(480, 270);
/// Vertical field of view of cameras for models, radians.
const FOV_Y: f32 = 0.7;

/// Stages a scene under its own lights, reduced to ideal ones, with its first camera.
///
/// A model without lights is placed on a floor in a three-quarter view, under a high sun, a low
/// sun, a spot and a point light.
///
/// # Errors
/// Errors if the scene is invalid.
pub fn stage_scene(scene: Scene, is_unlit_model: bool) -> Result<Staged, LabError> {
    if is_unlit_model {
        return on_a_floor(scene);
    }
    let mut lights = Vec::new();
    for (i, light) in scene.lights.iter().enumerate() {
        lights.push((format!("{i} {}", light.kind()), ideal(light)));
    }
    Ok(Staged { scene, lights })
}

/// Returns the light without extent.
pub(super) fn ideal(light: &Light) -> Light {
    match *light {
        Light::Directional { direction, .. } => Light::Directional {
            direction,
            angular_diameter: 0.0,
        },
        Light::Spot {
            position,
            direction,
            inner,
            outer,
            ..
        } => Light::Spot {
            position,
            direction,
            inner,
            outer,
            radius: 0.0,
        },
        Light::Point { position, .. } => Light::Point {
            position,
            radius: 0.0,
        },
        Light::Rect {
            center: position, ..
        }
        | Light::Disc {
            center: position, ..
        } => Light::Point {
            position,
            radius: 0.0,
        },
    }
}

/// Places a model on a floor in a three-quarter view, under the lights of [`lights_around`].
fn on_a_floor(mut scene: Scene) -> Result<Staged, LabError> {
    let bounds = Geometry::bake(&scene)?.bounds();
    let center = bounds.center();
    let extent = bounds.extent();
    let reach = extent.max_element();
    scene.meshes.push(floor(bounds, 3.0 * reach)?);
    scene
        .instances
        .push(Instance::new(scene.meshes.len() - 1, Affine3A::IDENTITY));
    let eye = center + Vec3::new(1.0, 0.8, 1.4).normalize() * (1.9 * reach);
    let target = center - Vec3::Y * (0.1 * reach);
    scene.cameras = vec![Camera::perspective(
        eye,
        target,
        Vec3::Y,
        FOV_Y,
        [0.05 * reach, 10.0 * reach],
        SIZE,
    )?];
    scene.lights.clear();
    Ok(Staged {
        scene,
        lights: lights_around(bounds),
    })
}

/// Returns a square floor below these bounds. `half` is half its side, metres.
fn floor(bounds: Aabb, half: f32) -> Result<Mesh, LabError> {
    let center = bounds.center();
    let corner = |x: f32, z: f32| Vec3::new(center.x + x * half, bounds.min.y, center.z + z * half);
    let corners = vec![
        corner(-1.0, -1.0),
        corner(-1.0, 1.0),
        corner(1.0, 1.0),
        corner(1.0, -1.0),
    ];
    Ok(Mesh::new("floor", corners, vec![[0, 1, 2], [0, 2, 3]])?)
}

/// Returns a high sun, a low sun, a spot and a point light around these bounds.
pub fn lights_around(bounds: Aabb) -> Vec<(String, Light)> {
    let center = bounds.center();
    let extent = bounds.extent();
    let reach = extent.max_element();
    let above = center + Vec3::new(-0.9, 1.3, 0.7) * reach;
    let target = center - Vec3::Y * (0.4 * extent.y);
    let direction = (target - above).normalize();
    let spot = Light::Spot {
        position: above,
        direction,
        inner: 0.5,
        outer: 0.6,
        radius: 0.0,
    };
    let bulb = Light::Point {
        position: center + Vec3::new(-0.7, 0.5, 0.9) * reach,
        radius: 0.0,
    };
    vec![
        ("sun".to_owned(), sun(Vec3::new(-0.5, -1.0, 0.3))),
        ("low sun".to_owned(), sun(Vec3::new(-1.0, -0.2, 0.2))),
        ("spot".to_owned(), spot),
        ("bulb".to_owned(), bulb),
    ]
}

/// Returns a sun without extent with this direction of its light.
fn sun(direction: Vec3) -> Light {
    Light::Directional {
        direction,
        angular_diameter: 0.0,
    }
}
