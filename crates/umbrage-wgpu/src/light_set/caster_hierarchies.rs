//! Hierarchies of casters that the device builds, for kernels that read them.
//!
//! The corners of all casters and each light's hierarchy are among the tables of the set's shaders.
//! A hierarchy is rebuilt when casters or its light's view change. Lights are built one after
//! another, so they share the buffers that only the passes use.

use crate::{
    hierarchy::{
        layout::HierarchyLayout,
        passes::{
            Hierarchy, HierarchyInput, HierarchyPasses, capacity_for, corner_rows, most_bytes,
            why_not_built, why_too_large,
        },
    },
    light_set::{
        buffers::{Region, SharedTables},
        casters::Casters,
        corners::{CornerStage, triangle_count, why_unreadable},
        ids::LightKey,
        state::{HeldLight, LightState},
    },
    resources::{
        counters::{ResourceFactory, is_kept},
        pipelines::Pipelines,
    },
};
use slotmap::{SecondaryMap, SlotMap};
use umbrage_core::{CutOuts, DeviceHierarchy, RecipeError};
use wgpu::{CommandEncoder, ComputePassTimestampWrites, Device, Limits};

/// Builds the hierarchies on the device.
#[derive(Debug, Default)]
pub(crate) struct CasterHierarchies {
    corners: CornerStage,
    /// True if casters changed since their corners were written.
    corners_stale: bool,
    lights: SecondaryMap<LightKey, LightHierarchy>,
    passes: HierarchyPasses,
    /// [`SharedTables::moves`] at the time of the last build.
    moves: u64,
    /// Capacity for references, for tests; at least that of the casters.
    pub(crate) most_references: Option<u32>,
}

/// The hierarchy of one light.
#[derive(Debug, Default)]
struct LightHierarchy {
    hierarchy: Hierarchy,
    is_stale: bool,
    /// False if its light is switched off. It is then not rebuilt.
    is_enabled: bool,
}

/// Returns the reason why a device can't build hierarchies of these casters, or `None`.
pub(crate) fn why_no_hierarchy(casters: &Casters, limits: &Limits) -> Option<String> {
    if let Some(why) = why_not_built(triangle_count(casters), limits) {
        return Some(why);
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
    light.state.shown_plan()?.recipe.hierarchy.as_ref()
}

impl CasterHierarchies {
    /// Marks all hierarchies as out of date.
    pub(crate) fn mark_stale(&mut self) {
        self.corners_stale = true;
        for held in self.lights.values_mut() {
            held.is_stale = true;
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
            self.passes.drop_scratch();
            self.corners.drop_bindings();
            return tables.free(Region::Corners);
        }
        let triangles = triangle_count(casters) as u32;
        let limits = device.limits();
        let most = most_bytes(&limits);
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
            let Some(held) = self.lights.get_mut(id) else {
                continue;
            };
            if held.hierarchy.layout() != layout {
                changed |= tables.free(Region::Light(id));
            }
            held.is_stale |= held.hierarchy.resize(layout, triangles, made.faces);
        }
        // Reserve the regions, and refuse lights that exceed the device's limits.
        for (id, light) in lights.iter_mut() {
            let Some(layout) = self.lights.get(id).map(|held| held.hierarchy.layout()) else {
                continue;
            };
            let tables_bytes = 16 * u64::from(layout.rows()) + tables.bytes_without(id);
            let Some(why) = why_too_large(&layout, tables_bytes, triangles, &limits) else {
                changed |= tables.reserve(Region::Light(id), layout.rows());
                continue;
            };
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
        held.map_or(0, |held| held.hierarchy.layout().capacity)
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
        for (id, held) in &mut self.lights {
            let light = lights.get(id);
            held.is_enabled = light.is_some_and(|light| light.is_enabled);
            let made = light.and_then(shown_hierarchy);
            held.is_stale |= made.is_some_and(|made| held.hierarchy.uniforms != made.uniforms);
        }
        if self.due_count() == 0 {
            return;
        }
        if self.corners_stale {
            self.corners
                .prepare(factory, pipelines, casters, cut_outs, buffer, corners);
        }
        // Create the scratch buffers for the largest hierarchy.
        let layouts = self.lights.values().map(|held| held.hierarchy.layout());
        if self.passes.fit_scratch(factory, layouts) {
            self.drop_bindings();
        }
        // Write the inputs of each hierarchy that is out of date.
        let due = self.lights.iter_mut().filter(|(_, held)| held.is_due());
        let inputs = due.filter_map(|(id, held)| {
            let made = lights.get(id).and_then(shown_hierarchy)?;
            Some(HierarchyInput {
                hierarchy: &mut held.hierarchy,
                made,
                nodes: tables.place_of(Region::Light(id)).first,
                corners,
            })
        });
        self.passes
            .prepare(factory, pipelines, buffer, inputs.collect());
    }

    /// Drops the bind groups of all lights, and with them the buffers that only they keep. Lights
    /// that are due get others.
    fn drop_bindings(&mut self) {
        for held in self.lights.values_mut() {
            held.hierarchy.drop_binding();
        }
    }

    /// Returns the bytes of the buffers that only the passes use.
    pub(crate) fn scratch_bytes(&self) -> u64 {
        self.passes.scratch_bytes()
    }

    /// Returns the number of lights whose hierarchies are built in this frame.
    pub(crate) fn due_count(&self) -> u32 {
        self.lights.values().filter(|held| held.is_due()).count() as u32
    }

    /// Records the passes of all hierarchies that are due. `stamps` returns the timestamps of a
    /// light's pass.
    pub(crate) fn encode<'q>(
        &mut self,
        encoder: &mut CommandEncoder,
        lights: &SlotMap<LightKey, HeldLight>,
        mut stamps: impl FnMut(LightKey) -> Option<ComputePassTimestampWrites<'q>>,
    ) {
        for (id, held) in &mut self.lights {
            // Skip lights that were removed since `prepare`.
            if !held.is_due() || !lights.contains_key(id) {
                continue;
            }
            let (corners, stale) = (&self.corners, &mut self.corners_stale);
            self.passes
                .encode(encoder, &held.hierarchy, stamps(id), |pass| {
                    if std::mem::take(stale) {
                        corners.encode(pass);
                    }
                });
            held.is_stale = false;
        }
    }
}

impl LightHierarchy {
    /// Returns whether it must be built in this frame.
    fn is_due(&self) -> bool {
        self.is_enabled && self.is_stale
    }
}
