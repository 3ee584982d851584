//! Shapes whose clean surface a formula tells, and noise on them.

use crate::{
    builtin::noise::uniform,
    primitives::{mapped, octasphere, torus},
};
use umbrage_core::glam::{IVec3, Vec3};
use umbrage_core::{Mesh, WeldedVertices};

/// A closed shape around the origin, laid out over one texture square.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Solid {
    /// A ball: radius in metres.
    Sphere {
        /// Above 0.
        radius: f32,
    },
    /// A ring around the y axis.
    Torus {
        /// From the axis to the middle of the tube, metres.
        major: f32,
        /// Radius of the tube, metres: below `major`.
        minor: f32,
    },
}

impl Solid {
    /// About 4,000 (sphere) or 4,600 (torus) vertices on the clean surface, with clean normals and
    /// texture coordinates; the texture's seams and, on the sphere, its poles have doubled
    /// vertices.
    pub fn mesh(&self) -> Mesh {
        match *self {
            Self::Sphere { radius } => mapped(&octasphere(radius, 5)),
            Self::Torus { major, minor } => torus(major, minor, [96, 48]),
        }
    }

    /// Metres from a point to the clean surface, at least 0.
    pub fn distance(&self, p: Vec3) -> f64 {
        let p = p.as_dvec3();
        match *self {
            Self::Sphere { radius } => (p.length() - f64::from(radius)).abs(),
            Self::Torus { major, minor } => {
                let from_ring = p.x.hypot(p.z) - f64::from(major);
                (from_ring.hypot(p.y) - f64::from(minor)).abs()
            }
        }
    }

    /// The mean of [`Solid::distance`] over a mesh's places: doubled vertices count once.
    pub fn mean_distance(&self, mesh: &Mesh) -> f64 {
        let places = WeldedVertices::new(&mesh.positions);
        let mut sum = 0.0;
        for place in 0..places.count() as u32 {
            let first = places.vertices(place)[0];
            sum += self.distance(mesh.positions[first as usize]);
        }
        sum / places.count() as f64
    }
}

/// Returns the mesh with each place moved along its averaged normal by -`amplitude` to `amplitude`
/// metres, uniformly at random from the place's number and `seed`: the same on every machine.
/// Shading normals are dropped, since they are those of the clean shape.
pub fn roughened(mesh: &Mesh, amplitude: f32, seed: i32) -> Mesh {
    let places = WeldedVertices::new(&mesh.positions);
    let normals = places.normals(mesh);
    let mut out = mesh.clone();
    for (position, &place) in out.positions.iter_mut().zip(places.group_of()) {
        let random = uniform(IVec3::new(place as i32, seed, 0));
        let offset = amplitude * (2.0 * random - 1.0);
        *position += normals[place as usize] * offset;
    }
    out.normals = Vec::new();
    out.tangents = Vec::new();
    out
}
