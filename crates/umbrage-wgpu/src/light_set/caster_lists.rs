//! Per-cell triangle lists that the device builds, for kernels that read them.
//!
//! The corners of all casters and each light's tables are among the tables of the set's shaders.
//! Lists are rebuilt when casters or their light's grid change. Only the device knows the number of
//! their items. It counts them first, and if they exceed the capacity, it uses wider cells, so that
//! the frame is correct in any case. The count is read some frames later, without waiting, to
//! adjust the capacity.

use crate::{
    light_set::{
        buffers::{Region, SharedTables},
        casters::Casters,
        corners::{CORNERS, CornerStage, group_counts, triangle_count, why_unreadable},
        ids::LightKey,
        state::{HeldLight, LightState},
    },
    resources::{
        bindings::{Binding, Bound, Slot},
        counters::ResourceFactory,
        late_read::LateRead,
        pipelines::{Pipelines, compute_pipeline, shader},
    },
};
use slotmap::{SecondaryMap, SlotMap};
use umbrage_core::{DeviceLists, Module, RecipeError, join};
use wgpu::{
    BindGroupLayout, Buffer, BufferUsages, CommandEncoder, ComputePass, ComputePassDescriptor,
    ComputePassTimestampWrites, ComputePipeline, Device, Limits, ShaderStages,
};

/// Greatest number of attempts: each further one doubles the width of cells.
const TRIES: usize = 4;
/// Initial capacity for items, per caster and per cell.
const ITEMS_A_CASTER: u64 = 3;
const ITEMS_A_CELL: u64 = 2;
/// Initial capacity for touches of the faces of a light with a position, per caster.
const TOUCHES_AT_LAMP: u64 = 2;
/// Spare capacity, as a fraction (one over this) of what was needed.
const SPARE: u64 = 4;
/// Workgroups for large casters: each column handles different casters, each row a different part
/// of their cells.
const LARGE_GROUPS: [u32; 2] = [1024, 4];
/// Greatest number of casters: an id uses 29 bits of a touch.
const MOST_CASTERS: u64 = 1 << 29;

/// Bytes of an unsorted item, and of a row of touches.
const UNSORTED_BYTES: u64 = 12;
const TOUCH_BYTES: u64 = 16;

/// Bytes of `ListsPlace`.
const PLACE_BYTES: usize = 32;

/// Builds the lists on the device.
#[derive(Debug, Default)]
pub(crate) struct CasterLists {
    corners: CornerStage,
    /// True if casters changed since their corners were written.
    corners_stale: bool,
    kinds: Vec<ListKind>,
    lights: SecondaryMap<LightKey, LightLists>,
    /// [`SharedTables::moves`] at the time of the last build.
    moves: u64,
    pub(crate) limits: ItemLimits,
}

/// Test overrides of the capacity for items.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct ItemLimits {
    /// Greatest capacity.
    pub(crate) most: Option<u32>,
    /// Initial capacity.
    pub(crate) first: Option<u32>,
}

/// Result of building lists. Only public for tests.
#[cfg_attr(
    not(feature = "testing"),
    expect(unreachable_pub, reason = "only public for tests")
)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Listing {
    /// True if the capacity sufficed in the end.
    pub has_room: bool,
    /// Number of times that cells were made twice as wide.
    pub halved: u32,
    /// Number of items that the first attempt needs.
    pub items: u32,
    /// Rows of touches that the first attempt needs.
    pub touches: u32,
}

/// Pipelines of all lists with the same WGSL.
#[derive(Debug)]
struct ListKind {
    modules: Vec<Module>,
    layout: BindGroupLayout,
    further_layout: BindGroupLayout,
    note_touches: ComputePipeline,
    clear_cells: ComputePipeline,
    tried: [ComputePipeline; 6],
    filled: [ComputePipeline; 4],
}

/// Unit of a pass's invocations.
#[derive(Clone, Copy, Debug)]
enum For {
    Casters,
    Cells,
    /// Blocks of cells, including one extra cell.
    Blocks,
    Large,
    One,
}

/// A pass: its shader, its action for each cell that a caster touches, and its invocations.
type Pass = (&'static str, Option<u32>, For);

const FIND_COVERS: Option<u32> = Some(0);
const COUNT: Option<u32> = Some(1);
const FILL: Option<u32> = Some(2);

/// Passes of an attempt.
const TRY: [Pass; 6] = [
    ("visit_small", FIND_COVERS, For::Casters),
    ("visit_large", FIND_COVERS, For::Large),
    ("visit_small", COUNT, For::Casters),
    ("visit_large", COUNT, For::Large),
    ("sum_blocks", None, For::Blocks),
    ("sum_all", None, For::One),
];
/// Passes after the last attempt.
const FILLED: [Pass; 4] = [
    ("place_cells", None, For::Blocks),
    ("visit_small", FILL, For::Casters),
    ("visit_large", FILL, For::Large),
    ("sort_items", None, For::Cells),
];

/// Bytes of the arguments of an indirect dispatch.
const DISPATCH_BYTES: u64 = 12;
/// Number of passes of a further attempt, which begins by clearing cells.
const FURTHER: u64 = 1 + TRY.len() as u64;

/// Capacity of the buffers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Room {
    triangles: u32,
    items: u32,
    touches: u32,
    cells: u32,
}

/// The lists of one light.
#[derive(Debug)]
struct LightLists {
    room: Room,
    /// Needs reported by the last lists that were read.
    needed: Option<Listing>,
    /// The grid for which lists are built.
    grid: Vec<u8>,
    kind: usize,
    is_stale: bool,
    /// False if their light is switched off. They are then not rebuilt.
    is_enabled: bool,
    buffers: Option<ListBuffers>,
    binding: Binding,
    further_binding: Binding,
    read: LateRead,
}

#[derive(Debug)]
struct ListBuffers {
    grid: Buffer,
    place: Buffer,
    work: Buffer,
    unsorted: Buffer,
    touches: Buffer,
    /// Indirect dispatch arguments of further attempts.
    further: Buffer,
}

/// Returns the reason why a device can't build lists, or `None`.
pub(crate) fn why_not_listed(casters: &Casters, limits: &Limits) -> Option<String> {
    let has_compute = limits.max_compute_invocations_per_workgroup >= 256
        && limits.max_compute_workgroups_per_dimension >= 1 << 15
        && limits.max_storage_buffers_per_shader_stage >= 5;
    if !has_compute {
        return Some(
            "building caster lists needs compute workgroups of 256 and five storage buffers, which exceeds the device's limits".to_owned(),
        );
    }
    if triangle_count(casters) >= MOST_CASTERS {
        return Some(format!(
            "caster lists support fewer than {MOST_CASTERS} triangles, and there are more"
        ));
    }
    if !casters.own().is_empty() {
        return Some(
            "caster lists can't contain casters that the program draws (`add_own_caster`)"
                .to_owned(),
        );
    }
    if casters.meshes().any(|(_, mesh)| mesh.draw.holes.is_some()) {
        return Some(
            "caster lists support alpha-tested triangles only in `SetFrame::geometry`".to_owned(),
        );
    }
    why_unreadable(casters, limits)
}

/// Returns whether a light uses device-built lists.
fn wants_lists(light: &HeldLight) -> bool {
    shown_lists(light).is_some()
}

/// Returns the lists of a light's current plan.
fn shown_lists(light: &HeldLight) -> Option<&DeviceLists> {
    light.state.shown_plan()?.lists.as_ref()
}

impl CasterLists {
    /// Marks all lists as out of date.
    pub(crate) fn mark_stale(&mut self) {
        self.corners_stale = true;
        for lists in self.lights.values_mut() {
            lists.is_stale = true;
        }
    }

    /// Ensures capacity for the lists of all lights that use them. Returns whether any position
    /// changed.
    pub(crate) fn make_room(
        &mut self,
        device: &Device,
        lights: &mut SlotMap<LightKey, HeldLight>,
        casters: &Casters,
        tables: &mut SharedTables,
    ) -> bool {
        // Drop the lists of lights that no longer use any.
        self.lights
            .retain(|id, _| lights.get(id).is_some_and(wants_lists));
        if !lights.values().any(wants_lists) {
            return false;
        }
        let triangles = triangle_count(casters) as u32;
        let mut changed = tables.reserve(Region::Corners, CORNERS * triangles.max(1));
        let most = device.limits().max_storage_buffer_binding_size;
        for (id, light) in lights.iter_mut() {
            let Some(made) = shown_lists(light) else {
                continue;
            };
            if !self.lights.contains_key(id) {
                self.lights.insert(id, LightLists::new(device));
            }
            let Some(lists) = self.lights.get_mut(id) else {
                continue;
            };
            // Compute the needed capacity, and reject lights that exceed the device's limits.
            let room = lists.wanted_room(made, triangles, self.limits);
            let rows = room.rows(made);
            let tables_bytes = 16 * rows.iter().sum::<u64>() + tables.bytes_without(id);
            let bytes = tables_bytes.max(room.scratch_bytes(made));
            if bytes > most {
                let why = format!(
                    "its lists of {triangles} triangles need {} MiB, and shaders of the device can bind {} MiB; request a device with a greater `max_storage_buffer_binding_size`",
                    bytes >> 20,
                    most >> 20
                );
                light.state = LightState::Refused(RecipeError::unsupported_because(why));
                tables.free(id);
                self.lights.remove(id);
                changed = true;
                continue;
            }
            // Reserve the capacity.
            if lists.room != room {
                lists.room = room;
                lists.buffers = None;
                lists.is_stale = true;
            }
            for (i, &rows) in rows.iter().enumerate() {
                changed |= tables.reserve(Region::Light(id, i), rows as u32);
            }
        }
        changed
    }

    /// Creates and writes the inputs of this frame's passes.
    pub(crate) fn prepare(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        lights: &SlotMap<LightKey, HeldLight>,
        casters: &Casters,
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
        }
        let corners = tables.place_of(Region::Corners);
        for (id, lists) in &mut self.lights {
            let light = lights.get(id);
            lists.is_enabled = light.is_some_and(|light| light.is_enabled);
            let made = light.and_then(shown_lists);
            lists.is_stale |= made.is_some_and(|made| lists.grid != made.uniforms);
        }
        if self.corners_stale && self.due_count() > 0 {
            self.corners
                .prepare(factory, pipelines, casters, buffer, corners.first);
        }
        for (id, lists) in &mut self.lights {
            let Some(made) = lights.get(id).and_then(shown_lists) else {
                continue;
            };
            // Find the pipelines of the list, or create them.
            let known = self
                .kinds
                .iter()
                .position(|kind| kind.modules == made.modules);
            lists.kind = known.unwrap_or_else(|| {
                self.kinds.push(ListKind::new(factory, pipelines, made));
                self.kinds.len() - 1
            });
            // Write the inputs of lists that are out of date.
            if lists.is_due() {
                let rows = [
                    tables.place_of(Region::Light(id, 0)).first,
                    tables.place_of(Region::Light(id, 1)).first,
                    tables.place_of(Region::Light(id, 2)).first,
                    corners.first,
                ];
                let kind = &self.kinds[lists.kind];
                lists.write(factory, kind, made, rows, buffer);
            }
        }
    }

    /// Waits for the last lists of a light, and returns their result.
    #[cfg(feature = "testing")]
    pub(crate) fn look(&mut self, device: &Device, id: LightKey) -> Option<Listing> {
        let lists = self.lights.get_mut(id)?;
        lists.read.wait(device).ok()?;
        lists.needed = lists.read.take(Listing::read).or(lists.needed);
        lists.needed
    }

    /// Returns whether buffers are missing for a light that is on.
    pub(crate) fn lack_buffers(&self, lights: &SlotMap<LightKey, HeldLight>) -> bool {
        let is_on = |id| lights.get(id).is_some_and(|light| light.is_enabled);
        let mut lists = self.lights.iter();
        lists.any(|(id, lists)| lists.buffers.is_none() && is_on(id))
    }

    /// Returns the number of lights whose lists are built in this frame.
    pub(crate) fn due_count(&self) -> u32 {
        self.lights.values().filter(|lists| lists.is_due()).count() as u32
    }

    /// Records the passes of all lists that are due. `stamps` returns the timestamps of a
    /// light's pass.
    pub(crate) fn encode<'q>(
        &mut self,
        encoder: &mut CommandEncoder,
        lights: &SlotMap<LightKey, HeldLight>,
        mut stamps: impl FnMut(LightKey) -> Option<ComputePassTimestampWrites<'q>>,
    ) {
        for (id, lists) in &mut self.lights {
            // Skip lights that were removed since `prepare`.
            let Some(buffers) = lists.buffers.as_ref().filter(|_| lights.contains_key(id)) else {
                continue;
            };
            if !lists.is_due() {
                continue;
            }
            encoder.clear_buffer(&buffers.work, 0, None);
            let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor {
                label: Some("umbrage lists"),
                timestamp_writes: stamps(id),
            });
            if self.corners_stale {
                self.corners.encode(&mut pass);
                self.corners_stale = false;
            }
            self.kinds[lists.kind].encode(&mut pass, lists, &buffers.further);
            drop(pass);
            if lists.read.is_idle() {
                lists.read.record(encoder, &buffers.work);
            }
            lists.is_stale = false;
        }
    }
}

impl ListKind {
    fn new(
        factory: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        made: &DeviceLists,
    ) -> Self {
        let slots = [
            Slot::Uniform,
            Slot::Uniform,
            Slot::Written,
            Slot::Written,
            Slot::Written,
            Slot::Written,
        ];
        let stages = ShaderStages::COMPUTE;
        let layout = pipelines.layouts.get(factory, stages, &slots);
        let further_layout = pipelines.layouts.get(factory, stages, &[Slot::Written]);
        let module = shader(factory.device, "umbrage lists", &join(&made.modules));
        let mut pipeline = |(entry, does, of): Pass| {
            factory.counters.pipelines += 1;
            let constants: Vec<(&str, f64)> =
                does.iter().map(|&does| ("DOES", f64::from(does))).collect();
            // The pass that writes the dispatch arguments of others also binds them.
            let further = matches!(of, For::One).then_some(&further_layout);
            let groups = [Some(&layout), further];
            let groups = &groups[..1 + usize::from(further.is_some())];
            compute_pipeline(factory.device, &module, entry, &constants, groups)
        };
        Self {
            modules: made.modules.clone(),
            note_touches: pipeline(("note_touches", None, For::Casters)),
            clear_cells: pipeline(("clear_cells", None, For::Cells)),
            tried: TRY.map(&mut pipeline),
            filled: FILLED.map(&mut pipeline),
            layout,
            further_layout,
        }
    }

    fn encode(&self, pass: &mut ComputePass<'_>, lists: &LightLists, further: &Buffer) {
        let room = lists.room;
        pass.set_bind_group(0, lists.binding.group(), &[]);
        let dispatch = |pass: &mut ComputePass<'_>, pipeline: &ComputePipeline, of: For| {
            let [x, y] = room.groups(of);
            pass.set_pipeline(pipeline);
            pass.dispatch_workgroups(x, y, 1);
        };
        let try_all = |pass: &mut ComputePass<'_>, is_first: bool| {
            for ((i, pipeline), (_, _, of)) in (1..).zip(&self.tried).zip(TRY) {
                if matches!(of, For::One) {
                    pass.set_bind_group(1, lists.further_binding.group(), &[]);
                    dispatch(pass, pipeline, of);
                    pass.set_bind_group(1, None, &[]);
                } else if is_first {
                    dispatch(pass, pipeline, of);
                } else {
                    pass.set_pipeline(pipeline);
                    pass.dispatch_workgroups_indirect(further, i * DISPATCH_BYTES);
                }
            }
        };
        dispatch(pass, &self.note_touches, For::Casters);
        try_all(pass, true);
        for _ in 1..TRIES {
            pass.set_pipeline(&self.clear_cells);
            pass.dispatch_workgroups_indirect(further, 0);
            try_all(pass, false);
        }
        for (pipeline, (_, _, of)) in self.filled.iter().zip(FILLED) {
            dispatch(pass, pipeline, of);
        }
    }
}

impl Room {
    /// Returns the rows of tiles, cells and items.
    fn rows(&self, made: &DeviceLists) -> [u64; 3] {
        [
            u64::from(made.tiles.div_ceil(2)),
            u64::from(self.cells) + 1,
            u64::from(self.items.div_ceil(2)),
        ]
    }

    /// Returns the bytes of the largest buffer that only the passes use.
    fn scratch_bytes(&self, made: &DeviceLists) -> u64 {
        let unsorted = UNSORTED_BYTES * u64::from(self.items);
        let touches = TOUCH_BYTES * u64::from(self.touches);
        unsorted.max(touches).max(4 * made.work_words())
    }

    /// Returns the dispatch arguments of the passes of a further attempt: three words each.
    fn further(&self) -> Vec<u32> {
        let first = std::iter::once(For::Cells);
        let passes = first.chain(TRY.map(|(_, _, of)| of));
        let counts = passes.map(|of| self.groups(of));
        counts.flat_map(|[x, y]| [x, y, 1]).collect()
    }

    fn groups(&self, of: For) -> [u32; 2] {
        match of {
            For::Casters => group_counts(self.triangles),
            For::Cells => group_counts(self.cells),
            For::Blocks => [(self.cells + 1).div_ceil(DeviceLists::BLOCK), 1],
            For::Large => LARGE_GROUPS,
            For::One => [1, 1],
        }
    }
}

impl LightLists {
    fn new(device: &Device) -> Self {
        Self {
            room: Room::default(),
            needed: None,
            grid: Vec::new(),
            kind: 0,
            is_stale: true,
            is_enabled: true,
            buffers: None,
            binding: Binding::default(),
            further_binding: Binding::default(),
            read: LateRead::new(device, "umbrage lists read", 4 * DeviceLists::HEAD),
        }
    }

    /// Returns whether they must be built in this frame.
    fn is_due(&self) -> bool {
        self.is_enabled && self.is_stale
    }

    /// Returns the capacity for the lists of this number of triangles. Keeps at least the current
    /// capacity if the lists fit.
    fn wanted_room(&mut self, made: &DeviceLists, triangles: u32, limits: ItemLimits) -> Room {
        if let Some(needed) = self.read.take(Listing::read) {
            self.needed = Some(needed);
        }
        let cells = made.cells();
        let first_items = ITEMS_A_CASTER * u64::from(triangles) + ITEMS_A_CELL * u64::from(cells);
        let first_items = limits.first.map_or(first_items, u64::from);
        let at_lamp = if made.faces > 1 { TOUCHES_AT_LAMP } else { 1 };
        let first_touches = (at_lamp + 1) * u64::from(triangles) + 1024;
        // Round up, so that small changes of the number of casters have no effect.
        let rounded = |count: u64| {
            let step = (count / 16).max(1).next_power_of_two();
            count.next_multiple_of(step).min(u64::from(u32::MAX / 4)) as u32
        };
        let with_needed = |first: u64, needed: Option<u32>, held: u32| {
            let needed = needed.map_or(0, |n| u64::from(n) + u64::from(n) / SPARE);
            if u64::from(held) >= first.max(needed) {
                return held;
            }
            rounded(first.max(needed))
        };
        let Room { items, touches, .. } = self.room;
        let wanted_items = with_needed(first_items, self.needed.map(|n| n.items), items);
        Room {
            triangles,
            items: limits
                .most
                .map_or(wanted_items, |most| most.min(wanted_items)),
            touches: with_needed(first_touches, self.needed.map(|n| n.touches), touches),
            cells,
        }
    }

    fn write(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        kind: &ListKind,
        made: &DeviceLists,
        rows: [u32; 4],
        tables: &Buffer,
    ) {
        // Create the buffers on first use.
        let room = self.room;
        let buffers = self.buffers.get_or_insert_with(|| {
            let storage = BufferUsages::STORAGE;
            let mut buffer = |label: &str, usage, bytes: u64| factory.buffer(label, usage, bytes);
            ListBuffers {
                grid: buffer(
                    "umbrage lists' grid",
                    BufferUsages::UNIFORM,
                    made.uniforms.len() as u64,
                ),
                place: buffer(
                    "umbrage lists' place",
                    BufferUsages::UNIFORM,
                    PLACE_BYTES as u64,
                ),
                work: buffer(
                    "umbrage lists' cells",
                    storage | BufferUsages::COPY_SRC,
                    4 * made.work_words(),
                ),
                unsorted: buffer(
                    "umbrage unsorted items",
                    storage,
                    UNSORTED_BYTES * u64::from(room.items),
                ),
                touches: buffer(
                    "umbrage touches",
                    storage,
                    TOUCH_BYTES * u64::from(room.touches),
                ),
                further: buffer(
                    "umbrage further tries",
                    storage | BufferUsages::INDIRECT,
                    DISPATCH_BYTES * FURTHER,
                ),
            }
        });
        // Write the uniforms.
        self.grid.clone_from(&made.uniforms);
        let [tiles, cells, items, corners] = rows;
        let place = [
            tiles,
            cells,
            items,
            corners,
            room.triangles,
            room.items,
            room.touches,
            room.cells,
        ];
        factory.queue.write_buffer(&buffers.grid, 0, &made.uniforms);
        factory
            .queue
            .write_buffer(&buffers.place, 0, bytemuck::cast_slice(&place));
        // Bind the buffers.
        let all = [
            &buffers.grid,
            &buffers.place,
            tables,
            &buffers.work,
            &buffers.unsorted,
            &buffers.touches,
        ];
        let bound = all.map(|buffer| Bound::Buffer(buffer.clone())).to_vec();
        self.binding
            .set(factory, "umbrage lists", &kind.layout, bound);
        let bound = vec![Bound::Buffer(buffers.further.clone())];
        self.further_binding.set(
            factory,
            "umbrage further tries",
            &kind.further_layout,
            bound,
        );
        factory
            .queue
            .write_buffer(&buffers.further, 0, bytemuck::cast_slice(&room.further()));
    }
}

impl Listing {
    /// Reads the beginning of `work`.
    fn read(bytes: &[u8]) -> Self {
        let word = |i: usize| {
            let word = bytes[4 * i..].first_chunk().copied().unwrap_or_default();
            u32::from_le_bytes(word)
        };
        let first = DeviceLists::NEEDED as usize;
        Self {
            has_room: word(0) != 0,
            halved: word(1),
            items: word(first),
            touches: (DeviceLists::LARGE_TOUCH * word(first + 1)).saturating_add(word(first + 2)),
        }
    }
}
