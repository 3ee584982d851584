//! Vertices that share a position. Meshes duplicate vertices at seams of texture coordinates or
//! normals.

use crate::scene::Mesh;
use glam::{DVec3, Vec3};
use std::collections::HashMap;

/// Vertices grouped by position. Vertices at bit-equal positions share a group (zeros of both signs
/// are equal).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct WeldedVertices {
    /// The group of each vertex.
    group_of: Vec<u32>,
    /// Vertices, sorted by group.
    order: Vec<u32>,
    /// First index of each group in `order`, followed by the length of `order`.
    starts: Vec<u32>,
}

impl WeldedVertices {
    /// Groups vertices. Groups are numbered in the order of their first vertices.
    pub fn new(positions: &[Vec3]) -> Self {
        let mut known = HashMap::with_capacity(positions.len());
        let mut group_of = Vec::with_capacity(positions.len());
        for position in positions {
            // Add 0 to make -0 positive.
            let key = position.to_array().map(|x| (x + 0.0).to_bits());
            let next = known.len() as u32;
            group_of.push(*known.entry(key).or_insert(next));
        }
        // Count the vertices of each group, then compute running sums.
        let mut starts = vec![0_u32; known.len() + 1];
        for &place in &group_of {
            starts[place as usize + 1] += 1;
        }
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        let mut order: Vec<u32> = (0..positions.len() as u32).collect();
        order.sort_by_key(|&v| group_of[v as usize]);
        Self {
            group_of,
            order,
            starts,
        }
    }

    /// Returns the number of groups.
    pub fn count(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Returns the group of each vertex.
    pub fn group_of(&self) -> &[u32] {
        &self.group_of
    }

    /// Returns the vertices of a group, in order.
    ///
    /// # Panics
    /// Panics if there is no such group.
    pub fn vertices(&self, place: u32) -> &[u32] {
        let start = self.starts[place as usize];
        let end = self.starts[place as usize + 1];
        &self.order[start as usize..end as usize]
    }

    /// Returns, for each vertex, the mean of the values of all vertices at its position. `values`
    /// has one entry per vertex.
    pub fn shared_mean(&self, values: &[Vec3]) -> Vec<Vec3> {
        let mut means = Vec::with_capacity(self.count());
        for place in 0..self.count() as u32 {
            let vertices = self.vertices(place);
            let sum: Vec3 = vertices.iter().map(|&v| values[v as usize]).sum();
            means.push(sum / vertices.len() as f32);
        }
        self.group_of
            .iter()
            .map(|&place| means[place as usize])
            .collect()
    }

    /// Returns the unit normals of the groups, averaged by area from the triangles around them;
    /// zero if these have none.
    pub fn normals(&self, mesh: &Mesh) -> Vec<Vec3> {
        let mut sums = vec![DVec3::ZERO; self.count()];
        for (v, n) in corner_normals(mesh) {
            sums[self.group_of[v as usize] as usize] += n;
        }
        sums.into_iter().map(unit).collect()
    }
}

/// Returns every corner's vertex and its triangle's normal, whose length is twice the triangle's
/// area. In f64, since the squares of the smallest triangles leave the range of f32.
pub(crate) fn corner_normals(mesh: &Mesh) -> impl Iterator<Item = (u32, DVec3)> + '_ {
    mesh.triangles.iter().flat_map(|t| {
        let [a, b, c] = t.map(|v| mesh.positions[v as usize].as_dvec3());
        let n = (b - a).cross(c - a);
        t.map(|v| (v, n))
    })
}

/// Returns a unit vector in 32 bits; zero for zero.
pub(crate) fn unit(v: DVec3) -> Vec3 {
    v.normalize_or_zero().as_vec3()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_positions_are_one_place() {
        let places = WeldedVertices::new(&[
            Vec3::X,
            Vec3::ZERO,
            Vec3::X,
            Vec3::Y,
            -Vec3::ZERO,
            Vec3::X * 1.000_001,
        ]);
        assert_eq!(places.group_of(), [0, 1, 0, 2, 1, 3]);
        assert_eq!(
            (places.vertices(0), places.vertices(1), places.count()),
            (&[0, 2][..], &[1, 4][..], 4)
        );
        assert_eq!(WeldedVertices::new(&[]).count(), 0);
    }

    #[test]
    fn means_are_shared_within_places_alone() {
        let places = WeldedVertices::new(&[Vec3::X, Vec3::Y, Vec3::X]);
        let means = places.shared_mean(&[Vec3::ONE, Vec3::Z, Vec3::splat(3.0)]);
        assert_eq!(means, [Vec3::splat(2.0), Vec3::Z, Vec3::splat(2.0)]);
    }

    #[test]
    fn normals_weigh_by_area_across_seams() {
        // Two triangles that meet at a right angle in an edge with duplicated vertices; one has
        // three times the area.
        let positions = [
            Vec3::ZERO,
            Vec3::X,
            Vec3::Y,
            Vec3::ZERO,
            Vec3::Z * 3.0,
            Vec3::X,
        ]
        .to_vec();
        let mesh = Mesh::new("hinge", positions, vec![[0, 1, 2], [3, 4, 5]]).unwrap();
        let normals = WeldedVertices::new(&mesh.positions).normals(&mesh);
        let expected = Vec3::new(0.0, 3.0, 1.0).normalize();
        // Both are rounded once from f64.
        assert!(normals[0].distance(expected) < 1e-6, "{normals:?}");
        assert_eq!(normals[2], Vec3::Z);
    }
}
