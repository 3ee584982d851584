//! World-space corners of all casters, computed by the device: the input of hierarchies.

use crate::{
    frame::PositionFormat,
    hierarchy::passes::{corner_rows, group_counts},
    light_set::{
        casters::{Casters, MeshDraw, MeshSlots},
        ids::MeshKey,
    },
    resources::{
        bindings::{Binding, Bound, Slot},
        counters::ResourceFactory,
        pipelines::{Pipelines, compute_pipeline, shader},
        windows::Windows,
    },
    wgsl::stages::shader_of,
};
use slotmap::SecondaryMap;
use std::num::NonZeroU64;
use umbrage_core::CutOuts;
use wgpu::{Buffer, BufferUsages, ComputePass, ComputePipeline, IndexFormat, Limits, ShaderStages};

/// Bytes of `PlacedMesh` in corners.wgsl.
const NUMBERS: NonZeroU64 = NonZeroU64::new(44).unwrap();

/// Transforms the casters of all meshes to world space.
#[derive(Debug, Default)]
pub(crate) struct CornerStage {
    pipeline: Option<ComputePipeline>,
    numbers: Windows,
    bindings: SecondaryMap<MeshKey, Binding>,
    /// The meshes that have casters, in order, with their numbers of triangles.
    placed: Vec<(MeshKey, u32)>,
}

/// Returns the number of triangles of all casters, counting each placement.
pub(crate) fn triangle_count(casters: &Casters) -> u64 {
    casters.meshes().map(|(_, mesh)| triangles_of(mesh)).sum()
}

fn triangles_of(mesh: &MeshSlots) -> u64 {
    mesh.draw.triangles() * mesh.slots().len() as u64
}

impl CornerStage {
    /// Drops the bind groups, and with them the buffers that only they keep.
    pub(crate) fn drop_bindings(&mut self) {
        self.bindings.clear();
    }

    /// Writes the inputs of the passes. `cut_outs` are the records of alpha-tested casters, if there
    /// are any. `first_row` is the row at which the corners begin in the tables.
    pub(crate) fn prepare(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        casters: &Casters,
        cut_outs: Option<&CutOuts>,
        tables: &Buffer,
        first_row: u32,
    ) {
        self.placed.clear();
        let Some(instances) = casters.instances.buffer() else {
            return;
        };
        // Write the uniforms of each mesh with casters.
        let mut row = first_row;
        let placed = &mut self.placed;
        let numbers = casters.meshes().filter_map(|(id, mesh)| {
            let triangles = triangles_of(mesh) as u32;
            if triangles == 0 {
                return None;
            }
            placed.push((id, triangles));
            let numbers = numbers_of(mesh, cut_outs, row);
            row += corner_rows(triangles);
            Some(numbers)
        });
        let Some((numbers, _)) = self.numbers.write(factory, "umbrage corners", numbers) else {
            return;
        };
        // Create the pipeline on first use.
        let slots = [
            Slot::Window(NUMBERS),
            Slot::Table,
            Slot::Table,
            Slot::Table,
            Slot::Written,
        ];
        let layout = pipelines
            .layouts
            .get(factory, ShaderStages::COMPUTE, &slots);
        self.pipeline.get_or_insert_with(|| {
            let module = shader(factory.device, "umbrage corners", &shader_of(&["corners"]));
            factory.counters.pipelines += 1;
            compute_pipeline(factory.device, &module, "place_corners", &[Some(&layout)])
        });
        // Bind the buffers of each mesh.
        for &(id, _) in &self.placed {
            let Some(mesh) = casters.mesh(id) else {
                continue;
            };
            // Without indices, bind the vertices as a placeholder that is not read.
            let indices = mesh.indices.as_ref().map_or(&mesh.vertices, |(b, _)| b);
            let bound = vec![
                Bound::Window(numbers.clone(), NUMBERS),
                Bound::Buffer(mesh.vertices.clone()),
                Bound::Buffer(indices.clone()),
                Bound::Buffer(instances.clone()),
                Bound::Buffer(tables.clone()),
            ];
            if !self.bindings.contains_key(id) {
                self.bindings.insert(id, Binding::default());
            }
            if let Some(binding) = self.bindings.get_mut(id) {
                binding.set(factory, "umbrage corners", &layout, bound);
            }
        }
        // Drop the bindings of removed meshes.
        self.bindings.retain(|id, _| casters.mesh(id).is_some());
    }

    /// Records the passes that transform all casters.
    pub(crate) fn encode(&self, pass: &mut ComputePass<'_>) {
        let Some(pipeline) = &self.pipeline else {
            return;
        };
        pass.set_pipeline(pipeline);
        for (i, &(id, triangles)) in self.placed.iter().enumerate() {
            let Some(binding) = self.bindings.get(id) else {
                continue;
            };
            pass.set_bind_group(0, binding.group(), &[self.numbers.offset(i)]);
            let [x, y] = group_counts(triangles);
            pass.dispatch_workgroups(x, y, 1);
        }
    }
}

fn numbers_of(mesh: &MeshSlots, cut_outs: Option<&CutOuts>, first_row: u32) -> [u32; 11] {
    let draw = &mesh.draw;
    let slots = mesh.slots();
    let format = match draw.layout.format {
        PositionFormat::Float32x3 => 0,
        PositionFormat::Float16x4 => 1,
        PositionFormat::Snorm16x4 => 2,
    };
    let index_bits = match draw.indices {
        None => 0,
        Some((_, IndexFormat::Uint16)) => 16,
        Some((_, IndexFormat::Uint32)) => 32,
    };
    let first_record = match (draw.holes, cut_outs) {
        (Some(_), Some(cut_outs)) => cut_outs.record_row(draw.range.start / 3),
        _ => None,
    };
    // The format is first, since it depends on no placement: see `STEADY_FIRST_WORD`.
    [
        format,
        slots.start,
        slots.len() as u32,
        draw.triangles() as u32,
        first_row,
        (draw.layout.stride / 4) as u32,
        (draw.layout.position_offset / 4) as u32,
        index_bits,
        draw.range.start,
        draw.base_vertex.cast_unsigned(),
        first_record.unwrap_or(0),
    ]
}

/// Returns the reason why compute shaders can't read the casters' buffers, or `None`.
pub(crate) fn why_unreadable(casters: &Casters, limits: &Limits) -> Option<String> {
    let most = limits.max_storage_buffer_binding_size;
    for (_, mesh) in casters.meshes() {
        let MeshSlots { draw, .. } = mesh;
        let indices = draw.indices.as_ref().map(|(buffer, _)| buffer);
        let buffers = [Some(&draw.vertices), indices];
        for buffer in buffers.into_iter().flatten() {
            if let Some(why) = why_unbound(draw, buffer, most) {
                return Some(why);
            }
        }
    }
    None
}

fn why_unbound(mesh: &MeshDraw, buffer: &Buffer, most: u64) -> Option<String> {
    let label = &mesh.label;
    let bytes = buffer.size();
    if !buffer.usage().contains(BufferUsages::STORAGE) {
        return Some(format!(
            "compute shaders read the triangles of mesh `{label}`, whose buffers need the usage `STORAGE`"
        ));
    }
    if !bytes.is_multiple_of(4) || bytes > most {
        return Some(format!(
            "compute shaders read the triangles of mesh `{label}`: its buffers must be a multiple of 4 and at most {most} bytes, and one has {bytes}"
        ));
    }
    None
}
