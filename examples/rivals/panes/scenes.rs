//! Two scenes with panes of three colours in the sun.

use super::{Glass, MATERIALS};
use std::f32::consts::TAU;
use umbrage::{
    Camera, Instance, Invalid, Light, Material, Mesh, Scene,
    glam::{Affine3A, UVec2, Vec3},
};

/// Red, green and blue.
pub const GLASS: [Glass; MATERIALS] = [
    Glass {
        material: 1,
        transmittance: Vec3::new(0.9, 0.15, 0.1),
    },
    Glass {
        material: 2,
        transmittance: Vec3::new(0.2, 0.8, 0.3),
    },
    Glass {
        material: 3,
        transmittance: Vec3::new(0.15, 0.3, 0.9),
    },
];
/// Index of the opaque material.
const OPAQUE: u32 = 0;
/// Number of shards.
const SHARDS: u32 = 120;

/// Returns a window of three colours with two more panes behind it. It is in the plane z = 0, and
/// the sun shines through it towards +z.
///
/// # Errors
/// Returns an error if `size` has no pixels.
pub fn window(size: UVec2) -> Result<Scene, Invalid> {
    let sun = Vec3::new(0.3, -0.8, 0.6);
    let [eye, target] = [Vec3::new(3.5, 4.0, 8.5), Vec3::new(0.2, 0.8, 1.2)];
    let mut scene = sunny("coloured-window", sun, eye, target, size)?;
    let upright = |width: f32, height: f32| [Vec3::X * width, Vec3::Y * height];
    let mut put =
        |corner: Vec3, sides: [Vec3; 2], material| put(&mut scene, corner, sides, material);
    let [red, _, blue] = GLASS.map(|glass| glass.material);
    let floor = [Vec3::Z * 12.0, Vec3::X * 12.0];
    put(Vec3::new(-6.0, 0.0, -4.0), floor, OPAQUE)?;
    // Put three panes between four posts, under a beam.
    for (i, glass) in GLASS.iter().enumerate() {
        let corner = Vec3::new(-2.0 + 1.4 * i as f32, 0.1, 0.0);
        put(corner, upright(1.3, 2.8), glass.material)?;
    }
    for i in 0..4 {
        let corner = Vec3::new(-2.1 + 1.4 * i as f32, 0.0, 0.0);
        put(corner, upright(0.1, 2.9), OPAQUE)?;
    }
    put(Vec3::new(-2.1, 2.9, 0.0), upright(4.3, 0.15), OPAQUE)?;
    // Put two panes behind the window: blue over red and green, and red over red.
    put(Vec3::new(-1.2, 0.4, 1.0), upright(1.2, 1.0), blue)?;
    put(Vec3::new(-2.4, 0.3, 0.7), upright(0.9, 1.2), red)?;
    Ok(scene)
}

/// Returns shards of glass above a floor, at all angles and with many overlaps.
///
/// # Errors
/// Returns an error if `size` has no pixels.
pub fn shards(size: UVec2) -> Result<Scene, Invalid> {
    let sun = Vec3::new(0.25, -0.9, 0.3);
    let [eye, target] = [Vec3::new(0.5, 5.5, 8.0), Vec3::new(0.5, 0.0, 0.8)];
    let mut scene = sunny("shards", sun, eye, target, size)?;
    let floor = [Vec3::Z * 14.0, Vec3::X * 14.0];
    put(&mut scene, Vec3::new(-7.0, 0.0, -6.0), floor, OPAQUE)?;
    for i in 0..SHARDS {
        // Distribute them evenly without rows (Roberts 2018, "The unreasonable effectiveness of
        // quasirandom sequences", in five dimensions).
        let [x, y, z, turn, tilt] = [0.8813, 0.7766, 0.6844, 0.6032, 0.5316]
            .map(|step: f32| (0.5 + step * i as f32).fract());
        let corner = Vec3::new(5.0 * x - 2.5, 0.6 + 1.8 * y, 4.0 * z - 2.2);
        let (sine, cosine) = (TAU * turn).sin_cos();
        let along = Vec3::new(cosine, tilt - 0.5, sine);
        let across = along.cross(Vec3::new(tilt - 0.5, 1.0, 0.5 - turn));
        let sides = [along * 0.7, across.normalize_or_zero() * 0.5];
        let glass = GLASS[i as usize % MATERIALS];
        put(&mut scene, corner, sides, glass.material)?;
    }
    Ok(scene)
}

/// Returns a scene without objects.
fn sunny(
    name: &str,
    direction: Vec3,
    eye: Vec3,
    target: Vec3,
    size: UVec2,
) -> Result<Scene, Invalid> {
    let depth_range = [0.1, 100.0];
    Ok(Scene {
        name: name.to_owned(),
        materials: vec![Material::default(); 1 + MATERIALS],
        lights: vec![Light::Directional {
            direction,
            angular_diameter: 0.0,
        }],
        cameras: vec![Camera::perspective(
            eye,
            target,
            Vec3::Y,
            0.8,
            depth_range,
            size,
        )?],
        ..Scene::default()
    })
}

/// Adds a rectangle.
fn put(scene: &mut Scene, corner: Vec3, sides: [Vec3; 2], material: u32) -> Result<(), Invalid> {
    let [along, across] = sides;
    let corners = vec![
        corner,
        corner + along,
        corner + along + across,
        corner + across,
    ];
    let mesh = Mesh::new("rectangle", corners, vec![[0, 1, 2], [0, 2, 3]])?;
    scene.meshes.push(mesh);
    let mut instance = Instance::new(scene.meshes.len() - 1, Affine3A::IDENTITY);
    instance.material = Some(material as usize);
    scene.instances.push(instance);
    Ok(())
}
