//! Shadow volumes of a silhouette, as faces to draw.
//!
//! Crow 1977, "Shadow algorithms for computer graphics"; McGuire, Hughes, Egan, Kilgard and Everitt 2003, "Fast,
//! practical and robust shadows": walls from edges to infinity, and caps at both ends. Infinity is one point for a
//! directional light, so that its walls are triangles and there is nothing to cap there.

use crate::silhouette::{Silhouette, Welded};
use glam::{DVec4, Vec4};
use umbrage_core::Faces;

/// The volumes' faces, counter-clockwise seen from outside. Each wall comes as often as its edge counts.
pub(crate) fn extrude(mesh: &Welded, silhouette: &Silhouette, light: DVec4) -> Faces {
    let far = Far { first: mesh.positions.len() as u32, is_one_point: light.w == 0.0 };
    let mut faces = Faces { vertices: mesh.positions.iter().map(|p| p.extend(1.0)).collect(), triangles: Vec::new() };
    let away = |p: &glam::Vec3| (p.as_dvec3() * light.w - light.truncate()).as_vec3().extend(0.0);
    if far.is_one_point {
        faces.vertices.push((-light).as_vec4());
    } else {
        faces.vertices.extend(mesh.positions.iter().map(away));
    }
    for cap in &silhouette.caps {
        far.add_caps(cap.corners, &mut faces.triangles);
    }
    for &(edge, count) in &silhouette.edges {
        (0..count).for_each(|_| far.add_wall(edge, &mut faces.triangles));
    }
    faces
}

/// The caps that the scene does not have as they are.
pub(crate) fn caps_apart(mesh: &Welded, silhouette: &Silhouette) -> Faces {
    let apart = silhouette.caps.iter().filter(|cap| !cap.in_scene);
    let triangles: Vec<[u32; 3]> = apart.map(|cap| cap.corners).collect();
    let point = |p: &glam::Vec3| -> Vec4 { p.extend(1.0) };
    let vertices = if triangles.is_empty() { Vec::new() } else { mesh.positions.iter().map(point).collect() };
    Faces { vertices, triangles }
}

/// Where the points at infinity are among the vertices.
struct Far {
    first: u32,
    is_one_point: bool,
}

impl Far {
    fn of(&self, near: u32) -> u32 {
        if self.is_one_point { self.first } else { self.first + near }
    }

    fn add_caps(&self, [a, b, c]: [u32; 3], triangles: &mut Vec<[u32; 3]>) {
        triangles.push([a, b, c]);
        if !self.is_one_point {
            triangles.push([self.of(a), self.of(c), self.of(b)]);
        }
    }

    /// The cap has the edge from `a` to `b`, so the wall next to it has it from `b` to `a`.
    fn add_wall(&self, [a, b]: [u32; 2], triangles: &mut Vec<[u32; 3]>) {
        triangles.push([b, a, self.of(a)]);
        if !self.is_one_point {
            triangles.push([b, self.of(a), self.of(b)]);
        }
    }
}
