//! The meshes of a scene's instances, transformed to world space.

use crate::{
    geometry::displaced_mesh,
    invalid::Invalid,
    scene::{Instance, Mesh, Scene},
};
use glam::{Mat3, Vec2, Vec3, Vec4};

/// Material index of triangles whose instance has none:
/// [`Material::default`](crate::Material::default).
pub const NO_MATERIAL: u32 = u32::MAX;

/// Vertices and triangles in world space. See [`Geometry`](super::Geometry) for the lists.
#[derive(Debug, Default)]
pub(super) struct PlacedMeshes {
    pub(super) positions: Vec<Vec3>,
    pub(super) normals: Vec<Vec3>,
    pub(super) uvs: Vec<Vec2>,
    pub(super) tangents: Vec<Vec4>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) materials: Vec<u32>,
    /// Hash of positions and triangles.
    pub(super) hash: u64,
}

impl PlacedMeshes {
    /// Appends the triangles of the instances for which `wanted` is true.
    pub(super) fn append_all(
        &mut self,
        scene: &Scene,
        wanted: impl Fn(&Instance) -> bool,
    ) -> Result<(), Invalid> {
        for instance in &scene.instances {
            if wanted(instance) {
                self.append(scene, instance)?;
            }
        }
        Ok(())
    }

    /// Returns the id of the next triangle to be appended.
    pub(super) fn next_id(&self) -> u32 {
        self.triangles.len() as u32
    }

    fn append(&mut self, scene: &Scene, instance: &Instance) -> Result<(), Invalid> {
        let mesh = &*displaced_mesh::apply_displacement(scene, instance, self.triangles.len())?;
        let base = self.positions.len() as u32;
        let world_from_local = instance.world_from_local;
        for &p in &mesh.positions {
            self.positions.push(world_from_local.transform_point3(p));
        }
        let mirrored = world_from_local.matrix3.determinant() < 0.0;
        let first = self.triangles.len();
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|v| v + base);
            // A mirror turns counter-clockwise triangles clockwise.
            self.triangles
                .push(if mirrored { [a, c, b] } else { [a, b, c] });
        }
        self.append_normals(mesh, instance, first);
        self.append_attributes(mesh, instance, mirrored);
        Ok(())
    }

    fn append_normals(&mut self, mesh: &Mesh, instance: &Instance, first_triangle: usize) {
        if !mesh.normals.is_empty() {
            // Transform normals by the inverse transpose.
            let m = Mat3::from(instance.world_from_local.matrix3);
            let world_from_local = m.inverse().transpose();
            for &normal in &mesh.normals {
                self.normals
                    .push((world_from_local * normal).normalize_or_zero());
            }
            return;
        }
        // Weight by area: the cross product's length is twice the triangle's area.
        self.normals.resize(self.positions.len(), Vec3::ZERO);
        for triangle in &self.triangles[first_triangle..] {
            let [a, b, c] = triangle.map(|v| self.positions[v as usize]);
            let normal = (b - a).cross(c - a);
            for &v in triangle {
                self.normals[v as usize] += normal;
            }
        }
        let first = self.positions.len() - mesh.positions.len();
        for normal in &mut self.normals[first..] {
            *normal = normal.normalize_or_zero();
        }
    }

    /// Appends the attributes that only shading reads. Such an attribute stays empty until a mesh
    /// has it; earlier entries are then padded.
    fn append_attributes(&mut self, mesh: &Mesh, instance: &Instance, mirrored: bool) {
        let first = self.positions.len() - mesh.positions.len();
        if !mesh.uvs.is_empty() {
            self.uvs.resize(first, Vec2::ZERO);
            self.uvs.extend_from_slice(&mesh.uvs);
        }
        if !mesh.tangents.is_empty() {
            let m = Mat3::from(instance.world_from_local.matrix3);
            // A mirror keeps u and v on the surface, but flips n x t.
            let handedness = if mirrored { -1.0 } else { 1.0 };
            self.tangents.resize(first, Vec4::ZERO);
            for tangent in &mesh.tangents {
                let along_u = (m * tangent.truncate()).normalize_or_zero();
                self.tangents.push(along_u.extend(tangent.w * handedness));
            }
        }
        if let Some(material) = instance.material {
            self.materials
                .resize(self.triangles.len() - mesh.triangles.len(), NO_MATERIAL);
            self.materials.resize(self.triangles.len(), material as u32);
        }
    }

    /// Pads the attributes that some meshes have to the number of vertices or triangles, and
    /// computes the hash.
    pub(super) fn finish(&mut self) {
        let vertices = self.positions.len();
        let triangles = self.triangles.len();
        if !self.uvs.is_empty() {
            self.uvs.resize(vertices, Vec2::ZERO);
        }
        if !self.tangents.is_empty() {
            self.tangents.resize(vertices, Vec4::ZERO);
        }
        if !self.materials.is_empty() {
            self.materials.resize(triangles, NO_MATERIAL);
        }
        self.hash = self.content_hash();
    }

    fn content_hash(&self) -> u64 {
        let mut hash = FIRST_HASH;
        for position in &self.positions {
            for coordinate in position.to_array() {
                hash = hash_word(hash, coordinate.to_bits());
            }
        }
        for &vertex in self.triangles.iter().flatten() {
            hash = hash_word(hash, vertex);
        }
        hash
    }
}

/// The hash of an empty list.
const FIRST_HASH: u64 = 0xcbf2_9ce4_8422_2325;

/// Returns a hash with another word mixed in: FNV-1a (Fowler, Noll, Vo), a word at a time.
pub(super) fn hash_word(hash: u64, word: u32) -> u64 {
    (hash ^ u64::from(word)).wrapping_mul(0x0100_0000_01b3)
}
