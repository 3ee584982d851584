//! Preparation of a frame: plans, layers, the choice of redraws, and uploads.

use crate::{
    device::error_scopes::Scopes,
    light_set::{
        LightSet, PlannedFor, SetCutOuts,
        buffers::{MAX_NAMED_LAYERS, Uploaded},
        caster_hierarchies::{CasterHierarchies, why_no_hierarchy},
        ids::{LightId, LightKey},
        masks::{MaskInputs, MaskPass, MaskReceivers, MaskStage},
        options::{SetFrame, SetReport},
        passes::{CastSources, PassList},
        plan::{Difference, LightPlan, PlanInputs},
        pool::{LayerClass, LayerPool},
        shader::SetText,
        state::{HeldLight, LightMaps, LightState},
        still_layers::still_bytes,
    },
    resources::{
        counters::ResourceFactory, kernel_stage::Sources, pipelines::Pipelines, tables::Tables,
    },
};
use slotmap::{SecondaryMap, SlotMap};
use std::sync::Arc;
use umbrage_core::{BackendError, Light, RecipeError, ShadowTechnique, View};

impl LightSet {
    /// Checks whether the set supports a light with a technique. It creates nothing on the device,
    /// so it can be used to fill menus. Some techniques visit all triangles of the frame to compute
    /// their recipe: call it between frames, or for a small scene.
    ///
    /// # Errors
    /// Errors with the reason of [`Unserved::Refused`](crate::Unserved::Refused). Ignores
    /// everything that depends on the other lights, such as budgets.
    pub fn check(
        &self,
        light: &Light,
        technique: &dyn ShadowTechnique,
        frame: &SetFrame<'_>,
    ) -> Result<(), RecipeError> {
        light.validate()?;
        let unbuilt = why_no_hierarchy(&self.casters, &self.device.limits());
        let inputs = PlanInputs {
            recipes: &self.limits,
            unbuilt: unbuilt.as_deref(),
            cut_outs: self.cut_outs.as_ref().map(SetCutOuts::records),
        };
        let view = self.view(frame, light);
        plan_light(technique, &view, !self.casters.own().is_empty(), inputs)?;
        Ok(())
    }

    /// Returns the text of the next frame, with these techniques instead of the present ones. The
    /// set stays as it is: compile the pipelines, in the background if you like, then call
    /// [`set_technique`](Self::set_technique). Lights that are off don't count until they are
    /// switched on. Casters and lights that are added in between may lead to another text.
    ///
    /// # Errors
    /// Errors if one of these techniques is refused, with the reason of
    /// [`Unserved::Refused`](crate::Unserved::Refused), or if there is no such light. With
    /// [`ApiErrors::AtOnce`](crate::ApiErrors::AtOnce) it also errors with errors of the graphics
    /// API.
    pub fn text_with(
        &mut self,
        frame: &SetFrame<'_>,
        techniques: &[(LightId, Arc<dyn ShadowTechnique>)],
    ) -> Result<SetText, RecipeError> {
        let mut changed = SecondaryMap::new();
        for (id, technique) in techniques {
            changed.insert(self.light_key(*id)?, technique);
        }
        let unbuilt = why_no_hierarchy(&self.casters, &self.device.limits());
        let inputs = PlanInputs {
            recipes: &self.limits,
            unbuilt: unbuilt.as_deref(),
            cut_outs: self.cut_outs.as_ref().map(SetCutOuts::records),
        };
        let has_own = !self.casters.own().is_empty();
        // Plan all lights that are on, as `prepare` does.
        let mut made: SecondaryMap<LightKey, LightPlan> = SecondaryMap::new();
        for (key, light) in self.lights.iter().filter(|(_, light)| light.is_enabled) {
            let settings = &light.settings;
            let technique = changed.get(key).copied();
            let view = self.view(frame, &settings.light);
            let used = technique.unwrap_or(&settings.technique);
            match plan_light(&**used, &view, has_own, inputs) {
                Ok(plan) => drop(made.insert(key, plan)),
                Err(error) if technique.is_some() => return Err(error),
                // The light will be refused, and needs no text.
                Err(_) => {}
            }
        }
        let newest = |key: LightKey| -> Option<&LightPlan> {
            let light = &self.lights[key];
            let kept = light.state.newest().filter(|_| !light.is_enabled);
            made.get(key).or(kept)
        };
        // Determine the text of the lights that fit into the budget, in the set's order.
        let bytes = |key: LightKey| newest(key).map(LightPlan::bytes);
        let fitting = lights_within(self.options.budget.bytes, &self.lights, bytes);
        let plans: Vec<&LightPlan> = self
            .lights
            .keys()
            .filter(|key| fitting.contains(key))
            .filter_map(newest)
            .collect();
        // Catch errors of the graphics API: this creates the text's bind group layout.
        let scopes = Scopes::open(&self.device);
        let factory = ResourceFactory::new(&self.device, &self.queue, &mut self.counters);
        let text = self
            .shader
            .text_of(&factory, &mut self.pipelines, &self.pool, &plans);
        if let Err(error) = self.errors.close(scopes, self.options.errors) {
            self.forget_objects();
            return Err(RecipeError::unsupported_because(error.to_string()));
        }
        text
    }

    /// Plans the lights that changed, selects the layers to draw, and writes their inputs.
    ///
    /// # Errors
    /// Errors if the camera is invalid. With [`ApiErrors::AtOnce`](crate::ApiErrors::AtOnce) it
    /// also errors if memory runs out, or a kernel's WGSL is invalid (with the compiler's message).
    /// After an error all GPU objects are recreated.
    pub fn prepare(&mut self, frame: &SetFrame<'_>) -> Result<&SetReport, BackendError> {
        self.is_prepared = false;
        frame.camera.validate()?;
        let draws_all = self.unsubmitted_encoders.any() || self.casters.is_rebased();
        if draws_all {
            self.draw_all_again();
        }
        self.passes.clear();
        self.report = SetReport::default();
        self.meter.collect(&self.queue);
        self.casters.begin_frame();
        self.plan_lights(frame);
        let layers_changed = self.assign_layers();
        self.mark_stale();
        self.choose_redraws();
        let result = self.write_within_scopes(draws_all || layers_changed);
        if let Err(error) = result {
            self.forget_objects();
            return Err(error);
        }
        self.casters.forget_changes();
        self.is_prepared = true;
        Ok(&self.report)
    }

    /// Creates the resources of [`encode_masks`](Self::encode_masks), for renderers that shade from
    /// a G-buffer. Call it after [`prepare`](Self::prepare).
    ///
    /// # Errors
    /// Errors with advice if nothing is prepared, if there is no such light, or if textures can't
    /// be used. With [`ApiErrors::AtOnce`](crate::ApiErrors::AtOnce) it also reports errors of the
    /// graphics API, like [`prepare`](Self::prepare).
    pub fn prepare_masks(&mut self, inputs: &MaskInputs<'_>) -> Result<(), BackendError> {
        inputs.validate()?;
        for &id in inputs.lights {
            self.light_key(id)?;
        }
        // Choose the pass of each light. All ids were checked above.
        let lights = &self.lights;
        let keys = inputs
            .lights
            .iter()
            .filter_map(|id| id.key_in(self.number).ok());
        self.masks.set_lights(keys.map(|key| {
            let light = &lights[key];
            let pass = match light.state.shown_plan() {
                Some(plan) if light.is_enabled => MaskPass::new(plan.kind.in_compute, light.index),
                _ => MaskPass::Clear,
            };
            (key, pass)
        }));
        // Open scopes only for new objects: otherwise there are no device errors.
        let makes = !self.masks.is_made_for(&self.shader, inputs);
        let scopes = makes.then(|| Scopes::open(&self.device));
        let mut factory = ResourceFactory::new(&self.device, &self.queue, &mut self.counters);
        let result = self
            .masks
            .prepare(&mut factory, &mut self.pipelines, &self.shader, inputs);
        let closed = scopes.map_or(Ok(()), |scopes| {
            self.errors.close(scopes, self.options.errors)
        });
        let outcome = closed.and(result);
        if outcome.is_err() {
            self.masks = MaskStage::default();
        }
        outcome.map_err(|error| match &inputs.receivers {
            MaskReceivers::Depth { depth, .. } => depth.with_advice(error),
            MaskReceivers::Positions(_) => error,
        })
    }

    /// Replaces the plans that may have changed.
    fn plan_lights(&mut self, frame: &SetFrame<'_>) {
        // Compare the inputs with those of the last plan.
        let now = PlannedFor {
            camera: *frame.camera,
            casters: self.casters_box(),
            has_own: !self.casters.own().is_empty(),
            geometry: frame.geometry.map(|g| g.revision),
        };
        let before = self.planned.replace(now);
        let same_camera = before.is_some_and(|before| before.camera == now.camera);
        let same_casters = before.is_some_and(|before| {
            PlannedFor {
                camera: now.camera,
                ..before
            } == now
        });
        let casters_moved = !self.casters.changed_boxes().is_empty() || self.casters.is_rebased();
        // Meshes determine whether the device can build hierarchies.
        let mut meshes_changed = false;
        if self.casters.has_grown() {
            let unbuilt = why_no_hierarchy(&self.casters, &self.device.limits());
            meshes_changed = unbuilt != self.unbuilt;
            self.unbuilt = unbuilt;
        }
        let inputs = PlanInputs {
            recipes: &self.limits,
            unbuilt: self.unbuilt.as_deref(),
            cut_outs: self.cut_outs.as_ref().map(SetCutOuts::records),
        };
        // Replace the plans of lights with changed inputs.
        for light in self.lights.values_mut() {
            let settings = &light.settings;
            if casters_moved || light.has_changed {
                let distance = self.casters.distance_from(&settings.light);
                light.has_changed |= distance != light.nearest_caster;
                light.nearest_caster = distance;
            }
            let is_alike = same_camera || !settings.technique.follows_camera(&settings.light);
            if same_casters && is_alike && !light.has_changed && !meshes_changed {
                continue;
            }
            // Plan a light that is off when it is switched on.
            light.has_changed = !light.is_enabled;
            if !light.is_enabled {
                continue;
            }
            self.report.planned += 1;
            let view = frame.view_of(&settings.light, now.casters, light.nearest_caster);
            match plan_light(&*settings.technique, &view, now.has_own, inputs) {
                Ok(plan) => {
                    self.layers_changed |= light.state.take_plan(plan) == Difference::Images;
                }
                Err(error) => {
                    light.state = LightState::Refused(error);
                    self.layers_changed = true;
                }
            }
        }
    }

    /// Assigns layers to lights, and releases unused ones. Returns whether there was a reason to.
    fn assign_layers(&mut self) -> bool {
        if !std::mem::take(&mut self.layers_changed) {
            return false;
        }
        let lights = &self.lights;
        let bytes = |id: LightKey| lights[id].state.newest().map(LightPlan::bytes);
        let fitting = lights_within(self.options.budget.bytes, lights, bytes);
        for (id, light) in &mut self.lights {
            // Release the layers of still casters: they only get the bytes that lights leave.
            for cast in &mut light.maps.casts {
                cast.still = None;
            }
            if !fitting.contains(&id) || !has_layers_for_plan(light, &self.pool) {
                release_layers(light, &mut self.pool);
                self.shader.forget(id);
            }
        }
        // Allocate the layers.
        let most_layers = self.limits.layers.min(MAX_NAMED_LAYERS);
        for id in fitting {
            take_layers(&mut self.lights[id], &mut self.pool, most_layers);
        }
        true
    }

    /// Marks the layers with changes.
    fn mark_stale(&mut self) {
        let casters = &self.casters;
        for light in self.lights.values_mut() {
            light
                .maps
                .mark_stale(casters.changed_boxes(), casters.still_changed());
        }
        if !casters.changed_boxes().is_empty() || casters.has_grown() {
            self.hierarchies.mark_stale();
        }
    }

    /// Chooses the lights whose uniforms or layers change in this frame, by urgency.
    fn choose_redraws(&mut self) {
        let lights = &mut self.lights;
        let chosen = &mut self.passes.lights;
        for (id, light) in &*lights {
            if !light.is_enabled {
                continue;
            }
            let is_shown = light.state.shown_plan().is_some();
            if light.state.has_next() || is_shown && light.waiting_layers() > 0 {
                chosen.push(id);
            }
        }
        chosen.sort_unstable_by(|&a, &b| {
            let a = &lights[a];
            let b = &lights[b];
            let by_urgency = b.urgency().total_cmp(&a.urgency());
            by_urgency.then(a.index.cmp(&b.index))
        });
        let mut left = self.options.budget.redraws;
        let mut is_first = true;
        chosen.retain(|&id| {
            let light = &mut lights[id];
            let layers = light.waiting_layers();
            // New uniforms alone cost nothing.
            // Other kinds of kernels are shown together, so that the text changes once.
            let is_forced = light.is_undrawn() || light.state.changes_kind();
            let is_chosen = layers == 0 || layers <= left || is_first || is_forced;
            if is_chosen {
                left = left.saturating_sub(layers);
                light.age = 0;
            } else {
                light.age += 1;
                self.report.waiting += layers;
            }
            is_first &= layers == 0;
            is_chosen
        });
    }

    /// Writes the frame. Collects errors of the graphics API unless nothing changed: scopes allocate
    /// memory, and still frames must not. Almost any other frame may create objects: layers of still
    /// casters, pipelines of meshes that come into view, or smaller tables. `is_redrawn` is true if
    /// layers were assigned, or all are drawn again.
    fn write_within_scopes(&mut self, is_redrawn: bool) -> Result<(), BackendError> {
        let has_changes = is_redrawn
            || self.shader.has_changes()
            || self.casters.has_grown()
            || !self.casters.changed_boxes().is_empty()
            || !self.passes.lights.is_empty();
        if !has_changes {
            let before = self.counters;
            let result = self.write();
            if cfg!(feature = "testing") {
                assert_eq!(self.counters, before, "objects outside of error scopes");
            }
            return result;
        }
        let scopes = Scopes::open(&self.device);
        let result = self.write();
        let closed = self.errors.close(scopes, self.options.errors);
        closed.and(result)
    }

    /// Creates and writes the resources of the chosen lights, moved casters and shaders.
    fn write(&mut self) -> Result<(), BackendError> {
        let textures_changed = self.make_textures();
        self.show_plans();
        self.list_passes();
        let for_passes = self.upload_passes();
        let for_shaders = self.write_shader(textures_changed)?;
        self.report.redrawn = self.passes.count() as u32;
        self.report.uploaded = for_passes + for_shaders.bytes;
        Ok(())
    }

    /// Recreates the textures that are too small. Returns whether there were any.
    fn make_textures(&mut self) -> bool {
        let mut factory = ResourceFactory::new(&self.device, &self.queue, &mut self.counters);
        let lost = self.pool.make_textures(&mut factory);
        for (id, light) in &mut self.lights {
            let mut ranges = light.maps.ranges.iter();
            let has_lost = ranges.any(|range| lost.contains(&range.class));
            if has_lost && light.state.shown_plan().is_some() {
                // Ignore the budget: shaders would read an empty texture.
                light.state.lose_content();
                if light.is_enabled && !self.passes.lights.contains(&id) {
                    self.passes.lights.push(id);
                }
            }
        }
        !lost.is_empty()
    }

    /// Makes the newest plans of the chosen lights current.
    fn show_plans(&mut self) {
        let mut factory = ResourceFactory::new(&self.device, &self.queue, &mut self.counters);
        for &id in &self.passes.lights {
            let light = &mut self.lights[id];
            let Some(difference) = light.state.show_next() else {
                continue;
            };
            self.shader.change();
            let (Some(plan), maps) = (light.state.shown_plan(), &mut light.maps) else {
                continue;
            };
            if difference == Difference::Images {
                let images = plan.recipe.images.iter().zip(&maps.ranges);
                let image = |(&desc, range)| self.pool.image(desc, range);
                maps.images = images.filter_map(image).collect();
            }
            if difference > Difference::Numbers {
                let mut sources = Sources {
                    recipe: &plan.recipe,
                    images: &maps.images,
                    tables: &mut self.tables,
                    hierarchy: None,
                };
                let pipelines = &mut self.pipelines;
                maps.filters.prepare(&mut factory, pipelines, &mut sources);
                maps.make_casts(&mut factory, pipelines, plan);
            }
        }
        self.tables.forget_unreachable();
    }

    /// Lists the passes that draw the chosen lights' layers.
    fn list_passes(&mut self) {
        let held = self.pool.bytes() + still_bytes(&self.lights);
        let mut sources = CastSources {
            set: self.number,
            casters: &self.casters,
            option: self.options.still_layers,
            prices: self.meter.prices(),
            bytes_left: self.options.budget.bytes.saturating_sub(held),
        };
        let mut factory = ResourceFactory::new(&self.device, &self.queue, &mut self.counters);
        for i in 0..self.passes.lights.len() {
            let id = self.passes.lights[i];
            let maps = &mut self.lights[id].maps;
            let pipelines = &mut self.pipelines;
            self.passes
                .push_light(&mut factory, pipelines, &mut sources, id, maps);
        }
    }

    /// Uploads placements, and the inputs of the passes. Returns the number of bytes.
    fn upload_passes(&mut self) -> u64 {
        let mut factory = ResourceFactory::new(&self.device, &self.queue, &mut self.counters);
        let placements = self.casters.upload(&mut factory);
        let holes = self.cut_outs.as_ref().map(|held| &held.lists);
        let inputs = self
            .passes
            .upload(&mut factory, &mut self.pipelines, &self.lights, holes);
        placements + inputs
    }

    /// Writes the shader data of the lights, and the inputs of hierarchies.
    fn write_shader(&mut self, textures_changed: bool) -> Result<Uploaded, BackendError> {
        // Free the tables that no light uses before adding new ones.
        self.shader.retain_tables(&self.lights);
        let has_moved = self.hierarchies.make_room(
            &self.device,
            &mut self.lights,
            &self.casters,
            self.shader.tables_mut(),
        );
        if has_moved {
            self.shader.change();
        }
        let mut factory = ResourceFactory::new(&self.device, &self.queue, &mut self.counters);
        let uploaded = self.shader.write(
            &mut factory,
            &mut self.pipelines,
            &mut self.lights,
            &self.pool,
            textures_changed,
        )?;
        self.hierarchies.prepare(
            &mut factory,
            &mut self.pipelines,
            &self.lights,
            &self.casters,
            self.cut_outs.as_ref().map(SetCutOuts::records),
            self.shader.tables(),
        );
        self.report.hierarchies = self.hierarchies.due_count();
        Ok(uploaded)
    }

    /// Marks everything to be redrawn.
    fn draw_all_again(&mut self) {
        self.casters.instances.mark_outdated();
        self.hierarchies.mark_stale();
        for light in self.lights.values_mut() {
            light.maps.mark_all_stale();
        }
    }

    /// Drops all GPU objects, so that the next frame recreates them.
    pub(super) fn forget_objects(&mut self) {
        self.is_prepared = false;
        self.pipelines = Pipelines::default();
        self.masks = MaskStage::default();
        self.tables = Tables::default();
        self.hierarchies = CasterHierarchies::default();
        self.pool = LayerPool::default();
        self.passes = PassList::default();
        self.casters.instances.lose_buffer();
        self.shader.lose_buffers();
        for (id, light) in &mut self.lights {
            light.maps = LightMaps::default();
            light.state.lose_content();
            self.shader.forget(id);
        }
        self.layers_changed = true;
    }
}

/// Plans a light. The view's triangles may not contain casters that the program draws (`has_own`),
/// so maps are then fitted to the box around all casters.
fn plan_light(
    technique: &dyn ShadowTechnique,
    view: &View<'_>,
    has_own: bool,
    inputs: PlanInputs<'_>,
) -> Result<LightPlan, RecipeError> {
    if has_own && view.geometry.is_some() {
        let boxes_only = View {
            geometry: None,
            ..*view
        };
        let plan = LightPlan::of_light(technique, &boxes_only, inputs);
        let Err(RecipeError::Unsupported(_)) = plan else {
            return plan;
        };
        // Techniques without maps may need the triangles.
        return match LightPlan::of_light(technique, view, inputs) {
            Ok(with_triangles) if !with_triangles.recipe.casts.is_empty() => plan,
            with_triangles => with_triangles,
        };
    }
    LightPlan::of_light(technique, view, inputs)
}

/// Returns the lights whose maps fit into a number of bytes, by priority. `bytes` returns those that
/// a light needs; `None` if it has no plan.
fn lights_within(
    mut most: u64,
    lights: &SlotMap<LightKey, HeldLight>,
    bytes: impl Fn(LightKey) -> Option<u64>,
) -> Vec<LightKey> {
    let mut order: Vec<LightKey> = lights.keys().collect();
    order.sort_by(|&a, &b| {
        let (a, b) = (&lights[a], &lights[b]);
        let by_priority = b.settings.priority.total_cmp(&a.settings.priority);
        by_priority.then(a.index.cmp(&b.index))
    });
    order.retain(|&id| match bytes(id) {
        Some(needed) if needed <= most => {
            most -= needed;
            true
        }
        _ => false,
    });
    order
}

/// Returns whether a light's layers are those of its newest plan.
fn has_layers_for_plan(light: &HeldLight, pool: &LayerPool) -> bool {
    let Some(plan) = light.state.newest() else {
        return false;
    };
    let images = &plan.recipe.images;
    let ranges = &light.maps.ranges;
    let fits = images.iter().zip(ranges).all(|(image, range)| {
        pool.class(range.class) == LayerClass::of_image(image)
            && range.layers.len() == image.layers as usize
    });
    images.len() == ranges.len() && fits
}

/// Releases a light's layers.
fn release_layers(light: &mut HeldLight, pool: &mut LayerPool) {
    for range in light.maps.ranges.drain(..) {
        pool.give_back(&range);
    }
    light.maps.images.clear();
    light.maps.casts.clear();
    light.state.lose_layers();
}

/// Allocates layers for a light that has none, unless a texture would need more than `most`.
fn take_layers(light: &mut HeldLight, pool: &mut LayerPool, most: u32) {
    let LightState::OverBudget(plan) = &light.state else {
        return;
    };
    let ranges = &mut light.maps.ranges;
    if ranges.is_empty() {
        for image in &plan.recipe.images {
            let Some(range) = pool.take(image, most) else {
                for range in ranges.drain(..) {
                    pool.give_back(&range);
                }
                return;
            };
            ranges.push(range);
        }
    }
    light.state.gain_layers();
}
