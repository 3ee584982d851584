//! Subdivision of meshes without a change of shape.

use crate::{
    invalid::Invalid,
    scene::{Mesh, material::MAX_SUBDIVISIONS},
};
use glam::{Vec3, Vec4};
use std::collections::HashMap;

/// Greatest number of triangles after subdivision: their positions, normals and hierarchy fit into
/// a few gigabytes.
pub const MAX_SUBDIVIDED_TRIANGLES: usize = 1 << 24;

impl Mesh {
    /// Splits each triangle in four at the midpoints of its edges, `times` times, without
    /// smoothing. Triangles that share an edge share the new vertex. Where two edges share only
    /// their ends' positions, the new vertices' positions are bit-equal. Texture coordinates are
    /// interpolated; normals and tangents are interpolated and normalized.
    ///
    /// # Errors
    /// Errors if the result would have more than [`MAX_SUBDIVIDED_TRIANGLES`].
    pub fn subdivide(&self, times: u32) -> Result<Self, Invalid> {
        self.check_subdivisions(times, MAX_SUBDIVIDED_TRIANGLES)?;
        let mut mesh = self.clone();
        for _ in 0..times {
            mesh = mesh.split();
        }
        Ok(mesh)
    }

    /// Errors if the result would have more than `room` triangles.
    pub(crate) fn check_subdivisions(&self, times: u32, room: usize) -> Result<(), Invalid> {
        let count = self.subdivided_count(times);
        if times == 0 || times <= MAX_SUBDIVISIONS && count <= room as u128 {
            return Ok(());
        }
        let most = (0..=MAX_SUBDIVISIONS)
            .rev()
            .find(|&fewer| self.subdivided_count(fewer) <= room as u128)
            .unwrap_or(0);
        let why = format!(
            "would have {count} triangles after {times} subdivisions of {}, and at most {room} fit",
            self.triangles.len()
        );
        Err(Invalid::new(
            format!("mesh `{}`", self.name),
            why,
            format!("use at most {most} subdivisions"),
        ))
    }

    /// Returns the number of triangles after some subdivisions: each multiplies it by four. Beyond
    /// 60 subdivisions the number is constant, to avoid overflow.
    fn subdivided_count(&self, times: u32) -> u128 {
        (self.triangles.len() as u128) << (2 * times.min(60))
    }

    /// Splits each triangle in four.
    fn split(mut self) -> Self {
        // Index of the midpoint of each edge, keyed by its vertices, the least first.
        let mut middles = HashMap::with_capacity(self.triangles.len() * 3 / 2);
        let coarse = std::mem::take(&mut self.triangles);
        self.triangles.reserve_exact(4 * coarse.len());
        for [a, b, c] in coarse {
            let ab = self.middle(a, b, &mut middles);
            let bc = self.middle(b, c, &mut middles);
            let ca = self.middle(c, a, &mut middles);
            self.triangles.push([a, ab, ca]);
            self.triangles.push([b, bc, ab]);
            self.triangles.push([c, ca, bc]);
            self.triangles.push([ab, bc, ca]);
        }
        self
    }

    /// Returns the index of the midpoint of an edge. Adds the vertex if `middles` doesn't contain
    /// it.
    fn middle(&mut self, p: u32, q: u32, middles: &mut HashMap<(u32, u32), u32>) -> u32 {
        *middles
            .entry((p.min(q), p.max(q)))
            .or_insert_with(|| self.push_middle(p, q))
    }

    /// Adds the midpoint of two vertices, and returns its index.
    fn push_middle(&mut self, p: u32, q: u32) -> u32 {
        let p = p as usize;
        let q = q as usize;
        // Halve before adding: the sum may exceed the range of f32.
        self.positions
            .push(self.positions[p] * 0.5 + self.positions[q] * 0.5);
        if !self.normals.is_empty() {
            self.normals
                .push(edge_midpoint(self.normals[p], self.normals[q]));
        }
        if !self.uvs.is_empty() {
            self.uvs.push(self.uvs[p] * 0.5 + self.uvs[q] * 0.5);
        }
        if !self.tangents.is_empty() {
            let t = self.tangents[p];
            let u = self.tangents[q];
            let direction: Vec3 = edge_midpoint(t.truncate(), u.truncate());
            self.tangents.push(Vec4::from((direction, t.w)));
        }
        (self.positions.len() - 1) as u32
    }
}

/// Returns the unit vector halfway between two directions of any length; zero if they are opposite.
fn edge_midpoint(a: Vec3, b: Vec3) -> Vec3 {
    (a.normalize_or_zero() + b.normalize_or_zero()).normalize_or_zero()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    fn bent_mesh() -> Mesh {
        Mesh {
            name: "bent".to_owned(),
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y],
            normals: vec![Vec3::Z, Vec3::X * 2.0, Vec3::Z, Vec3::Z],
            uvs: vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y],
            tangents: vec![Vec4::new(1.0, 0.0, 0.0, -1.0); 4],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
        }
    }

    fn area(mesh: &Mesh) -> f32 {
        mesh.triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
                0.5 * (b - a).cross(c - a).z
            })
            .sum()
    }

    #[test]
    fn four_for_one_with_shared_edges() {
        let fine = bent_mesh().subdivide(1).unwrap();
        fine.validate().unwrap();
        assert_eq!(
            (fine.triangles.len(), fine.positions.len()),
            (8, 9),
            "the common edge has one midpoint"
        );
        assert_eq!(area(&fine), 1.0);
        let twice = bent_mesh().subdivide(3).unwrap();
        assert_eq!((twice.triangles.len(), twice.positions.len()), (128, 81));
        assert!(twice.triangles.iter().all(|t| area(&Mesh {
            triangles: vec![*t],
            ..twice.clone()
        }) > 0.0));
    }

    #[test]
    fn attributes_are_blended() {
        let fine = bent_mesh().subdivide(1).unwrap();
        let middle = fine
            .positions
            .iter()
            .position(|p| *p == Vec3::X * 0.5)
            .unwrap();
        assert!(
            fine.normals[middle].distance(Vec3::new(1.0, 0.0, 1.0).normalize()) < 1e-6,
            "each has the same weight"
        );
        assert_eq!(
            (fine.uvs[middle], fine.tangents[middle]),
            (Vec2::X * 0.5, Vec4::new(1.0, 0.0, 0.0, -1.0))
        );
    }

    #[test]
    fn too_many_are_refused_with_what_would_do() {
        let error = bent_mesh().subdivide(9).unwrap_err().to_string();
        assert!(
            error.contains("mesh `bent`: would have 524288 triangles after 9 subdivisions of 2"),
            "{error}"
        );
        let error = bent_mesh()
            .check_subdivisions(5, 600)
            .unwrap_err()
            .to_string();
        assert!(
            error.ends_with("at most 600 fit; use at most 4 subdivisions"),
            "{error}"
        );
        assert!(bent_mesh().subdivide(u32::MAX).is_err());
    }
}
