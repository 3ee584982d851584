//! [`LightSet`]: the shadows of many lights in one renderer.

mod buffers;
mod cast_list;
mod casters;
mod culling;
mod light;
mod masks;
mod plan;
mod pool;
mod report;
mod shader;
mod steady_box;
mod still_layers;
mod submitted;
mod text;

pub use casters::{CasterId, Mesh, MeshId};
pub use light::{LightId, SetLight, Unserved};
pub use masks::{MaskFormat, MaskInputs, NormalCoding, SetNormals, SetReceivers};
pub use report::SetReport;

use crate::{
    cast::Layouts,
    device::{
        error_scopes::Scopes,
        later_errors::{ApiErrors, LaterErrors},
    },
    light_set::{
        buffers::Uploaded,
        cast_list::{CastList, CastPart, Instances},
        casters::Casters,
        culling::ShownSlots,
        light::{LightCast, LightState, StillLayer},
        masks::MaskStage,
        plan::{Difference, LightPlan},
        pool::LayerPool,
        shader::SetShader,
        submitted::Submission,
    },
    renderer::{check_device, limits},
    resources::{
        counters::{Counters, ResourceFactory},
        kernel_stage::Sources,
        pipelines::Pipelines,
        tables::Tables,
    },
    targets::CastTarget,
};
use glam::Affine3A;
use slotmap::SlotMap;
use std::sync::Arc;
use umbrage_core::{
    Aabb, BackendError, BackendLimits, Camera, Geometry, Invalid, Light, RecipeError,
    ShadowTechnique, View, invalid,
};
use wgpu::{BindGroup, BindGroupLayout, CommandEncoder, Device, Queue, RenderPass, TextureView};

/// What a set may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SetBudget {
    /// Most bytes of all lights' layers together. Lights that don't fit, those of the least priority, are not served.
    pub bytes: u64,
    /// Most layers drawn in a frame, but always those of one light. The others keep what was drawn before, or wait: see
    /// [`Unserved::Waiting`].
    pub redraws: u32,
}

impl Default for SetBudget {
    /// 256 MiB, and no bound on redraws.
    fn default() -> Self {
        Self {
            bytes: 256 << 20,
            redraws: u32::MAX,
        }
    }
}

/// Whether a layer in which something moves keeps what is still in a layer of its own, which is copied instead of drawn again.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StillLayers {
    /// Where drawing what is still would take longer than the copy.
    #[default]
    Auto,
    /// Wherever something moves.
    Always,
    /// Nowhere.
    Never,
}

/// Options that hold for all that a set does.
#[derive(Clone, Debug, Default)]
pub struct LightSetOptions {
    /// Index of the bind group that [`LightSet::wgsl`] declares: the only one that the set takes.
    pub group: u32,
    /// Stands before every name that [`LightSet::wgsl`] declares.
    pub prefix: String,
    /// What the set may take.
    pub budget: SetBudget,
    /// Whether layers are split by what moves.
    pub still_layers: StillLayers,
    /// When errors of the graphics API are told.
    pub errors: ApiErrors,
}

/// What a frame is planned for.
#[derive(Clone, Copy, Debug)]
pub struct SetFrame<'a> {
    /// The camera.
    pub camera: &'a Camera,
    /// The casters' triangles, where the program has them: techniques that trace rays need them.
    pub geometry: Option<FrameGeometry<'a>>,
}

/// A geometry that may change between frames.
#[derive(Clone, Copy, Debug)]
pub struct FrameGeometry<'a> {
    /// The triangles.
    pub triangles: &'a Geometry,
    /// Another number whenever the triangles changed.
    pub revision: u64,
}

/// The shadows of any number of lights, each by a technique of its own: one [`prepare`](Self::prepare), one
/// [`encode`](Self::encode), one bind group and one WGSL text for all of them.
///
/// The set keeps casters and lights from frame to frame, and draws only what changed: a layer is drawn again when its light
/// moved, or when a caster that may show in it did. In a frame in which nothing changed, nothing is drawn or written.
///
/// ```no_run
/// use std::sync::Arc;
/// use umbrage_core::{BackendError, Camera, Light, ShadowTechnique};
/// use umbrage_wgpu::{LightSet, LightSetOptions, SetFrame, SetLight, wgpu};
///
/// /// Once: a set with one light, whose text goes before the program's own fragment shader.
/// fn start(
///     device: &wgpu::Device,
///     light: Light,
///     technique: Arc<dyn ShadowTechnique>,
/// ) -> Result<LightSet, BackendError> {
///     let options = LightSetOptions { group: 1, ..LightSetOptions::default() };
///     let mut set = LightSet::new(device, options)?;
///     set.add_light(SetLight { light, technique, priority: 1.0 })?;
///     Ok(set)
/// }
///
/// /// Every frame; then set `set.bind_group()` at group 1, and call `shadow(light, position, normal, pixel)`.
/// fn frame(
///     set: &mut LightSet,
///     device: &wgpu::Device,
///     queue: &wgpu::Queue,
///     encoder: &mut wgpu::CommandEncoder,
///     camera: &Camera,
/// ) -> Result<(), BackendError> {
///     set.prepare(device, queue, &SetFrame { camera, geometry: None })?;
///     set.encode(encoder)
/// }
/// ```
///
/// # Order
/// Prepare, encode, and submit the encoder (or drop it), then prepare the next frame. What `prepare` writes is in place from
/// the next submission on. An encoder that is dropped without being submitted is found out: what it would have drawn is drawn
/// with the next frame.
#[derive(Debug)]
pub struct LightSet {
    device: Device,
    options: LightSetOptions,
    limits: BackendLimits,
    counters: Counters,
    pipelines: Pipelines,
    /// Tables of filters.
    tables: Tables,
    casters: Casters,
    instances: Instances,
    lights: SlotMap<LightId, LightState>,
    /// By index in shaders, whether a light has it.
    indices: Vec<bool>,
    pool: LayerPool,
    shader: SetShader,
    masks: MaskStage,
    list: CastList,
    /// Scratch: the slots that show in a layer.
    shown: ShownSlots,
    errors: LaterErrors,
    submission: Submission,
    layouts: Option<Layouts>,
    /// The lights that get new numbers or layers in this frame. Its memory is used again.
    chosen: Vec<LightId>,
    /// What the last plans were made for.
    planned: Option<PlannedFor>,
    /// Whether layers must be dealt out anew.
    layers_changed: bool,
    report: SetReport,
}

/// What all plans depend on, beside their lights.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PlannedFor {
    camera: Camera,
    casters: Aabb,
    geometry: Option<u64>,
}

impl LightSet {
    /// Returns an empty set for this device.
    ///
    /// # Errors
    /// Errors if the device has too few bind groups for [`LightSetOptions::group`], or if the prefix can't begin a WGSL identifier.
    pub fn new(device: &Device, options: LightSetOptions) -> Result<Self, BackendError> {
        let groups = device.limits().max_bind_groups;
        if options.group >= groups {
            let why = format!("is {}", options.group);
            let help = format!("use 0 to {}", groups - 1);
            return Err(Invalid::new("bind group of the light set", why, help).into());
        }
        let shader = SetShader::new(options.group, &options.prefix, &device.limits())?;
        Ok(Self {
            device: device.clone(),
            options,
            limits: limits(device),
            counters: Counters::default(),
            pipelines: Pipelines::default(),
            tables: Tables::default(),
            casters: Casters::default(),
            instances: Instances::default(),
            lights: SlotMap::with_key(),
            indices: Vec::new(),
            pool: LayerPool::default(),
            shader,
            masks: MaskStage::default(),
            list: CastList::default(),
            shown: ShownSlots::default(),
            errors: LaterErrors::default(),
            submission: Submission::default(),
            layouts: None,
            chosen: Vec::new(),
            planned: None,
            layers_changed: false,
            report: SetReport::default(),
        })
    }

    /// Adds a mesh, which casts nothing yet.
    ///
    /// # Errors
    /// Errors, with the mesh's label, if a buffer lacks a usage, if layout or range don't fit the buffers, or if the bounds are empty
    /// or not finite.
    pub fn add_mesh(&mut self, mesh: &Mesh<'_>) -> Result<MeshId, Invalid> {
        self.casters.add_mesh(mesh, &self.device.limits())
    }

    /// Removes a mesh, and with it what keeps its buffers alive.
    ///
    /// # Errors
    /// Errors if casters use it, or if there is no such mesh.
    pub fn remove_mesh(&mut self, mesh: MeshId) -> Result<(), Invalid> {
        self.casters.remove_mesh(mesh)
    }

    /// Places a mesh into the world, as one more caster. Casters of one mesh are drawn as instances.
    ///
    /// # Errors
    /// Errors if there is no such mesh, or if the placement is not finite.
    pub fn add_caster(
        &mut self,
        mesh: MeshId,
        world_from_local: Affine3A,
    ) -> Result<CasterId, Invalid> {
        self.casters.add(mesh, world_from_local)
    }

    /// Moves a caster. Where it was and where it is, layers are drawn again; if it stays, nothing is.
    ///
    /// # Errors
    /// Errors if there is no such caster, or if the placement is not finite.
    pub fn move_caster(
        &mut self,
        caster: CasterId,
        world_from_local: Affine3A,
    ) -> Result<(), Invalid> {
        self.casters.place(caster, world_from_local)
    }

    /// Removes a caster.
    ///
    /// # Errors
    /// Errors if there is no such caster.
    pub fn remove_caster(&mut self, caster: CasterId) -> Result<(), Invalid> {
        self.casters.remove(caster)
    }

    /// Says that something changed in a box (world space) that the set can't know of: vertices in a buffer, or what the caller
    /// draws itself ([`encode_with`](Self::encode_with)). Call it with the box before and with the box after.
    ///
    /// # Errors
    /// Errors if a number is not finite.
    pub fn touch(&mut self, bounds: &Aabb) -> Result<(), Invalid> {
        bounds.validate().map_err(|e| e.within("changed part"))?;
        self.casters.touch(bounds);
        Ok(())
    }

    /// Adds a light.
    ///
    /// # Errors
    /// Errors if a number of the light or the priority can't be used.
    pub fn add_light(&mut self, light: SetLight) -> Result<LightId, Invalid> {
        check_light(&light.light, light.priority)?;
        let free = self.indices.iter().position(|taken| !taken);
        let index = free.unwrap_or_else(|| {
            self.indices.push(false);
            self.indices.len() - 1
        });
        self.indices[index] = true;
        Ok(self.lights.insert(LightState::new(index as u32, light)))
    }

    /// Moves or changes a light. If it stays the same, nothing happens.
    ///
    /// # Errors
    /// Errors if there is no such light, or if one of its numbers can't be used.
    pub fn set_light(&mut self, id: LightId, light: Light) -> Result<(), Invalid> {
        let state = self.lights.get_mut(id).ok_or_else(unknown_light)?;
        check_light(&light, state.settings.priority)?;
        if state.settings.light != light {
            state.settings.light = light;
            state.has_changed = true;
        }
        Ok(())
    }

    /// Gives a light another technique, or another setting of its technique.
    ///
    /// # Errors
    /// Errors if there is no such light.
    pub fn set_technique(
        &mut self,
        id: LightId,
        technique: Arc<dyn ShadowTechnique>,
    ) -> Result<(), Invalid> {
        let state = self.lights.get_mut(id).ok_or_else(unknown_light)?;
        state.settings.technique = technique;
        state.has_changed = true;
        Ok(())
    }

    /// Sets what decides which lights come first where not all can be served.
    ///
    /// # Errors
    /// Errors if there is no such light, or if the priority is not finite.
    pub fn set_priority(&mut self, id: LightId, priority: f32) -> Result<(), Invalid> {
        let state = self.lights.get_mut(id).ok_or_else(unknown_light)?;
        invalid::finite("light's priority", &[priority])?;
        self.layers_changed |= state.settings.priority != priority;
        state.settings.priority = priority;
        Ok(())
    }

    /// Removes a light. Its index goes to the next light that is added.
    ///
    /// # Errors
    /// Errors if there is no such light.
    pub fn remove_light(&mut self, id: LightId) -> Result<(), Invalid> {
        let mut state = self.lights.remove(id).ok_or_else(unknown_light)?;
        self.indices[state.index as usize] = false;
        self.shader.forget(&mut state);
        for range in &state.ranges {
            self.pool.give_back(range);
        }
        self.layers_changed = true;
        Ok(())
    }

    /// Returns a light's index, for `shadow` in shaders. It stays as long as the light does.
    ///
    /// # Errors
    /// Errors if there is no such light.
    pub fn index_of(&self, id: LightId) -> Result<u32, Invalid> {
        let state = self.lights.get(id).ok_or_else(unknown_light)?;
        Ok(state.index)
    }

    /// Returns the lights that cast no shadows, as of the last [`prepare`](Self::prepare), and why.
    pub fn unserved(&self) -> impl Iterator<Item = (LightId, Unserved)> + '_ {
        self.lights
            .iter()
            .filter_map(|(id, light)| Some((id, light.unserved()?)))
    }

    /// Returns what the last [`prepare`](Self::prepare) found to do.
    pub fn report(&self) -> &SetReport {
        &self.report
    }

    /// Returns the box for which lights are planned: one around all casters whose sides lie on a coarse grid, so that it stays the
    /// same while casters move a little, and with it maps that are fitted to it.
    pub fn casters_box(&self) -> Aabb {
        steady_box::around(&self.casters.bounds())
    }

    /// Returns how many casters there are.
    pub fn caster_count(&self) -> usize {
        self.casters.count()
    }

    /// Plans the lights that changed, finds the layers that must be drawn, and writes what they need.
    ///
    /// # Errors
    /// Errors if the camera can't be used or the device is another than the set's; with [`ApiErrors::AtOnce`] also if memory runs
    /// out, or a kernel's WGSL is at fault (with the compiler's message). After an error everything is made anew.
    pub fn prepare(
        &mut self,
        device: &Device,
        queue: &Queue,
        frame: &SetFrame<'_>,
    ) -> Result<&SetReport, BackendError> {
        check_device(device, &self.device)?;
        frame.camera.validate()?;
        if self.submission.was_dropped() {
            self.draw_all_again();
        }
        self.list.clear();
        self.report = SetReport::default();
        self.casters.begin_frame();
        self.plan_lights(frame);
        self.deal_out_layers();
        for light in self.lights.values_mut() {
            light.mark_stale(self.casters.changed(), self.casters.still_changed());
        }
        let mut chosen = std::mem::take(&mut self.chosen);
        self.choose_redraws(&mut chosen);
        // Where nothing new is shown nothing is made, and there is no error to ask the device for.
        let makes = self.shader.is_outdated()
            || self.casters.has_grown()
            || chosen.iter().any(|&id| self.lights[id].wanted.is_some());
        let scopes = makes.then(|| Scopes::open(device));
        let result = self.write(queue, &mut chosen);
        self.chosen = chosen;
        let closed = scopes.map_or(Ok(()), |scopes| {
            self.errors.close(scopes, self.options.errors)
        });
        let result = closed.and(result);
        if let Err(error) = result {
            self.make_anew();
            return Err(error);
        }
        self.casters.forget_changes();
        Ok(&self.report)
    }

    /// Records the passes that draw what [`prepare`](Self::prepare) found to be drawn; none if nothing changed.
    ///
    /// # Errors
    /// Errors if [`prepare`](Self::prepare) has not succeeded before.
    pub fn encode(&mut self, encoder: &mut CommandEncoder) -> Result<(), BackendError> {
        self.encode_with(encoder, |_, _| ())
    }

    /// Records the passes as [`encode`](Self::encode) does, and calls `own_draws` at the end of each one that draws casters, for what
    /// the caller draws itself (skinned meshes, leaves with holes): pipelines with the target's
    /// [`primitive`](CastTarget::primitive) and [`depth_stencil`](CastTarget::depth_stencil) and a vertex shader that ends in
    /// `clip_from_world * p_world`. Layers are not drawn again for what changes there: see [`touch`](Self::touch).
    ///
    /// # Errors
    /// Errors if [`encode`](Self::encode) does.
    pub fn encode_with(
        &mut self,
        encoder: &mut CommandEncoder,
        mut own_draws: impl FnMut(&mut RenderPass<'_>, &CastTarget),
    ) -> Result<(), BackendError> {
        if self.shader.bind_group().is_none() {
            return Err(unprepared());
        }
        if self.list.count() == 0 {
            return Ok(());
        }
        self.submission.watch(encoder, &self.device);
        let mut filtered: Option<LightId> = None;
        let mut casts = self.list.casts().enumerate().peekable();
        while let Some((pass, (id, cast, _))) = casts.next() {
            let light = &self.lights[id];
            if filtered != Some(id) {
                light.filters.clear(encoder);
                filtered = Some(id);
            }
            self.list.encode(
                encoder,
                pass,
                &light.casts[cast],
                &self.casters,
                &self.instances,
                &mut own_draws,
            );
            // The light's last cast: its filters follow.
            if casts.peek().is_none_or(|&(_, (next, ..))| next != id) {
                light.filters.encode(encoder, None);
            }
        }
        drop(casts);
        for (id, cast, part) in self.list.casts() {
            let cast = &mut self.lights[id].casts[cast];
            match (part, &mut cast.still) {
                (CastPart::Still, Some(still)) => still.is_stale = false,
                _ => cast.is_stale = false,
            }
        }
        self.list.clear();
        Ok(())
    }

    /// Returns the WGSL to paste before your own shader: `fn shadow(light: u32, position: vec3f, normal: vec3f, pixel: vec2u) -> f32`,
    /// the visibility of a light, 0..=1, at a position (world space) with a unit normal; lights that are not served are lit. `pixel`
    /// turns the patterns of kernels that vary from pixel to pixel. `shadow_on` takes a triangle's id besides, which kernels that
    /// trace rays need.
    ///
    /// The text changes with the kinds of kernels and the sizes of maps that lights use, as
    /// [`wgsl_revision`](Self::wgsl_revision) tells.
    pub fn wgsl(&self) -> &str {
        self.shader.text()
    }

    /// Returns a number that grows whenever [`wgsl`](Self::wgsl) and the bind group's layout change: then make the pipelines anew that
    /// contain the text.
    pub fn wgsl_revision(&self) -> u64 {
        self.shader.revision()
    }

    /// Returns what [`wgsl`](Self::wgsl) reads: set it at [`LightSetOptions::group`]. Ask for it in every frame, after
    /// [`prepare`](Self::prepare).
    ///
    /// # Errors
    /// Errors if [`encode`](Self::encode) does.
    pub fn bind_group(&self) -> Result<(&BindGroup, &BindGroupLayout), BackendError> {
        self.shader.bind_group().ok_or_else(unprepared)
    }

    /// Makes what [`encode_masks`](Self::encode_masks) needs, for renderers that shade from a G-buffer. Call it after
    /// [`prepare`](Self::prepare).
    ///
    /// # Errors
    /// Errors if nothing is prepared, if there is no such light, or if textures can't be used: with what to change. As
    /// [`prepare`](Self::prepare), with [`ApiErrors::AtOnce`] also with errors of the graphics API.
    pub fn prepare_masks(
        &mut self,
        queue: &Queue,
        inputs: &MaskInputs<'_>,
    ) -> Result<(), BackendError> {
        inputs.validate()?;
        let mut lights = Vec::with_capacity(inputs.lights.len());
        for &id in inputs.lights {
            let light = self.lights.get(id).ok_or_else(unknown_light)?;
            lights.push(light.shown.is_some().then_some(light.index));
        }
        let device = self.device.clone();
        let scopes = Scopes::open(&device);
        let mut factory = ResourceFactory {
            device: &device,
            queue,
            counters: &mut self.counters,
        };
        let result = self.masks.prepare(
            &mut factory,
            &mut self.pipelines,
            &self.shader,
            inputs,
            lights.into_iter(),
        );
        let closed = self.errors.close(scopes, self.options.errors);
        let outcome = closed.and(result);
        if outcome.is_err() {
            self.masks = MaskStage::default();
        }
        outcome
    }

    /// Records a pass for each light that [`prepare_masks`](Self::prepare_masks) was given, after those of
    /// [`encode`](Self::encode). Returns the masks: a texture with a layer for each light, its visibility, 1 where nothing receives.
    ///
    /// # Errors
    /// Errors if [`prepare_masks`](Self::prepare_masks) has not succeeded before.
    pub fn encode_masks(&self, encoder: &mut CommandEncoder) -> Result<&TextureView, BackendError> {
        let help = "call `prepare_masks` first, and look at its error";
        self.masks
            .encode(encoder, &self.shader)
            .ok_or_else(|| Invalid::new("masks", "have nothing prepared", help).into())
    }

    /// Returns an error of the graphics API that came since this was last asked, with [`ApiErrors::Later`]. After one, everything is
    /// made anew with the next frame.
    pub fn take_error(&mut self) -> Option<BackendError> {
        let error = self.errors.take()?;
        self.make_anew();
        Some(error)
    }

    /// Returns the bytes of all maps, and of the layers that hold still casters.
    pub fn map_bytes(&self) -> u64 {
        self.pool.bytes() + still_bytes(&self.lights)
    }

    /// Returns how many GPU objects were made so far.
    #[cfg(feature = "testing")]
    pub fn counters(&self) -> Counters {
        self.counters
    }

    /// Makes new plans for the lights whose plan may have changed.
    fn plan_lights(&mut self, frame: &SetFrame<'_>) {
        let now = PlannedFor {
            camera: *frame.camera,
            casters: self.casters_box(),
            geometry: frame.geometry.map(|g| g.revision),
        };
        let has_changed = self.planned != Some(now);
        self.planned = Some(now);
        for light in self.lights.values_mut() {
            if !has_changed && !light.has_changed {
                continue;
            }
            light.has_changed = false;
            let view = View {
                camera: frame.camera,
                light: &light.settings.light,
                casters: now.casters,
                geometry: frame.geometry.map(|g| g.triangles),
                receivers: None,
                fits: None,
            };
            self.report.planned += 1;
            match plan(&*light.settings.technique, &view, &self.limits) {
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
    fn deal_out_layers(&mut self) {
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
        for &id in &order {
            let light = &mut self.lights[id];
            if light.has_room && light.shown.is_none() {
                take_layers(light, &mut self.pool, self.limits.layers);
            }
        }
    }

    /// Writes the lights that get new numbers or layers in this frame, those with the greatest urgency first.
    fn choose_redraws(&mut self, chosen: &mut Vec<LightId>) {
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
            let is_chosen = layers == 0 || layers <= left || is_first;
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
    fn write(&mut self, queue: &Queue, chosen: &mut Vec<LightId>) -> Result<(), BackendError> {
        let device = self.device.clone();
        let mut factory = ResourceFactory {
            device: &device,
            queue,
            counters: &mut self.counters,
        };
        let mut uploaded = Uploaded::default();
        let held = self.pool.bytes() + still_bytes(&self.lights);
        let mut bytes_left = self.options.budget.bytes.saturating_sub(held);
        let layouts = match self.layouts.take() {
            Some(layouts) => layouts,
            None => Layouts::new(&factory, &mut self.pipelines),
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
                    &self.casters,
                    cast,
                    &self.shown,
                );
                let is_split =
                    may_split && is_wanted && has_still_layer(&mut factory, cast, &mut bytes_left);
                let parts: &[CastPart] = match &cast.still {
                    _ if !is_split => &[CastPart::Whole],
                    Some(still) if !still.is_stale => &[CastPart::Moving],
                    _ => &[CastPart::Still, CastPart::Moving],
                };
                if !is_split {
                    cast.still = None;
                }
                for &part in parts {
                    self.list.push(
                        &mut factory,
                        &mut self.pipelines,
                        &layouts,
                        &self.casters,
                        id,
                        index,
                        cast,
                        &self.shown,
                        part,
                    );
                }
            }
        }
        self.layouts = Some(layouts);
        self.tables.forget_unreachable();
        uploaded.add(self.instances.upload(&mut factory, &mut self.casters));
        self.list.upload(&mut factory, &mut self.pipelines);
        let shader = self.shader.write(
            &mut factory,
            &mut self.pipelines,
            &mut self.lights,
            &self.pool,
            !lost.is_empty(),
        )?;
        uploaded.add(shader);
        self.report.redrawn = self.list.count() as u32;
        self.report.uploaded = uploaded.bytes + 64 * u64::from(self.report.redrawn);
        Ok(())
    }

    /// Marks everything to be drawn.
    fn draw_all_again(&mut self) {
        for light in self.lights.values_mut() {
            light.mark_all_stale();
        }
    }

    /// Forgets all GPU objects, so that the next frame makes them anew.
    fn make_anew(&mut self) {
        self.pipelines = Pipelines::default();
        self.layouts = None;
        self.masks = MaskStage::default();
        self.tables = Tables::default();
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

/// Plans a light.
fn plan(
    technique: &dyn ShadowTechnique,
    view: &View<'_>,
    limits: &BackendLimits,
) -> Result<LightPlan, RecipeError> {
    let recipe = technique.recipe(view)?;
    recipe.validate(limits)?;
    LightPlan::new(recipe)
}

/// Returns whether a light's layers are not those that its newest plan needs.
fn has_other_images(light: &LightState, pool: &LayerPool) -> bool {
    let Some(plan) = light.plan() else {
        return true;
    };
    let images = &plan.recipe.images;
    let fit = images.iter().zip(&light.ranges).all(|(image, range)| {
        pool.class(range.class) == pool::LayerClass::of(image)
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
fn still_bytes(lights: &SlotMap<LightId, LightState>) -> u64 {
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

fn check_light(light: &Light, priority: f32) -> Result<(), Invalid> {
    light.validate()?;
    invalid::finite("light's priority", &[priority])
}

fn unknown_light() -> Invalid {
    let help = "use an id that this set gave and that was not removed since";
    Invalid::new("light", "is not in the light set", help)
}

fn unprepared() -> BackendError {
    let help = "call `prepare` first, and look at its error";
    Invalid::new("light set", "has nothing prepared", help).into()
}

/// Programs share a set between threads.
#[cfg(not(target_arch = "wasm32"))]
const _: () = {
    const fn may_be_shared<T: Send + Sync>() {}
    may_be_shared::<LightSet>();
};
