//! Light markers: small cubes at the positions of lights, for images.

use crate::scene::{Instance, Mesh, Scene, camera::Camera, light::Light, material::Material};
use glam::{Affine3A, Mat4, Vec3};

/// Settings of the light marker.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightMarker {
    /// Emitted colour of the cube, linear: the light's colour.
    pub color: Vec3,
    /// Side of the cube as a fraction of the image's height, at its depth.
    pub height: f32,
    /// Position of the marker of a directional light, for example the eye of a manual fit. `None`
    /// for no marker.
    pub directional_at: Option<Vec3>,
}

impl Default for LightMarker {
    fn default() -> Self {
        Self {
            color: Vec3::ONE,
            height: 1.0 / 40.0,
            directional_at: None,
        }
    }
}

impl LightMarker {
    /// Returns the position of the cube, and half its side in metres. `None` if it can't be marked:
    /// a directional light without a position, or a light in the plane through the camera's eye
    /// perpendicular to its view.
    pub fn place(&self, light: &Light, camera: &Camera) -> Option<(Vec3, f32)> {
        let at = light.position().or(self.directional_at)?;
        let camera = camera.standard();
        let clip_from_view = camera.clip_from_view.as_dmat4();
        let view_from_world = Mat4::from(camera.world_from_view).as_dmat4().inverse();
        let in_view = view_from_world.transform_point3(at.as_dvec3());
        // The image's half height there is w / m11, with perspective or without.
        let w = clip_from_view.row(3).dot(in_view.extend(1.0));
        let half_height = (w / clip_from_view.y_axis.y).abs();
        let half = (half_height * f64::from(self.height)) as f32;
        let is_visible = half.is_finite() && half > 0.0 && at.is_finite();
        is_visible.then_some((at, half))
    }
}

impl Scene {
    /// Returns the scene with a cube in the light's colour at its first light; area lights are
    /// marked at their centre. The cube has the same size in the image of the first camera at any
    /// distance. It neither casts nor receives, so it changes no shadow. It hides the geometry
    /// behind it, so compute errors from masks of the scene without it. Returns the scene unchanged
    /// if there is nothing to mark.
    #[must_use]
    pub fn with_light_marker(&self, marker: LightMarker) -> Self {
        let mut scene = self.clone();
        let (Some(light), Some(camera)) = (self.lights.first(), self.cameras.first()) else {
            return scene;
        };
        let Some((at, half)) = marker.place(light, camera) else {
            return scene;
        };
        let mesh = scene.meshes.len();
        let material = scene.materials.len();
        let world_from_local =
            Affine3A::from_translation(at) * Affine3A::from_scale(Vec3::splat(half));
        scene.meshes.push(cube());
        scene.materials.push(Material {
            diffuse: Vec3::ZERO,
            specular: Vec3::ZERO,
            emissive: marker.color,
            ..Material::default()
        });
        scene.instances.push(Instance {
            mesh,
            world_from_local,
            casts: false,
            receives: false,
            material: Some(material),
        });
        scene
    }
}

/// Returns a cube from -1 to 1. Bits 0, 1 and 2 of a corner's index select x, y and z of 1.
fn cube() -> Mesh {
    let corner = |i: u32| {
        let unit = Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32);
        unit * 2.0 - 1.0
    };
    // Counter-clockwise seen from outside.
    let sides = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    let triangles = sides
        .iter()
        .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
        .collect();
    Mesh {
        name: "light marker".to_owned(),
        positions: (0..8).map(corner).collect(),
        triangles,
        ..Mesh::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{geometry::Geometry, light_space::Extents, math::transform};
    use glam::UVec2;

    const SIZE: UVec2 = UVec2::new(200, 100);

    fn scene(light: Light, camera: Camera) -> Scene {
        let mut floor = cube();
        floor.name = "floor".to_owned();
        let instances = vec![Instance::new(
            0,
            Affine3A::from_scale(Vec3::new(9.0, 0.1, 9.0)),
        )];
        let meshes = vec![floor];
        let lights = vec![light];
        let cameras = vec![camera];
        Scene {
            name: "test".to_owned(),
            meshes,
            instances,
            lights,
            cameras,
            ..Scene::default()
        }
    }

    fn lamp(distance: f32) -> Light {
        Light::Point {
            position: Vec3::new(0.3, 0.2, -distance),
            radius: 0.0,
        }
    }

    fn camera() -> Camera {
        Camera::perspective(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, 1.0, [0.1, 99.0], SIZE).unwrap()
    }

    /// Returns the number of rows between the cube's top and bottom edge, halfway along the view.
    fn rows(camera: &Camera, at: Vec3, half: f32) -> f32 {
        let clip_from_world = camera.space().clip_from_world();
        let ndc_y = |p: Vec3| {
            let clip = transform(clip_from_world, p);
            clip.y / clip.w
        };
        (ndc_y(at + Vec3::Y * half) - ndc_y(at - Vec3::Y * half)) * 0.5 * SIZE.y as f32
    }

    #[test]
    fn the_cube_is_as_high_in_the_image_at_any_distance() {
        let flat = Extents {
            left: -4.0,
            right: 4.0,
            bottom: -2.0,
            top: 2.0,
            near: 0.1,
            far: 99.0,
        };
        let flat = Camera::orthographic(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, flat, SIZE).unwrap();
        for (camera, distance) in [(camera(), 1.0), (camera(), 40.0), (flat, 1.0), (flat, 40.0)] {
            let marker = LightMarker {
                height: 0.05,
                ..LightMarker::default()
            };
            let (at, half) = marker.place(&lamp(distance), &camera).unwrap();
            assert!(
                (rows(&camera, at, half) - 5.0).abs() < 1e-3,
                "{distance} m: {} rows",
                rows(&camera, at, half)
            );
        }
    }

    #[test]
    fn the_cube_stands_where_the_light_is_and_changes_no_shadow() {
        let plain = scene(lamp(7.0), camera());
        let marked = plain.with_light_marker(LightMarker::default());
        marked.validate().unwrap();
        let before = Geometry::bake(&plain).unwrap();
        let after = Geometry::bake(&marked).unwrap();
        assert_eq!(
            (before.casters(), before.receivers()),
            (after.casters(), after.receivers())
        );
        let added = Geometry::vertices_of(&after, 12..24);
        let center = added.sum::<Vec3>() / 36.0;
        assert!(
            center.abs_diff_eq(Vec3::new(0.3, 0.2, -7.0), 1e-5),
            "{center}"
        );
        assert_eq!(after.materials()[12..], [0; 12]);
        assert_eq!(after.materials()[..12], [crate::geometry::NO_MATERIAL; 12]);
    }

    #[test]
    fn directional_lights_are_marked_only_where_one_needs_it() {
        let sun = Light::Directional {
            direction: Vec3::NEG_Y,
            angular_diameter: 0.0,
        };
        let plain = scene(sun, camera());
        assert_eq!(plain.with_light_marker(LightMarker::default()), plain);
        let at = LightMarker {
            directional_at: Some(Vec3::new(0.0, 3.0, -9.0)),
            ..LightMarker::default()
        };
        assert_eq!(plain.with_light_marker(at).instances.len(), 2);
    }

    #[test]
    fn a_light_at_the_eye_is_not_marked() {
        let light = Light::Point {
            position: Vec3::ZERO,
            radius: 0.0,
        };
        assert_eq!(LightMarker::default().place(&light, &camera()), None);
    }
}
