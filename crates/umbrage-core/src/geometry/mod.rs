//! A scene's triangles in world space: the one list that truth and every backend share.

pub(crate) mod aabb;
pub(crate) mod box_tree;
pub mod bvh;
pub(crate) mod clip_polygon;
mod derived;
pub(crate) mod displaced_mesh;
pub mod displacement;
pub(crate) mod ray_box;
pub(crate) mod ray_triangle;
pub(crate) mod subdivide;
pub(crate) mod weld;

use crate::{
    Aabb, Bvh, Instance, Invalid, Mesh, Scene,
    geometry::{
        box_tree::{BoxTree, RUN},
        derived::Derived,
    },
};
use glam::{Mat3, Vec2, Vec3, Vec4};
use rayon::prelude::*;
use std::{
    any::Any,
    ops::Range,
    sync::{Arc, OnceLock},
};

/// The material of triangles whose instance names none: [`Material::default`](crate::Material::default).
pub const NO_MATERIAL: u32 = u32::MAX;

/// World-space triangles, ordered so that casters and receivers are each one contiguous range.
#[derive(Clone, Debug, Default)]
pub struct Geometry {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    uvs: Vec<Vec2>,
    tangents: Vec<Vec4>,
    triangles: Vec<[u32; 3]>,
    materials: Vec<u32>,
    casters: Range<u32>,
    receivers: Range<u32>,
    fingerprint: u64,
    bvh: OnceLock<Arc<Bvh>>,
    bvh_tables: OnceLock<[Rows; 2]>,
    bounds: OnceLock<Aabb>,
    box_tree: OnceLock<Arc<BoxTree>>,
    max_receiver_extent: OnceLock<f32>,
    derived: Derived,
}

/// Rows of four words, as shaders' tables hold them.
type Rows = Arc<[[u32; 4]]>;

impl Geometry {
    /// Places every instance of a scene into the world, displaced if its material says so. Mirroring instances keep their
    /// outside out.
    ///
    /// # Errors
    /// Errors if [`Scene::validate`] does; if subdivisions make too many triangles; and if a placement leaves the range of `f32`.
    pub fn bake(scene: &Scene) -> Result<Self, Invalid> {
        scene.validate()?;
        let mut out = Self::default();
        // In this order, casters and receivers are each one range, which overlap.
        out.append_all(scene, |i| i.casts && !i.receives)?;
        let first_receiver = out.triangles.len() as u32;
        out.append_all(scene, |i| i.casts && i.receives)?;
        let end_of_casters = out.triangles.len() as u32;
        out.append_all(scene, |i| !i.casts && i.receives)?;
        let end_of_receivers = out.triangles.len() as u32;
        out.append_all(scene, |i| !i.casts && !i.receives)?;
        out.pad_attributes();
        out.casters = 0..end_of_casters;
        out.receivers = first_receiver..end_of_receivers;
        if let Some(i) = out.positions.iter().position(|p| !p.is_finite()) {
            return Err(Invalid::new(
                format!("scene `{}`, world vertex {i}", scene.name),
                format!("is {}", out.positions[i]),
                "use smaller matrices: the product left the range of 32-bit floats",
            ));
        }
        out.fingerprint = out.hash();
        Ok(out)
    }

    /// Appends the triangles of the instances for which `wanted` is true.
    fn append_all(
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

    fn append(&mut self, scene: &Scene, instance: &Instance) -> Result<(), Invalid> {
        let mesh = &*displaced_mesh::applied(scene, instance, self.triangles.len())?;
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
            // Normals stay normal under the inverse transpose.
            let m = Mat3::from(instance.world_from_local.matrix3);
            let world_from_local = m.inverse().transpose();
            for &normal in &mesh.normals {
                self.normals
                    .push((world_from_local * normal).normalize_or_zero());
            }
            return;
        }
        // Area-weighted: the cross product's length is twice the triangle's area.
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

    /// Appends what only shading reads. Such an attribute stays empty until a mesh has it; what came before is padded then.
    fn append_attributes(&mut self, mesh: &Mesh, instance: &Instance, mirrored: bool) {
        let first = self.positions.len() - mesh.positions.len();
        if !mesh.uvs.is_empty() {
            self.uvs.resize(first, Vec2::ZERO);
            self.uvs.extend_from_slice(&mesh.uvs);
        }
        if !mesh.tangents.is_empty() {
            let m = Mat3::from(instance.world_from_local.matrix3);
            // A mirror keeps u and v where they are on the surface, but turns n x t around.
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

    /// Makes attributes that some meshes have as long as the lists of vertices or triangles.
    fn pad_attributes(&mut self) {
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
    }

    /// Returns a hash of all that the backends draw: FNV-1a (Fowler, Noll, Vo), a word at a time.
    fn hash(&self) -> u64 {
        let mut hash = 0xcbf2_9ce4_8422_2325_u64;
        let mut add = |word: u32| hash = (hash ^ u64::from(word)).wrapping_mul(0x0100_0000_01b3);
        for position in &self.positions {
            add(position.x.to_bits());
            add(position.y.to_bits());
            add(position.z.to_bits());
        }
        for &vertex in self.triangles.iter().flatten() {
            add(vertex);
        }
        add(self.casters.start);
        add(self.casters.end);
        add(self.receivers.start);
        add(self.receivers.end);
        hash
    }

    /// Returns the same triangles, none of which casts: the negative control of every comparison.
    #[must_use]
    pub fn without_casters(&self) -> Self {
        let mut out = Self {
            casters: 0..0,
            bvh: OnceLock::new(),
            bvh_tables: OnceLock::new(),
            derived: Derived::default(),
            ..self.clone()
        };
        out.fingerprint = out.hash();
        out
    }

    /// Returns the same triangles without the hierarchies that were built over them, as if they had just been placed: for those
    /// who time what is built once a scene.
    #[must_use]
    pub fn without_hierarchies(&self) -> Self {
        Self {
            bvh: OnceLock::new(),
            bvh_tables: OnceLock::new(),
            bounds: OnceLock::new(),
            box_tree: OnceLock::new(),
            ..self.clone()
        }
    }

    /// World positions of the vertices, metres.
    pub fn positions(&self) -> &[Vec3] {
        &self.positions
    }

    /// World-space unit shading normals, one a vertex; zero where no triangle gives one.
    pub fn normals(&self) -> &[Vec3] {
        &self.normals
    }

    /// Texture coordinates, one a vertex, origin top left; empty when no mesh has any, zero where a mesh has none.
    pub fn uvs(&self) -> &[Vec2] {
        &self.uvs
    }

    /// World-space tangents, one a vertex: xyz of unit length along growing u, w the handedness (bitangent = w n x t);
    /// empty when no mesh has any, zero where a mesh has none.
    pub fn tangents(&self) -> &[Vec4] {
        &self.tangents
    }

    /// Indices into [`Scene::materials`], one a triangle, [`NO_MATERIAL`] for the default one; empty when no instance
    /// names any.
    pub fn materials(&self) -> &[u32] {
        &self.materials
    }

    /// Vertex indices of all triangles. A triangle's place in this list is its id everywhere.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Returns the vertex indices of a range of triangles.
    ///
    /// Panics if the range reaches beyond the list.
    pub fn run(&self, run: &Range<u32>) -> &[[u32; 3]] {
        &self.triangles[run.start as usize..run.end as usize]
    }

    /// Ids of the triangles that cast.
    pub fn casters(&self) -> Range<u32> {
        self.casters.clone()
    }

    /// Ids of the triangles that receive.
    pub fn receivers(&self) -> Range<u32> {
        self.receivers.clone()
    }

    /// Returns the corners of a triangle.
    ///
    /// # Panics
    /// Panics if there is no such triangle.
    pub fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.triangles[triangle as usize].map(|v| self.positions[v as usize])
    }

    /// Returns the vertices of a range of triangles, each as often as it is used.
    pub fn vertices_of(&self, triangles: Range<u32>) -> impl Iterator<Item = Vec3> + '_ {
        let range = triangles.start as usize..triangles.end as usize;
        self.triangles[range]
            .iter()
            .flatten()
            .map(|&v| self.positions[v as usize])
    }

    /// Returns the box around everything. It is found on first use.
    pub fn bounds(&self) -> Aabb {
        *self
            .bounds
            .get_or_init(|| Aabb::around(self.positions.iter().copied()))
    }

    /// Returns the box around the casters. The boxes that it is made of are found on first use.
    pub fn caster_bounds(&self) -> Aabb {
        self.bounds_of(self.casters())
    }

    /// Returns the box around a range of triangles.
    pub(crate) fn bounds_of(&self, triangles: Range<u32>) -> Aabb {
        let first_whole_run = triangles.start.next_multiple_of(RUN);
        let count = self.triangles.len() as u32;
        // The last run of the list may be shorter.
        let end_of_whole_runs = if triangles.end == count {
            count
        } else {
            triangles.end / RUN * RUN
        };
        if first_whole_run >= end_of_whole_runs {
            return Aabb::around(self.vertices_of(triangles));
        }
        let before = Aabb::around(self.vertices_of(triangles.start..first_whole_run));
        let whole = self.box_tree().around(first_whole_run..end_of_whole_runs);
        let after = Aabb::around(self.vertices_of(end_of_whole_runs..triangles.end));
        before.union(&whole).union(&after)
    }

    /// Returns a number that is equal for bit-equal triangles in the same order with the same roles, and otherwise differs.
    pub fn fingerprint(&self) -> u64 {
        self.fingerprint
    }

    /// Returns the hierarchy over the casters, which is built on first use (the one costly step of ray tracing).
    pub fn bvh(&self) -> &Arc<Bvh> {
        self.bvh.get_or_init(|| Arc::new(Bvh::build(self)))
    }

    /// Returns what `make` makes of the triangles: once for each type, and from then on the same. It is for what techniques need
    /// again and again and no light or camera changes, such as welded edges. `make` must not ask for the same type.
    pub fn derived<T: Any + Send + Sync>(&self, make: impl FnOnce(&Self) -> T) -> Arc<T> {
        self.derived.get_or_make(|| make(self))
    }

    /// Returns the greatest extent of a receiving triangle along an axis, metres; found on first use.
    pub fn max_receiver_extent(&self) -> f32 {
        *self.max_receiver_extent.get_or_init(|| {
            let extents = self.receivers().into_par_iter().map(|id| {
                let bounds = Aabb::around(self.corners(id));
                (bounds.max - bounds.min).max_element()
            });
            extents.reduce(|| 0.0, f32::max)
        })
    }

    /// Returns the boxes around runs of triangles, built on first use.
    pub(crate) fn box_tree(&self) -> &BoxTree {
        self.box_tree
            .get_or_init(|| Arc::new(BoxTree::of_triangles(self)))
    }

    /// Returns how many triangles fits looked at one by one so far, each as often as they did.
    #[cfg(feature = "testing")]
    pub fn triangles_looked_at(&self) -> u64 {
        self.box_tree().counted()
    }

    /// Returns [`Bvh::node_rows`] and [`Bvh::triangle_rows`], made on first use and shared from then on.
    pub fn bvh_tables(&self) -> &[Rows; 2] {
        self.bvh_tables.get_or_init(|| {
            let bvh = self.bvh();
            [bvh.node_rows().into(), bvh.triangle_rows(self).into()]
        })
    }
}

#[cfg(test)]
#[path = "geometry_tests.rs"]
mod tests;
