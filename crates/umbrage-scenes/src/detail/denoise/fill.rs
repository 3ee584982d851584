//! Texels from vertices: each takes what the nearest vertex in the texture has.

use kiddo::{ImmutableKdTree, SquaredEuclidean};
use std::collections::HashSet;
use umbrage_core::glam::{UVec2, Vec2};
use umbrage_core::{Invalid, Mesh};

/// Returns, for each texel, rows from the top, the vertex whose texture coordinates lie nearest to its centre, measured in
/// texels.
pub(super) fn nearest_vertices(mesh: &Mesh, size: UVec2) -> Result<Vec<u32>, Invalid> {
    let (vertices, points) = distinct(mesh, size.as_vec2());
    let tree = ImmutableKdTree::new_from_slice(&points).map_err(|e| {
        let why = format!("has texture coordinates that can't be searched: {e:?}");
        Invalid::new(format!("mesh `{}`", mesh.name), why, "lay them out anew")
    })?;
    let mut out = Vec::with_capacity(size.element_product() as usize);
    for y in 0..size.y {
        for x in 0..size.x {
            let center = [x as f32 + 0.5, y as f32 + 0.5];
            let nearest = tree
                .query(&center)
                .nearest_one::<SquaredEuclidean<f32>>()
                .execute();
            out.push(vertices[nearest.item as usize]);
        }
    }
    Ok(out)
}

/// Returns vertices with different texture coordinates, and these in texels.
fn distinct(mesh: &Mesh, size: Vec2) -> (Vec<u32>, Vec<[f32; 2]>) {
    let mut known = HashSet::with_capacity(mesh.uvs.len());
    let mut vertices = Vec::new();
    let mut points = Vec::new();
    for (vertex, uv) in (0..).zip(&mesh.uvs) {
        let point = (*uv * size).to_array();
        // The sum with 0 makes -0 positive.
        let is_new = known.insert(point.map(|x| (x + 0.0).to_bits()));
        if is_new {
            vertices.push(vertex);
            points.push(point);
        }
    }
    (vertices, points)
}
