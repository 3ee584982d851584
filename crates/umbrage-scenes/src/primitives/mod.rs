//! Shapes of built-in scenes. They are closed unless stated otherwise, and counter-clockwise seen
//! from outside.

mod lathe;
mod mapped;
mod prism;
mod solids;
mod sphere;
mod torus;
mod tube;

pub(crate) use lathe::{lathe, pillar};
pub(crate) use mapped::map_mesh;
pub(crate) use prism::prism;
pub(crate) use solids::{block, grid, quad, room, slabs_around, tile_mesh};
pub(crate) use sphere::{icosphere, octasphere};
pub(crate) use torus::torus;
pub(crate) use tube::tube;

#[cfg(test)]
mod tests;

use umbrage_core::Mesh;
use umbrage_core::glam::Vec3;

/// Returns a mesh whose shading normals core averages.
fn bare(name: &str, positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Mesh {
    Mesh {
        name: name.to_owned(),
        positions,
        triangles,
        ..Mesh::default()
    }
}

/// Returns the point at `turn` (of a full turn) on the unit circle, from +x towards +y. Computed in
/// `f64`, so that the library of every platform rounds to the same `f32`.
pub(crate) fn on_circle(turn: f64) -> (f32, f32) {
    let (sin, cos) = (turn * std::f64::consts::TAU).sin_cos();
    (cos as f32, sin as f32)
}
