//! A scene's triangles in world space: the one list that truth and every backend share.

use crate::{Aabb, Bvh, Instance, Invalid, Mesh, Scene};
use glam::Vec3;
use std::{
    ops::Range,
    sync::{Arc, OnceLock},
};

/// World-space triangles, ordered so that casters and receivers are each one contiguous range.
#[derive(Clone, Debug, Default)]
pub struct Geometry {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    casters: Range<u32>,
    receivers: Range<u32>,
    fingerprint: u64,
    bvh: OnceLock<Arc<Bvh>>,
    bvh_tables: OnceLock<[Rows; 2]>,
}

/// Rows of four words, as shaders' tables hold them.
type Rows = Arc<[[u32; 4]]>;

impl Geometry {
    /// Places every instance of a scene into the world. Mirroring instances keep their outside out.
    ///
    /// # Errors
    /// As [`Scene::validate`]; and when a placement leaves the range of `f32`.
    pub fn bake(scene: &Scene) -> Result<Self, Invalid> {
        scene.validate()?;
        let mut out = Self::default();
        let mut ends = [0_u32; 4];
        for (end, class) in ends.iter_mut().zip([(true, false), (true, true), (false, true), (false, false)]) {
            for instance in scene.instances.iter().filter(|i| (i.casts, i.receives) == class) {
                out.append(&scene.meshes[instance.mesh], instance);
            }
            *end = out.triangles.len() as u32;
        }
        (out.casters, out.receivers) = (0..ends[1], ends[0]..ends[2]);
        match out.positions.iter().position(|p| !p.is_finite()) {
            None => {
                out.fingerprint = out.hash();
                Ok(out)
            }
            Some(i) => Err(Invalid::new(
                format!("scene `{}`, world vertex {i}", scene.name),
                format!("is {}", out.positions[i]),
                "use smaller matrices: the product left the range of 32-bit floats",
            )),
        }
    }

    fn append(&mut self, mesh: &Mesh, instance: &Instance) {
        let base = self.positions.len() as u32;
        let world_from_local = instance.world_from_local;
        self.positions.extend(mesh.positions.iter().map(|&p| world_from_local.transform_point3(p)));
        let mirrored = world_from_local.matrix3.determinant() < 0.0;
        self.triangles.extend(mesh.triangles.iter().map(|t| {
            let t = t.map(|v| v + base);
            if mirrored { [t[0], t[2], t[1]] } else { t }
        }));
        let first = self.triangles.len() - mesh.triangles.len();
        self.append_normals(mesh, instance, first);
    }

    fn append_normals(&mut self, mesh: &Mesh, instance: &Instance, first_triangle: usize) {
        if !mesh.normals.is_empty() {
            let m = glam::Mat3::from(instance.world_from_local.matrix3);
            let cofactors = m.inverse().transpose();
            return self.normals.extend(mesh.normals.iter().map(|&n| (cofactors * n).normalize_or_zero()));
        }
        // Area-weighted: the cross product's length is twice the triangle's area.
        self.normals.resize(self.positions.len(), Vec3::ZERO);
        for t in &self.triangles[first_triangle..] {
            let [a, b, c] = t.map(|v| self.positions[v as usize]);
            let n = (b - a).cross(c - a);
            t.iter().for_each(|&v| self.normals[v as usize] += n);
        }
        let first = self.positions.len() - mesh.positions.len();
        self.normals[first..].iter_mut().for_each(|n| *n = n.normalize_or_zero());
    }

    /// FNV-1a over the bits of all that the backends draw.
    fn hash(&self) -> u64 {
        let words = self.positions.iter().flat_map(|p| p.to_array().map(f32::to_bits));
        let words = words.chain(self.triangles.iter().flatten().copied());
        let words = words.chain([self.casters.start, self.casters.end, self.receivers.start, self.receivers.end]);
        words.fold(0xcbf2_9ce4_8422_2325, |h, w| (h ^ u64::from(w)).wrapping_mul(0x0100_0000_01b3))
    }

    /// The same triangles, none of which casts: the negative control of every comparison.
    #[must_use]
    pub fn without_casters(&self) -> Self {
        let mut out = Self { casters: 0..0, bvh: OnceLock::new(), bvh_tables: OnceLock::new(), ..self.clone() };
        out.fingerprint = out.hash();
        out
    }

    /// World positions of the vertices, metres.
    pub fn positions(&self) -> &[Vec3] {
        &self.positions
    }

    /// World-space unit shading normals, one a vertex; zero where no triangle gives one.
    pub fn normals(&self) -> &[Vec3] {
        &self.normals
    }

    /// Vertex indices of all triangles. A triangle's place in this list is its id everywhere.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Ids of the triangles that cast.
    pub fn casters(&self) -> Range<u32> {
        self.casters.clone()
    }

    /// Ids of the triangles that receive.
    pub fn receivers(&self) -> Range<u32> {
        self.receivers.clone()
    }

    /// The corners of a triangle.
    ///
    /// # Panics
    /// If there is no such triangle.
    pub fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.triangles[triangle as usize].map(|v| self.positions[v as usize])
    }

    /// The vertices of a range of triangles, each as often as it is used.
    pub fn vertices_of(&self, triangles: Range<u32>) -> impl Iterator<Item = Vec3> + '_ {
        let range = triangles.start as usize..triangles.end as usize;
        self.triangles[range].iter().flatten().map(|&v| self.positions[v as usize])
    }

    /// The box around everything.
    pub fn bounds(&self) -> Aabb {
        Aabb::around(self.positions.iter().copied())
    }

    /// The box around the casters.
    pub fn caster_bounds(&self) -> Aabb {
        Aabb::around(self.vertices_of(self.casters()))
    }

    /// Tells geometries apart: equal for bit-equal triangles in the same order with the same roles.
    pub fn fingerprint(&self) -> u64 {
        self.fingerprint
    }

    /// The hierarchy over the casters, built on first use (the one costly step of ray tracing).
    pub fn bvh(&self) -> &Arc<Bvh> {
        self.bvh.get_or_init(|| Arc::new(Bvh::build(self)))
    }

    /// [`Bvh::node_rows`] and [`Bvh::triangle_rows`], made on first use and shared from then on.
    pub fn bvh_tables(&self) -> &[Rows; 2] {
        self.bvh_tables.get_or_init(|| {
            let bvh = self.bvh();
            [bvh.node_rows().into(), bvh.triangle_rows(self).into()]
        })
    }
}
