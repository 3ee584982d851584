//! The casters of a light set: meshes in the caller's buffers, with their placements.
//!
//! Culling and drawing read plain arrays, with one entry per slot. The casters of a mesh have
//! consecutive slots, so that neighbours are drawn by one instanced draw.

use crate::{
    frame::{BufferedTriangles, Indices, VertexLayout},
    light_set::{
        culling::CullingBoxes,
        ids::{CasterKey, MeshKey},
        instances::{Columns, Instances},
        own_casters::OwnCasters,
        unknown,
    },
    resources::{counters::ResourceFactory, cut_outs::GpuCutOuts},
    wgsl::stages::HoleRule,
};
use glam::{Affine3A, Vec3};
use slotmap::SlotMap;
use std::ops::Range;
use umbrage_core::{Aabb, Invalid, Light, invalid};
use wgpu::{Buffer, IndexFormat, Limits, RenderPass};

/// Number of slots of a mesh with its first caster.
const FIRST_SLOTS: u32 = 4;
/// More than the rounding of distances between points.
const DISTANCE_SLACK: f32 = 0.999;
/// Number of frames without a move after which a caster counts as still.
const REST: u64 = 30;

/// Triangles in the caller's buffers, placed into the world by casters.
#[derive(Clone, Debug)]
pub struct CasterMesh<'a> {
    /// Name of the mesh in errors.
    pub label: &'a str,
    /// Vertices in a buffer of the set's device, usage `VERTEX`. For device-built hierarchies, both
    /// vertices and indices also need `STORAGE`. The set keeps the buffer alive as long as the mesh
    /// exists.
    pub vertices: &'a Buffer,
    /// Layout of the positions in the vertex buffer.
    pub layout: VertexLayout,
    /// Vertex indices; `None` if every three vertices are a triangle.
    pub indices: Option<Indices<'a>>,
    /// Range of indices to draw, or of vertices if there are no indices. Its length is a multiple
    /// of three.
    pub range: Range<u32>,
    /// Added to each index; less than the number of vertices in the buffer.
    pub base_vertex: i32,
    /// Box around the positions in the buffer. Casters outside a map are not drawn into it, so
    /// shadows are lost if the box is too small.
    pub bounds: Aabb,
}

/// A mesh, owned by the set.
#[derive(Debug)]
pub(crate) struct MeshDraw {
    pub(crate) label: String,
    pub(crate) vertices: Buffer,
    pub(crate) layout: VertexLayout,
    pub(crate) indices: Option<(Buffer, IndexFormat)>,
    pub(crate) range: Range<u32>,
    pub(crate) base_vertex: i32,
    bounds: Aabb,
    /// Alpha test of its triangles, if any. Shaders read such triangles from the lists of their
    /// geometry, in world space.
    pub(crate) holes: Option<HoleRule>,
}

/// A mesh, with the slots of its casters.
#[derive(Debug)]
pub(crate) struct MeshSlots {
    pub(crate) draw: MeshDraw,
    /// Slots reserved for the mesh.
    block: Range<u32>,
    /// The casters in the first of these slots, in order.
    casters: Vec<CasterKey>,
}

#[derive(Clone, Copy, Debug)]
struct CasterPlace {
    mesh: MeshKey,
    /// Index among the mesh's casters.
    index: u32,
    /// The frame of its last move.
    moved_in: u64,
}

/// All meshes and casters.
#[derive(Debug, Default)]
pub(crate) struct Casters {
    meshes: SlotMap<MeshKey, MeshSlots>,
    places: SlotMap<CasterKey, CasterPlace>,
    /// The casters that the program draws.
    pub(super) own: OwnCasters,
    /// Box of the caster in each slot. Slots without a caster have an empty box.
    boxes: CullingBoxes,
    /// Placement in each slot.
    columns: Vec<Columns>,
    /// The placements on the device.
    pub(super) instances: Instances,
    /// For each slot, whether the caster moved recently.
    moving: Vec<bool>,
    /// The casters that moved recently.
    moved_lately: Vec<CasterKey>,
    /// Frame counter.
    frame: u64,
    /// Boxes with changes.
    pub(super) changed: Vec<Aabb>,
    /// Boxes with changes among the still casters.
    still_changed: Vec<Aabb>,
    /// Slots whose placements changed.
    written: Vec<u32>,
    /// True if meshes or own casters were added or removed, or slots added, since changes were
    /// cleared. Pipelines and buffers may then have to be created.
    pub(super) has_grown: bool,
    /// True if casters were placed relative to another anchor since changes were cleared.
    pub(super) is_rebased: bool,
}

impl CasterMesh<'_> {
    fn validate(&self, limits: &Limits) -> Result<(), Invalid> {
        let triangles = BufferedTriangles {
            vertices: self.vertices,
            layout: self.layout,
            indices: self.indices,
            range: &self.range,
        };
        triangles.validate(limits)?;
        if self.indices.is_none() && self.base_vertex != 0 {
            let base = self.base_vertex;
            let why = format!("is {base}, but there are no indices");
            let help = "use 0, and shift the range";
            return Err(Invalid::new("base vertex", why, help));
        }
        self.check_base_vertex()?;
        self.bounds.validate()?;
        if self.bounds.is_empty() {
            let help = "use the box around the mesh's positions";
            return Err(Invalid::new("bounds", "are empty", help));
        }
        Ok(())
    }

    /// Errors if no index can refer to a vertex of the buffer. Only the device has the indices, so
    /// a base vertex that is wrong for some of them can't be found.
    fn check_base_vertex(&self) -> Result<(), Invalid> {
        let base = i64::from(self.base_vertex);
        let vertices = self.layout.vertices(self.vertices.size());
        let greatest_index = match self.indices {
            Some(Indices {
                format: IndexFormat::Uint16,
                ..
            }) => i64::from(u16::MAX),
            _ => i64::from(u32::MAX),
        };
        if base + greatest_index < 0 {
            let why = format!("is {base}, and indices are at most {greatest_index}");
            let help = "use the position of the mesh's first vertex in the buffer";
            return Err(Invalid::new("base vertex", why, help));
        }
        if base >= vertices as i64 && !self.range.is_empty() {
            let why = format!("is {base}, and the buffer holds {vertices} vertices");
            let help = "count vertices, not bytes or indices";
            return Err(Invalid::new("base vertex", why, help));
        }
        Ok(())
    }
}

impl MeshDraw {
    /// Returns the number of triangles per caster.
    pub(crate) fn triangles(&self) -> u64 {
        u64::from(self.range.end - self.range.start) / 3
    }

    /// Binds the mesh's buffers.
    pub(crate) fn bind(&self, pass: &mut RenderPass<'_>) {
        if self.holes.is_some() {
            return;
        }
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        if let Some((buffer, format)) = &self.indices {
            pass.set_index_buffer(buffer.slice(..), *format);
        }
    }

    /// Draws the casters in a range of slots.
    pub(crate) fn draw(&self, pass: &mut RenderPass<'_>, slots: Range<u32>) {
        match self.indices {
            Some(_) if self.holes.is_none() => {
                pass.draw_indexed(self.range.clone(), self.base_vertex, slots);
            }
            // Shaders read the indices of alpha-tested triangles themselves.
            _ => pass.draw(self.range.clone(), slots),
        }
    }
}

impl Casters {
    pub(crate) fn add_mesh(
        &mut self,
        mesh: &CasterMesh<'_>,
        limits: &Limits,
    ) -> Result<MeshKey, Invalid> {
        let name = || format!("mesh `{}`", mesh.label);
        mesh.validate(limits)
            .map_err(|e| e.within_context(name()))?;
        let draw = MeshDraw {
            label: mesh.label.to_owned(),
            vertices: mesh.vertices.clone(),
            layout: mesh.layout,
            indices: mesh.indices.map(|i| (i.buffer.clone(), i.format)),
            range: mesh.range.clone(),
            base_vertex: mesh.base_vertex,
            bounds: mesh.bounds,
            holes: None,
        };
        Ok(self.insert(draw))
    }

    /// Adds a part of the alpha-tested casters, which are in world space.
    ///
    /// Errors if its box is not finite.
    pub(crate) fn add_cut_outs(
        &mut self,
        lists: &GpuCutOuts,
        triangles: &Range<u32>,
        bounds: Aabb,
    ) -> Result<CasterKey, Invalid> {
        let mesh = self.insert(MeshDraw {
            label: "alpha-tested triangles".to_owned(),
            vertices: lists.positions.clone(),
            layout: VertexLayout::PACKED,
            indices: Some((lists.indices.clone(), IndexFormat::Uint32)),
            range: 3 * triangles.start..3 * triangles.end,
            base_vertex: 0,
            bounds,
            holes: Some(lists.rule()),
        });
        self.add(mesh, Affine3A::IDENTITY)
    }

    /// Removes a part added by [`add_cut_outs`](Self::add_cut_outs).
    pub(crate) fn remove_cut_outs(&mut self, id: CasterKey) -> Result<(), Invalid> {
        let place = *self.places.get(id).ok_or_else(|| unknown("caster"))?;
        self.remove(id)?;
        self.remove_mesh(place.mesh)
    }

    fn insert(&mut self, draw: MeshDraw) -> MeshKey {
        self.has_grown = true;
        self.meshes.insert(MeshSlots {
            draw,
            block: 0..0,
            casters: Vec::new(),
        })
    }

    /// Removes a mesh that has no casters.
    pub(crate) fn remove_mesh(&mut self, id: MeshKey) -> Result<(), Invalid> {
        let mesh = self.meshes.get(id).ok_or_else(|| unknown("mesh"))?;
        if !mesh.casters.is_empty() {
            let why = format!("has {} casters", mesh.casters.len());
            let what = format!("mesh `{}`", mesh.draw.label);
            return Err(Invalid::new(what, why, "remove its casters first"));
        }
        self.meshes.remove(id);
        // Without its buffers, the device may be able to build hierarchies.
        self.has_grown = true;
        Ok(())
    }

    pub(crate) fn add(
        &mut self,
        mesh_id: MeshKey,
        world_from_local: Affine3A,
    ) -> Result<CasterKey, Invalid> {
        let mesh = self.meshes.get(mesh_id).ok_or_else(|| unknown("mesh"))?;
        let bounds = world_bounds(&mesh.draw, &world_from_local)?;
        let index = mesh.casters.len() as u32;
        if index == mesh.block.end - mesh.block.start {
            self.grow(mesh_id);
        }
        let id = self.places.insert(CasterPlace {
            mesh: mesh_id,
            index,
            moved_in: 0,
        });
        // The mesh was found above.
        let mesh = &mut self.meshes[mesh_id];
        mesh.casters.push(id);
        let slot = mesh.block.start + index;
        self.put(slot, &bounds, &world_from_local);
        self.moving[slot as usize] = false;
        self.changed.push(bounds);
        self.still_changed.push(bounds);
        Ok(id)
    }

    pub(crate) fn place(
        &mut self,
        id: CasterKey,
        world_from_local: Affine3A,
    ) -> Result<(), Invalid> {
        let place = *self.places.get(id).ok_or_else(|| unknown("caster"))?;
        let mesh = &self.meshes[place.mesh];
        let slot = mesh.block.start + place.index;
        let columns = world_from_local.to_cols_array();
        if self.columns[slot as usize] == columns {
            return Ok(());
        }
        let bounds = world_bounds(&mesh.draw, &world_from_local)?;
        let before = self.boxes.get(slot);
        self.put(slot, &bounds, &world_from_local);
        self.changed.push(before);
        self.changed.push(bounds);
        self.places[id].moved_in = self.frame;
        if !self.moving[slot as usize] {
            // The caster leaves the still ones.
            self.moving[slot as usize] = true;
            self.moved_lately.push(id);
            self.still_changed.push(before);
        }
        Ok(())
    }

    /// Places a caster without recording a change: everything is redrawn. It keeps its state as
    /// still or moving.
    pub(crate) fn rebase(
        &mut self,
        id: CasterKey,
        world_from_local: Affine3A,
    ) -> Result<(), Invalid> {
        let place = self.places.get(id).ok_or_else(|| unknown("caster"))?;
        let mesh = &self.meshes[place.mesh];
        let slot = mesh.block.start + place.index;
        let bounds = world_bounds(&mesh.draw, &world_from_local)?;
        self.put(slot, &bounds, &world_from_local);
        self.is_rebased = true;
        Ok(())
    }

    pub(crate) fn remove(&mut self, id: CasterKey) -> Result<(), Invalid> {
        let place = self.places.remove(id).ok_or_else(|| unknown("caster"))?;
        let mesh = &mut self.meshes[place.mesh];
        let slot = mesh.block.start + place.index;
        let last = mesh.block.start + mesh.casters.len() as u32 - 1;
        mesh.casters.swap_remove(place.index as usize);
        let bounds = self.boxes.get(slot);
        self.changed.push(bounds);
        if self.moving[slot as usize] {
            self.moved_lately.retain(|other| *other != id);
        } else {
            self.still_changed.push(bounds);
        }
        if slot != last {
            // The last of the mesh's casters moves to the free slot.
            let moved = mesh.casters[place.index as usize];
            self.places[moved].index = place.index;
            self.boxes.copy(last, slot);
            self.columns[slot as usize] = self.columns[last as usize];
            self.moving[slot as usize] = self.moving[last as usize];
            self.written.push(slot);
        }
        self.boxes.set(last, &Aabb::EMPTY);
        Ok(())
    }

    /// Marks a box as changed.
    pub(crate) fn touch(&mut self, bounds: &Aabb) {
        self.changed.push(*bounds);
        self.still_changed.push(*bounds);
    }

    /// Begins a frame: casters that have not moved for a while count as still again.
    pub(crate) fn begin_frame(&mut self) {
        self.frame += 1;
        let frame = self.frame;
        let Self {
            meshes,
            places,
            boxes,
            moving,
            still_changed,
            ..
        } = self;
        self.moved_lately.retain(|&id| {
            let Some(place) = places.get(id) else {
                return false;
            };
            if frame - place.moved_in <= REST {
                return true;
            }
            let slot = meshes[place.mesh].block.start + place.index;
            moving[slot as usize] = false;
            // The caster joins the still ones.
            still_changed.push(boxes.get(slot));
            false
        });
    }

    /// Returns the box around all casters.
    pub(crate) fn bounds(&self) -> Aabb {
        self.boxes.around_all().union(&self.own.bounds())
    }

    /// Returns a lower bound of the distance from a light's position to a caster's box, metres; 0
    /// for lights without a position. It is a power of two, so it seldom changes when casters move.
    pub(crate) fn distance_from(&self, light: &Light) -> f32 {
        let Some(position) = light.position() else {
            return 0.0;
        };
        let distance = self
            .boxes
            .distance_from(position)
            .min(self.own.distance_from(position));
        power_of_two_below(distance * DISTANCE_SLACK)
    }

    /// Returns the changes since [`forget_changes`](Self::forget_changes).
    pub(crate) fn changed_boxes(&self) -> &[Aabb] {
        &self.changed
    }

    /// Returns the changes among the still casters since then.
    pub(crate) fn still_changed(&self) -> &[Aabb] {
        &self.still_changed
    }

    /// Returns, for each slot, whether the caster moved recently.
    pub(crate) fn moving_flags(&self) -> &[bool] {
        &self.moving
    }

    pub(crate) fn forget_changes(&mut self) {
        self.changed.clear();
        self.still_changed.clear();
        self.has_grown = false;
        self.is_rebased = false;
    }

    /// Returns whether casters were rebased since [`forget_changes`](Self::forget_changes).
    pub(crate) fn is_rebased(&self) -> bool {
        self.is_rebased
    }

    /// Returns whether meshes or slots were added since [`forget_changes`](Self::forget_changes).
    pub(crate) fn has_grown(&self) -> bool {
        self.has_grown
    }

    /// Uploads the placements that changed. Returns the number of bytes.
    pub(crate) fn upload(&mut self, factory: &mut ResourceFactory<'_>) -> u64 {
        let bytes = self.instances.upload(factory, &self.columns, &self.written);
        self.written.clear();
        bytes
    }

    pub(crate) fn boxes(&self) -> &CullingBoxes {
        &self.boxes
    }

    /// Returns each mesh with the slots of its casters.
    pub(crate) fn meshes(&self) -> impl Iterator<Item = (MeshKey, &MeshSlots)> {
        self.meshes.iter()
    }

    pub(crate) fn mesh(&self, id: MeshKey) -> Option<&MeshDraw> {
        self.meshes.get(id).map(|mesh| &mesh.draw)
    }

    /// Returns the number of casters, the program's own included.
    pub(crate) fn count(&self) -> usize {
        self.places.len() + self.own.count()
    }

    fn put(&mut self, slot: u32, bounds: &Aabb, world_from_local: &Affine3A) {
        self.boxes.set(slot, bounds);
        self.columns[slot as usize] = world_from_local.to_cols_array();
        self.written.push(slot);
    }

    /// Doubles the slots of a mesh. Unless it is the last one, it moves behind all others, and its
    /// old slots stay empty.
    fn grow(&mut self, id: MeshKey) {
        self.has_grown = true;
        let mesh = &mut self.meshes[id];
        let old = mesh.block.clone();
        let count = (2 * (old.end - old.start)).max(FIRST_SLOTS);
        let slots = self.columns.len() as u32;
        let stays = old.end == slots && !old.is_empty();
        let first = if stays { old.start } else { slots };
        mesh.block = first..first + count;
        self.columns
            .resize((first + count) as usize, Columns::default());
        self.moving.resize((first + count) as usize, false);
        self.boxes.grow(first + count);
        if stays {
            return;
        }
        for (from, to) in old.zip(first..) {
            self.boxes.copy(from, to);
            self.boxes.set(from, &Aabb::EMPTY);
            self.columns[to as usize] = self.columns[from as usize];
            self.moving[to as usize] = self.moving[from as usize];
            self.written.push(to);
        }
    }
}

impl MeshSlots {
    /// Returns the slots with casters.
    pub(crate) fn slots(&self) -> Range<u32> {
        self.block.start..self.block.start + self.casters.len() as u32
    }
}

/// Returns the greatest power of two that is not above a positive number; 0 for subnormal ones.
fn power_of_two_below(x: f32) -> f32 {
    // Keep the exponent.
    f32::from_bits(x.to_bits() & 0x7f80_0000)
}

/// Returns the box around a placed mesh.
///
/// Errors if a number of the placement or of the box is not finite.
fn world_bounds(mesh: &MeshDraw, world_from_local: &Affine3A) -> Result<Aabb, Invalid> {
    // Transform the half extents by the matrix's absolute values (Arvo 1990, "Transforming
    // axis-aligned bounding boxes").
    let centre = world_from_local.transform_point3(mesh.bounds.center());
    let half = mesh.bounds.extent() * 0.5;
    let matrix = world_from_local.matrix3;
    let reach = Vec3::from(matrix.x_axis.abs()) * half.x
        + Vec3::from(matrix.y_axis.abs()) * half.y
        + Vec3::from(matrix.z_axis.abs()) * half.z;
    let bounds = Aabb {
        min: centre - reach,
        max: centre + reach,
    };
    // Each number of the placement is a term of the box, and 0 times infinity is NaN: a finite box
    // has a finite placement.
    if !(bounds.min.is_finite() && bounds.max.is_finite()) {
        let placement = invalid::finite("world from local", &world_from_local.to_cols_array());
        let checked = placement.and_then(|()| bounds.validate());
        checked.map_err(|e| e.within_context(format!("caster of mesh `{}`", mesh.label)))?;
    }
    Ok(bounds)
}

#[cfg(test)]
mod tests {
    use super::power_of_two_below;

    #[test]
    fn powers_of_two_are_below() {
        for (x, expected) in [(0.0, 0.0), (1.0, 1.0), (3.99, 2.0), (4.0, 4.0), (0.3, 0.25)] {
            assert_eq!(power_of_two_below(x), expected, "{x}");
        }
        assert_eq!(power_of_two_below(f32::INFINITY), f32::INFINITY);
    }
}
