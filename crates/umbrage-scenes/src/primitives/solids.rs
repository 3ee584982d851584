//! Flat-sided shapes.

use super::bare;
use umbrage_core::Mesh;
use umbrage_core::glam::Vec3;

/// A flat rectangle at height 0 that faces up, open at its rim: `half` in x and z, `cells` quads along each.
pub(crate) fn grid(half: [f32; 2], cells: [u32; 2], height: impl Fn(f32, f32) -> f32) -> Mesh {
    let [nx, nz] = cells;
    let at = |i: u32, n: u32, half: f32| half * (2.0 * i as f32 / n as f32 - 1.0);
    let mut positions = Vec::with_capacity((nx as usize + 1) * (nz as usize + 1));
    for k in 0..=nz {
        positions.extend((0..=nx).map(|i| {
            let (x, z) = (at(i, nx, half[0]), at(k, nz, half[1]));
            Vec3::new(x, height(x, z), z)
        }));
    }
    let corner = |i: u32, k: u32| k * (nx + 1) + i;
    let triangles = (0..nz).flat_map(|k| {
        (0..nx).flat_map(move |i| {
            let [a, b, c, d] = [corner(i, k), corner(i, k + 1), corner(i + 1, k + 1), corner(i + 1, k)];
            [[a, b, c], [a, c, d]]
        })
    });
    bare("grid", positions, triangles.collect())
}

/// One quad from its corners in order, open; it faces where they run counter-clockwise.
pub(crate) fn quad(corners: [Vec3; 4]) -> Mesh {
    bare("quad", corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]])
}

/// A box with flat shading normals: four vertices a side.
pub(crate) fn block(min: Vec3, max: Vec3) -> Mesh {
    let mut mesh = bare("box", Vec::new(), Vec::new());
    for axis in 0..3 {
        for sign in [-1.0_f32, 1.0] {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let base = mesh.positions.len() as u32;
            for (s, t) in [(0, 0), (1, 0), (1, 1), (0, 1)] {
                let mut p = if sign > 0.0 { max } else { min };
                p[u] = [min, max][s][u];
                p[v] = [min, max][t][v];
                mesh.positions.push(p);
                mesh.normals.push(Vec3::AXES[axis] * sign);
            }
            let sides = if sign > 0.0 { [[0, 1, 2], [0, 2, 3]] } else { [[0, 2, 1], [0, 3, 2]] };
            mesh.triangles.extend(sides.map(|t| t.map(|v| v + base)));
        }
    }
    mesh
}
