//! Texels from vertices: each texel receives the value of the nearest vertex in the texture.

use rstar::{RTree, primitives::GeomWithData};
use std::collections::HashSet;
use umbrage_core::glam::{UVec2, Vec2};
use umbrage_core::{Invalid, Mesh};

/// A vertex's position in the texture, texels, and its index.
type FilledTexel = GeomWithData<[f32; 2], u32>;

/// Returns the nearest vertex in the texture for each texel, rows from the top. Distances are from
/// the centre of the texel, in texels.
pub(super) fn nearest_vertices(mesh: &Mesh, size: UVec2) -> Result<Vec<u32>, Invalid> {
    let tree = RTree::bulk_load(distinct(mesh, size.as_vec2())?);
    let mut nearest = Vec::with_capacity(size.element_product() as usize);
    for row in 0..size.y {
        for column in 0..size.x {
            let center = [column as f32 + 0.5, row as f32 + 0.5];
            let place = tree.nearest_neighbor(center).ok_or_else(|| {
                let what = format!("mesh `{}`", mesh.name);
                Invalid::new(what, "has no texture coordinates", "give it some")
            })?;
            nearest.push(place.data);
        }
    }
    Ok(nearest)
}

/// Returns the vertices with distinct texture coordinates.
///
/// # Errors
/// Returns an error if a coordinate is not finite.
fn distinct(mesh: &Mesh, size: Vec2) -> Result<Vec<FilledTexel>, Invalid> {
    let mut known = HashSet::with_capacity(mesh.uvs.len());
    let mut places = Vec::with_capacity(mesh.uvs.len());
    for (vertex, uv) in mesh.uvs.iter().enumerate() {
        let place = *uv * size;
        if !place.is_finite() {
            let why = format!("has texture coordinates {uv} at vertex {vertex}");
            return Err(Invalid::new(
                format!("mesh `{}`", mesh.name),
                why,
                "unwrap the mesh again",
            ));
        }
        // Add 0, which turns -0 into 0.
        let bits = [place.x + 0.0, place.y + 0.0].map(f32::to_bits);
        if known.insert(bits) {
            places.push(FilledTexel::new(place.to_array(), vertex as u32));
        }
    }
    Ok(places)
}
