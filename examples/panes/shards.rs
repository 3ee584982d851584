//! Shards of glass in three colours that hang over a floor in the sun, at all angles and many above each other.

use super::window::{GLASS, OPAQUE, put};
use std::f32::consts::TAU;
use umbrage::{
    Camera, Invalid, Light, Material, Scene,
    glam::{UVec2, Vec3},
};

/// How many shards.
const SHARDS: u32 = 120;

/// Returns the scene.
///
/// # Errors
/// Errors if `size` has no pixels.
pub fn scene(size: UVec2) -> Result<Scene, Invalid> {
    let mut scene = Scene {
        name: "shards".to_owned(),
        materials: vec![Material::default(); 1 + GLASS.len()],
        lights: vec![Light::Directional {
            direction: Vec3::new(0.25, -0.9, 0.3),
            angular_diameter: 0.0,
        }],
        cameras: vec![Camera::perspective(
            Vec3::new(0.5, 5.5, 8.0),
            Vec3::new(0.5, 0.0, 0.8),
            Vec3::Y,
            0.8,
            [0.1, 100.0],
            size,
        )?],
        ..Scene::default()
    };
    let floor = [Vec3::Z * 14.0, Vec3::X * 14.0];
    put(&mut scene, Vec3::new(-7.0, 0.0, -6.0), floor, OPAQUE)?;
    for i in 0..SHARDS {
        // Evenly spread, and in no rows (Roberts 2018, "The unreasonable effectiveness of quasirandom sequences", in five dimensions).
        let [x, y, z, turn, tilt] = [0.8813, 0.7766, 0.6844, 0.6032, 0.5316]
            .map(|step: f32| (0.5 + step * i as f32).fract());
        let corner = Vec3::new(5.0 * x - 2.5, 0.6 + 1.8 * y, 4.0 * z - 2.2);
        let (sine, cosine) = (TAU * turn).sin_cos();
        let along = Vec3::new(cosine, tilt - 0.5, sine);
        let across = along.cross(Vec3::new(tilt - 0.5, 1.0, 0.5 - turn));
        let sides = [along * 0.7, across.normalize_or_zero() * 0.5];
        let glass = GLASS[i as usize % GLASS.len()];
        put(&mut scene, corner, sides, glass.material as usize)?;
    }
    Ok(scene)
}
