//! Spheres.

use std::collections::HashMap;
use umbrage_core::Mesh;
use umbrage_core::glam::{DVec3, Vec3};

/// A sphere of `20 * 4^splits` nearly equal triangles from an icosahedron, with all vertices on the
/// sphere.
pub(crate) fn icosphere(center: impl Into<Vec3>, radius: f32, splits: u32) -> Mesh {
    sphere(center.into(), radius, splits, icosahedron())
}

/// A sphere of `8 * 4^splits` triangles from an octahedron. They are less equal, but the poles are
/// vertices, and the meridians of every quarter turn are edges, where a texture can begin and end.
pub(crate) fn octasphere(radius: f32, splits: u32) -> Mesh {
    let directions = [
        DVec3::Y,
        DVec3::Z,
        DVec3::X,
        DVec3::NEG_Z,
        DVec3::NEG_X,
        DVec3::NEG_Y,
    ];
    let upper = (1..5).map(|i| [0, i, i % 4 + 1]);
    let lower = (1..5).map(|i| [5, i % 4 + 1, i]);
    sphere(
        Vec3::ZERO,
        radius,
        splits,
        (directions.to_vec(), upper.chain(lower).collect()),
    )
}

fn sphere(center: Vec3, radius: f32, splits: u32, polyhedron: (Vec<DVec3>, Vec<[u32; 3]>)) -> Mesh {
    let (mut directions, mut triangles) = polyhedron;
    for _ in 0..splits {
        let mut middles = HashMap::new();
        triangles = triangles
            .into_iter()
            .flat_map(|t| split(t, &mut directions, &mut middles))
            .collect();
    }
    let place = |d: &DVec3| (center.as_dvec3() + *d * f64::from(radius)).as_vec3();
    Mesh {
        name: "sphere".to_owned(),
        positions: directions.iter().map(place).collect(),
        normals: directions.iter().map(|d| d.as_vec3()).collect(),
        triangles,
        ..Mesh::default()
    }
}

fn split(
    triangle: [u32; 3],
    directions: &mut Vec<DVec3>,
    middles: &mut HashMap<(u32, u32), u32>,
) -> [[u32; 3]; 4] {
    let [a, b, c] = triangle;
    let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(p, q)| {
        *middles.entry((p.min(q), p.max(q))).or_insert_with(|| {
            directions.push((directions[p as usize] + directions[q as usize]).normalize());
            directions.len() as u32 - 1
        })
    });
    [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
}

fn icosahedron() -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let golden = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let mut directions = Vec::new();
    for (one, phi) in [
        (-1.0, golden),
        (1.0, golden),
        (-1.0, -golden),
        (1.0, -golden),
    ] {
        directions.push(DVec3::new(one, phi, 0.0).normalize());
    }
    directions.extend_from_within(..);
    directions.extend_from_within(..4);
    // The three golden rectangles are rotations of each other about the diagonal.
    directions[4..8]
        .iter_mut()
        .for_each(|d| *d = DVec3::new(d.z, d.x, d.y));
    directions[8..]
        .iter_mut()
        .for_each(|d| *d = DVec3::new(d.y, d.z, d.x));
    let triangles = [
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    (directions, triangles.to_vec())
}
