//! A small scene in colour: textures, a normal map, a mirrored and a smooth object, a light's
//! marker.

use umbrage_core::{
    Camera, Extents, Instance, Invalid, Light, LightMarker, Material, Mesh, Scene, Texture,
    glam::{Affine3A, UVec2, Vec2, Vec3},
};
use umbrage_scenes::{fitting_normal_map, with_tangents};

const SIZE: UVec2 = UVec2::new(160, 120);

/// The scene under this light, with its marker.
///
/// # Errors
/// Never returns an error, since the scene is valid.
pub fn scene(light: Light, camera: Camera) -> Result<Scene, Invalid> {
    let floor = with_tangents(&floor())?;
    let ball = with_tangents(&ball())?;
    let bumps = fitting_normal_map(&waves(), 0.03, Vec2::ONE)?;
    let scene = Scene {
        name: "painted".to_owned(),
        meshes: vec![floor, ball],
        instances: instances(),
        materials: materials(),
        textures: vec![checks(), bumps],
        lights: vec![light],
        cameras: vec![camera],
        ..Scene::default()
    };
    Ok(scene.with_light_marker(LightMarker {
        directional_at: Some(Vec3::new(-1.5, 1.4, -1.0)),
        ..LightMarker::default()
    }))
}

/// Lights of every kind, all from the left. Those with a position are visible to both cameras.
pub fn lights() -> [Light; 5] {
    let position = Vec3::new(-1.2, 1.8, 1.0);
    let half = Vec3::new(0.3, 0.0, 0.0);
    [
        Light::Directional {
            direction: Vec3::new(1.0, -2.0, -0.7),
            angular_diameter: 0.0,
        },
        Light::Spot {
            position,
            direction: -position,
            inner: 0.4,
            outer: 0.7,
            radius: 0.0,
        },
        Light::Point {
            position,
            radius: 0.0,
        },
        Light::Rect {
            center: position,
            half_u: half,
            half_v: Vec3::new(0.0, 0.0, 0.2),
        },
        Light::Disc {
            center: position,
            normal: Vec3::NEG_Y,
            radius: 0.3,
        },
    ]
}

/// Cameras with and without perspective.
///
/// # Errors
/// Never returns an error, since the cameras are valid.
pub fn cameras() -> Result<[Camera; 2], Invalid> {
    let eye = Vec3::new(0.6, 2.4, 4.2);
    let target = Vec3::new(0.0, 0.3, 0.0);
    let flat = Extents {
        left: -2.4,
        right: 2.4,
        bottom: -1.8,
        top: 1.8,
        near: 0.1,
        far: 20.0,
    };
    let perspective = Camera::perspective(eye, target, Vec3::Y, 0.8, [0.1, 50.0], SIZE)?;
    Ok([
        perspective,
        Camera::orthographic(eye, target, Vec3::Y, flat, SIZE)?,
    ])
}

/// Two balls over a floor, one of them mirrored and without a texture's colour, and a third without
/// a material.
fn instances() -> Vec<Instance> {
    let place = |mesh, scale: Vec3, at: Vec3, material| {
        let world_from_local = Affine3A::from_translation(at) * Affine3A::from_scale(scale);
        Instance {
            material,
            ..Instance::new(mesh, world_from_local)
        }
    };
    vec![
        place(0, Vec3::splat(3.0), Vec3::ZERO, Some(0)),
        place(1, Vec3::splat(0.7), Vec3::new(-0.9, 0.7, 0.0), Some(1)),
        place(
            1,
            Vec3::new(-0.5, 0.6, 0.5),
            Vec3::new(0.6, 0.6, 0.6),
            Some(2),
        ),
        place(1, Vec3::splat(0.3), Vec3::new(1.3, 0.3, -0.6), None),
    ]
}

fn materials() -> Vec<Material> {
    let floor = Material {
        diffuse: Vec3::splat(0.8),
        diffuse_texture: Some(0),
        normal_map: Some(1),
        ..Material::default()
    };
    let shiny = Material {
        specular: Vec3::splat(0.6),
        shininess_log2: 7,
        ..floor
    };
    let red = Material {
        diffuse: Vec3::new(0.6, 0.08, 0.05),
        diffuse_texture: None,
        ..shiny
    };
    vec![floor, shiny, red]
}

/// A quad from -1 to 1 in y = 0, with three repeats of the texture along each side.
fn floor() -> Mesh {
    Mesh {
        name: "floor".to_owned(),
        positions: vec![
            Vec3::new(-1.0, 0.0, -1.0),
            Vec3::new(-1.0, 0.0, 1.0),
            Vec3::new(1.0, 0.0, 1.0),
            Vec3::new(1.0, 0.0, -1.0),
        ],
        uvs: vec![
            Vec2::ZERO,
            Vec2::new(0.0, 3.0),
            Vec2::splat(3.0),
            Vec2::new(3.0, 0.0),
        ],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

/// A coarse unit ball, with four repeats of the texture around it and two from pole to pole.
fn ball() -> Mesh {
    const AROUND: u32 = 24;
    const DOWN: u32 = 12;
    let mut mesh = Mesh {
        name: "ball".to_owned(),
        ..Mesh::default()
    };
    for i in 0..=DOWN {
        for j in 0..=AROUND {
            let v = i as f32 / DOWN as f32;
            let u = j as f32 / AROUND as f32;
            let (sin, cos) = (v * std::f32::consts::PI).sin_cos();
            let (z, x) = (u * std::f32::consts::TAU).sin_cos();
            mesh.positions.push(Vec3::new(x * sin, cos, -z * sin));
            mesh.uvs.push(Vec2::new(4.0 * u, 2.0 * v));
        }
    }
    mesh.normals = mesh.positions.clone();
    for i in 0..DOWN * AROUND {
        let a = i / AROUND * (AROUND + 1) + i % AROUND;
        let b = a + AROUND + 1;
        mesh.triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
    }
    mesh
}

/// A texture without symmetries: every flip or turn changes it.
fn checks() -> Texture {
    let light = [0.9, 0.85, 0.7, 1.0];
    let dark = [0.25, 0.2, 0.2, 1.0];
    let blue = [0.1, 0.3, 0.7, 1.0];
    let texels = [light, dark, light, dark, blue, dark, light, light];
    Texture {
        name: "checks".to_owned(),
        size: UVec2::new(4, 2),
        texels: texels.to_vec().into(),
    }
}

/// Heights 0 to 1: four waves in one direction, two in the other.
fn waves() -> Texture {
    let wave =
        |i: u32, count: f32| 0.5 + 0.5 * (i as f32 / 32.0 * count * std::f32::consts::TAU).sin();
    let texels = (0..32 * 32).map(|i| [wave(i % 32, 4.0) * wave(i / 32, 2.0); 4]);
    Texture {
        name: "waves".to_owned(),
        size: UVec2::splat(32),
        texels: texels.collect(),
    }
}
