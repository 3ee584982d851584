//! Shader interface of a set: one WGSL text, one bind group, and the uniforms behind them.

use crate::{
    light_set::{
        buffers::{
            ImagePlace, LightEntry, LightNumbers, NumberSpace, Records, Region, SharedTables,
            Uploaded,
        },
        ids::LightKey,
        plan::LightPlan,
        pool::{LayerClass, LayerPool},
        state::{HeldLight, LightState},
    },
    resources::{
        bindings::{Binding, Bound, Slot},
        counters::ResourceFactory,
        kernel_stage::image_slot,
        pipelines::Pipelines,
    },
    wgsl::{
        kernel::{InputImage, InputKind},
        resolver::{check_prefix, with_prefix},
        set::{KernelKind, MapBinding, TextParts, UnnumberedText},
    },
};
use slotmap::{SecondaryMap, SlotMap};
use std::{
    hash::{DefaultHasher, Hash as _, Hasher as _},
    sync::Arc,
};
use umbrage_core::{BackendError, DeviceHierarchy, ImageDesc, Invalid, RecipeError, Table};
use wgpu::{BindGroup, BindGroupLayout, Limits, ShaderStages};

/// WGSL text, bindings and uniforms of a set.
#[derive(Debug)]
pub(crate) struct SetShader {
    prefix: String,
    interface: Interface,
    tables: SharedTables,
    /// Uniform record of each shown light.
    records: SecondaryMap<LightKey, KernelRecord>,
    /// Hashes of all texts so far. The revision of each is its index, plus 1.
    texts: Vec<[u64; 2]>,
    text: String,
    /// The text with the user's prefix.
    prefixed_text: String,
    revision: u64,
    binding: Binding,
    /// True if kinds or maps were added since the text was generated.
    is_outdated: bool,
    /// True if entries and uniforms differ from those that were written.
    has_changed: bool,
}

/// What the text depends on: the kinds of kernels, their uniforms, and the bound textures.
#[derive(Clone, Debug)]
struct Interface {
    group: u32,
    most_maps: usize,
    kinds: Vec<KernelKind>,
    numbers: LightNumbers,
    maps: Vec<MapBinding>,
    /// See [`TextParts::classes`].
    classes: Vec<Vec<Vec<usize>>>,
}

/// The WGSL text of a set's lights, with the layout of its bind group.
#[derive(Clone, Debug)]
pub struct SetText {
    /// See [`LightSet::wgsl`](crate::LightSet::wgsl).
    pub wgsl: String,
    /// See [`LightSet::wgsl_revision`](crate::LightSet::wgsl_revision).
    pub revision: u64,
    /// See [`LightSet::bind_group`](crate::LightSet::bind_group).
    pub layout: BindGroupLayout,
}

/// A light's uniforms, by kind and index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct KernelRecord {
    kind: usize,
    index: usize,
}

/// Greatest number of bound textures: an index uses 8 bits of a light's entry.
const MAX_MAPS: u32 = 256;
/// Number of texts until a first binding is used again. With [`MAX_MAPS`] and the other
/// bindings, less than the 1,000 bindings of a group that WebGPU guarantees.
const FIRST_BINDINGS: u64 = 256;
/// Greatest number of kinds of kernels: a kind uses 8 bits of a light's entry.
const MAX_KINDS: usize = 255;
/// Stages of shaders that may contain the text.
const STAGES: ShaderStages = ShaderStages::FRAGMENT.union(ShaderStages::COMPUTE);

impl SetShader {
    /// Errors if the prefix can't begin a WGSL identifier.
    pub(crate) fn new(group: u32, prefix: &str, limits: &Limits) -> Result<Self, Invalid> {
        check_prefix(prefix)?;
        Ok(Self {
            prefix: prefix.to_owned(),
            interface: Interface {
                group,
                most_maps: limits.max_sampled_textures_per_shader_stage.min(MAX_MAPS) as usize,
                kinds: Vec::new(),
                numbers: LightNumbers::new(limits.max_uniform_buffer_binding_size),
                maps: Vec::new(),
                classes: Vec::new(),
            },
            tables: SharedTables::default(),
            records: SecondaryMap::new(),
            texts: Vec::new(),
            text: String::new(),
            prefixed_text: String::new(),
            revision: 0,
            binding: Binding::default(),
            is_outdated: true,
            has_changed: true,
        })
    }

    /// Returns the text without the prefix.
    pub(crate) fn text(&self) -> &str {
        &self.text
    }

    pub(crate) fn prefixed_text(&self) -> &str {
        &self.prefixed_text
    }

    pub(crate) fn group(&self) -> u32 {
        self.interface.group
    }

    pub(crate) fn revision(&self) -> u64 {
        self.revision
    }

    pub(crate) fn bind_group(&self) -> Option<(&BindGroup, &BindGroupLayout)> {
        self.binding.group().zip(self.binding.layout())
    }

    pub(crate) fn tables(&self) -> &SharedTables {
        &self.tables
    }

    pub(crate) fn tables_mut(&mut self) -> &mut SharedTables {
        &mut self.tables
    }

    /// Returns whether lights or the text changed since the last frame.
    pub(crate) fn has_changes(&self) -> bool {
        self.has_changed || self.is_outdated
    }

    /// Marks that the plans of shown lights differ from those that were written.
    pub(crate) fn change(&mut self) {
        self.has_changed = true;
    }

    /// Allocates an index for a new light.
    pub(crate) fn take_index(&mut self) -> u32 {
        self.interface.numbers.entries.take() as u32
    }

    pub(crate) fn give_back_index(&mut self, index: u32) {
        self.interface.numbers.entries.give_back(index as usize);
    }

    /// Frees a light's uniforms. From the next [`write`](Self::write) on, it has no shadows in
    /// shaders.
    pub(crate) fn forget(&mut self, light: LightKey) {
        if let Some(KernelRecord { kind, index }) = self.records.remove(light) {
            self.interface.numbers.kernels[kind].give_back(index);
        }
        self.has_changed = true;
    }

    /// Drops all buffers and bind groups.
    pub(crate) fn lose_buffers(&mut self) {
        self.interface.numbers.lose_buffer();
        self.tables.lose_buffer();
        self.binding = Binding::default();
        self.has_changed = true;
    }

    /// Writes the uniforms of all lights, and replaces text and bind group if needed.
    /// `maps_changed` is true if textures were replaced.
    ///
    /// Errors if a kernel's WGSL can't be prefixed.
    pub(crate) fn write(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        lights: &mut SlotMap<LightKey, HeldLight>,
        pool: &LayerPool,
        maps_changed: bool,
    ) -> Result<Uploaded, BackendError> {
        if !self.has_changed && !self.is_outdated && !maps_changed {
            return Ok(Uploaded::default());
        }
        self.register_all(lights);
        let most = factory.device.limits().max_storage_buffer_binding_size;
        self.refuse_long_tables(lights, most);
        self.set_records(lights);
        self.has_changed = false;
        self.is_outdated |= self.interface.numbers.make_room();
        let mut uploaded = self.interface.numbers.upload(factory);
        uploaded.add(self.tables.upload(factory));
        if self.is_outdated {
            self.make_text()?;
        }
        let has_group = self.binding.group().is_some();
        if self.is_outdated || uploaded.made_buffer || maps_changed || !has_group {
            self.bind(factory, pipelines, pool);
        }
        self.is_outdated = false;
        Ok(uploaded)
    }

    /// Ensures that kinds and bindings for all lights with layers are registered, whether they are
    /// drawn yet or not.
    fn register_all(&mut self, lights: &mut SlotMap<LightKey, HeldLight>) {
        let is_registered = |light: &HeldLight| {
            let plan = light.state.plan_with_layers();
            plan.is_none_or(|plan| self.interface.has(&plan.kind, &map_bindings(plan, light)))
        };
        if !lights.values().all(is_registered) {
            // The text changes anyway: drop unused kinds and maps.
            self.interface.clear();
            self.records.clear();
            self.is_outdated = true;
            for light in lights.values_mut() {
                if let Some(plan) = light.state.plan_with_layers()
                    && let Err(error) = self
                        .interface
                        .register(&plan.kind, &map_bindings(plan, light))
                {
                    light.state = LightState::Refused(error);
                }
            }
        }
        let plans = lights.values();
        let plans: Vec<&LightPlan> = plans
            .filter_map(|light| light.state.plan_with_layers())
            .collect();
        self.interface.reserve_records(&plans);
    }

    /// Returns the text for lights with these plans, in the order of the set's lights. The texts of
    /// plans with images of classes that `pool` lacks differ from those with known classes alone.
    ///
    /// Errors if a kernel's WGSL can't be prefixed.
    pub(crate) fn text_of(
        &mut self,
        factory: &ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        pool: &LayerPool,
        plans: &[&LightPlan],
    ) -> Result<SetText, RecipeError> {
        let mut classes = pool.classes();
        let mut class_of = |image: &ImageDesc| {
            let class = LayerClass::of_image(image);
            let known = classes.iter().position(|other| *other == class);
            known.unwrap_or_else(|| {
                classes.push(class);
                classes.len() - 1
            })
        };
        let maps: Vec<Vec<MapBinding>> = plans
            .iter()
            .map(|plan| {
                let inputs = plan.recipe.receive.inputs.iter().enumerate();
                let binding = |(i, &image): (usize, &usize)| MapBinding {
                    class: class_of(&plan.recipe.images[image]),
                    kind: plan.kind.shape.images[i].kind,
                };
                inputs.map(binding).collect()
            })
            .collect();
        // Do what `write` does for these plans.
        let mut interface = self.interface.clone();
        let pairs = plans.iter().zip(&maps);
        if !pairs
            .clone()
            .all(|(plan, maps)| interface.has(&plan.kind, maps))
        {
            interface.clear();
            for (plan, maps) in pairs {
                // A light that exceeds the limits will be refused, and needs no text.
                let _ = interface.register(&plan.kind, maps);
            }
        }
        interface.reserve_records(plans);
        interface.numbers.make_room();
        let text = interface.parts().text()?;
        let revision = self.number(&text);
        let first = first_binding(revision);
        Ok(SetText {
            wgsl: with_prefix(&text.numbered(first), &self.prefix)?,
            revision,
            layout: pipelines
                .layouts
                .get_from(factory, STAGES, first, &interface.slots()),
        })
    }

    /// Sets the uniforms of all lights.
    fn set_records(&mut self, lights: &SlotMap<LightKey, HeldLight>) {
        let mut entries = vec![LightEntry::default(); self.interface.numbers.entries.count()];
        for (id, light) in lights {
            let Some(plan) = light.state.shown_plan() else {
                continue;
            };
            // The kind was registered.
            let Some(kind) = self
                .interface
                .kinds
                .iter()
                .position(|kind| *kind == plan.kind)
            else {
                continue;
            };
            let index = match self.records.get(id) {
                Some(held) if held.kind == kind => held.index,
                held => {
                    if let Some(other) = held {
                        self.interface.numbers.kernels[other.kind].give_back(other.index);
                    }
                    self.interface.numbers.kernels[kind].take()
                }
            };
            self.interface.numbers.kernels[kind].set(index, &plan.uniforms);
            let record = KernelRecord { kind, index };
            self.records.insert(id, record);
            // The default entry is lit. A light that is off keeps its record.
            if light.is_enabled {
                entries[light.index as usize] = self.entry(id, plan, light, record);
            }
        }
        for (index, entry) in entries.iter().enumerate() {
            let words = entry.words();
            self.interface
                .numbers
                .entries
                .set(index, bytemuck::cast_slice(&words));
        }
    }

    fn entry(
        &mut self,
        id: LightKey,
        plan: &LightPlan,
        light: &HeldLight,
        record: KernelRecord,
    ) -> LightEntry {
        let mut entry = LightEntry {
            kind: record.kind as u32 + 1,
            kernel: record.index as u32,
            ..LightEntry::default()
        };
        let receive = &plan.recipe.receive;
        for (i, &image) in receive.inputs.iter().enumerate() {
            let binding = map_binding(plan, light, i, image);
            let map = self.interface.maps.iter().position(|map| *map == binding);
            entry.images[i] = ImagePlace {
                texture: map.unwrap_or(0) as u32,
                first: light.maps.ranges[image].layers.start,
            };
        }
        let mut first_given = 0;
        if plan.recipe.hierarchy.is_some() {
            entry.tables[0] = self.tables.place_of(Region::Light(id));
            entry.tables[1] = self.tables.place_of(Region::Corners);
            first_given = DeviceHierarchy::TABLES;
        }
        for (i, table) in (first_given..).zip(plan.given_tables()) {
            entry.tables[i] = self.tables.place(table);
        }
        entry
    }

    /// Refuses the lights of least priority whose tables, together with those of all lights before
    /// them, exceed what a shader can bind.
    fn refuse_long_tables(&mut self, lights: &mut SlotMap<LightKey, HeldLight>, most: u64) {
        let mut bytes = self.tables.region_bytes();
        // Add up the tables by priority, counting shared ones once.
        let mut order: Vec<LightKey> = lights.keys().collect();
        order.sort_by(|&a, &b| {
            let priority = |id: LightKey| lights[id].settings.priority;
            priority(b).total_cmp(&priority(a))
        });
        let mut counted: Vec<Arc<[[u32; 4]]>> = Vec::new();
        for id in order {
            let light = &mut lights[id];
            let Some(plan) = light.state.shown_plan() else {
                continue;
            };
            let mut with_own = bytes;
            let counted_before = counted.len();
            for rows in plan.given_tables().map(Table::rows) {
                if !counted.iter().any(|other| Arc::ptr_eq(other, rows)) {
                    counted.push(rows.clone());
                    with_own += size_of_val::<[[u32; 4]]>(rows) as u64;
                }
            }
            if with_own <= most || with_own == bytes {
                bytes = with_own;
            } else {
                counted.truncate(counted_before);
                let why = format!(
                    "with its tables, the lights of the set need {} KiB, and shaders of the device can bind {} KiB; request a device with a greater `max_storage_buffer_binding_size`",
                    with_own >> 10,
                    most >> 10
                );
                light.state = LightState::Refused(RecipeError::unsupported_because(why));
                self.forget(id);
            }
        }
    }

    /// Drops the tables that no shown light uses, if lights changed.
    pub(crate) fn retain_tables(&mut self, lights: &SlotMap<LightKey, HeldLight>) {
        if !self.has_changed {
            return;
        }
        let plans = || lights.values().filter_map(|light| light.state.shown_plan());
        let is_used = |rows: &Arc<[[u32; 4]]>| {
            plans().any(|plan| plan.given_tables().any(|table| table.rows() == rows))
        };
        let is_built = |id: LightKey| {
            let shown = lights.get(id).and_then(|light| light.state.shown_plan());
            shown.is_some_and(|plan| plan.recipe.hierarchy.is_some())
        };
        self.tables.retain(is_used, is_built);
    }

    /// Returns the number of a text: that of an equal one, or a new one.
    fn number(&mut self, text: &UnnumberedText) -> u64 {
        let text = text.numbered(0);
        let hash = [0_u8, 1].map(|seed| {
            let mut hasher = DefaultHasher::new();
            (seed, &text).hash(&mut hasher);
            hasher.finish()
        });
        let known = self.texts.iter().position(|other| *other == hash);
        let index = known.unwrap_or_else(|| {
            self.texts.push(hash);
            self.texts.len() - 1
        });
        index as u64 + 1
    }

    fn make_text(&mut self) -> Result<(), Invalid> {
        let text = self.interface.parts().text()?;
        self.revision = self.number(&text);
        self.text = text.numbered(first_binding(self.revision));
        self.prefixed_text = with_prefix(&self.text, &self.prefix)?;
        Ok(())
    }

    fn bind(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        pool: &LayerPool,
    ) {
        let interface = &self.interface;
        // Both buffers were uploaded.
        let buffers = [interface.numbers.buffer(), self.tables.buffer()];
        let buffers = buffers.into_iter().flatten().cloned().map(Bound::Buffer);
        let views = interface
            .maps
            .iter()
            .filter_map(|map| pool.whole(map.class));
        let mut bound: Vec<Bound> = buffers.chain(views.cloned().map(Bound::View)).collect();
        let slots = interface.slots();
        if bound.len() < slots.len() {
            bound.push(Bound::Sampler(pipelines.sampler(factory.device)));
        }
        self.binding.first = first_binding(self.revision);
        let entries = slots.into_iter().zip(bound).collect();
        let layouts = &mut pipelines.layouts;
        self.binding
            .bind(factory, layouts, STAGES, "umbrage lights", entries);
    }
}

impl Interface {
    fn clear(&mut self) {
        self.kinds.clear();
        self.numbers.kernels.clear();
        self.maps.clear();
        self.classes.clear();
    }

    /// Returns the index of a kind of kernel.
    fn index_of(&self, kind: &KernelKind) -> Option<usize> {
        self.kinds.iter().position(|other| other == kind)
    }

    /// Returns whether a kernel of this kind can read these textures.
    fn has(&self, kind: &KernelKind, maps: &[MapBinding]) -> bool {
        let Some(kind) = self.index_of(kind) else {
            return false;
        };
        maps.iter()
            .zip(&self.classes[kind])
            .all(|(binding, classes)| {
                let map = self.maps.iter().position(|map| map == binding);
                map.is_some_and(|map| classes.contains(&map))
            })
    }

    /// Registers a kind of kernel that reads these textures.
    ///
    /// Errors with `Unsupported` if a shader can't bind that much.
    fn register(&mut self, kind: &KernelKind, maps: &[MapBinding]) -> Result<(), RecipeError> {
        let index = match self.index_of(kind) {
            Some(index) => index,
            None => self.add_kind(kind)?,
        };
        for (i, &binding) in maps.iter().enumerate() {
            let known = self.maps.iter().position(|map| *map == binding);
            let map = match known {
                Some(map) => map,
                None => self.add_map(binding)?,
            };
            let classes = &mut self.classes[index][i];
            if !classes.contains(&map) {
                classes.push(map);
            }
        }
        Ok(())
    }

    fn add_kind(&mut self, kind: &KernelKind) -> Result<usize, RecipeError> {
        if self.kinds.len() == MAX_KINDS {
            let why = format!("the lights of the set have {MAX_KINDS} other kinds of kernels");
            return Err(RecipeError::unsupported_because(why));
        }
        let stride = kind.uniforms.map_or(0, |(_, size)| size);
        self.kinds.push(kind.clone());
        self.numbers.kernels.push(Records::new(stride));
        self.classes.push(vec![Vec::new(); kind.shape.images.len()]);
        Ok(self.kinds.len() - 1)
    }

    fn add_map(&mut self, binding: MapBinding) -> Result<usize, RecipeError> {
        if self.maps.len() == self.most_maps {
            let why = format!(
                "the lights of the set have maps of {} other sizes and formats, which is the limit of shaders on this device",
                self.most_maps
            );
            return Err(RecipeError::unsupported_because(why));
        }
        self.maps.push(binding);
        Ok(self.maps.len() - 1)
    }

    /// Ensures that each kind has at least as many records as lights with these plans.
    fn reserve_records(&mut self, plans: &[&LightPlan]) {
        for (kind, records) in self.kinds.iter().zip(&mut self.numbers.kernels) {
            let count = plans.iter().filter(|plan| plan.kind == *kind).count();
            while records.count() < count {
                records.push();
            }
        }
    }

    fn parts(&self) -> TextParts<'_> {
        TextParts {
            group: self.group,
            kinds: &self.kinds,
            numbers: &self.numbers,
            maps: &self.maps,
            classes: &self.classes,
        }
    }

    /// Returns the slots of the bind group: uniforms, tables, textures, and a sampler if kernels
    /// compare with it.
    fn slots(&self) -> Vec<Slot> {
        let numbers = match self.numbers.space() {
            NumberSpace::Uniform => Slot::Uniform,
            NumberSpace::Storage => Slot::Table,
        };
        let mut slots = vec![numbers, Slot::Table];
        let image = |map: &MapBinding| InputImage {
            kind: map.kind,
            layered: true,
        };
        slots.extend(self.maps.iter().map(|map| image_slot(image(map))));
        if self.maps.iter().any(|map| map.kind == InputKind::Compared) {
            slots.push(Slot::Sampler);
        }
        slots
    }
}

/// Returns the number of the first binding. It differs between texts, so that the graphics API
/// refuses pipelines with another one.
fn first_binding(revision: u64) -> u32 {
    (revision % FIRST_BINDINGS) as u32
}

/// Returns the bindings of a light's kernel.
fn map_bindings(plan: &LightPlan, light: &HeldLight) -> Vec<MapBinding> {
    let inputs = plan.recipe.receive.inputs.iter().enumerate();
    inputs
        .map(|(i, &image)| map_binding(plan, light, i, image))
        .collect()
}

/// Returns the binding of input `i` of a light's kernel, which is this image of the recipe.
fn map_binding(plan: &LightPlan, light: &HeldLight, i: usize, image: usize) -> MapBinding {
    MapBinding {
        class: light.maps.ranges[image].class,
        kind: plan.kind.shape.images[i].kind,
    }
}

/// Returns the error of a set that is not prepared.
pub(crate) fn unprepared_error() -> BackendError {
    let help = "call `prepare` first, and check its error";
    Invalid::new("light set", "has nothing prepared", help).into()
}
