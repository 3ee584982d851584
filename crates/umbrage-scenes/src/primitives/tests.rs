use super::*;
use std::collections::HashMap;
use umbrage_core::glam::DVec3;

/// Returns six times the volume, which is positive if triangles are counter-clockwise seen from
/// outside.
fn signed_volume(mesh: &Mesh) -> f64 {
    let corner = |v: u32| mesh.positions[v as usize].as_dvec3();
    mesh.triangles
        .iter()
        .map(|t| t.map(corner))
        .map(|[a, b, c]: [DVec3; 3]| a.dot(b.cross(c)))
        .sum()
}

/// Reports whether each directed edge, by position, has exactly one counterpart in the other
/// direction.
fn is_closed(mesh: &Mesh) -> bool {
    let key = |v: u32| {
        mesh.positions[v as usize]
            .to_array()
            .map(|x| (x + 0.0).to_bits())
    };
    let mut edges: HashMap<_, i32> = HashMap::new();
    for t in &mesh.triangles {
        for (p, q) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
            *edges.entry((key(p), key(q))).or_default() += 1;
        }
    }
    edges
        .iter()
        .all(|(&(p, q), &n)| n == 1 && edges.get(&(q, p)) == Some(&1))
}

fn solids() -> Vec<(Mesh, f64)> {
    let arc: Vec<_> = (0..9)
        .map(|i| {
            (
                Vec3::new(i as f32, (i * i) as f32 * 0.1, 0.3 * i as f32),
                0.4,
            )
        })
        .collect();
    let step = [
        (0.0, 0.0),
        (2.0, 0.0),
        (2.0, 2.0),
        (1.0, 2.0),
        (1.0, 1.0),
        (0.0, 1.0),
    ];
    vec![
        (block([-1.0, 2.0, 0.5], [1.0, 5.0, 1.5]), 6.0),
        (icosphere([3.0, 1.0, 2.0], 2.0, 4), 33.51),
        (pillar(1.0, 2.0, 128), std::f64::consts::TAU),
        (
            lathe(
                &[(0.0, -1.0), (0.7, -0.7), (1.0, 0.0), (0.7, 0.7), (0.0, 1.0)],
                64,
            ),
            3.5,
        ),
        (tube(&arc, 24), 5.0),
        (prism(&step, 1.0, -1.0), 6.0),
        (octasphere(1.0, 5), 4.19),
        (map_mesh(&octasphere(1.0, 5)), 4.19),
        (map_mesh(&icosphere(Vec3::ZERO, 1.0, 4)), 4.19),
        (torus(2.0, 0.5, [64, 32]), 9.87),
    ]
}

#[test]
fn solids_are_closed_face_out_and_hold_their_volume() {
    for (mesh, volume) in solids() {
        mesh.validate().unwrap();
        assert!(is_closed(&mesh), "{} leaks", mesh.name);
        let found = signed_volume(&mesh) / 6.0;
        // Facets reduce round shapes by a few per cent, and the tube's ends are slanted.
        assert!(
            found > 0.9 * volume && found < 1.2 * volume,
            "{}: {found} for {volume}",
            mesh.name
        );
    }
}

#[test]
fn the_checks_object_to_spoilt_solids() {
    for (mesh, _) in solids() {
        let mut open = mesh.clone();
        open.triangles.pop();
        assert!(
            !is_closed(&open),
            "{} lacks a triangle unnoticed",
            mesh.name
        );
        let mut flipped = mesh.clone();
        flipped.triangles[0].swap(0, 1);
        assert!(
            !is_closed(&flipped),
            "{} has a flipped triangle unnoticed",
            mesh.name
        );
        let mut inside_out = mesh;
        inside_out.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        assert!(signed_volume(&inside_out) < 0.0);
    }
}

#[test]
fn shading_normals_agree_with_the_winding() {
    for (mesh, _) in solids().into_iter().filter(|(m, _)| !m.normals.is_empty()) {
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
            let geometric = (b - a).cross(c - a).normalize();
            assert!(
                t.iter()
                    .all(|&v| geometric.dot(mesh.normals[v as usize]) > 0.9),
                "{} {t:?}",
                mesh.name
            );
        }
    }
}

#[test]
fn flat_shapes_face_up() {
    for mesh in [
        grid([3.0, 2.0], [4, 5], |_, _| 0.0),
        quad([Vec3::ZERO, Vec3::Z, Vec3::X + Vec3::Z, Vec3::X]),
    ] {
        mesh.validate().unwrap();
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
            assert!((b - a).cross(c - a).y > 0.0, "{}", mesh.name);
        }
    }
}

#[test]
fn a_sphere_keeps_its_vertices_on_its_surface() {
    let center = Vec3::new(1.0, 2.0, 3.0);
    let mesh = icosphere([1.0, 2.0, 3.0], 0.5, 5);
    assert_eq!(mesh.triangles.len(), 20_480);
    // Allow one rounding to f32 of coordinates below 4.
    assert!(
        mesh.positions
            .iter()
            .all(|p| (p.distance(center) - 0.5).abs() < 1e-6)
    );
}

#[test]
fn spheres_are_mapped_without_jumps() {
    for (mesh, beyond) in [
        (map_mesh(&octasphere(1.0, 4)), 1.0),
        (map_mesh(&icosphere(Vec3::ZERO, 1.0, 4)), 1.1),
    ] {
        assert!(
            mesh.uvs
                .iter()
                .all(|uv| uv.min_element() >= 0.0 && uv.x <= beyond && uv.y <= 1.0)
        );
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|v| mesh.uvs[v as usize]);
            assert!(
                (a.max(b).max(c) - a.min(b).min(c)).max_element() < 0.3,
                "{a} {b} {c}"
            );
        }
        // Seen from +z, the centre of the texture, u grows to the right.
        for (p, uv) in mesh
            .positions
            .iter()
            .zip(&mesh.uvs)
            .filter(|(p, _)| p.z > 0.5 && p.x.abs() > 1e-6)
        {
            assert_eq!(uv.x > 0.5, p.x > 0.0, "{p} {uv}");
            assert!((f64::from(uv.y) - f64::from(p.y).acos() / std::f64::consts::PI).abs() < 1e-6);
        }
    }
}
