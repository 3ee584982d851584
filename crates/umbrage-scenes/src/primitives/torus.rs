//! Rings.

use super::on_circle;
use umbrage_core::Mesh;
use umbrage_core::glam::{Vec2, Vec3};

/// A ring around the y axis. `major` is the distance to the centre of its tube, `minor` the tube's
/// radius, `segments` are around the axis and around the tube. u runs once around the axis and v
/// once around the tube; vertices at the seams are doubled.
pub(crate) fn torus(major: f32, minor: f32, segments: [u32; 2]) -> Mesh {
    let [around, across] = segments;
    let mut mesh = Mesh {
        name: "torus".to_owned(),
        ..Mesh::default()
    };
    for j in 0..=across {
        for i in 0..=around {
            // The last vertex equals the first, bit for bit.
            let (x, z) = on_circle(f64::from(i % around) / f64::from(around));
            let (out, up) = on_circle(f64::from(j % across) / f64::from(across));
            let r = major + minor * out;
            mesh.positions.push(Vec3::new(r * x, minor * up, -r * z));
            mesh.normals.push(Vec3::new(out * x, up, -out * z));
            mesh.uvs.push(Vec2::new(
                i as f32 / around as f32,
                1.0 - j as f32 / across as f32,
            ));
        }
    }
    let corner = |i: u32, j: u32| j * (around + 1) + i;
    let quads = (0..across).flat_map(|j| (0..around).map(move |i| (i, j)));
    mesh.triangles = quads
        .flat_map(|(i, j)| {
            let a = corner(i, j);
            let b = corner(i + 1, j);
            let c = corner(i + 1, j + 1);
            let d = corner(i, j + 1);
            [[a, b, c], [a, c, d]]
        })
        .collect();
    mesh
}
