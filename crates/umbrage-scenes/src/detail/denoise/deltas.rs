//! How far vertices stand out from the means of their neighbours.

use std::collections::BTreeSet;
use umbrage_core::glam::{DVec3, Vec3};
use umbrage_core::{Invalid, Mesh, WeldedVertices};

/// A closed mesh's places, with what the method needs of them.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    pub(super) places: WeldedVertices,
    /// Unit normals of the places.
    pub(super) normals: Vec<Vec3>,
    /// Metres along the normal, of the places.
    pub(super) deltas: Vec<f32>,
}

impl Surface {
    /// `rounds` times averaging tells what part of the offsets neighbours share; it is left out. 0 leaves nothing out.
    pub(super) fn new(mesh: &Mesh, rounds: u32) -> Result<Self, Invalid> {
        check(mesh)?;
        let places = WeldedVertices::new(&mesh.positions);
        let edges = edges(mesh, &places);
        if let Some(&(a, b)) = edges
            .iter()
            .find(|&&(a, b)| edges.binary_search(&(b, a)).is_err())
        {
            let [p, q] = [a, b].map(|place| mesh.positions[places.vertices(place)[0] as usize]);
            let why = format!("is open: no second triangle meets the edge from {p} to {q}");
            return Err(Invalid::new(
                format!("mesh `{}`", mesh.name),
                why,
                "close its holes",
            ));
        }
        let normals = places.normals(mesh);
        let mut deltas = deltas(mesh, &places, &edges, &normals);
        if rounds > 0 {
            let shared = (0..rounds).fold(deltas.clone(), |values, _| averaged(&values, &edges));
            deltas
                .iter_mut()
                .zip(shared)
                .for_each(|(delta, shared)| *delta -= shared);
        }
        Ok(Self {
            places,
            normals,
            deltas,
        })
    }

    /// The mesh's normals: equal for all vertices of a place.
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
    let invalid =
        |why: String, help: &str| Err(Invalid::new(format!("mesh `{}`", mesh.name), why, help));
    if mesh.uvs.is_empty() {
        return invalid(
            "has no texture coordinates to store a map over".to_owned(),
            "give it uvs",
        );
    }
    match mesh
        .uvs
        .iter()
        .find(|uv| uv.min_element() < 0.0 || uv.max_element() > 1.0)
    {
        Some(uv) => invalid(
            format!(
                "has the texture coordinates {uv}: beyond 0 to 1, a texel would stand for several places"
            ),
            "lay its uvs out in one square",
        ),
        None => Ok(()),
    }
}

/// Directed edges between places in order, each once; those without length left out.
fn edges(mesh: &Mesh, places: &WeldedVertices) -> Vec<(u32, u32)> {
    let corners = mesh
        .triangles
        .iter()
        .map(|t| t.map(|v| places.group_of()[v as usize]));
    let edges = corners
        .flat_map(|[a, b, c]| [(a, b), (b, c), (c, a)])
        .filter(|(a, b)| a != b);
    // Sorted, so that sums round alike in every run.
    edges.collect::<BTreeSet<_>>().into_iter().collect()
}

fn deltas(
    mesh: &Mesh,
    places: &WeldedVertices,
    edges: &[(u32, u32)],
    normals: &[Vec3],
) -> Vec<f32> {
    let at = |place: u32| mesh.positions[places.vertices(place)[0] as usize].as_dvec3();
    let mut sums = vec![(DVec3::ZERO, 0_u32); places.count()];
    for &(a, b) in edges {
        let (sum, count) = &mut sums[a as usize];
        (*sum, *count) = (*sum + at(b), *count + 1);
    }
    let delta = |(place, (sum, count)): (usize, (DVec3, u32))| match count {
        0 => 0.0,
        _ => (at(place as u32) - sum / f64::from(count)).dot(normals[place].as_dvec3()) as f32,
    };
    sums.into_iter().enumerate().map(delta).collect()
}

/// The mean of each place's value and its neighbours'.
fn averaged(values: &[f32], edges: &[(u32, u32)]) -> Vec<f32> {
    let mut sums: Vec<(f64, u32)> = values.iter().map(|&v| (f64::from(v), 1)).collect();
    for &(a, b) in edges {
        let (sum, count) = &mut sums[a as usize];
        (*sum, *count) = (*sum + f64::from(values[b as usize]), *count + 1);
    }
    sums.into_iter()
        .map(|(sum, count)| (sum / f64::from(count)) as f32)
        .collect()
}
