//! Passes that build hierarchies.

use crate::{
    hierarchy::{
        layout::{HierarchyLayout, count_at},
        sort::{MOST_ITEMS, SortBuffers, SortRange, SortStage},
    },
    resources::{
        bindings::{Binding, Bound, Slot},
        counters::{ResourceFactory, is_kept},
        pipelines::Pipelines,
        windows::Windows,
    },
};
use std::num::NonZeroU64;
use umbrage_core::{DeviceHierarchy, Module, join};
use wgpu::{
    BindGroupLayout, Buffer, BufferUsages, CommandEncoder, ComputePass, ComputePassDescriptor,
    ComputePassTimestampWrites, ComputePipeline, Limits, ShaderStages,
};

/// Capacity for references, per caster. Casters are divided into at most 1.8 pieces on average.
const REFERENCES: u64 = 2;
/// Greatest further capacity for a light with several faces.
const MORE_REFERENCES: u64 = 1 << 18;
/// Greatest number of casters: an id uses 29 bits of a reference, and all references are sorted.
const MOST_CASTERS: u64 = (MOST_ITEMS - MORE_REFERENCES) / (REFERENCES + 1);
/// Least limit of the storage buffers of a shader.
const STORAGE_BUFFERS: u32 = 7;

/// Bytes of a reference, and of the box of a node.
const REFERENCE_BYTES: u64 = 8;
const BOX_BYTES: u64 = 32;

/// Words and bytes of `HierarchyPlace`.
const PLACE_WORDS: usize = 8 + DeviceHierarchy::LEVELS;
const PLACE: NonZeroU64 = NonZeroU64::new(4 * PLACE_WORDS as u64).unwrap();

/// The shaders of a hierarchy.
const SHADERS: [&str; 4] = ["count_pieces", "make_keys", "build_leaves", "build_nodes"];

/// Rows of a caster's corners.
const CORNERS: u32 = 3;

/// Passes that build hierarchies one after another, in one buffer of tables. They share scratch
/// buffers.
#[derive(Debug, Default)]
pub(crate) struct HierarchyPasses {
    scratch: Option<Scratch>,
    /// Inputs of the passes: a window for each level of each hierarchy.
    places: Windows,
    sort: SortStage,
}

/// One hierarchy in a buffer of tables.
#[derive(Debug, Default)]
pub(crate) struct Hierarchy {
    /// Number of casters.
    casters: u32,
    /// Greatest number of their references, at most the layout's capacity: passes have no
    /// invocations for capacity that is only kept.
    most_references: u32,
    layout: HierarchyLayout,
    /// The uniforms for which it is built.
    pub(crate) uniforms: Vec<u8>,
    pipelines: Option<HierarchyPipelines>,
    view: Option<Buffer>,
    binding: Binding,
    /// Its number among those that are built, and its first window.
    number: usize,
    first_window: usize,
}

/// A hierarchy to build. `nodes` and `corners` are its first rows, and those of the corners, in the
/// tables.
#[derive(Debug)]
pub(crate) struct HierarchyInput<'a> {
    pub(crate) hierarchy: &'a mut Hierarchy,
    pub(crate) made: &'a DeviceHierarchy,
    pub(crate) nodes: u32,
    pub(crate) corners: u32,
}

/// Pipelines of the hierarchies with the same WGSL, in the order of [`SHADERS`].
#[derive(Debug)]
struct HierarchyPipelines {
    modules: Vec<Module>,
    layout: BindGroupLayout,
    shaders: Vec<ComputePipeline>,
}

/// Buffers that only the passes use.
#[derive(Debug)]
struct Scratch {
    capacity: u32,
    nodes: u32,
    sort: SortBuffers,
    references: Buffer,
    boxes: Buffer,
}

/// Returns the reason why a device can't build a hierarchy of this number of casters, or `None`.
pub(crate) fn why_not_built(casters: u64, limits: &Limits) -> Option<String> {
    let has_compute = limits.max_compute_invocations_per_workgroup >= 256
        && limits.max_compute_workgroup_size_x >= 256
        && limits.max_compute_workgroups_per_dimension >= 65_535
        && limits.max_storage_buffers_per_shader_stage >= STORAGE_BUFFERS;
    if !has_compute {
        return Some(format!(
            "building hierarchies of casters needs compute workgroups of 256, 65535 of them, and {STORAGE_BUFFERS} storage buffers, which exceeds the device's limits: request `wgpu::Limits::default()`"
        ));
    }
    if casters >= MOST_CASTERS {
        return Some(format!(
            "hierarchies of a device support fewer than {MOST_CASTERS} triangles, and there are more"
        ));
    }
    None
}

/// Returns the reason why a hierarchy needs more memory than shaders can bind, or `None`.
/// `tables_bytes` are those of the tables that contain it.
pub(crate) fn why_too_large(
    layout: &HierarchyLayout,
    tables_bytes: u64,
    casters: u32,
    limits: &Limits,
) -> Option<String> {
    let most = most_bytes(limits);
    let bytes = tables_bytes.max(Scratch::largest_buffer(layout));
    (bytes > most).then(|| {
        format!(
            "its hierarchy of {casters} triangles and their corners need {} MiB, and shaders of the device can bind {} MiB; request a device with a greater `max_storage_buffer_binding_size`",
            bytes >> 20,
            most >> 20
        )
    })
}

/// Returns the largest buffer that shaders can bind, bytes.
pub(crate) fn most_bytes(limits: &Limits) -> u64 {
    limits
        .max_storage_buffer_binding_size
        .min(limits.max_buffer_size)
}

/// Returns the rows of the corners of this number of casters.
pub(crate) fn corner_rows(casters: u32) -> u32 {
    CORNERS * casters.max(1)
}

/// Returns the capacity for the references of this number of casters: `held` if it is kept (see
/// [`is_kept`]), otherwise the needed one, rounded up.
pub(crate) fn capacity_for(casters: u32, faces: u32, held: u32) -> u32 {
    let needed = needed_capacity(casters, faces);
    if is_kept(held.into(), needed) {
        return held;
    }
    // Round up, so that small changes of the number of casters have no effect.
    let step = (needed / 16).max(1).next_power_of_two();
    needed.next_multiple_of(step) as u32
}

/// Returns the capacity that the references of this number of casters need.
fn needed_capacity(casters: u32, faces: u32) -> u64 {
    let casters = u64::from(casters);
    // A caster may be visible on several faces. Few are, if there are many casters.
    let most_faces = u64::from(faces).saturating_sub(REFERENCES);
    let more = (most_faces * casters).min(MORE_REFERENCES);
    REFERENCES * casters + more
}

/// Returns the numbers of workgroups of 64, across and down, for this number of invocations.
pub(crate) fn group_counts(invocations: u32) -> [u32; 2] {
    const MOST_ACROSS: u32 = 1 << 15;
    let groups = invocations.div_ceil(64).max(1);
    let across = groups.min(MOST_ACROSS);
    [across, groups.div_ceil(across)]
}

impl HierarchyPasses {
    /// Ensures that the scratch buffers fit hierarchies with these layouts. Returns whether new ones
    /// were created: the caller then drops the bindings of all hierarchies, which keep the old ones.
    pub(crate) fn fit_scratch(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        layouts: impl Iterator<Item = HierarchyLayout> + Clone,
    ) -> bool {
        let capacity = layouts.clone().map(|l| l.capacity).max().unwrap_or(0);
        let nodes = layouts.map(|l| l.nodes).max().unwrap_or(0);
        let fits = |held: &Scratch| {
            is_kept(held.capacity.into(), capacity.into())
                && is_kept(held.nodes.into(), nodes.into())
        };
        if self.scratch.as_ref().is_some_and(fits) {
            return false;
        }
        self.scratch = Some(Scratch::new(factory, capacity, nodes));
        true
    }

    /// Drops the scratch buffers, and the bind groups that keep them.
    pub(crate) fn drop_scratch(&mut self) {
        self.scratch = None;
        self.sort.drop_bindings();
    }

    /// Returns the bytes of the scratch buffers.
    pub(crate) fn scratch_bytes(&self) -> u64 {
        let buffers = self.scratch.iter().flat_map(|scratch| {
            let own = [&scratch.references, &scratch.boxes];
            own.into_iter().chain(scratch.sort.all())
        });
        buffers.map(Buffer::size).sum()
    }

    /// Creates and writes the inputs of the passes, after [`fit_scratch`](Self::fit_scratch).
    pub(crate) fn prepare(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        tables: &Buffer,
        mut built: Vec<HierarchyInput<'_>>,
    ) {
        let Some(scratch) = &self.scratch else {
            return;
        };
        // Number the windows of each hierarchy.
        let mut windows = Vec::new();
        let mut ranges = Vec::new();
        for input in &mut built {
            let hierarchy = &mut *input.hierarchy;
            hierarchy.number = ranges.len();
            hierarchy.first_window = windows.len();
            ranges.push(hierarchy.sort_range());
            let levels = 0..hierarchy.layout.levels;
            windows.extend(levels.map(|level| hierarchy.place(input.nodes, input.corners, level)));
        }
        self.sort
            .prepare(factory, pipelines, &scratch.sort, ranges.into_iter());
        let windows = windows.into_iter();
        let Some((places, _)) = self.places.write(factory, "umbrage hierarchies", windows) else {
            return;
        };
        // Write the inputs of each hierarchy.
        for HierarchyInput {
            hierarchy, made, ..
        } in built
        {
            hierarchy.write(factory, pipelines, made, [&places, tables], scratch);
        }
    }

    /// Records the passes of a hierarchy, after those of `before`.
    pub(crate) fn encode(
        &self,
        encoder: &mut CommandEncoder,
        hierarchy: &Hierarchy,
        timestamp_writes: Option<ComputePassTimestampWrites<'_>>,
        before: impl FnOnce(&mut ComputePass<'_>),
    ) {
        let (Some(scratch), Some(pipelines)) = (&self.scratch, &hierarchy.pipelines) else {
            return;
        };
        encoder.clear_buffer(&scratch.sort.head, 0, None);
        let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor {
            label: Some("umbrage hierarchy"),
            timestamp_writes,
        });
        before(&mut pass);
        let binding = hierarchy.binding.group();
        let dispatch = |pass: &mut ComputePass<'_>, shader: usize, level: u32, count| {
            let window = self.places.offset(hierarchy.first_window + level as usize);
            let [x, y] = group_counts(count);
            pass.set_pipeline(&pipelines.shaders[shader]);
            pass.set_bind_group(0, binding, &[window]);
            pass.dispatch_workgroups(x, y, 1);
        };
        let [count_pieces, make_keys, build_leaves, build_nodes] = [0, 1, 2, 3];
        dispatch(&mut pass, count_pieces, 0, hierarchy.casters);
        dispatch(&mut pass, make_keys, 0, hierarchy.casters);
        self.sort
            .encode(&mut pass, hierarchy.number, hierarchy.sort_range());
        dispatch(&mut pass, build_leaves, 0, hierarchy.most_references);
        for level in 1..hierarchy.layout.levels {
            let count = count_at(level, hierarchy.most_references);
            dispatch(&mut pass, build_nodes, level, count);
        }
    }
}

impl HierarchyPipelines {
    fn new(
        factory: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        modules: &[Module],
    ) -> Self {
        let slots = [
            Slot::Uniform,
            Slot::Window(PLACE),
            Slot::Written,
            Slot::Written,
            Slot::Table,
            Slot::Written,
            Slot::Written,
            Slot::Written,
        ];
        let layout = pipelines
            .layouts
            .get(factory, ShaderStages::COMPUTE, &slots);
        let groups = [Some(&layout)];
        let text = join(modules);
        let shaders = pipelines.computes(factory, "umbrage hierarchy", text, &SHADERS, &groups);
        Self {
            modules: modules.to_vec(),
            layout,
            shaders,
        }
    }
}

impl Scratch {
    fn new(factory: &mut ResourceFactory<'_>, capacity: u32, nodes: u32) -> Self {
        let storage = BufferUsages::STORAGE;
        let references_bytes = REFERENCE_BYTES * u64::from(capacity.max(1));
        let boxes_bytes = BOX_BYTES * u64::from(nodes.max(1));
        Self {
            capacity,
            nodes,
            sort: SortBuffers::new(factory, capacity, DeviceHierarchy::HEAD),
            references: factory.buffer("umbrage references", storage, references_bytes),
            boxes: factory.buffer("umbrage boxes", storage, boxes_bytes),
        }
    }

    /// Returns the bytes of the largest buffer for a hierarchy.
    fn largest_buffer(layout: &HierarchyLayout) -> u64 {
        let references = REFERENCE_BYTES * u64::from(layout.capacity);
        references.max(BOX_BYTES * u64::from(layout.nodes))
    }
}

impl Hierarchy {
    pub(crate) fn layout(&self) -> HierarchyLayout {
        self.layout
    }

    /// Sets the layout, and the number of casters with their number of faces. Returns whether the
    /// hierarchy has to be built again.
    pub(crate) fn resize(&mut self, layout: HierarchyLayout, casters: u32, faces: u32) -> bool {
        let before = (self.layout, self.casters, self.most_references);
        let needed = needed_capacity(casters, faces);
        self.layout = layout;
        self.casters = casters;
        self.most_references = needed.min(layout.capacity.into()) as u32;
        before != (self.layout, self.casters, self.most_references)
    }

    /// Drops the bind group, and with it the buffers that only it keeps.
    pub(crate) fn drop_binding(&mut self) {
        self.binding = Binding::default();
    }

    fn sort_range(&self) -> SortRange {
        SortRange {
            first: self.casters,
            most: self.most_references,
        }
    }

    /// Returns `HierarchyPlace` of a pass that groups the items of a level.
    fn place(&self, nodes: u32, corners: u32, level: u32) -> [u32; PLACE_WORDS] {
        let layout = &self.layout;
        let mut words = [0; PLACE_WORDS];
        let ids = nodes + layout.first_id_row();
        // The first word stays 0: see `STEADY_FIRST_WORD`.
        words[1..5].copy_from_slice(&[nodes, ids, corners, self.casters]);
        words[5..8].copy_from_slice(&[self.most_references, layout.levels, level]);
        words[8..].copy_from_slice(&layout.firsts);
        words
    }

    /// Writes the view and binds the buffers: `shared` are those of the places and the tables.
    fn write(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        made: &DeviceHierarchy,
        shared: [&Buffer; 2],
        scratch: &Scratch,
    ) {
        // Find the pipelines, or create them.
        let known = self.pipelines.take();
        let known = known.filter(|known| known.modules == made.modules);
        let known =
            known.unwrap_or_else(|| HierarchyPipelines::new(factory, pipelines, &made.modules));
        // Write the view.
        self.uniforms.clone_from(&made.uniforms);
        let bytes = made.uniforms.len() as u64;
        let held = self.view.take().filter(|view| view.size() == bytes);
        let view =
            held.unwrap_or_else(|| factory.buffer("umbrage view", BufferUsages::UNIFORM, bytes));
        factory.queue.write_buffer(&view, 0, &made.uniforms);
        let view = self.view.insert(view);
        // Bind the buffers.
        let [places, tables] = shared;
        let sort = &scratch.sort;
        let buffers = [
            tables,
            &sort.keys[0],
            &sort.numbers[0],
            &sort.head,
            &scratch.references,
            &scratch.boxes,
        ];
        let mut bound = vec![
            Bound::Buffer(view.clone()),
            Bound::Window(places.clone(), PLACE),
        ];
        bound.extend(buffers.map(|buffer| Bound::Buffer(buffer.clone())));
        let layout = &known.layout;
        self.binding
            .set(factory, "umbrage hierarchy", layout, bound);
        self.pipelines = Some(known);
    }
}

#[cfg(test)]
mod tests {
    use super::group_counts;

    #[test]
    fn groups_hold_all_invocations() {
        for (invocations, expected) in [
            (0, [1, 1]),
            (1, [1, 1]),
            (65, [2, 1]),
            (64 << 15, [1 << 15, 1]),
            ((64 << 15) + 1, [1 << 15, 2]),
        ] {
            assert_eq!(group_counts(invocations), expected, "{invocations}");
        }
    }
}
