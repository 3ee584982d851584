//! Extruded outlines.

use super::bare;
use crate::polygon::triangulate;
use umbrage_core::Mesh;
use umbrage_core::glam::Vec3;

/// Extrudes a simple outline in x and y, counter-clockwise seen from +z, from `near` down to `far`
/// in z.
pub(crate) fn prism(outline: &[(f32, f32)], near: f32, far: f32) -> Mesh {
    let n = outline.len() as u32;
    let layer = |z: f32| outline.iter().map(move |&(x, y)| Vec3::new(x, y, z));
    let positions: Vec<Vec3> = layer(near).chain(layer(far)).collect();
    let front = triangulate(&positions[..outline.len()]);
    let mut triangles = front.clone();
    triangles.extend(front.iter().map(|&[a, b, c]| [a + n, c + n, b + n]));
    triangles.extend((0..n).flat_map(|i| {
        let j = (i + 1) % n;
        [[i, i + n, j + n], [i, j + n, j]]
    }));
    bare("prism", positions, triangles)
}
