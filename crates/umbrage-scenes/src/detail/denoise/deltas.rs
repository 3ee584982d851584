//! Offsets of vertices from the means of their neighbours.

use std::collections::BTreeSet;
use umbrage_core::glam::{DVec3, Vec3};
use umbrage_core::{Invalid, Mesh, WeldedVertices};

/// The distinct positions of a closed mesh, with the data that the method needs.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    pub(super) places: WeldedVertices,
    /// Unit normals of the positions.
    pub(super) normals: Vec<Vec3>,
    /// Offsets of the positions along the normals, metres.
    pub(super) deltas: Vec<f32>,
}

impl Surface {
    /// Measures a mesh. Averaging the offsets over neighbours `rounds` times yields their common
    /// part, which is subtracted; 0 rounds subtract nothing.
    pub(super) fn new(mesh: &Mesh, rounds: u32) -> Result<Self, Invalid> {
        check(mesh)?;
        let places = WeldedVertices::new(&mesh.positions);
        let edges = edges(mesh, &places);
        for &(a, b) in &edges {
            if edges.binary_search(&(b, a)).is_err() {
                let p = place_position(mesh, &places, a);
                let q = place_position(mesh, &places, b);
                let what = format!("mesh `{}`", mesh.name);
                let why = format!("is open: no second triangle meets the edge from {p} to {q}");
                return Err(Invalid::new(what, why, "close its holes"));
            }
        }
        let normals = places.normals(mesh);
        let mut deltas = deltas(mesh, &places, &edges, &normals);
        if rounds > 0 {
            let mut shared = deltas.clone();
            for _ in 0..rounds {
                shared = averaged_values(&shared, &edges);
            }
            for (delta, shared) in deltas.iter_mut().zip(shared) {
                *delta -= shared;
            }
        }
        Ok(Self {
            places,
            normals,
            deltas,
        })
    }

    /// Returns the normals of the mesh, equal for all vertices of one position.
    pub(super) fn vertex_normals(&self) -> Vec<Vec3> {
        self.places
            .group_of()
            .iter()
            .map(|&place| self.normals[place as usize])
            .collect()
    }

    pub(super) fn vertex_delta(&self, vertex: usize) -> f32 {
        self.deltas[self.places.group_of()[vertex] as usize]
    }
}

fn check(mesh: &Mesh) -> Result<(), Invalid> {
    mesh.validate()?;
    let what = format!("mesh `{}`", mesh.name);
    if mesh.uvs.is_empty() {
        let why = "has no texture coordinates to store a map over";
        return Err(Invalid::new(what, why, "add uvs"));
    }
    for uv in &mesh.uvs {
        if uv.min_element() < 0.0 || uv.max_element() > 1.0 {
            let why = format!(
                "has the texture coordinates {uv}: beyond 0 to 1, a texel would represent several positions"
            );
            return Err(Invalid::new(what, why, "unwrap its uvs into one square"));
        }
    }
    Ok(())
}

/// Returns the distinct directed edges between positions, in order, without those of length zero.
fn edges(mesh: &Mesh, places: &WeldedVertices) -> Vec<(u32, u32)> {
    // Sort the edges, so that sums round equally in every run.
    let mut edges = BTreeSet::new();
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|v| places.group_of()[v as usize]);
        for (from, to) in [(a, b), (b, c), (c, a)] {
            if from != to {
                edges.insert((from, to));
            }
        }
    }
    edges.into_iter().collect()
}

fn place_position(mesh: &Mesh, places: &WeldedVertices, place: u32) -> Vec3 {
    mesh.positions[places.vertices(place)[0] as usize]
}

/// Returns the offset of each position from the mean of its neighbours along its normal, metres; 0
/// without neighbours.
fn deltas(
    mesh: &Mesh,
    places: &WeldedVertices,
    edges: &[(u32, u32)],
    normals: &[Vec3],
) -> Vec<f32> {
    let mut sums = vec![DVec3::ZERO; places.count()];
    let mut counts = vec![0_u32; places.count()];
    for &(a, b) in edges {
        sums[a as usize] += place_position(mesh, places, b).as_dvec3();
        counts[a as usize] += 1;
    }
    let mut deltas = vec![0.0; places.count()];
    for (place, delta) in deltas.iter_mut().enumerate() {
        if counts[place] > 0 {
            let mean = sums[place] / f64::from(counts[place]);
            let position = place_position(mesh, places, place as u32).as_dvec3();
            *delta = (position - mean).dot(normals[place].as_dvec3()) as f32;
        }
    }
    deltas
}

/// Averages the value of each position and its neighbours.
fn averaged_values(values: &[f32], edges: &[(u32, u32)]) -> Vec<f32> {
    let mut sums: Vec<f64> = values.iter().map(|&v| f64::from(v)).collect();
    let mut counts = vec![1_u32; values.len()];
    for &(a, b) in edges {
        sums[a as usize] += f64::from(values[b as usize]);
        counts[a as usize] += 1;
    }
    sums.into_iter()
        .zip(counts)
        .map(|(sum, count)| (sum / f64::from(count)) as f32)
        .collect()
}
