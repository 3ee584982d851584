use super::*;
use glam::{Affine3A, Quat, UVec2};

use crate::scene::{
    Instance, Mesh,
    material::{Material, Texture},
};

/// A triangle in z = 0: u along x, v against y; the bitangent runs up y.
fn triangle() -> Mesh {
    Mesh {
        name: "triangle".to_owned(),
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
        normals: vec![Vec3::Z; 3],
        uvs: vec![Vec2::Y, Vec2::ONE, Vec2::ZERO],
        tangents: vec![Vec4::new(1.0, 0.0, 0.0, 1.0); 3],
        triangles: vec![[0, 1, 2]],
    }
}

fn bare() -> Mesh {
    Mesh {
        normals: Vec::new(),
        uvs: Vec::new(),
        tangents: Vec::new(),
        ..triangle()
    }
}

fn bake(meshes: Vec<Mesh>, instances: Vec<Instance>) -> Geometry {
    let textures = vec![Texture {
        name: "grey".to_owned(),
        size: UVec2::ONE,
        texels: vec![[0.5; 4]].into(),
    }];
    let materials = vec![
        Material::default(),
        Material {
            diffuse_texture: Some(0),
            ..Material::default()
        },
    ];
    Geometry::bake(&Scene {
        meshes,
        instances,
        materials,
        textures,
        ..Scene::default()
    })
    .unwrap()
}

fn place(mesh: usize, material: Option<usize>, world_from_local: Affine3A) -> Instance {
    Instance {
        material,
        ..Instance::new(mesh, world_from_local)
    }
}

#[test]
fn what_nobody_has_stays_empty() {
    let g = bake(vec![bare()], vec![place(0, None, Affine3A::IDENTITY)]);
    assert!(g.uvs().is_empty() && g.tangents().is_empty() && g.materials().is_empty());
}

#[test]
fn what_some_have_is_padded_for_the_others() {
    let order = [(0, None), (1, Some(1)), (0, Some(0)), (0, None)];
    let instances = order
        .map(|(mesh, material)| place(mesh, material, Affine3A::IDENTITY))
        .to_vec();
    let g = bake(vec![bare(), triangle()], instances);
    assert_eq!(g.materials(), [NO_MATERIAL, 1, 0, NO_MATERIAL]);
    assert_eq!((g.uvs().len(), g.tangents().len()), (12, 12));
    assert_eq!(g.uvs()[3..6], triangle().uvs);
    assert_eq!([g.uvs()[2], g.uvs()[6], g.uvs()[11]], [Vec2::ZERO; 3]);
    assert_eq!([g.tangents()[2], g.tangents()[11]], [Vec4::ZERO; 2]);
}

/// Attributes follow the triangles when casters are moved to the front of the list.
#[test]
fn attributes_follow_the_order_of_roles() {
    let neither = Instance {
        casts: false,
        receives: false,
        ..place(0, Some(0), Affine3A::IDENTITY)
    };
    let g = bake(
        vec![bare(), triangle()],
        vec![neither, place(1, Some(1), Affine3A::IDENTITY)],
    );
    assert_eq!(g.materials(), [1, 0]);
    assert_eq!(g.uvs(), [triangle().uvs, vec![Vec2::ZERO; 3]].concat());
    let control = g.without_casters();
    assert_eq!(
        (control.materials(), control.uvs(), control.tangents()),
        (g.materials(), g.uvs(), g.tangents())
    );
}

/// On the surface, the tangent points along u and the bitangent against v, for every placement.
#[test]
fn frames_follow_turns_scales_and_mirrors() {
    let turned = Affine3A::from_rotation_x(0.7) * Affine3A::from_rotation_z(1.1);
    for scale in [
        Vec3::ONE,
        Vec3::new(-2.0, 3.0, 0.5),
        Vec3::new(1.0, 1.0, -4.0),
        Vec3::splat(-0.1),
    ] {
        let m = turned * Affine3A::from_scale(scale);
        let g = bake(vec![triangle()], vec![place(0, None, m)]);
        let n = g.normals()[0];
        let t = g.tangents()[0];
        let u = m.transform_vector3(Vec3::X).normalize();
        let up = m.transform_vector3(Vec3::Y).normalize();
        assert!(t.truncate().abs_diff_eq(u, 1e-6), "{scale}: {t} is not {u}");
        let b = n.cross(t.truncate()) * t.w;
        assert!(b.abs_diff_eq(up, 1e-6), "{scale}: {b} is not {up}");
    }
}

#[test]
fn long_names_are_refused_by_their_beginning() {
    let named = |letter: &str, count| Scene {
        name: letter.repeat(count),
        ..Scene::default()
    };
    assert!(named("x", crate::scene::MAX_NAME_BYTES).validate().is_ok());
    // Two-byte letters count twice, and are not split.
    for (scene, length) in [
        (named("x", 201), 201),
        (named("x", 5000), 5000),
        (named("é", 101), 202),
    ] {
        let why = scene.validate().expect_err("too long").to_string();
        assert!(
            why.contains(&format!("a name of {length} bytes")) && why.contains("at most 200"),
            "{why}"
        );
        assert!(why.len() < 150, "{why}");
    }
}

/// A ground of 200 km across an axis moves no receiver off its plane. One that is tilted does, in
/// proportion to its extent.
#[test]
fn only_lengths_that_round_normals_count_as_reach() {
    let mesh = Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Z],
        ..bare()
    };
    let reach_of = |placement: Affine3A| {
        bake(vec![mesh.clone()], vec![place(0, None, placement)]).receiver_reach()
    };
    let size = Vec3::splat(2e5);
    let across_y = Affine3A::from_scale_rotation_translation(size, Quat::IDENTITY, Vec3::Y * 7.0);
    assert_eq!(reach_of(across_y), 0.0);
    let upright = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
    let across_z = Affine3A::from_scale_rotation_translation(size, upright, Vec3::ZERO);
    // The rotation's rounding remains: some 2^-24 of the extent.
    assert!(reach_of(across_z) < 0.1);
    let tilted = Quat::from_rotation_z(0.3);
    let tilted = Affine3A::from_scale_rotation_translation(size, tilted, Vec3::ZERO);
    let reach = reach_of(tilted);
    assert!((0.2..1.0).contains(&(reach / 2e5)), "{reach}");
    // The reach of slivers is their extent, and so is that of triangles without area.
    let sliver = Mesh {
        positions: vec![Vec3::ZERO, Vec3::ONE, Vec3::new(0.5, 0.5, 0.500_1)],
        ..bare()
    };
    let flat = Mesh {
        positions: vec![Vec3::ZERO, Vec3::ONE, Vec3::ONE],
        ..bare()
    };
    for mesh in [sliver, flat] {
        let geometry = bake(vec![mesh], vec![place(0, None, Affine3A::IDENTITY)]);
        assert_eq!(geometry.receiver_reach(), 1.0);
    }
}
