//! A window of three colours in the sun, with two more panes behind it.

use super::{Glass, MATERIALS};
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
/// The material of what is opaque.
pub(super) const OPAQUE: usize = 0;

/// Returns the scene. The window stands across z = 0, and the sun shines through it towards +z.
///
/// # Errors
/// Errors if `size` has no pixels.
pub fn scene(size: UVec2) -> Result<Scene, Invalid> {
    let mut scene = Scene {
        name: "coloured-window".to_owned(),
        materials: vec![Material::default(); 1 + MATERIALS],
        lights: vec![Light::Directional {
            direction: Vec3::new(0.3, -0.8, 0.6),
            angular_diameter: 0.0,
        }],
        cameras: vec![Camera::perspective(
            Vec3::new(3.5, 4.0, 8.5),
            Vec3::new(0.2, 0.8, 1.2),
            Vec3::Y,
            0.8,
            [0.1, 100.0],
            size,
        )?],
        ..Scene::default()
    };
    let upright = |width: f32, height: f32| [Vec3::X * width, Vec3::Y * height];
    let mut put =
        |corner: Vec3, sides: [Vec3; 2], material| put(&mut scene, corner, sides, material);
    let floor = [Vec3::Z * 12.0, Vec3::X * 12.0];
    put(Vec3::new(-6.0, 0.0, -4.0), floor, OPAQUE)?;
    // Three panes between four posts, under a beam.
    for (i, glass) in GLASS.iter().enumerate() {
        let left = -2.1 + 1.4 * i as f32;
        let sides = upright(1.3, 2.8);
        put(
            Vec3::new(left + 0.1, 0.1, 0.0),
            sides,
            glass.material as usize,
        )?;
    }
    for i in 0..4 {
        let left = -2.1 + 1.4 * i as f32;
        put(Vec3::new(left, 0.0, 0.0), upright(0.1, 2.9), OPAQUE)?;
    }
    put(Vec3::new(-2.1, 2.9, 0.0), upright(4.3, 0.15), OPAQUE)?;
    // Behind the window: blue over red and green, and red over red.
    let blue = GLASS[2].material as usize;
    put(Vec3::new(-1.2, 0.4, 1.0), upright(1.2, 1.0), blue)?;
    let red = GLASS[0].material as usize;
    put(Vec3::new(-2.4, 0.3, 0.7), upright(0.9, 1.2), red)?;
    Ok(scene)
}

/// Adds a rectangle.
pub(super) fn put(
    scene: &mut Scene,
    corner: Vec3,
    sides: [Vec3; 2],
    material: usize,
) -> Result<(), Invalid> {
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
    instance.material = Some(material);
    scene.instances.push(instance);
    Ok(())
}
