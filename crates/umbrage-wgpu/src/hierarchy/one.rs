//! The hierarchy of one recipe, which contains the casters' corners.

use crate::{
    hierarchy::{
        layout::HierarchyLayout,
        passes::{
            Hierarchy, HierarchyInput, HierarchyPasses, capacity_for, why_not_built, why_too_large,
        },
    },
    resources::{bindings::Bound, counters::ResourceFactory, pipelines::Pipelines},
};
use std::sync::Arc;
use umbrage_core::{DeviceHierarchy, Invalid, Recipe, TableId};
use wgpu::{Buffer, BufferUsages, CommandEncoder, ComputePassTimestampWrites, Limits};

/// Bytes of a row.
const ROW: u64 = 16;

/// The hierarchy of a recipe, if it has one. It is built in every frame, as maps are drawn.
#[derive(Debug, Default)]
pub(crate) struct RecipeHierarchy {
    passes: HierarchyPasses,
    hierarchy: Hierarchy,
    /// `None` if the recipe has no hierarchy.
    tables: Option<HierarchyTables>,
}

/// A recipe's tables of the hierarchy and of the corners, in one buffer.
#[derive(Debug)]
struct HierarchyTables {
    ids: [TableId; DeviceHierarchy::TABLES],
    buffer: Buffer,
    /// First row of the corners in the buffer.
    first_corner: u32,
    /// The corners in the buffer, kept so that their address is not reused.
    corners: Arc<[[u32; 4]]>,
}

/// Returns a recipe's tables of the hierarchy and of the corners.
fn table_ids(recipe: &Recipe) -> Option<[TableId; DeviceHierarchy::TABLES]> {
    recipe.hierarchy.as_ref()?;
    recipe.receive.tables.first_chunk().copied()
}

/// Returns the first row of the corners behind a hierarchy. It is at a valid offset of a binding.
fn first_corner_row(layout: &HierarchyLayout, limits: &Limits) -> u32 {
    let alignment = u64::from(limits.min_storage_buffer_offset_alignment).div_ceil(ROW);
    layout.rows().next_multiple_of(alignment as u32)
}

/// Errors if a device with these limits can't build the hierarchy of a valid recipe.
pub(crate) fn check_hierarchy(recipe: &Recipe, limits: &Limits) -> Result<(), Invalid> {
    let (Some(made), Some([_, corners])) = (&recipe.hierarchy, table_ids(recipe)) else {
        return Ok(());
    };
    let Some(corners) = recipe.tables.get(corners) else {
        return Ok(());
    };
    let rows = corners.rows().len() as u64;
    let casters = rows / 3;
    let too_large = || {
        let casters = casters as u32;
        let layout = HierarchyLayout::new(capacity_for(casters, made.faces, 0));
        let bytes = ROW * (u64::from(first_corner_row(&layout, limits)) + rows);
        why_too_large(&layout, bytes, casters, limits)
    };
    let Some(why) = why_not_built(casters, limits).or_else(too_large) else {
        return Ok(());
    };
    let help = "use a technique without a hierarchy (`exact` with `ExactStructure::Lists`), or another device";
    let why = format!("can't be executed on this device: {why}");
    Err(Invalid::new("recipe", why, help))
}

impl RecipeHierarchy {
    /// Creates and writes what the passes need; drops it if the recipe has no hierarchy.
    pub(crate) fn prepare(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        recipe: &Recipe,
    ) {
        let (Some(made), Some(ids)) = (&recipe.hierarchy, table_ids(recipe)) else {
            *self = Self::default();
            return;
        };
        // Choose the sizes.
        let corners = recipe.tables[ids[1]].rows();
        let casters = (corners.len() / 3) as u32;
        let held_capacity = self.hierarchy.layout().capacity;
        let layout = HierarchyLayout::new(capacity_for(casters, made.faces, held_capacity));
        self.hierarchy.resize(layout, casters, made.faces);
        let first_corner = first_corner_row(&layout, &factory.device.limits());
        // Upload the corners, unless the buffer contains them.
        let held = self.tables.take();
        let is_known = held.as_ref().is_some_and(|held| {
            Arc::ptr_eq(&held.corners, corners) && held.first_corner == first_corner
        });
        let tables = match held {
            Some(held) if is_known => HierarchyTables { ids, ..held },
            held => HierarchyTables::upload(factory, held, ids, first_corner, corners),
        };
        // Write the inputs of the passes.
        if self.passes.fit_scratch(factory, [layout].into_iter()) {
            self.hierarchy.drop_binding();
        }
        let input = HierarchyInput {
            hierarchy: &mut self.hierarchy,
            made,
            nodes: 0,
            corners: first_corner,
        };
        self.passes
            .prepare(factory, pipelines, &tables.buffer, vec![input]);
        self.tables = Some(tables);
    }

    /// Returns the binding of a table of the recipe, if the hierarchy contains it.
    pub(crate) fn table(&self, id: TableId) -> Option<Bound> {
        let tables = self.tables.as_ref()?;
        let corners = ROW * u64::from(tables.first_corner);
        let range = match tables.ids.iter().position(|&table| table == id)? {
            0 => 0..corners,
            _ => corners..tables.buffer.size(),
        };
        Some(Bound::Part(tables.buffer.clone(), range))
    }

    /// Returns whether the recipe has a hierarchy.
    pub(crate) fn has_passes(&self) -> bool {
        self.tables.is_some()
    }

    /// Records the passes, if there are any.
    pub(crate) fn encode(
        &self,
        encoder: &mut CommandEncoder,
        timestamp_writes: Option<ComputePassTimestampWrites<'_>>,
    ) {
        if self.has_passes() {
            self.passes
                .encode(encoder, &self.hierarchy, timestamp_writes, |_| ());
        }
    }

    /// Returns the bytes of all buffers, without those of the corners.
    pub(crate) fn bytes(&self) -> u64 {
        let tables = self.tables.as_ref();
        let hierarchy = tables.map_or(0, |tables| ROW * u64::from(tables.first_corner));
        hierarchy + self.passes.scratch_bytes()
    }
}

impl HierarchyTables {
    /// Uploads the corners to the buffer of `held` if it has the same size, or to another one.
    fn upload(
        factory: &mut ResourceFactory<'_>,
        held: Option<Self>,
        ids: [TableId; DeviceHierarchy::TABLES],
        first_corner: u32,
        corners: &Arc<[[u32; 4]]>,
    ) -> Self {
        let offset = ROW * u64::from(first_corner);
        let bytes: &[u8] = bytemuck::cast_slice(corners);
        let size = offset + bytes.len() as u64;
        let kept = held.map(|held| held.buffer);
        let buffer = kept
            .filter(|buffer| buffer.size() == size)
            .unwrap_or_else(|| factory.buffer("umbrage hierarchy", BufferUsages::STORAGE, size));
        factory.queue.write_buffer(&buffer, offset, bytes);
        Self {
            ids,
            buffer,
            first_corner,
            corners: corners.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{ROW, first_corner_row};
    use crate::hierarchy::layout::HierarchyLayout;
    use wgpu::Limits;

    #[test]
    fn corners_begin_behind_the_hierarchy_at_a_valid_offset() {
        for capacity in [1, 7, 1000, 12_345] {
            let layout = HierarchyLayout::new(capacity);
            for alignment in [4, 16, 32, 64, 256] {
                let limits = Limits {
                    min_storage_buffer_offset_alignment: alignment,
                    ..Limits::default()
                };
                let row = first_corner_row(&layout, &limits);
                assert!(row >= layout.rows(), "{capacity}, {alignment}");
                let offset = ROW * u64::from(row);
                assert!(
                    offset.is_multiple_of(alignment.into()),
                    "{capacity}, {alignment}"
                );
            }
        }
    }
}
