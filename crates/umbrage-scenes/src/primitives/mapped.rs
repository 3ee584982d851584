//! Texture coordinates for spheres.

use std::collections::HashMap;
use umbrage_core::Mesh;
use umbrage_core::glam::{DVec3, Vec2};

/// Distance from the axis, as a fraction of the radius, below which a vertex is a pole without
/// longitude.
const POLE: f64 = 1e-9;

/// Returns a mesh around the origin with longitude and latitude as texture coordinates. Seen from
/// outside, u grows to the right, from -z through -x; v starts at the top. Vertices are doubled at
/// the seam and at the poles; triangles across the seam exceed u = 1.
pub(crate) fn map_mesh(mesh: &Mesh) -> Mesh {
    let mut out = Mesh {
        name: mesh.name.clone(),
        ..Mesh::default()
    };
    let mut known = HashMap::new();
    for t in &mesh.triangles {
        let uvs = unwrap_triangle(t.map(|v| mesh.positions[v as usize].as_dvec3()));
        let corners = [0, 1, 2].map(|i| {
            let v: u32 = t[i];
            let uv: Vec2 = uvs[i];
            *known
                .entry((v, uv.to_array().map(f32::to_bits)))
                .or_insert_with(|| {
                    out.positions.push(mesh.positions[v as usize]);
                    out.normals.extend(mesh.normals.get(v as usize));
                    out.uvs.push(uv);
                    out.positions.len() as u32 - 1
                })
        });
        out.triangles.push(corners);
    }
    out
}

/// Returns a triangle's coordinates without a jump.
fn unwrap_triangle(corners: [DVec3; 3]) -> [Vec2; 3] {
    let mut longitudes = corners.map(longitude);
    let most = longitudes.iter().flatten().copied().fold(0.0, f64::max);
    longitudes
        .iter_mut()
        .flatten()
        .filter(|u| most - **u > 0.5)
        .for_each(|u| *u += 1.0);
    let known: Vec<f64> = longitudes.iter().flatten().copied().collect();
    let mean = known.iter().sum::<f64>() / known.len().max(1) as f64;
    let latitude = |p: DVec3| (p.y / p.length()).clamp(-1.0, 1.0).acos() / std::f64::consts::PI;
    [0, 1, 2].map(|i| {
        Vec2::new(
            longitudes[i].unwrap_or(mean) as f32,
            latitude(corners[i]) as f32,
        )
    })
}

/// Returns the longitude, from 0 to below 1. `None` at the poles.
fn longitude(p: DVec3) -> Option<f64> {
    if p.x.hypot(p.z) <= POLE * p.length() {
        return None;
    }
    let turn = p.x.atan2(p.z) / std::f64::consts::TAU + 0.5;
    Some(if turn >= 1.0 { 0.0 } else { turn })
}
