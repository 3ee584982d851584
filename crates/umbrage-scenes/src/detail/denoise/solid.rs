//! Shapes with an analytic clean surface, and noise on them.

use crate::{
    builtin::noise::uniform,
    primitives::{map_mesh, octasphere, torus},
};
use umbrage_core::glam::{IVec3, Vec3};
use umbrage_core::{Mesh, WeldedVertices};

/// A closed shape around the origin whose texture coordinates cover one square.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Solid {
    /// A ball.
    Sphere {
        /// Radius in metres, above 0.
        radius: f32,
    },
    /// A ring around the y axis.
    Torus {
        /// Distance from the axis to the centre of the tube, metres.
        major: f32,
        /// Radius of the tube, metres, below `major`.
        minor: f32,
    },
}

impl Solid {
    /// Returns about 4,000 (sphere) or 4,600 (torus) vertices on the clean surface, with clean
    /// normals and texture coordinates. Vertices are doubled at the seams of the texture and at the
    /// poles of the sphere.
    pub fn mesh(&self) -> Mesh {
        match *self {
            Self::Sphere { radius } => map_mesh(&octasphere(radius, 5)),
            Self::Torus { major, minor } => torus(major, minor, [96, 48]),
        }
    }

    /// Returns the distance from a point to the clean surface, metres, at least 0.
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

    /// Returns the mean of [`Solid::distance`] over the distinct positions of a mesh.
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

/// Returns the mesh with each position moved along its averaged normal by -`amplitude` to
/// `amplitude` metres. The offsets are uniform and depend only on the index of the position and
/// `seed`: they are equal on every machine. Shading normals are dropped, since they are those of
/// the clean shape.
pub fn roughen_mesh(mesh: &Mesh, amplitude: f32, seed: i32) -> Mesh {
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
