//! Texels from vertices: each takes what the nearest vertex in the texture has.

use kiddo::{ImmutableKdTree, SquaredEuclidean};
use std::collections::HashSet;
use umbrage_core::glam::{UVec2, Vec2};
use umbrage_core::{Invalid, Mesh};

/// For each texel, rows from the top, the vertex whose texture coordinates lie nearest to its centre, measured in
/// texels.
pub(super) fn nearest_vertices(mesh: &Mesh, size: UVec2) -> Result<Vec<u32>, Invalid> {
    let (vertices, points) = distinct(mesh, size.as_vec2());
    let tree = ImmutableKdTree::new_from_slice(&points).map_err(|e| {
        let why = format!("has texture coordinates that can't be searched: {e:?}");
        Invalid::new(format!("mesh `{}`", mesh.name), why, "lay them out anew")
    })?;
    let centre = |i: u32| [(i % size.x) as f32 + 0.5, (i / size.x) as f32 + 0.5];
    let nearest = |i| {
        tree.query(&centre(i))
            .nearest_one::<SquaredEuclidean<f32>>()
            .execute()
            .item
    };
    Ok((0..size.element_product())
        .map(|i| vertices[nearest(i) as usize])
        .collect())
}

/// Vertices with different texture coordinates, and these in texels.
fn distinct(mesh: &Mesh, size: Vec2) -> (Vec<u32>, Vec<[f32; 2]>) {
    let mut known = HashSet::with_capacity(mesh.uvs.len());
    let points = mesh
        .uvs
        .iter()
        .map(|uv| (*uv * size).to_array())
        .enumerate();
    points
        .filter(|(_, p)| known.insert(p.map(|x| (x + 0.0).to_bits())))
        .map(|(v, p)| (v as u32, p))
        .unzip()
}
