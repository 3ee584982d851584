//! Hierarchies of casters that the device builds, for kernels that read them.
//!
//! The corners of all casters and each light's hierarchy are among the tables of the set's shaders.
//! A hierarchy is rebuilt when casters or its light's view change. Lights are built one after
//! another, so they share the buffers that only the passes use.

use crate::{
    light_set::{
        buffers::{Region, SharedTables, is_kept},
        casters::Casters,
        corners::{CORNERS, CornerStage, group_counts, triangle_count, why_unreadable},
        hierarchy_layout::HierarchyLayout,
        ids::LightKey,
        sort::{MOST_ITEMS, SortBuffers, SortRange, SortStage},
        state::{HeldLight, LightState},
    },
    resources::{
        bindings::{Binding, Bound, Slot},
        counters::ResourceFactory,
        pipelines::{Pipelines, compute_pipeline, shader},
        windows::Windows,
    },
};
use slotmap::{SecondaryMap, SlotMap};
use std::num::NonZeroU64;
use umbrage_core::{CutOuts, DeviceHierarchy, Module, RecipeError, join};
use wgpu::{
    BindGroupLayout, Buffer, BufferUsages, CommandEncoder, ComputePass, ComputePassDescriptor,
    ComputePassTimestampWrites, ComputePipeline, Device, Limits, ShaderStages,
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

/// Builds the hierarchies on the device.
#[derive(Debug, Default)]
pub(crate) struct CasterHierarchies {
    corners: CornerStage,
    /// True if casters changed since their corners were written.
    corners_stale: bool,
    kinds: Vec<HierarchyKind>,
    lights: SecondaryMap<LightKey, LightHierarchy>,
    scratch: Option<Scratch>,
    /// Inputs of the passes: a window for each level of each hierarchy that is due.
    places: Windows,
    sort: SortStage,
    /// [`SharedTables::moves`] at the time of the last build.
    moves: u64,
    /// Capacity for references, for tests; at least that of the casters.
    pub(crate) most_references: Option<u32>,
}

/// Pipelines of all hierarchies with the same WGSL.
#[derive(Debug)]
struct HierarchyKind {
    modules: Vec<Module>,
    layout: BindGroupLayout,
    count_pieces: ComputePipeline,
    make_keys: ComputePipeline,
    build_leaves: ComputePipeline,
    build_nodes: ComputePipeline,
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

/// The hierarchy of one light.
#[derive(Debug, Default)]
struct LightHierarchy {
    casters: u32,
    layout: HierarchyLayout,
    /// The uniforms for which it is built.
    uniforms: Vec<u8>,
    kind: usize,
    is_stale: bool,
    /// False if its light is switched off. It is then not rebuilt.
    is_enabled: bool,
    view: Option<Buffer>,
    binding: Binding,
    /// Its number among those that are due, and its first window.
    number: usize,
    first_window: usize,
}

/// Returns the reason why a device can't build hierarchies, or `None`.
pub(crate) fn why_not_built(casters: &Casters, limits: &Limits) -> Option<String> {
    let has_compute = limits.max_compute_invocations_per_workgroup >= 256
        && limits.max_compute_workgroup_size_x >= 256
        && limits.max_compute_workgroups_per_dimension >= 65_535
        && limits.max_storage_buffers_per_shader_stage >= STORAGE_BUFFERS;
    if !has_compute {
        return Some(format!(
            "building hierarchies of casters needs compute workgroups of 256, 65535 of them, and {STORAGE_BUFFERS} storage buffers, which exceeds the device's limits: request `wgpu::Limits::default()`"
        ));
    }
    if triangle_count(casters) >= MOST_CASTERS {
        return Some(format!(
            "hierarchies of a device support fewer than {MOST_CASTERS} triangles, and there are more"
        ));
    }
    if !casters.own().is_empty() {
        return Some(
            "hierarchies of a device can't contain casters that the program draws (`add_own_caster`)"
                .to_owned(),
        );
    }
    why_unreadable(casters, limits)
}

/// Returns whether a light uses a device-built hierarchy.
fn wants_hierarchy(light: &HeldLight) -> bool {
    shown_hierarchy(light).is_some()
}

/// Returns the hierarchy of a light's current plan.
fn shown_hierarchy(light: &HeldLight) -> Option<&DeviceHierarchy> {
    light.state.shown_plan()?.hierarchy.as_ref()
}

impl CasterHierarchies {
    /// Marks all hierarchies as out of date.
    pub(crate) fn mark_stale(&mut self) {
        self.corners_stale = true;
        for hierarchy in self.lights.values_mut() {
            hierarchy.is_stale = true;
        }
    }

    /// Ensures capacity for the hierarchies of all lights that use them. Returns whether any
    /// position changed.
    pub(crate) fn make_room(
        &mut self,
        device: &Device,
        lights: &mut SlotMap<LightKey, HeldLight>,
        casters: &Casters,
        tables: &mut SharedTables,
    ) -> bool {
        // Drop the hierarchies of lights that no longer use any.
        self.lights
            .retain(|id, _| lights.get(id).is_some_and(wants_hierarchy));
        if !lights.values().any(wants_hierarchy) {
            // Bind groups keep buffers alive, too.
            self.scratch = None;
            self.sort.drop_bindings();
            self.corners.drop_bindings();
            return tables.free(Region::Corners);
        }
        let triangles = triangle_count(casters) as u32;
        let limits = device.limits();
        let most = limits
            .max_storage_buffer_binding_size
            .min(limits.max_buffer_size);
        // Free what exceeds the need if the tables would be too large otherwise.
        let held_rows = self.rows(lights, triangles, Some(tables));
        let is_beyond = tables.fixed_bytes() + 16 * held_rows > most;
        if is_beyond && self.rows(lights, triangles, None) < held_rows {
            tables.free_regions();
            self.lights.clear();
        }
        let mut changed = tables.reserve(Region::Corners, corner_rows(triangles));
        // Free the regions that change, so that the checks below don't count them.
        for (id, light) in &*lights {
            let Some(made) = shown_hierarchy(light) else {
                continue;
            };
            let layout = self.layout_for(made, triangles, self.capacity_of(id));
            if !self.lights.contains_key(id) {
                self.lights.insert(id, LightHierarchy::default());
            }
            let Some(hierarchy) = self.lights.get_mut(id) else {
                continue;
            };
            if hierarchy.layout != layout {
                hierarchy.layout = layout;
                hierarchy.is_stale = true;
                changed |= tables.free(Region::Light(id));
            }
            hierarchy.is_stale |= hierarchy.casters != triangles;
            hierarchy.casters = triangles;
        }
        // Reserve the regions, and refuse lights that exceed the device's limits.
        for (id, light) in lights.iter_mut() {
            let Some(layout) = self.lights.get(id).map(|hierarchy| hierarchy.layout) else {
                continue;
            };
            let tables_bytes = 16 * u64::from(layout.rows()) + tables.bytes_without(id);
            let bytes = tables_bytes.max(Scratch::largest_buffer(&layout));
            if bytes <= most {
                changed |= tables.reserve(Region::Light(id), layout.rows());
                continue;
            }
            let why = format!(
                "its hierarchy of {triangles} triangles needs {} MiB, and shaders of the device can bind {} MiB; request a device with a greater `max_storage_buffer_binding_size`",
                bytes >> 20,
                most >> 20
            );
            light.state = LightState::Refused(RecipeError::unsupported_because(why));
            tables.free(Region::Light(id));
            self.lights.remove(id);
            changed = true;
        }
        changed
    }

    /// Returns the layout of a hierarchy, whose present capacity is `held`.
    fn layout_for(&self, made: &DeviceHierarchy, triangles: u32, held: u32) -> HierarchyLayout {
        let capacity = self.most_references.map_or_else(
            || capacity_for(triangles, made.faces, held),
            |most| most.max(triangles),
        );
        HierarchyLayout::new(capacity)
    }

    /// Returns the present capacity of a light's hierarchy, 0 if there is none.
    fn capacity_of(&self, id: LightKey) -> u32 {
        let held = self.lights.get(id);
        held.map_or(0, |hierarchy| hierarchy.layout.capacity)
    }

    /// Returns the number of rows that all regions need, with what is kept of those in `held`.
    fn rows(
        &self,
        lights: &SlotMap<LightKey, HeldLight>,
        triangles: u32,
        held: Option<&SharedTables>,
    ) -> u64 {
        let hierarchies = lights.iter().filter_map(|(id, light)| {
            let made = shown_hierarchy(light)?;
            let capacity = held.map_or(0, |_| self.capacity_of(id));
            Some(self.layout_for(made, triangles, capacity).rows())
        });
        let needed = corner_rows(triangles);
        let held = held.map_or(0, |tables| tables.place_of(Region::Corners).count);
        let is_kept = is_kept(held.into(), needed.into());
        let corners = if is_kept { held } else { needed };
        hierarchies.chain([corners]).map(u64::from).sum()
    }

    /// Creates and writes the inputs of this frame's passes.
    pub(crate) fn prepare(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        lights: &SlotMap<LightKey, HeldLight>,
        casters: &Casters,
        cut_outs: Option<&CutOuts>,
        tables: &SharedTables,
    ) {
        if self.lights.is_empty() {
            return;
        }
        let Some(buffer) = tables.buffer() else {
            return;
        };
        if self.moves != tables.moves() {
            // Rebuild everything: the device's rows were moved or lost.
            self.moves = tables.moves();
            self.mark_stale();
            self.drop_bindings();
            self.corners.drop_bindings();
        }
        let corners = tables.place_of(Region::Corners).first;
        for (id, hierarchy) in &mut self.lights {
            let light = lights.get(id);
            hierarchy.is_enabled = light.is_some_and(|light| light.is_enabled);
            let made = light.and_then(shown_hierarchy);
            hierarchy.is_stale |= made.is_some_and(|made| hierarchy.uniforms != made.uniforms);
        }
        if self.due_count() == 0 {
            return;
        }
        if self.corners_stale {
            self.corners
                .prepare(factory, pipelines, casters, cut_outs, buffer, corners);
        }
        let places = self.prepare_shared(factory, pipelines, tables, corners);
        let (Some(scratch), Some(places)) = (&self.scratch, places) else {
            return;
        };
        // Write the inputs of each hierarchy that is out of date.
        for (id, hierarchy) in &mut self.lights {
            let made = lights.get(id).and_then(shown_hierarchy);
            let (Some(made), true) = (made, hierarchy.is_due()) else {
                continue;
            };
            // Find the pipelines of the hierarchy, or create them.
            let known = self
                .kinds
                .iter()
                .position(|kind| kind.modules == made.modules);
            hierarchy.kind = known.unwrap_or_else(|| {
                self.kinds
                    .push(HierarchyKind::new(factory, pipelines, made));
                self.kinds.len() - 1
            });
            let layout = &self.kinds[hierarchy.kind].layout;
            hierarchy.write(factory, layout, made, [&places, buffer], scratch);
        }
    }

    /// Creates and writes what the hierarchies that are due share: the scratch buffers, the inputs
    /// of the sort, and the windows of their passes. `corners` is the first row of the corners.
    /// Returns the buffer of the windows.
    fn prepare_shared(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        tables: &SharedTables,
        corners: u32,
    ) -> Option<Buffer> {
        // Number the windows of each hierarchy.
        let mut windows = Vec::new();
        let mut ranges = Vec::new();
        for (id, hierarchy) in &mut self.lights {
            if hierarchy.is_due() {
                hierarchy.number = ranges.len();
                hierarchy.first_window = windows.len();
                ranges.push(hierarchy.sort_range());
                let nodes = tables.place_of(Region::Light(id)).first;
                let levels = 0..hierarchy.layout.levels;
                windows.extend(levels.map(|level| hierarchy.place(nodes, corners, level)));
            }
        }
        // Create the scratch buffers for the largest hierarchy.
        let layouts = || self.lights.values().map(|hierarchy| hierarchy.layout);
        let capacity = layouts().map(|layout| layout.capacity).max().unwrap_or(0);
        let nodes = layouts().map(|layout| layout.nodes).max().unwrap_or(0);
        let fits = |held: &Scratch| {
            is_kept(held.capacity.into(), capacity.into())
                && is_kept(held.nodes.into(), nodes.into())
        };
        if !self.scratch.as_ref().is_some_and(fits) {
            self.drop_bindings();
            self.scratch = Some(Scratch::new(factory, capacity, nodes));
        }
        let scratch = self.scratch.as_ref()?;
        self.sort
            .prepare(factory, pipelines, &scratch.sort, ranges.into_iter());
        let windows = windows.into_iter();
        let written = self.places.write(factory, "umbrage hierarchies", windows);
        written.map(|(buffer, _)| buffer)
    }

    /// Drops the bind groups of all lights, and with them the buffers that only they keep. Lights
    /// that are due get others.
    fn drop_bindings(&mut self) {
        for hierarchy in self.lights.values_mut() {
            hierarchy.binding = Binding::default();
        }
    }

    /// Returns the bytes of the buffers that only the passes use.
    pub(crate) fn scratch_bytes(&self) -> u64 {
        let buffers = self.scratch.iter().flat_map(|scratch| {
            let own = [&scratch.references, &scratch.boxes];
            own.into_iter().chain(scratch.sort.all())
        });
        buffers.map(Buffer::size).sum()
    }

    /// Returns the number of lights whose hierarchies are built in this frame.
    pub(crate) fn due_count(&self) -> u32 {
        self.lights.values().filter(|light| light.is_due()).count() as u32
    }

    /// Records the passes of all hierarchies that are due. `stamps` returns the timestamps of a
    /// light's pass.
    pub(crate) fn encode<'q>(
        &mut self,
        encoder: &mut CommandEncoder,
        lights: &SlotMap<LightKey, HeldLight>,
        mut stamps: impl FnMut(LightKey) -> Option<ComputePassTimestampWrites<'q>>,
    ) {
        let Some(scratch) = &self.scratch else {
            return;
        };
        for (id, hierarchy) in &mut self.lights {
            // Skip lights that were removed since `prepare`.
            if !hierarchy.is_due() || !lights.contains_key(id) {
                continue;
            }
            encoder.clear_buffer(&scratch.sort.head, 0, None);
            let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor {
                label: Some("umbrage hierarchy"),
                timestamp_writes: stamps(id),
            });
            if self.corners_stale {
                self.corners.encode(&mut pass);
                self.corners_stale = false;
            }
            let kind = &self.kinds[hierarchy.kind];
            kind.encode(&mut pass, hierarchy, &self.places, &self.sort);
            hierarchy.is_stale = false;
        }
    }
}

/// Returns the rows of the corners of this number of casters.
fn corner_rows(casters: u32) -> u32 {
    CORNERS * casters.max(1)
}

/// Returns the capacity for the references of this number of casters: `held` if it is kept (see
/// [`is_kept`]), otherwise the needed one, rounded up.
fn capacity_for(casters: u32, faces: u32, held: u32) -> u32 {
    let casters = u64::from(casters);
    // A caster may be visible on several faces. Few are, if there are many casters.
    let most_faces = u64::from(faces).saturating_sub(REFERENCES);
    let more = (most_faces * casters).min(MORE_REFERENCES);
    let needed = REFERENCES * casters + more;
    if is_kept(held.into(), needed) {
        return held;
    }
    // Round up, so that small changes of the number of casters have no effect.
    let step = (needed / 16).max(1).next_power_of_two();
    needed.next_multiple_of(step) as u32
}

impl HierarchyKind {
    fn new(
        factory: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        made: &DeviceHierarchy,
    ) -> Self {
        let slots = [
            Slot::Uniform,
            Slot::Window(PLACE),
            Slot::Written,
            Slot::Written,
            Slot::Written,
            Slot::Written,
            Slot::Written,
            Slot::Written,
        ];
        let layout = pipelines
            .layouts
            .get(factory, ShaderStages::COMPUTE, &slots);
        let module = shader(factory.device, "umbrage hierarchy", &join(&made.modules));
        let mut pipeline = |entry: &str| {
            factory.counters.pipelines += 1;
            compute_pipeline(factory.device, &module, entry, &[Some(&layout)])
        };
        Self {
            modules: made.modules.clone(),
            count_pieces: pipeline("count_pieces"),
            make_keys: pipeline("make_keys"),
            build_leaves: pipeline("build_leaves"),
            build_nodes: pipeline("build_nodes"),
            layout,
        }
    }

    fn encode(
        &self,
        pass: &mut ComputePass<'_>,
        hierarchy: &LightHierarchy,
        places: &Windows,
        sort: &SortStage,
    ) {
        let binding = hierarchy.binding.group();
        let dispatch = |pass: &mut ComputePass<'_>, pipeline, level, count| {
            let window = places.offset(hierarchy.first_window + level as usize);
            let [x, y] = group_counts(count);
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, binding, &[window]);
            pass.dispatch_workgroups(x, y, 1);
        };
        dispatch(pass, &self.count_pieces, 0, hierarchy.casters);
        dispatch(pass, &self.make_keys, 0, hierarchy.casters);
        sort.encode(pass, hierarchy.number, hierarchy.sort_range());
        for level in 0..hierarchy.layout.levels {
            let pipeline = if level == 0 {
                &self.build_leaves
            } else {
                &self.build_nodes
            };
            dispatch(pass, pipeline, level, hierarchy.layout.count_at(level));
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

impl LightHierarchy {
    /// Returns whether it must be built in this frame.
    fn is_due(&self) -> bool {
        self.is_enabled && self.is_stale
    }

    fn sort_range(&self) -> SortRange {
        SortRange {
            first: self.casters,
            most: self.layout.capacity,
        }
    }

    /// Returns `HierarchyPlace` of a pass that groups the items of a level.
    fn place(&self, nodes: u32, corners: u32, level: u32) -> [u32; PLACE_WORDS] {
        let layout = &self.layout;
        let mut words = [0; PLACE_WORDS];
        let ids = nodes + layout.first_id_row();
        // The first word stays 0: see `STEADY_FIRST_WORD`.
        words[1..5].copy_from_slice(&[nodes, ids, corners, self.casters]);
        words[5..8].copy_from_slice(&[layout.capacity, layout.levels, level]);
        words[8..].copy_from_slice(&layout.firsts);
        words
    }

    /// Writes the view and binds the buffers: `shared` are those of the places and the tables.
    fn write(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        layout: &BindGroupLayout,
        made: &DeviceHierarchy,
        shared: [&Buffer; 2],
        scratch: &Scratch,
    ) {
        self.uniforms.clone_from(&made.uniforms);
        let bytes = made.uniforms.len() as u64;
        let held = self.view.take().filter(|view| view.size() == bytes);
        let view =
            held.unwrap_or_else(|| factory.buffer("umbrage view", BufferUsages::UNIFORM, bytes));
        factory.queue.write_buffer(&view, 0, &made.uniforms);
        let view = self.view.insert(view);
        let [places, tables] = shared;
        let sort = &scratch.sort;
        let written = [
            tables,
            &sort.keys[0],
            &sort.values[0],
            &sort.head,
            &scratch.references,
            &scratch.boxes,
        ];
        let mut bound = vec![
            Bound::Buffer(view.clone()),
            Bound::Window(places.clone(), PLACE),
        ];
        bound.extend(written.map(|buffer| Bound::Buffer(buffer.clone())));
        self.binding
            .set(factory, "umbrage hierarchy", layout, bound);
    }
}
