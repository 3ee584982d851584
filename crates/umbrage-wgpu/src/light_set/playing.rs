//! The steps of a frame: plans, layers, the choice of what is redrawn, and what is written for it.

use super::{LightSet, PlannedFor};
use crate::{
    cast::Layouts,
    light_set::{
        buffers::{MAX_NAMED_LAYERS, Uploaded},
        cast_list::{CastList, CastSources, PassName},
        caster_lists::{CasterLists, why_not_listed},
        light::{LightCast, LightId, LightState, StillLayer},
        masks::MaskStage,
        options::SetFrame,
        plan::{Difference, LightPlan},
        pool::{LayerClass, LayerPool},
        shader::SetShader,
        still_layers,
        timestamps::PassCasters,
    },
    resources::{
        counters::ResourceFactory, cut_outs::cut_out_layout, kernel_stage::Sources,
        pipelines::Pipelines, tables::Tables,
    },
};
use slotmap::SlotMap;
use umbrage_core::{Aabb, BackendError, BackendLimits, Light, RecipeError, ShadowTechnique, View};
use wgpu::Queue;

impl LightSet {
    /// Checks whether the set can serve a light with a technique, and makes nothing on the device: for lists in which a user picks one. The
    /// technique makes its recipe, for which some go through all triangles of the frame: ask between frames, or about a small scene.
    ///
    /// # Errors
    /// Errors with the reason that [`Unserved::Refused`](crate::Unserved::Refused) would have. What depends on the other lights, such as
    /// budgets, is left out.
    pub fn check(
        &self,
        light: &Light,
        technique: &dyn ShadowTechnique,
        frame: &SetFrame<'_>,
    ) -> Result<(), RecipeError> {
        light.validate()?;
        let view = view_of(light, frame, self.casters_box());
        let unlisted = why_not_listed(&self.casters, &self.device.limits());
        let limits = PlanLimits {
            recipes: &self.limits,
            unlisted: unlisted.as_deref(),
        };
        plan(technique, &view, limits)?;
        Ok(())
    }

    /// Makes new plans for the lights whose plan may have changed.
    pub(super) fn plan_lights(&mut self, frame: &SetFrame<'_>) {
        let now = PlannedFor {
            camera: *frame.camera,
            casters: self.casters_box(),
            geometry: frame.geometry.map(|g| g.revision),
        };
        let before = self.planned.replace(now);
        let mut meshes_changed = false;
        let same_camera = before.is_some_and(|before| before.camera == now.camera);
        let same_casters = before
            .is_some_and(|before| before.casters == now.casters && before.geometry == now.geometry);
        if self.casters.has_grown() {
            // Meshes decide whether lists can be made.
            let unlisted = why_not_listed(&self.casters, &self.device.limits());
            meshes_changed = unlisted != self.unlisted;
            self.unlisted = unlisted;
        }
        let limits = PlanLimits {
            recipes: &self.limits,
            unlisted: self.unlisted.as_deref(),
        };
        for light in self.lights.values_mut() {
            let settings = &light.settings;
            let is_alike = same_camera || !settings.technique.follows_camera(&settings.light);
            if same_casters && is_alike && !light.has_changed && !meshes_changed {
                continue;
            }
            light.has_changed = false;
            let view = view_of(&light.settings.light, frame, now.casters);
            self.report.planned += 1;
            match plan(&*light.settings.technique, &view, limits) {
                Ok(plan) => {
                    let was_refused = light.refused.is_some();
                    let difference = light.take_plan(plan);
                    self.layers_changed |= was_refused || difference == Difference::Images;
                }
                Err(error) => {
                    light.refused = Some(error);
                    light.wanted = None;
                    self.layers_changed = true;
                }
            }
        }
    }

    /// Decides which lights have layers, and gives and takes them.
    pub(super) fn deal_out_layers(&mut self) {
        if !std::mem::take(&mut self.layers_changed) {
            return;
        }
        let mut order: Vec<LightId> = self.lights.keys().collect();
        order.sort_by(|&a, &b| {
            let a = &self.lights[a];
            let b = &self.lights[b];
            let by_priority = b.settings.priority.total_cmp(&a.settings.priority);
            by_priority.then(a.index.cmp(&b.index))
        });
        let mut bytes = 0;
        for &id in &order {
            let light = &mut self.lights[id];
            // Lights come first: what they leave is given to layers of still casters anew.
            for cast in &mut light.casts {
                cast.still = None;
            }
            let wanted = match light.plan() {
                Some(plan) if light.refused.is_none() => plan.bytes(),
                _ => u64::MAX,
            };
            light.has_room = wanted <= self.options.budget.bytes - bytes;
            if light.has_room {
                bytes += wanted;
            }
            if !light.has_room || has_other_images(light, &self.pool) {
                release(light, &mut self.pool, &mut self.shader);
            }
        }
        let most_layers = self.limits.layers.min(MAX_NAMED_LAYERS);
        for &id in &order {
            let light = &mut self.lights[id];
            if light.has_room && light.shown.is_none() {
                take_layers(light, &mut self.pool, most_layers);
            }
        }
    }

    /// Writes the lights that get new numbers or layers in this frame, those with the greatest urgency first.
    pub(super) fn choose_redraws(&mut self, chosen: &mut Vec<LightId>) {
        chosen.clear();
        for (id, light) in &self.lights {
            let is_idle = light.waiting_layers() == 0 && light.wanted.is_none();
            if light.has_room && light.refused.is_none() && !is_idle {
                chosen.push(id);
            }
        }
        let lights = &mut self.lights;
        chosen.sort_unstable_by(|&a, &b| {
            let a = &lights[a];
            let b = &lights[b];
            b.urgency()
                .total_cmp(&a.urgency())
                .then(a.index.cmp(&b.index))
        });
        let mut left = self.options.budget.redraws;
        let mut is_first = true;
        chosen.retain(|&id| {
            let light = &mut lights[id];
            let layers = light.waiting_layers();
            // New numbers alone cost nothing.
            let is_chosen = layers == 0 || layers <= left || is_first || light.is_undrawn();
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

    /// Makes and writes all that the chosen lights, moved casters and the shaders need.
    pub(super) fn write(
        &mut self,
        queue: &Queue,
        chosen: &mut Vec<LightId>,
    ) -> Result<(), BackendError> {
        let device = self.device.clone();
        let mut factory = ResourceFactory {
            device: &device,
            queue,
            counters: &mut self.counters,
        };
        let mut uploaded = Uploaded::default();
        let held = self.pool.bytes() + still_bytes(&self.lights);
        let mut bytes_left = self.options.budget.bytes.saturating_sub(held);
        let mut layouts = match self.layouts.take() {
            Some(layouts) => layouts,
            None => Layouts::new(&factory, &mut self.pipelines),
        };
        layouts.cut_outs = match &self.cut_outs {
            Some(held) => {
                let rule = held.lists.rule();
                Some(cut_out_layout(&factory, &mut self.pipelines, rule))
            }
            None => None,
        };
        let lost = self.pool.make_textures(&mut factory);
        for (id, light) in &mut self.lights {
            let has_lost = light.ranges.iter().any(|range| lost.contains(&range.class));
            if has_lost && light.shown.is_some() {
                // What was drawn is gone with the old texture. The budget can't put this off: shaders would read an empty one.
                let shown = light.shown.take();
                light.wanted = light.wanted.take().or(shown);
                if !chosen.contains(&id) {
                    chosen.push(id);
                }
            }
        }
        for &id in &*chosen {
            let light = &mut self.lights[id];
            if light.wanted.is_some() {
                self.shader.change();
            }
            show_wanted(
                light,
                &mut factory,
                &mut self.pipelines,
                &mut self.tables,
                &self.pool,
                &layouts,
            );
            let may_split = light.may_split();
            for index in 0..light.casts.len() {
                let cast = &mut light.casts[index];
                if !cast.is_stale {
                    continue;
                }
                cast.volume.find(self.casters.boxes(), &mut self.shown);
                let is_wanted = still_layers::is_wanted(
                    self.options.still_layers,
                    self.meter.prices(),
                    &self.casters,
                    cast,
                    &self.shown,
                );
                let is_split =
                    may_split && is_wanted && has_still_layer(&mut factory, cast, &mut bytes_left);
                let parts: &[PassCasters] = match &cast.still {
                    _ if !is_split => &[PassCasters::All],
                    Some(still) if !still.is_stale => &[PassCasters::Moving],
                    _ => &[PassCasters::Still, PassCasters::Moving],
                };
                if !is_split {
                    cast.still = None;
                }
                let sources = CastSources {
                    layouts: &layouts,
                    casters: &self.casters,
                    shown: &self.shown,
                };
                for &part in parts {
                    let name = PassName {
                        light: id,
                        cast: index,
                        part,
                    };
                    let pipelines = &mut self.pipelines;
                    self.list
                        .push(&mut factory, pipelines, &sources, cast, name);
                }
            }
        }
        self.layouts = Some(layouts);
        self.tables.forget_unreachable();
        uploaded.add(self.instances.upload(&mut factory, &mut self.casters));
        let holes = self.cut_outs.as_ref().map(|held| &held.lists);
        self.list.upload(&mut factory, &mut self.pipelines, holes);
        uploaded.add(self.write_shader(queue, !lost.is_empty())?);
        self.report.redrawn = self.list.count() as u32;
        self.report.uploaded = uploaded.bytes + 64 * u64::from(self.report.redrawn);
        Ok(())
    }

    /// Writes what shaders read of the lights, and what makes lists of casters. `maps_changed` says that textures were made anew.
    fn write_shader(
        &mut self,
        queue: &Queue,
        maps_changed: bool,
    ) -> Result<Uploaded, BackendError> {
        let device = self.device.clone();
        let mut factory = ResourceFactory {
            device: &device,
            queue,
            counters: &mut self.counters,
        };
        let has_moved = self.lists.make_room(
            &device,
            &mut self.lights,
            &self.casters,
            self.shader.tables_mut(),
        );
        if has_moved {
            self.shader.change();
        }
        let shader = self.shader.write(
            &mut factory,
            &mut self.pipelines,
            &mut self.lights,
            &self.pool,
            maps_changed,
        )?;
        self.lists.prepare(
            &mut factory,
            &mut self.pipelines,
            &self.lights,
            &self.casters,
            &self.instances,
            self.shader.tables(),
        );
        self.report.listed = self.lists.stale_count();
        Ok(shader)
    }

    /// Marks everything to be drawn.
    pub(super) fn draw_all_again(&mut self) {
        self.lists.mark_stale();
        for light in self.lights.values_mut() {
            light.mark_all_stale();
        }
    }

    /// Forgets all GPU objects, so that the next frame makes them anew.
    pub(super) fn make_anew(&mut self) {
        self.pipelines = Pipelines::default();
        self.layouts = None;
        self.masks = MaskStage::default();
        self.tables = Tables::default();
        self.lists = CasterLists::default();
        self.pool = LayerPool::default();
        self.list = CastList::default();
        self.instances.lose_buffer();
        self.shader.lose_buffers();
        for light in self.lights.values_mut() {
            light.ranges.clear();
            light.images.clear();
            light.casts.clear();
            light.filters = Default::default();
            let shown = light.shown.take();
            light.wanted = light.wanted.take().or(shown);
            self.shader.forget(light);
        }
        self.layers_changed = true;
    }
}

/// Returns what a light's plan is made for.
pub(super) fn view_of<'a>(light: &'a Light, frame: &SetFrame<'a>, casters: Aabb) -> View<'a> {
    View {
        camera: frame.camera,
        light,
        casters,
        geometry: frame.geometry.map(|g| g.triangles),
        receivers: None,
        fits: None,
    }
}

/// What plans depend on beside their view.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlanLimits<'a> {
    pub(super) recipes: &'a BackendLimits,
    /// Why the device can't make lists of casters, if it can't.
    pub(super) unlisted: Option<&'a str>,
}

/// Plans a light.
pub(super) fn plan(
    technique: &dyn ShadowTechnique,
    view: &View<'_>,
    limits: PlanLimits<'_>,
) -> Result<LightPlan, RecipeError> {
    if view.geometry.is_none()
        && let Some(made) = technique.device_recipe(view)
    {
        let made = made?;
        if let Some(why) = limits.unlisted {
            return Err(RecipeError::unsupported(why));
        }
        made.recipe.validate(limits.recipes)?;
        return LightPlan::of_lists(made);
    }
    let recipe = technique.recipe(view)?;
    recipe.validate(limits.recipes)?;
    LightPlan::new(recipe)
}

/// Returns whether a light's layers are not those that its newest plan needs.
fn has_other_images(light: &LightState, pool: &LayerPool) -> bool {
    let Some(plan) = light.plan() else {
        return true;
    };
    let images = &plan.recipe.images;
    let fit = images.iter().zip(&light.ranges).all(|(image, range)| {
        pool.class(range.class) == LayerClass::of(image)
            && range.layers.len() == image.layers as usize
    });
    images.len() != light.ranges.len() || !fit
}

/// Takes a light's layers away. It is shown again once it has layers that are drawn.
fn release(light: &mut LightState, pool: &mut LayerPool, shader: &mut SetShader) {
    for range in light.ranges.drain(..) {
        pool.give_back(&range);
    }
    light.images.clear();
    light.casts.clear();
    let shown = light.shown.take();
    light.wanted = light.wanted.take().or(shown);
    shader.forget(light);
}

/// Gives layers to a light. It has no room if a texture would need more than `most`.
fn take_layers(light: &mut LightState, pool: &mut LayerPool, most: u32) {
    if !light.ranges.is_empty() {
        return;
    }
    let Some(plan) = light.wanted.as_ref() else {
        return;
    };
    for image in &plan.recipe.images {
        let Some(range) = pool.take(image, most) else {
            for range in light.ranges.drain(..) {
                pool.give_back(&range);
            }
            light.has_room = false;
            return;
        };
        light.ranges.push(range);
    }
}

/// Makes a light's newest plan the one that is shown.
fn show_wanted(
    light: &mut LightState,
    factory: &mut ResourceFactory<'_>,
    pipelines: &mut Pipelines,
    tables: &mut Tables,
    pool: &LayerPool,
    layouts: &Layouts,
) {
    let Some(plan) = light.wanted.take() else {
        return;
    };
    let difference = light
        .shown
        .as_ref()
        .map_or(Difference::Images, |shown| plan.difference(shown));
    if difference == Difference::Images {
        let images = plan.recipe.images.iter().zip(&light.ranges);
        light.images = images
            .filter_map(|(&desc, range)| pool.image(desc, range))
            .collect();
    }
    if difference > Difference::Numbers {
        let mut sources = Sources {
            recipe: &plan.recipe,
            images: &light.images,
            tables,
        };
        light.filters.prepare(factory, pipelines, &mut sources);
    }
    light.shown = Some(plan);
    if difference > Difference::Numbers {
        light.make_casts(factory, &layouts.peeled);
    }
}

/// Returns the bytes of all layers that hold still casters.
pub(super) fn still_bytes(lights: &SlotMap<LightId, LightState>) -> u64 {
    let casts = lights.values().flat_map(|light| &light.casts);
    casts
        .filter_map(|cast| cast.still.as_ref())
        .map(StillLayer::bytes)
        .sum()
}

/// Returns whether a cast has a layer for the casters that are still; makes one, if it takes no more than the bytes that are left.
fn has_still_layer(
    factory: &mut ResourceFactory<'_>,
    cast: &mut LightCast,
    bytes_left: &mut u64,
) -> bool {
    if cast.still.is_some() {
        return true;
    }
    let bytes = still_layers::bytes_of(&cast.target);
    if bytes > *bytes_left {
        return false;
    }
    *bytes_left -= bytes;
    cast.still = Some(StillLayer::beside(factory, &cast.target));
    true
}
