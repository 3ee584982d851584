//! World-space triangles of a scene: one list, shared by truth and every backend.

pub(crate) mod aabb;
pub(crate) mod box_tree;
pub mod bvh;
#[doc(hidden)]
pub mod clip_polygon;
pub mod cut_out;
mod derived;
pub(crate) mod displaced_mesh;
pub mod displacement;
pub mod hashed_alpha;
mod placed;
#[cfg(test)]
mod random;
pub(crate) mod ray_box;
pub(crate) mod ray_triangle;
pub(crate) mod segment_lanes;
#[cfg(feature = "serde")]
mod serialized;
#[cfg(feature = "rays")]
pub(crate) mod shaft;
pub(crate) mod subdivide;
pub(crate) mod weld;

pub use crate::geometry::placed::NO_MATERIAL;

#[cfg(feature = "rays")]
use crate::geometry::bvh::Bvh;
use crate::{
    geometry::{
        aabb::Aabb,
        box_tree::{BoxTree, RUN},
        cut_out::CutOuts,
        derived::Derived,
        placed::PlacedMeshes,
    },
    invalid::Invalid,
    parallel::prelude::*,
    scene::{Instance, Scene, material::AlphaCutout},
};
use glam::{DVec3, Vec2, Vec3, Vec4};
use std::{
    any::Any,
    collections::BTreeMap,
    ops::Range,
    sync::{Arc, OnceLock},
};

/// Triangles per box of [`Geometry::run_boxes`]; the last box may have fewer.
pub const TRIANGLES_A_RUN: u32 = RUN;

/// World-space triangles, ordered so that casters and receivers are each one contiguous range.
/// Clones share the triangles.
///
/// `serde` writes the triangles, without values computed on first use. The deserialized geometry
/// has the same [fingerprint](Geometry::fingerprint).
#[derive(Clone, Debug, Default)]
pub struct Geometry {
    placed: Arc<PlacedMeshes>,
    casters: Range<u32>,
    receivers: Range<u32>,
    /// Alpha-tested casters and other triangles; `None` if all are opaque.
    cut_outs: Option<Arc<CutOuts>>,
    fingerprint: u64,
    #[cfg(feature = "rays")]
    bvh: OnceLock<Arc<Bvh>>,
    #[cfg(feature = "rays")]
    bvh_tables: OnceLock<[SharedRows; 2]>,
    bounds: OnceLock<Aabb>,
    box_tree: OnceLock<Arc<BoxTree>>,
    receiver_reach: OnceLock<f32>,
    derived: Derived,
}

/// Instances whose triangles are contiguous.
struct Group {
    casts: bool,
    receives: bool,
    has_holes: bool,
}

/// Order of the triangles. Casters and receivers are each one range, and the ranges overlap.
/// Alpha-tested triangles form two runs. One joins the last cast-only triangles and the first that
/// do both. The other joins the last receive-only triangles and the first that do neither.
#[rustfmt::skip]
const GROUPS: [Group; 8] = [
    Group { casts: true, receives: false, has_holes: false },
    Group { casts: true, receives: false, has_holes: true },
    Group { casts: true, receives: true, has_holes: true },
    Group { casts: true, receives: true, has_holes: false },
    Group { casts: false, receives: true, has_holes: false },
    Group { casts: false, receives: true, has_holes: true },
    Group { casts: false, receives: false, has_holes: true },
    Group { casts: false, receives: false, has_holes: false },
];

impl Group {
    /// `has_holes` is the result of [`materials_with_holes`].
    fn has(&self, instance: &Instance, has_holes: &[bool]) -> bool {
        instance.casts == self.casts
            && instance.receives == self.receives
            && instance.material.is_some_and(|id| has_holes[id]) == self.has_holes
    }
}

/// Table rows of four words, for shaders.
#[cfg(feature = "rays")]
type SharedRows = Arc<[[u32; 4]]>;

impl Geometry {
    /// Transforms every instance of a scene to world space, and displaces it if its material
    /// requires it. Mirrored instances keep their orientation.
    ///
    /// # Errors
    /// Errors if [`Scene::validate`] does, if subdivision results in too many triangles, if an
    /// alpha texture with holes is too large, or if a transformed vertex exceeds the range of
    /// `f32`.
    pub fn bake(scene: &Scene) -> Result<Self, Invalid> {
        scene.validate()?;
        let mut placed = PlacedMeshes::default();
        let mut starts = [0; GROUPS.len() + 1];
        let has_holes = materials_with_holes(scene);
        for (i, group) in GROUPS.iter().enumerate() {
            placed.append_all(scene, |instance| group.has(instance, &has_holes))?;
            starts[i + 1] = placed.next_id();
        }
        placed.finish();
        if let Some(i) = placed.positions.iter().position(|p| !p.is_finite()) {
            return Err(Invalid::new(
                format!("scene `{}`, world vertex {i}", scene.name),
                format!("is {}", placed.positions[i]),
                "use smaller matrices: the product exceeds the range of 32-bit floats",
            ));
        }
        // Positions of these ranges in `GROUPS`.
        let casters = starts[0]..starts[4];
        let receivers = starts[2]..starts[6];
        let runs_with_holes = [starts[1]..starts[3], starts[5]..starts[7]];
        let mut out = Self {
            cut_outs: CutOuts::new(scene, &placed, runs_with_holes)?,
            placed: Arc::new(placed),
            casters,
            receivers,
            ..Self::default()
        };
        out.fingerprint = out.hash();
        Ok(out)
    }

    /// Returns a hash of everything that the backends draw.
    fn hash(&self) -> u64 {
        let mut hash = self.placed.hash;
        for end in [
            self.casters.start,
            self.casters.end,
            self.receivers.start,
            self.receivers.end,
        ] {
            hash = placed::hash_word(hash, end);
        }
        if let Some(cut_outs) = &self.cut_outs {
            for &word in cut_outs.rows().as_flattened() {
                hash = placed::hash_word(hash, word);
            }
            for &word in cut_outs
                .coverage_rows()
                .iter()
                .flat_map(|rows| rows.as_flattened())
            {
                hash = placed::hash_word(hash, word);
            }
        }
        hash
    }

    /// Returns the same triangles without casters: the negative control of every comparison.
    #[must_use]
    pub fn without_casters(&self) -> Self {
        let mut out = Self {
            casters: 0..0,
            #[cfg(feature = "rays")]
            bvh: OnceLock::new(),
            #[cfg(feature = "rays")]
            bvh_tables: OnceLock::new(),
            derived: Derived::default(),
            ..self.clone()
        };
        out.fingerprint = out.hash();
        out
    }

    /// Returns the same triangles without the hierarchies built so far, for benchmarks of work done
    /// once per scene.
    #[must_use]
    pub fn without_hierarchies(&self) -> Self {
        Self {
            #[cfg(feature = "rays")]
            bvh: OnceLock::new(),
            #[cfg(feature = "rays")]
            bvh_tables: OnceLock::new(),
            bounds: OnceLock::new(),
            box_tree: OnceLock::new(),
            receiver_reach: OnceLock::new(),
            derived: Derived::default(),
            ..self.clone()
        }
    }

    /// Returns the world positions of the vertices, metres.
    pub fn positions(&self) -> &[Vec3] {
        &self.placed.positions
    }

    /// Returns the world-space unit shading normals, one per vertex; zero for vertices whose
    /// triangles have no area.
    pub fn normals(&self) -> &[Vec3] {
        &self.placed.normals
    }

    /// Returns the texture coordinates, one per vertex, origin top left. Empty if no mesh has any,
    /// zero for meshes that have none.
    pub fn uvs(&self) -> &[Vec2] {
        &self.placed.uvs
    }

    /// Returns the world-space tangents, one per vertex: xyz of unit length along growing u, w the
    /// handedness (bitangent = w n x t). Empty if no mesh has any, zero for meshes that have none.
    pub fn tangents(&self) -> &[Vec4] {
        &self.placed.tangents
    }

    /// Returns indices into [`Scene::materials`], one per triangle, [`NO_MATERIAL`] for the default
    /// material. Empty if no instance has a material.
    pub fn materials(&self) -> &[u32] {
        &self.placed.materials
    }

    /// Returns the vertex indices of all triangles. A triangle's index in this list is its id
    /// everywhere.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.placed.triangles
    }

    /// Returns the vertex indices of a range of triangles.
    ///
    /// Panics if the range exceeds the list.
    pub fn run(&self, run: &Range<u32>) -> &[[u32; 3]] {
        &self.placed.triangles[run.start as usize..run.end as usize]
    }

    /// Returns the alpha-tested triangles; `None` if all are opaque.
    pub fn cut_outs(&self) -> Option<&Arc<CutOuts>> {
        self.cut_outs.as_ref()
    }

    /// Returns whether any caster is alpha-tested.
    pub fn has_cut_out_casters(&self) -> bool {
        let casters = self.casters();
        self.cut_outs.as_ref().is_some_and(|cut_outs| {
            let mut runs = cut_outs.runs().iter();
            runs.any(|run| run.start.max(casters.start) < run.end.min(casters.end))
        })
    }

    /// Returns whether a triangle's alpha texture has holes. They may be outside the triangle's
    /// uvs.
    #[inline]
    pub fn has_holes(&self, triangle: u32) -> bool {
        let cut_outs = self.cut_outs.as_ref();
        cut_outs.is_some_and(|cut_outs| cut_outs.record_row(triangle).is_some())
    }

    /// Returns the ids of the casters.
    pub fn casters(&self) -> Range<u32> {
        self.casters.clone()
    }

    /// Returns the opaque casters, as rising ranges of ids.
    pub fn casters_without_holes(&self) -> Vec<Range<u32>> {
        let casters = self.casters();
        match &self.cut_outs {
            Some(cut_outs) => {
                let [whole, _] = cut_outs.split(std::slice::from_ref(&casters));
                whole
            }
            None => Vec::from([casters]),
        }
    }

    /// Returns the ids of the receivers.
    pub fn receivers(&self) -> Range<u32> {
        self.receivers.clone()
    }

    /// Returns the corners of a triangle.
    ///
    /// # Panics
    /// Panics if there is no such triangle.
    #[inline]
    pub fn corners(&self, triangle: u32) -> [Vec3; 3] {
        let [a, b, c] = self.placed.triangles[triangle as usize];
        let positions = &self.placed.positions;
        [
            positions[a as usize],
            positions[b as usize],
            positions[c as usize],
        ]
    }

    /// Returns the vertices of a range of triangles, repeated if shared.
    pub fn vertices_of(&self, triangles: Range<u32>) -> impl Iterator<Item = Vec3> + '_ {
        let range = triangles.start as usize..triangles.end as usize;
        self.placed.triangles[range]
            .iter()
            .flatten()
            .map(|&v| self.placed.positions[v as usize])
    }

    /// Returns the box around all triangles, computed on first use.
    pub fn bounds(&self) -> Aabb {
        *self
            .bounds
            .get_or_init(|| Aabb::from_points(self.placed.positions.iter().copied()))
    }

    /// Returns the box around the casters. Its parts are computed on first use.
    pub fn caster_bounds(&self) -> Aabb {
        self.bounds_of(self.casters())
    }

    /// Returns the box around a range of triangles.
    pub(crate) fn bounds_of(&self, triangles: Range<u32>) -> Aabb {
        let first_whole_run = triangles.start.next_multiple_of(RUN);
        let count = self.placed.triangles.len() as u32;
        // The last run of the list may be shorter.
        let end_of_whole_runs = if triangles.end == count {
            count
        } else {
            triangles.end / RUN * RUN
        };
        if first_whole_run >= end_of_whole_runs {
            return Aabb::from_points(self.vertices_of(triangles));
        }
        let before = Aabb::from_points(self.vertices_of(triangles.start..first_whole_run));
        let whole = self
            .box_tree()
            .enclosing_box(first_whole_run..end_of_whole_runs);
        let after = Aabb::from_points(self.vertices_of(end_of_whole_runs..triangles.end));
        before.union(&whole).union(&after)
    }

    /// Returns a hash that is equal for bit-equal triangles in the same order with the same roles,
    /// and differs otherwise.
    pub fn fingerprint(&self) -> u64 {
        self.fingerprint
    }

    /// Returns the hierarchy over the casters, built on first use: the expensive step of ray
    /// tracing.
    #[cfg(feature = "rays")]
    pub fn bvh(&self) -> &Arc<Bvh> {
        self.bvh.get_or_init(|| Arc::new(Bvh::build(self)))
    }

    /// Returns a value computed by `make` from the triangles, and cached by type. Use it for data
    /// that depends on no light or camera, such as welded edges. `make` must not request the same
    /// type.
    pub fn derive_once<T: Any + Send + Sync>(&self, make: impl FnOnce(&Self) -> T) -> Arc<T> {
        self.derived.get_or_make(|| make(self))
    }

    /// Returns the greatest length of a receiving triangle whose rounding moves receivers off its
    /// plane, metres; computed on first use. It is at most the triangle's extent along an axis, and
    /// 0 for triangles across an axis, whatever their extent.
    pub fn receiver_reach(&self) -> f32 {
        *self.receiver_reach.get_or_init(|| {
            let receivers = self.receivers().into_par_iter();
            let reaches = receivers.map(|id| plane_reach(self.corners(id)));
            reaches.reduce(|| 0.0, f32::max)
        })
    }

    /// Returns the boxes around runs of [`TRIANGLES_A_RUN`] triangles, computed on first use.
    pub fn run_boxes(&self) -> &[Aabb] {
        self.box_tree().runs()
    }

    /// Returns the boxes around runs of triangles, built on first use.
    pub(crate) fn box_tree(&self) -> &BoxTree {
        self.box_tree
            .get_or_init(|| Arc::new(BoxTree::of_triangles(self)))
    }

    /// Returns the number of triangle tests by fits so far.
    #[cfg(feature = "testing")]
    pub fn triangles_looked_at(&self) -> u64 {
        self.box_tree().box_count()
    }

    /// Returns [`Bvh::node_rows`] and [`Bvh::triangle_rows`], computed on first use and then
    /// shared.
    #[cfg(feature = "rays")]
    pub fn bvh_tables(&self) -> &[SharedRows; 2] {
        self.bvh_tables.get_or_init(|| {
            let bvh = self.bvh();
            [bvh.node_rows().into(), bvh.triangle_rows(self).into()]
        })
    }
}

/// Returns, for each material of a valid scene, whether its alpha texture has a hole: a texel below
/// the cut-off. Without one, every [`AlphaFilter`](crate::AlphaFilter) returns opaque: the nearest
/// texel is opaque, and the coverage is 1 on all levels, which no threshold exceeds. Such a
/// material is therefore baked as one without alpha.
fn materials_with_holes(scene: &Scene) -> Vec<bool> {
    // Cache by texture: materials often share one, and textures have millions of texels.
    let mut known: BTreeMap<(usize, u32), bool> = BTreeMap::new();
    let mut has_holes = |alpha: &AlphaCutout| {
        let key = (alpha.texture, alpha.cutoff.to_bits());
        *known.entry(key).or_insert_with(|| {
            let texels = &scene.textures[alpha.texture].texels;
            let indices = 0..texels.len();
            !indices
                .into_par_iter()
                .all(|i| alpha.is_there(&texels.get(i)))
        })
    };
    let materials = scene.materials.iter();
    materials
        .map(|material| material.alpha.as_ref().is_some_and(&mut has_holes))
        .collect()
}

/// Returns the greatest length of a triangle whose rounding moves points off its plane, metres.
///
/// A point's distance from the plane is a sum over the axes of a component of the normal times a
/// difference of coordinates. Rounding moves a component by a few parts of the two products that it
/// is the difference of. These are 0 for an axis within the plane if the triangle is across another
/// axis: large differences along it then move nothing.
fn plane_reach(corners: [Vec3; 3]) -> f32 {
    // In 64 bits, since squares of the cross product may overflow 32.
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    let u = (b - a).abs();
    let v = (c - a).abs();
    // Sums of the normal's products, where the cross product has differences.
    let products = DVec3::new(
        u.y * v.z + u.z * v.y,
        u.z * v.x + u.x * v.z,
        u.x * v.y + u.y * v.x,
    );
    let weights = products / (b - a).cross(c - a).length();
    let farthest = weights.dot(u).max(weights.dot(v)) as f32;
    let bounds = Aabb::from_points(corners);
    let extent = (bounds.max - bounds.min).max_element();
    // Triangles without area have no normal: `min` ignores NaN.
    farthest.min(extent)
}

#[cfg(test)]
#[path = "geometry_tests.rs"]
mod tests;
