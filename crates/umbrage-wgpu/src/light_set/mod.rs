//! [`LightSet`]: the shadows of many lights in one renderer.

mod buffers;
mod cast_list;
mod caster_lists;
mod casters;
pub(crate) mod corners;
mod culling;
mod dropped_encoders;
mod encoding;
mod light;
mod masks;
mod options;
mod plan;
mod playing;
mod pool;
mod prices;
mod report;
mod shader;
mod steady_box;
mod still_layers;
#[cfg(feature = "testing")]
mod testing;
mod text;
mod timestamps;

#[cfg(feature = "testing")]
pub use caster_lists::Listing;
pub use casters::{CasterId, CasterMesh, MeshId};
pub use light::{LightId, SetLight, Unserved};
pub use masks::{MaskFormat, MaskInputs, NormalCoding, SetNormals, SetReceivers};
pub use options::{FrameGeometry, LightSetOptions, SetBudget, SetFrame, StillLayers};
pub use report::SetReport;
pub use timestamps::{PassCasters, SetPass, SetTimestamps, TimedPass};

use crate::{
    cast::Layouts,
    device::{error_scopes::Scopes, later_errors::LaterErrors},
    light_set::{
        buffers::MAX_LIGHTS,
        cast_list::{CastList, Instances},
        caster_lists::CasterLists,
        casters::Casters,
        culling::ShownSlots,
        dropped_encoders::DroppedEncoders,
        light::LightState,
        masks::MaskStage,
        playing::still_bytes,
        pool::LayerPool,
        prices::PriceMeter,
        shader::SetShader,
        timestamps::PassTimer,
    },
    renderer::{check_device, limits},
    resources::{
        counters::{Counters, ResourceFactory},
        cut_outs::{CutOutBuffers, GpuCutOuts},
        pipelines::Pipelines,
        tables::Tables,
    },
    targets::CastTarget,
};
use glam::Affine3A;
use slotmap::SlotMap;
use std::sync::Arc;
use umbrage_core::{Aabb, BackendError, BackendLimits, Camera, Invalid, Light, ShadowTechnique};
use wgpu::{
    BindGroup, BindGroupLayout, CommandEncoder, Device, Features, Limits, Queue, RenderPass,
    TextureView,
};

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
    /// Casters with holes.
    cut_outs: Option<SetCutOuts>,
    instances: Instances,
    lights: SlotMap<LightId, LightState>,
    /// By index in shaders, whether a light has it.
    indices: Vec<bool>,
    pool: LayerPool,
    shader: SetShader,
    masks: MaskStage,
    list: CastList,
    lists: CasterLists,
    /// Why the device can't make lists of casters, if it can't.
    unlisted: Option<String>,
    /// Scratch: the slots that show in a layer.
    shown: ShownSlots,
    meter: PriceMeter,
    errors: LaterErrors,
    dropped_encoders: DroppedEncoders,
    layouts: Option<Layouts>,
    /// The lights that get new numbers or layers in this frame. Its memory is used again.
    chosen: Vec<LightId>,
    /// What the last plans were made for.
    planned: Option<PlannedFor>,
    /// Whether layers must be dealt out anew.
    layers_changed: bool,
    /// Whether casters were placed relative to another anchor since the last frame.
    is_rebased: bool,
    report: SetReport,
}

/// The casters with holes of a set.
#[derive(Debug)]
struct SetCutOuts {
    lists: GpuCutOuts,
    casters: Vec<CasterId>,
}

/// What all plans depend on, beside their lights.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PlannedFor {
    camera: Camera,
    casters: Aabb,
    geometry: Option<u64>,
}

impl LightSet {
    /// The features without which a set can't play: none. Where the device has `TIMESTAMP_QUERY` and
    /// `TIMESTAMP_QUERY_INSIDE_ENCODERS`, [`StillLayers::Auto`] goes by what copies and draws take there.
    pub const REQUIRED_FEATURES: Features = Features::empty();

    /// The limits within which a set can play: those of WebGL 2, and two storage buffers in fragment shaders. Larger maps and more
    /// layers than these limits have ask for more.
    pub const REQUIRED_LIMITS: Limits = Limits {
        max_storage_buffers_per_shader_stage: 2,
        max_storage_buffer_binding_size: 1 << 27,
        ..Limits::downlevel_webgl2_defaults()
    };

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
            cut_outs: None,
            instances: Instances::default(),
            lights: SlotMap::with_key(),
            indices: Vec::new(),
            pool: LayerPool::default(),
            shader,
            masks: MaskStage::default(),
            list: CastList::default(),
            lists: CasterLists::default(),
            unlisted: None,
            shown: ShownSlots::default(),
            meter: PriceMeter::new(device),
            errors: LaterErrors::default(),
            dropped_encoders: DroppedEncoders::of(device),
            layouts: None,
            chosen: Vec::new(),
            planned: None,
            layers_changed: false,
            is_rebased: false,
            report: SetReport::default(),
        })
    }

    /// Adds a mesh, which casts nothing yet.
    ///
    /// # Errors
    /// Errors, with the mesh's label, if a buffer lacks a usage, if layout or range don't fit the buffers, or if the bounds are empty
    /// or not finite.
    pub fn add_mesh(&mut self, mesh: &CasterMesh<'_>) -> Result<MeshId, Invalid> {
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

    /// Places a caster anew because the [`Anchor`](umbrage_core::Anchor) changed, to which all placements are relative. Call it for every
    /// caster in that frame, and [`set_light`](Self::set_light) for every light with a place.
    ///
    /// The next [`prepare`](Self::prepare) finds all layers to be drawn, whatever [`SetBudget::redraws`] says: those that waited would
    /// show what lies a kilometre away. Unlike after [`move_caster`](Self::move_caster), casters that were still count as still.
    ///
    /// # Errors
    /// Errors if [`move_caster`](Self::move_caster) does.
    pub fn rebase_caster(
        &mut self,
        caster: CasterId,
        world_from_local: Affine3A,
    ) -> Result<(), Invalid> {
        self.casters.rebase(caster, world_from_local)?;
        self.is_rebased = true;
        Ok(())
    }

    /// Removes a caster.
    ///
    /// # Errors
    /// Errors if there is no such caster.
    pub fn remove_caster(&mut self, caster: CasterId) -> Result<(), Invalid> {
        self.casters.remove(caster)
    }

    /// Sets the triangles with holes that cast beside the set's casters, those of a geometry, where that has them (world space). They
    /// replace those before; none leaves the set without any. Maps leave their holes out by the rule of all backends.
    ///
    /// The set's own meshes must not hold these triangles: they hold [`Geometry::casters_without_holes`](umbrage_core::Geometry::casters_without_holes).
    /// Techniques that ask triangles ([`SetFrame::geometry`]) find the holes in that geometry.
    ///
    /// # Errors
    /// Errors if positions are not finite.
    pub fn set_cut_outs(&mut self, cut_outs: Option<&CutOutBuffers>) -> Result<(), Invalid> {
        if let Some(before) = self.cut_outs.take() {
            for caster in before.casters {
                self.casters.remove_cut_outs(caster)?;
            }
        }
        let Some(CutOutBuffers { lists, parts }) = cut_outs else {
            return Ok(());
        };
        let mut casters = Vec::with_capacity(parts.len());
        for (triangles, bounds) in parts {
            casters.push(self.casters.add_cut_outs(lists, triangles, *bounds)?);
        }
        self.cut_outs = Some(SetCutOuts {
            lists: lists.clone(),
            casters,
        });
        Ok(())
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
    /// Errors if a number of the light or the priority can't be used, or if there are 4,096 lights.
    pub fn add_light(&mut self, light: SetLight) -> Result<LightId, Invalid> {
        check_light(&light.light, light.priority)?;
        if self.lights.len() == MAX_LIGHTS {
            let why = format!("has {MAX_LIGHTS} lights");
            let help = "remove one first, or use a second set";
            return Err(Invalid::new("light set", why, help));
        }
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
    /// Errors if there is no such light, or if the priority is negative or not finite.
    pub fn set_priority(&mut self, id: LightId, priority: f32) -> Result<(), Invalid> {
        let state = self.lights.get_mut(id).ok_or_else(unknown_light)?;
        check_priority(priority)?;
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

    /// Returns how many casters there are; a part of those with holes counts as one.
    pub fn caster_count(&self) -> usize {
        self.casters.count()
    }

    /// Plans the lights that changed, finds the layers that must be drawn, and writes what they need.
    ///
    /// # Errors
    /// Errors if the camera can't be used or the device is another than the set's; with [`ApiErrors::AtOnce`](crate::ApiErrors::AtOnce) also if memory runs
    /// out, or a kernel's WGSL is at fault (with the compiler's message). After an error everything is made anew.
    pub fn prepare(
        &mut self,
        device: &Device,
        queue: &Queue,
        frame: &SetFrame<'_>,
    ) -> Result<&SetReport, BackendError> {
        check_device(device, &self.device)?;
        frame.camera.validate()?;
        let is_rebased = std::mem::take(&mut self.is_rebased);
        if self.dropped_encoders.any() || is_rebased {
            self.draw_all_again();
        }
        self.list.clear();
        self.report = SetReport::default();
        self.meter.collect(queue);
        self.casters.begin_frame();
        self.plan_lights(frame);
        self.deal_out_layers();
        for light in self.lights.values_mut() {
            light.mark_stale(self.casters.changed(), self.casters.still_changed());
        }
        if !self.casters.changed().is_empty() || self.casters.has_grown() {
            self.lists.mark_stale();
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
    /// the caller draws itself (skinned meshes): pipelines with the target's
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
        self.encode_passes(encoder, &mut own_draws, None)
    }

    /// Records the passes as [`encode_with`](Self::encode_with) does, each between two timestamps. `passes` is filled with those that
    /// are timed.
    ///
    /// # Errors
    /// Errors if [`encode`](Self::encode) does.
    pub fn encode_timed(
        &mut self,
        encoder: &mut CommandEncoder,
        mut own_draws: impl FnMut(&mut RenderPass<'_>, &CastTarget),
        stamps: &SetTimestamps<'_>,
        passes: &mut Vec<TimedPass>,
    ) -> Result<(), BackendError> {
        let timer = PassTimer::new(stamps, passes);
        self.encode_passes(encoder, &mut own_draws, Some(timer))
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
    /// [`prepare`](Self::prepare), with [`ApiErrors::AtOnce`](crate::ApiErrors::AtOnce) also with errors of the graphics API.
    pub fn prepare_masks(
        &mut self,
        queue: &Queue,
        inputs: &MaskInputs<'_>,
    ) -> Result<(), BackendError> {
        inputs.validate()?;
        if inputs
            .lights
            .iter()
            .any(|&id| !self.lights.contains_key(id))
        {
            return Err(unknown_light().into());
        }
        // Where nothing new is made, there is no error to ask the device for.
        let makes = !self.masks.is_made_for(&self.shader, inputs);
        let scopes = makes.then(|| Scopes::open(&self.device));
        let mut factory = ResourceFactory {
            device: &self.device,
            queue,
            counters: &mut self.counters,
        };
        let lights = &self.lights;
        let shown = inputs.lights.iter().map(|&id| {
            let light = &lights[id];
            (id, light.shown.is_some().then_some(light.index))
        });
        let result = self.masks.prepare(
            &mut factory,
            &mut self.pipelines,
            &self.shader,
            inputs,
            shown,
        );
        let closed = scopes.map_or(Ok(()), |scopes| {
            self.errors.close(scopes, self.options.errors)
        });
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
        self.masks
            .encode(encoder, &self.shader, None)
            .ok_or_else(masks::unprepared)
    }

    /// Records the passes as [`encode_masks`](Self::encode_masks) does, each between two timestamps. `passes` is filled with those that
    /// are timed.
    ///
    /// # Errors
    /// Errors if [`encode_masks`](Self::encode_masks) does.
    pub fn encode_masks_timed(
        &self,
        encoder: &mut CommandEncoder,
        stamps: &SetTimestamps<'_>,
        passes: &mut Vec<TimedPass>,
    ) -> Result<&TextureView, BackendError> {
        let timer = PassTimer::new(stamps, passes);
        self.masks
            .encode(encoder, &self.shader, Some(timer))
            .ok_or_else(masks::unprepared)
    }

    /// Returns an error of the graphics API that came since this was last asked, with [`ApiErrors::Later`](crate::ApiErrors::Later). After one, everything is
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
}

fn check_light(light: &Light, priority: f32) -> Result<(), Invalid> {
    light.validate()?;
    check_priority(priority)
}

fn check_priority(priority: f32) -> Result<(), Invalid> {
    if priority.is_finite() && priority >= 0.0 {
        return Ok(());
    }
    let why = format!("is {priority}");
    Err(Invalid::new("light's priority", why, "use 0 or more"))
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
