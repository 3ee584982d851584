use super::*;
use crate::primitives::{grid, map_mesh, octasphere, torus};
use umbrage_core::glam::{Vec2, Vec3};

fn bitangent(mesh: &Mesh, v: usize) -> Vec3 {
    mesh.normals[v].cross(mesh.tangents[v].truncate()) * mesh.tangents[v].w
}

/// Returns the greatest distance of unit vectors, over all vertices.
fn worst(mesh: &Mesh, found: impl Fn(usize) -> Vec3, expected: impl Fn(Vec3) -> Vec3) -> f32 {
    (0..mesh.positions.len())
        .map(|v| found(v).distance(expected(mesh.positions[v])))
        .fold(0.0, f32::max)
}

#[test]
fn tangents_run_along_u_and_bitangents_against_v() {
    // Map u along x and v along z, facing up.
    let mesh = with_tangents(&grid([2.0, 2.0], [3, 3], |_, _| 0.0)).unwrap();
    mesh.validate().unwrap();
    assert!(worst(&mesh, |v| mesh.tangents[v].truncate(), |_| Vec3::X) < 1e-6);
    assert!(worst(&mesh, |v| bitangent(&mesh, v), |_| Vec3::NEG_Z) < 1e-6);
    assert_eq!(
        (mesh.positions.len(), mesh.triangles.len()),
        (16, 18),
        "nothing is split without need"
    );
}

#[test]
fn mirrored_coordinates_flip_the_handedness_and_split_vertices() {
    let plain = grid([2.0, 2.0], [2, 1], |_, _| 0.0);
    // Mirror the texture in the middle, as on symmetric models.
    let uvs = plain
        .uvs
        .iter()
        .map(|uv| Vec2::new((uv.x - 0.5).abs(), uv.y))
        .collect();
    let mesh = with_tangents(&Mesh { uvs, ..plain }).unwrap();
    assert_eq!(
        mesh.positions.len(),
        8,
        "the two vertices in the middle are double"
    );
    for (v, p) in mesh
        .positions
        .iter()
        .enumerate()
        .filter(|(_, p)| p.x != 0.0)
    {
        assert_eq!(
            mesh.tangents[v],
            Vec4::new(p.x.signum(), 0.0, 0.0, p.x.signum()),
            "at {p}"
        );
        assert!(
            bitangent(&mesh, v).distance(Vec3::NEG_Z) < 1e-6,
            "green is up on both halves"
        );
    }
}

#[test]
fn a_torus_has_its_analytic_frames() {
    let mesh = with_tangents(&torus(2.0, 0.5, [64, 32])).unwrap();
    // u runs from +x towards -z.
    let around = |p: Vec3| Vec3::new(p.z, 0.0, -p.x).normalize();
    let up_the_tube = |p: Vec3| {
        let out = Vec3::new(p.x, 0.0, p.z).normalize();
        around(p).cross((p - 2.0 * out).normalize()) * -1.0
    };
    // The tolerance covers facets of 1/64 turn.
    assert!(worst(&mesh, |v| mesh.tangents[v].truncate(), around) < 0.05);
    assert!(worst(&mesh, |v| bitangent(&mesh, v), up_the_tube) < 0.05);
}

#[test]
fn frames_are_orthonormal_on_a_sphere_with_poles() {
    let mesh = with_tangents(&map_mesh(&octasphere(1.0, 4))).unwrap();
    for (v, t) in mesh.tangents.iter().enumerate() {
        let t3 = t.truncate();
        // Mikkelsen's tangents are unit vectors perpendicular to the normal, up to rounding.
        assert!(
            (t3.length() - 1.0).abs() < 1e-5
                && t3.dot(mesh.normals[v]).abs() < 1e-5
                && t.w.abs() == 1.0,
            "{t}"
        );
    }
}

#[test]
fn meshes_without_normals_get_them() {
    let mut bare = torus(2.0, 0.5, [32, 16]);
    let smooth = std::mem::take(&mut bare.normals);
    let mesh = with_tangents(&bare).unwrap();
    for (n, p) in mesh.normals.iter().zip(&mesh.positions) {
        let at = bare.positions.iter().position(|q| q == p).unwrap();
        assert!(n.distance(smooth[at]) < 0.1, "{n}");
    }
}

#[test]
fn degenerate_coordinates_still_give_frames() {
    let flat = grid([1.0, 1.0], [1, 1], |_, _| 0.0);
    let mesh = with_tangents(&Mesh {
        uvs: vec![Vec2::splat(0.5); 4],
        ..flat.clone()
    })
    .unwrap();
    mesh.validate().unwrap();
    assert!(
        mesh.tangents
            .iter()
            .all(|t| (t.truncate().length() - 1.0).abs() < 1e-5),
        "{:?}",
        mesh.tangents
    );
    let point = Mesh {
        positions: vec![Vec3::ONE; 4],
        normals: Vec::new(),
        ..flat.clone()
    };
    with_tangents(&point).unwrap().validate().unwrap();
    assert!(
        with_tangents(&Mesh {
            uvs: Vec::new(),
            ..flat
        })
        .unwrap_err()
        .to_string()
        .contains("no texture coordinates")
    );
}
