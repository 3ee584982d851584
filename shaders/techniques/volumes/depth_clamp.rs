//! Depth clamping for faces that extend beyond all geometry. Parts beyond a plane across the view
//! are flattened onto it, along the view. Without perspective they keep their image position, and
//! closed surfaces stay closed.

use crate::techniques::infinite_far::FarClampPlane;
use glam::DVec3;
use std::collections::HashMap;
use umbrage_core::Faces;

/// Returns the faces with all parts beyond the clamp plane flattened onto it.
pub(crate) fn flatten(faces: &Faces, clamp_plane: &FarClampPlane) -> Faces {
    let vertices: Vec<DVec3> = faces
        .vertices
        .iter()
        .map(|v| v.as_dvec4().truncate())
        .collect();
    let before: Vec<f64> = vertices
        .iter()
        .map(|v| clamp_plane.distance - clamp_plane.depth.dot(v.extend(1.0)))
        .collect();
    let mut cutter = Cutter {
        clamp_plane,
        vertices,
        before,
        flat: HashMap::new(),
        cuts: HashMap::new(),
    };
    let mut triangles = Vec::with_capacity(faces.triangles.len());
    for &triangle in &faces.triangles {
        cutter.add(triangle, &mut triangles);
    }
    Faces {
        vertices: cutter
            .vertices
            .iter()
            .map(|v| v.as_vec3().extend(1.0))
            .collect(),
        triangles,
    }
}

struct Cutter<'a> {
    clamp_plane: &'a FarClampPlane,
    vertices: Vec<DVec3>,
    /// Distances of the given vertices before the clamp plane, metres; negative beyond it.
    before: Vec<f64>,
    /// Flattened vertices by their original index.
    flat: HashMap<u32, u32>,
    /// Vertices on the clamp plane, by the edge cut there.
    cuts: HashMap<[u32; 2], u32>,
}

impl Cutter<'_> {
    fn is_before(&self, v: u32) -> bool {
        self.before[v as usize] >= 0.0
    }

    /// Adds the part of a triangle before the clamp plane, and the rest flattened.
    fn add(&mut self, triangle: [u32; 3], out: &mut Vec<[u32; 3]>) {
        if triangle.iter().all(|&v| self.is_before(v)) {
            return out.push(triangle);
        }
        let mut near = Vec::with_capacity(4);
        let mut far = Vec::with_capacity(4);
        for i in 0..3 {
            let v = triangle[i];
            let next = triangle[(i + 1) % 3];
            if self.is_before(v) {
                near.push(v);
            } else {
                far.push(self.flatten_vertex(v));
            }
            if self.is_before(v) != self.is_before(next) {
                let cut = self.cut([v.min(next), v.max(next)]);
                near.push(cut);
                far.push(cut);
            }
        }
        for polygon in [near, far] {
            out.extend((2..polygon.len()).map(|i| [polygon[0], polygon[i - 1], polygon[i]]));
        }
    }

    fn flatten_vertex(&mut self, v: u32) -> u32 {
        if let Some(&known) = self.flat.get(&v) {
            return known;
        }
        let along = self.clamp_plane.forward * self.before[v as usize];
        let flat = self.push(self.vertices[v as usize] + along);
        self.flat.insert(v, flat);
        flat
    }

    fn cut(&mut self, edge: [u32; 2]) -> u32 {
        if let Some(&known) = self.cuts.get(&edge) {
            return known;
        }
        let [p, q] = edge.map(|v| self.vertices[v as usize]);
        let [distance_p, distance_q] = edge.map(|v| self.before[v as usize].abs());
        let cut = self.push((p * distance_q + q * distance_p) / (distance_p + distance_q));
        self.cuts.insert(edge, cut);
        cut
    }

    fn push(&mut self, v: DVec3) -> u32 {
        self.vertices.push(v);
        self.vertices.len() as u32 - 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec4, Vec4};

    const BACKDROP: FarClampPlane = FarClampPlane {
        forward: DVec3::NEG_Z,
        depth: DVec4::new(0.0, 0.0, -1.0, 0.0),
        distance: 10.0,
    };

    #[test]
    fn what_is_before_stays() {
        let vertices = vec![
            Vec4::new(0.0, 0.0, -1.0, 1.0),
            Vec4::new(1.0, 0.0, -9.0, 1.0),
            Vec4::new(0.0, 1.0, 5.0, 1.0),
        ];
        let faces = Faces {
            vertices,
            triangles: vec![[0, 1, 2]],
        };
        assert_eq!(flatten(&faces, &BACKDROP), faces);
    }

    /// A slanted wall from two points 4 m away to one 14 m away is cut at 10 m, at x = 12, and flat
    /// beyond.
    #[test]
    fn walls_beyond_are_cut_and_laid_flat() {
        let vertices = vec![
            Vec4::new(0.0, 0.0, -4.0, 1.0),
            Vec4::new(0.0, 1.0, -4.0, 1.0),
            Vec4::new(20.0, 0.0, -14.0, 1.0),
        ];
        let out = flatten(
            &Faces {
                vertices,
                triangles: vec![[0, 1, 2]],
            },
            &BACKDROP,
        );
        let at = |i: u32| out.vertices[i as usize];
        assert_eq!(out.triangles.len(), 3);
        let beyond = out.triangles.iter().flatten().filter(|&&v| -at(v).z > 10.0);
        assert_eq!(beyond.count(), 0, "{out:?}");
        for expected in [
            Vec4::new(12.0, 0.0, -10.0, 1.0),
            Vec4::new(12.0, 0.4, -10.0, 1.0),
            Vec4::new(20.0, 0.0, -10.0, 1.0),
        ] {
            let is_there = |v: &Vec4| v.distance(expected) < 1e-5;
            assert!(out.vertices.iter().any(is_there), "{expected}: {out:?}");
        }
    }
}
