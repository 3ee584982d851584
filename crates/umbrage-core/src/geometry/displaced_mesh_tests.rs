use super::*;
use crate::{
    geometry::Geometry,
    scene::material::{Displacement, Material},
};
use glam::{Affine3A, UVec2, Vec2};
use std::collections::HashSet;

fn texture(size: u32, height: impl Fn(u32, u32) -> f32) -> Texture {
    let texels = (0..size * size)
        .map(|i| [height(i % size, i / size), 0.0, 0.0, 1.0])
        .collect();
    Texture {
        name: "relief".to_owned(),
        size: UVec2::splat(size),
        texels,
    }
}

/// Returns a unit square in x and z that faces up, u along x, v along z.
fn square() -> Mesh {
    let positions = vec![Vec3::ZERO, Vec3::Z, Vec3::X + Vec3::Z, Vec3::X];
    let uvs = positions.iter().map(|p| Vec2::new(p.x, p.z)).collect();
    Mesh {
        uvs,
        ..Mesh::new("square", positions, vec![[0, 1, 2], [0, 2, 3]]).unwrap()
    }
}

/// Returns a box of six squares with separate normals; `uv` returns the coordinates of each side's
/// corners.
fn cube(uv: impl Fn(usize, usize) -> Vec2) -> Mesh {
    let mut mesh = Mesh {
        name: "cube".to_owned(),
        ..Mesh::default()
    };
    for side in 0..6 {
        let n = Vec3::AXES[side / 2] * if side % 2 == 0 { 1.0 } else { -1.0 };
        let u = Vec3::AXES[(side / 2 + 1) % 3];
        let v = n.cross(u);
        let base = mesh.positions.len() as u32;
        for (i, (a, b)) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .into_iter()
            .enumerate()
        {
            mesh.positions.push(n + u * a + v * b);
            mesh.normals.push(n);
            mesh.uvs.push(uv(side, i));
        }
        mesh.triangles
            .extend([[0, 1, 2], [0, 2, 3]].map(|t| t.map(|i| i + base)));
    }
    mesh
}

/// Returns whether each directed edge, by position, has its opposite.
fn is_closed(mesh: &Mesh) -> bool {
    let key = |v: u32| {
        mesh.positions[v as usize]
            .to_array()
            .map(|x| (x + 0.0).to_bits())
    };
    let edges: HashSet<_> = mesh
        .triangles
        .iter()
        .flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])])
        .map(|(a, b)| (key(a), key(b)))
        .collect();
    edges.iter().all(|&(a, b)| edges.contains(&(b, a)))
}

fn scene(mesh: Mesh, texture: Texture, lambda: f32, subdivisions: u32) -> Scene {
    let displacement = Some(Displacement {
        texture: 0,
        lambda,
        subdivisions,
    });
    Scene {
        name: "s".to_owned(),
        meshes: vec![mesh],
        materials: vec![Material {
            displacement,
            ..Material::default()
        }],
        textures: vec![texture],
        instances: vec![Instance {
            material: Some(0),
            ..Instance::new(0, Affine3A::IDENTITY)
        }],
        ..Scene::default()
    }
}

/// Waves along u with a period of 32 texels.
fn waves() -> Texture {
    texture(32, |x, _| {
        0.5 + 0.5 * (x as f32 / 32.0 * std::f32::consts::TAU).sin()
    })
}

#[test]
fn the_baked_list_has_the_relief() {
    let scene = scene(square(), waves(), 0.1, 5);
    let baked = Geometry::bake(&scene).unwrap();
    assert_eq!(baked.triangles().len(), 2 * 4_usize.pow(5));
    for p in baked.positions() {
        let h = height(&scene.textures[0], Vec2::new(p.x, p.z));
        assert_eq!(
            *p,
            displaced(Vec3::new(p.x, 0.0, p.z), Vec3::Y, h, 0.1),
            "bit-equal to the shader's result"
        );
    }
    let low = baked.bounds().min.y;
    let high = baked.bounds().max.y;
    assert!(low < -0.09 && high > 0.09, "{low} {high}");
}

#[test]
fn fingerprints_tell_reliefs_apart() {
    let print = |lambda| {
        Geometry::bake(&scene(square(), waves(), lambda, 2))
            .unwrap()
            .fingerprint()
    };
    assert_ne!(print(0.1), print(0.2));
    assert_eq!(print(0.1), print(0.1));
}

#[test]
fn normals_fit_the_slope() {
    // Heights rise by 1 along u over 64 texels, apart from the jump at the repeat: 45 degrees at
    // lambda 1/2.
    let ramp = texture(64, |x, _| (x as f32 + 0.5) / 64.0);
    let baked = Geometry::bake(&scene(square(), ramp, 0.5, 5)).unwrap();
    let inner = baked
        .positions()
        .iter()
        .zip(baked.normals())
        .filter(|(p, _)| p.x > 0.1 && p.x < 0.9);
    let expected = Vec3::new(-1.0, 1.0, 0.0).normalize();
    let off = inner.map(|(_, n)| n.distance(expected)).fold(0.0, f32::max);
    // Rounding of positions at 1e-7 over triangles of 1/32.
    assert!(off < 1e-5, "{off}");
}

#[test]
fn a_normal_map_keeps_the_smooth_normals() {
    let mut scene = scene(square(), waves(), 0.1, 3);
    scene.meshes[0].tangents = vec![glam::Vec4::new(1.0, 0.0, 0.0, -1.0); 4];
    scene.materials[0].normal_map = Some(0);
    let baked = Geometry::bake(&scene).unwrap();
    assert!(baked.normals().iter().all(|n| *n == Vec3::Y));
    assert!(baked.bounds().extent().y > 0.1, "yet vertices move");
}

#[test]
fn seams_do_not_tear() {
    let seamed = cube(|side, corner| {
        Vec2::new(
            0.13 * side as f32 + 0.31 * corner as f32,
            0.27 * corner as f32,
        )
    });
    assert!(is_closed(&seamed));
    let moved = scene(seamed.clone(), waves(), 0.2, 3);
    let applied = apply_displacement(&moved, &moved.instances[0], 0).unwrap();
    assert!(is_closed(&applied));
    // Negative control: displacing each vertex alone tears the mesh.
    let fine = seamed.subdivide(3).unwrap();
    let alone = fine.positions.iter().zip(&fine.normals).zip(&fine.uvs);
    let positions = alone
        .map(|((&p, &n), &uv)| displaced(p, n, height(&moved.textures[0], uv), 0.2))
        .collect();
    assert!(!is_closed(&Mesh { positions, ..fine }));
}

#[test]
fn sharp_edges_stay_sharp_and_smooth_ones_smooth() {
    let flat = texture(1, |_, _| 1.0);
    let cube = cube(|_, corner| Vec2::splat(0.2 * corner as f32));
    let sharp = cube.displace_mesh(&flat, 0.1).unwrap();
    for (n, old) in sharp.normals.iter().zip(&cube.normals) {
        assert!(n.distance(*old) < 1e-6, "{n} was {old}");
    }
    let round = Mesh {
        normals: cube.positions.iter().map(|p| p.normalize()).collect(),
        ..cube
    };
    let smooth = round.displace_mesh(&flat, 0.1).unwrap();
    for (n, p) in smooth.normals.iter().zip(&smooth.positions) {
        assert!(n.distance(p.normalize()) < 0.2, "{n} at {p}");
    }
    let places = WeldedVertices::new(&round.positions);
    for place in 0..places.count() as u32 {
        let normals: HashSet<_> = places
            .vertices(place)
            .iter()
            .map(|&v| smooth.normals[v as usize].to_array().map(f32::to_bits))
            .collect();
        assert_eq!(normals.len(), 1, "shared across the seam");
    }
}

#[test]
fn meshes_without_normals_move_along_averaged_ones() {
    let lifted = square()
        .displace_mesh(&texture(1, |_, _| 1.0), 0.25)
        .unwrap();
    assert!(lifted.positions.iter().all(|p| p.y == 0.25), "{lifted:?}");
}

#[test]
fn what_cannot_be_displaced_is_refused() {
    let bare = Mesh {
        uvs: Vec::new(),
        ..square()
    };
    let message = |mesh: &Mesh, lambda| {
        mesh.displace_mesh(&waves(), lambda)
            .unwrap_err()
            .to_string()
    };
    assert!(message(&bare, 0.1).contains("has no texture coordinates"));
    assert!(message(&square(), f32::NAN).contains("holds NaN"));
    let empty = Texture {
        texels: Vec::new().into(),
        ..waves()
    };
    assert!(square().displace_mesh(&empty, 0.1).is_err());
}

#[test]
fn too_many_triangles_are_refused_for_the_scene_as_a_whole() {
    let mut scene = scene(square(), waves(), 0.1, 3);
    let room = |triangles| MAX_SUBDIVIDED_TRIANGLES - triangles;
    assert_eq!(
        apply_displacement(&scene, &scene.instances[0], room(128))
            .unwrap()
            .triangles
            .len(),
        128
    );
    let error = apply_displacement(&scene, &scene.instances[0], room(127))
        .unwrap_err()
        .to_string();
    assert_eq!(
        error,
        "mesh `square`: would have 128 triangles after 3 subdivisions of 2, and at most 127 fit; use at most 2 \
         subdivisions"
    );
    scene.materials[0].displacement = None;
    assert!(
        apply_displacement(&scene, &scene.instances[0], room(0)).is_ok(),
        "a mesh that is not subdivided has no limit"
    );
}
