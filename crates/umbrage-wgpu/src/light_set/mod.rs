//! [`LightSet`]: the shadows of many lights in one renderer.

pub(crate) mod buffers;
mod caster_hierarchies;
mod casters;
mod computed_masks;
mod corners;
mod culling;
mod encode;
mod ids;
mod instances;
mod masks;
mod options;
mod own_casters;
mod passes;
mod plan;
mod pool;
mod prepare;
mod prices;
mod shader;
mod state;
mod steady_box;
mod still_layers;
#[cfg(feature = "testing")]
mod testing;
mod timestamps;
mod unsubmitted_encoders;

pub use casters::CasterMesh;
pub use ids::{CasterId, LightId, MeshId, OwnCasterId};
#[allow(deprecated, reason = "former names stay for one release")]
pub use masks::SetReceivers;
pub use masks::{MaskFormat, MaskInputs, MaskReceivers, NormalCoding, SetNormals};
#[allow(deprecated, reason = "former names stay for one release")]
pub use options::SetLight;
pub use options::{
    FrameGeometry, LightSetOptions, SetBudget, SetFrame, SetReport, ShadowedLight, StillLayers,
    Unserved,
};
pub use shader::SetText;
pub use timestamps::{PassCasters, SetPass, SetTimestamps, TimedPass};

use crate::{
    device::{
        later_errors::LaterErrors,
        requirements::{COMPUTE_LIMITS, check_limits, limits},
    },
    light_set::{
        buffers::MAX_LIGHTS,
        caster_hierarchies::CasterHierarchies,
        casters::Casters,
        ids::{CasterKey, LightKey, SetNumber},
        masks::MaskStage,
        passes::PassList,
        pool::LayerPool,
        prices::PriceMeter,
        shader::SetShader,
        state::HeldLight,
        still_layers::still_bytes,
        unsubmitted_encoders::UnsubmittedEncoders,
    },
    resources::{
        counters::Counters,
        cut_out_buffers::CutOutBuffers,
        cut_outs::GpuCutOuts,
        pipelines::{Pipelines, cast_layout},
        tables::Tables,
    },
};
use glam::Affine3A;
use slotmap::SlotMap;
use std::sync::Arc;
use umbrage_core::{
    Aabb, BackendError, BackendLimits, Camera, CutOuts, Invalid, Light, ShadowTechnique, View,
};
use wgpu::{BindGroup, BindGroupLayout, Device, Features, Limits, Queue};

/// The shadows of any number of lights, each with its own technique. One
/// [`prepare`](Self::prepare), one [`encode`](Self::encode), one bind group and one WGSL text serve
/// all of them.
///
/// The set keeps casters and lights between frames, and only redraws changes. A layer is redrawn if
/// its light moved, or if a caster that may be visible in it did. In a frame without changes,
/// nothing is drawn or written.
///
/// ```no_run
/// use std::sync::Arc;
/// use umbrage_core::{BackendError, Camera, Light, ShadowTechnique};
/// use umbrage_wgpu::{LightSet, LightSetOptions, SetFrame, ShadowedLight, wgpu};
///
/// /// Once: create a set with one light. Its text goes before the program's fragment shader.
/// fn start(
///     device: &wgpu::Device,
///     queue: &wgpu::Queue,
///     light: Light,
///     technique: Arc<dyn ShadowTechnique>,
/// ) -> Result<LightSet, BackendError> {
///     let options = LightSetOptions { group: 1, ..LightSetOptions::default() };
///     let mut set = LightSet::new(device, queue, options)?;
///     set.add_light(ShadowedLight { light, technique, priority: 1.0 })?;
///     Ok(set)
/// }
///
/// /// Every frame. Then set `set.bind_group()` at group 1, and call
/// /// `shadow(light, position, normal, pixel)`.
/// fn frame(
///     set: &mut LightSet,
///     encoder: &mut wgpu::CommandEncoder,
///     camera: &Camera,
/// ) -> Result<(), BackendError> {
///     set.prepare(&SetFrame { camera, geometry: None })?;
///     set.encode(encoder)
/// }
/// ```
///
/// # Order
/// Prepare, encode, and submit the encoder (or drop it), then prepare the next frame. Writes of
/// `prepare` take effect with the next submission. If an encoder is dropped, or not submitted
/// before the next `prepare`, the next frame draws all layers again. Browsers report submissions
/// too late for that. Elsewhere, `prepare` polls the device while an encoder waits.
#[derive(Debug)]
pub struct LightSet {
    /// Checks the ids that callers pass.
    number: SetNumber,
    device: Device,
    queue: Queue,
    options: LightSetOptions,
    limits: BackendLimits,
    // Scene.
    casters: Casters,
    /// Alpha-tested casters.
    cut_outs: Option<SetCutOuts>,
    lights: SlotMap<LightKey, HeldLight>,
    // Inputs of the lights' plans, and whether layers must be assigned again.
    planned: Option<PlannedFor>,
    /// Reason why the device can't build hierarchies of casters, if it can't.
    unbuilt: Option<String>,
    layers_changed: bool,
    /// True if the last frame was prepared without an error.
    is_prepared: bool,
    // Shader resources.
    pool: LayerPool,
    shader: SetShader,
    hierarchies: CasterHierarchies,
    masks: MaskStage,
    // Frame state.
    passes: PassList,
    report: SetReport,
    meter: PriceMeter,
    errors: LaterErrors,
    unsubmitted_encoders: UnsubmittedEncoders,
    // GPU objects shared by all lights.
    counters: Counters,
    pipelines: Pipelines,
    cast_layout: BindGroupLayout,
    /// Tables of filters.
    tables: Tables,
}

/// The alpha-tested casters of a set.
#[derive(Debug)]
struct SetCutOuts {
    lists: GpuCutOuts,
    casters: Vec<CasterKey>,
}

impl SetCutOuts {
    /// Returns the records of the alpha-tested triangles.
    fn records(&self) -> &CutOuts {
        &self.lists.cut_outs
    }
}

/// Inputs of all plans in addition to their lights.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PlannedFor {
    camera: Camera,
    casters: Aabb,
    /// True if the program draws casters itself.
    has_own: bool,
    geometry: Option<u64>,
}

impl LightSet {
    /// The features that a set requires: none. If the device has `TIMESTAMP_QUERY` and
    /// `TIMESTAMP_QUERY_INSIDE_ENCODERS`, [`StillLayers::Auto`] uses measured costs of copies and
    /// draws.
    pub const REQUIRED_FEATURES: Features = Features::empty();

    /// The limits that a set requires: those of a [`ShadowRenderer`](crate::ShadowRenderer), and
    /// three storage buffers in shaders, which WebGPU guarantees. Maps or layers beyond these limits
    /// require more, and so does `exact` with a hierarchy that the device builds: workgroups of 256,
    /// and seven storage buffers.
    pub const REQUIRED_LIMITS: Limits = Limits {
        max_storage_buffers_per_shader_stage: 3,
        max_storage_buffer_binding_size: 1 << 27,
        ..COMPUTE_LIMITS
    };

    /// Returns an empty set for this device and its queue, both of which it keeps. A device that
    /// was lost and requested again needs a new set.
    ///
    /// # Errors
    /// Errors with the name of a limit of the device that is below
    /// [`REQUIRED_LIMITS`](Self::REQUIRED_LIMITS), except for `max_storage_buffer_binding_size`.
    /// Errors if there are too few bind groups for [`LightSetOptions::group`], or if the prefix
    /// can't begin a WGSL identifier.
    pub fn new(
        device: &Device,
        queue: &Queue,
        options: LightSetOptions,
    ) -> Result<Self, BackendError> {
        // Lights whose tables exceed the binding size are refused one by one.
        let needed = Limits {
            max_storage_buffer_binding_size: 0,
            ..Self::REQUIRED_LIMITS
        };
        check_limits(&needed, &device.limits(), "LightSet")?;
        let groups = device.limits().max_bind_groups;
        if options.group >= groups {
            let why = format!("is {}", options.group);
            let help = format!("use 0 to {}", groups - 1);
            return Err(Invalid::new("bind group of the light set", why, help).into());
        }
        let shader = SetShader::new(options.group, &options.prefix, &device.limits())?;
        Ok(Self {
            number: SetNumber::next(),
            device: device.clone(),
            queue: queue.clone(),
            options,
            limits: limits(device),
            casters: Casters::default(),
            cut_outs: None,
            lights: SlotMap::with_key(),
            planned: None,
            unbuilt: None,
            layers_changed: false,
            is_prepared: false,
            pool: LayerPool::default(),
            shader,
            hierarchies: CasterHierarchies::default(),
            masks: MaskStage::default(),
            passes: PassList::default(),
            report: SetReport::default(),
            meter: PriceMeter::new(device),
            errors: LaterErrors::default(),
            unsubmitted_encoders: UnsubmittedEncoders::of_device(device),
            counters: Counters::default(),
            pipelines: Pipelines::default(),
            cast_layout: cast_layout(device),
            tables: Tables::default(),
        })
    }

    /// Adds a mesh, which has no casters yet.
    ///
    /// # Errors
    /// Errors with the mesh's label if a buffer lacks a usage, if layout or range don't fit the
    /// buffers, or if the bounds are empty or not finite.
    pub fn add_mesh(&mut self, mesh: &CasterMesh<'_>) -> Result<MeshId, Invalid> {
        let key = self.casters.add_mesh(mesh, &self.device.limits())?;
        Ok(MeshId::new(self.number, key))
    }

    /// Removes a mesh, and releases its buffers.
    ///
    /// # Errors
    /// Errors if casters use it, or if there is no such mesh.
    pub fn remove_mesh(&mut self, mesh: MeshId) -> Result<(), Invalid> {
        self.casters.remove_mesh(mesh.key_in(self.number)?)
    }

    /// Adds a caster: a placement of a mesh. Casters of one mesh are drawn as instances.
    ///
    /// # Errors
    /// Errors if there is no such mesh, or if the placement is not finite.
    pub fn add_caster(
        &mut self,
        mesh: MeshId,
        world_from_local: Affine3A,
    ) -> Result<CasterId, Invalid> {
        let mesh = mesh.key_in(self.number)?;
        let key = self.casters.add(mesh, world_from_local)?;
        Ok(CasterId::new(self.number, key))
    }

    /// Moves a caster. Layers are redrawn at its old and its new position. Nothing is redrawn if it
    /// stays.
    ///
    /// # Errors
    /// Errors if there is no such caster, or if the placement is not finite.
    pub fn move_caster(
        &mut self,
        caster: CasterId,
        world_from_local: Affine3A,
    ) -> Result<(), Invalid> {
        let caster = caster.key_in(self.number)?;
        self.casters.place(caster, world_from_local)
    }

    /// Places a caster again after a change of the [`Anchor`](umbrage_core::Anchor), to which all
    /// placements are relative. Call it for every caster in that frame, and
    /// [`set_light`](Self::set_light) for every light with a position.
    ///
    /// The next [`prepare`](Self::prepare) redraws all layers, ignoring [`SetBudget::redraws`]:
    /// layers that waited would show geometry a kilometre away. Unlike after
    /// [`move_caster`](Self::move_caster), still casters stay still.
    ///
    /// # Errors
    /// Errors if [`move_caster`](Self::move_caster) does.
    pub fn rebase_caster(
        &mut self,
        caster: CasterId,
        world_from_local: Affine3A,
    ) -> Result<(), Invalid> {
        let caster = caster.key_in(self.number)?;
        self.casters.rebase(caster, world_from_local)
    }

    /// Removes a caster.
    ///
    /// # Errors
    /// Errors if there is no such caster.
    pub fn remove_caster(&mut self, caster: CasterId) -> Result<(), Invalid> {
        self.casters.remove(caster.key_in(self.number)?)
    }

    /// Adds a caster that the program draws itself in [`encode_with`](Self::encode_with), such as a
    /// skinned figure. `bounds` (world space) must contain it in its current pose: lights are
    /// planned for these boxes, and it is drawn only into layers in which its box may be visible.
    ///
    /// Device-built hierarchies don't contain such casters, so lights whose technique uses them
    /// are refused, with this reason. Techniques that read triangles see only those of
    /// [`SetFrame::geometry`]: add the figure's there.
    ///
    /// # Errors
    /// Errors if the box is empty or not finite.
    pub fn add_own_caster(&mut self, bounds: Aabb) -> Result<OwnCasterId, Invalid> {
        let key = self.casters.add_own(bounds)?;
        Ok(OwnCasterId::new(self.number, key))
    }

    /// Sets the box (world space) of a caster that the program draws itself. Layers that show the
    /// old or the new box are redrawn: call it whenever the caster moves or changes its pose.
    ///
    /// # Errors
    /// Errors if there is no such caster, or if the box is empty or not finite.
    pub fn move_own_caster(&mut self, caster: OwnCasterId, bounds: Aabb) -> Result<(), Invalid> {
        let caster = caster.key_in(self.number)?;
        self.casters.move_own(caster, bounds)
    }

    /// Sets the box of a caster that the program draws itself after a change of the
    /// [`Anchor`](umbrage_core::Anchor), like [`rebase_caster`](Self::rebase_caster).
    ///
    /// # Errors
    /// Errors if [`move_own_caster`](Self::move_own_caster) does.
    pub fn rebase_own_caster(&mut self, caster: OwnCasterId, bounds: Aabb) -> Result<(), Invalid> {
        let caster = caster.key_in(self.number)?;
        self.casters.rebase_own(caster, bounds)
    }

    /// Removes a caster that the program draws itself.
    ///
    /// # Errors
    /// Errors if there is no such caster.
    pub fn remove_own_caster(&mut self, caster: OwnCasterId) -> Result<(), Invalid> {
        self.casters.remove_own(caster.key_in(self.number)?)?;
        self.passes.forget_own(caster);
        Ok(())
    }

    /// Returns the layout of the bind group that passes of [`encode_with`](Self::encode_with) have
    /// set at index 0. It has one binding, for vertex shaders:
    /// `@group(0) @binding(0) var<uniform> clip_from_world: mat4x4f;`
    pub fn cast_layout(&self) -> &BindGroupLayout {
        &self.cast_layout
    }

    /// Sets the alpha-tested triangles that cast in addition to the set's casters (world space).
    /// They replace the previous ones; `None` removes them. Maps use the same alpha test as all
    /// backends.
    ///
    /// The set's own meshes must not contain these triangles, only those of
    /// [`Geometry::casters_without_holes`](umbrage_core::Geometry::casters_without_holes).
    /// Techniques that read triangles ([`SetFrame::geometry`]) use the alpha-tested triangles of
    /// that geometry.
    ///
    /// # Errors
    /// Errors if positions are not finite.
    pub fn set_cut_outs(&mut self, cut_outs: Option<&CutOutBuffers>) -> Result<(), Invalid> {
        if let Some(before) = self.cut_outs.take() {
            for caster in before.casters {
                self.casters.remove_cut_outs(caster)?;
            }
        }
        // Plan all lights again: recipes of hierarchies contain the records.
        for light in self.lights.values_mut() {
            light.has_changed = true;
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

    /// Reports that vertices in a buffer changed within a box (world space), which the set can't
    /// detect. Call it with the box before and the box after the change.
    ///
    /// # Errors
    /// Errors if a number is not finite.
    pub fn touch(&mut self, bounds: &Aabb) -> Result<(), Invalid> {
        bounds
            .validate()
            .map_err(|e| e.within_context("changed part"))?;
        self.casters.touch(bounds);
        Ok(())
    }

    /// Adds a light.
    ///
    /// # Errors
    /// Errors if a number of the light or the priority can't be used, or if there are 4,096 lights.
    pub fn add_light(&mut self, light: ShadowedLight) -> Result<LightId, Invalid> {
        check_light(&light.light, light.priority)?;
        if self.lights.len() == MAX_LIGHTS {
            let why = format!("has {MAX_LIGHTS} lights");
            let help = "remove one first, or use a second set";
            return Err(Invalid::new("light set", why, help));
        }
        let index = self.shader.take_index();
        let key = self.lights.insert(HeldLight::new(index, light));
        Ok(LightId::new(self.number, key))
    }

    /// Moves or changes a light. Has no effect if the light is unchanged.
    ///
    /// # Errors
    /// Errors if there is no such light, or if one of its numbers can't be used.
    pub fn set_light(&mut self, id: LightId, light: Light) -> Result<(), Invalid> {
        let state = self.light_mut(id)?;
        check_light(&light, state.settings.priority)?;
        if state.settings.light != light {
            state.settings.light = light;
            state.has_changed = true;
        }
        Ok(())
    }

    /// Sets the technique of a light, or its settings.
    ///
    /// # Errors
    /// Errors if there is no such light.
    pub fn set_technique(
        &mut self,
        id: LightId,
        technique: Arc<dyn ShadowTechnique>,
    ) -> Result<(), Invalid> {
        let state = self.light_mut(id)?;
        state.settings.technique = technique;
        state.has_changed = true;
        Ok(())
    }

    /// Switches a light on or off; new ones are on. The next [`prepare`](Self::prepare) applies it.
    /// A light that is off keeps its id, index and maps, and neither the text nor the layout
    /// changes. Its layers are not redrawn, and shaders get 1. Its maps still count towards
    /// [`SetBudget::bytes`]: to free them, use [`remove_light`](Self::remove_light).
    ///
    /// # Errors
    /// Errors if there is no such light.
    pub fn set_enabled(&mut self, id: LightId, is_enabled: bool) -> Result<(), Invalid> {
        let state = self.light_mut(id)?;
        let has_changed = state.is_enabled != is_enabled;
        state.is_enabled = is_enabled;
        if has_changed && is_enabled {
            // No budget delays layers that changed meanwhile.
            let is_replaced = state.has_changed;
            for cast in &mut state.maps.casts {
                cast.is_drawn &= !cast.is_stale && !is_replaced;
            }
        }
        if has_changed {
            self.shader.change();
        }
        Ok(())
    }

    /// Sets the priority of a light, used if not all lights can have shadows.
    ///
    /// # Errors
    /// Errors if there is no such light, or if the priority is negative or not finite.
    pub fn set_priority(&mut self, id: LightId, priority: f32) -> Result<(), Invalid> {
        let state = self.light_mut(id)?;
        check_priority(priority)?;
        let has_changed = state.settings.priority != priority;
        state.settings.priority = priority;
        self.layers_changed |= has_changed;
        Ok(())
    }

    /// Removes a light. Its index is reused by the next light that is added.
    ///
    /// # Errors
    /// Errors if there is no such light.
    pub fn remove_light(&mut self, id: LightId) -> Result<(), Invalid> {
        let key = self.light_key(id)?;
        let light = self.lights.remove(key).ok_or_else(unknown_light)?;
        self.shader.forget(key);
        self.shader.give_back_index(light.index);
        for range in &light.maps.ranges {
            self.pool.give_back(range);
        }
        self.layers_changed = true;
        Ok(())
    }

    /// Returns a light's index, for `shadow` in shaders. It is valid until the light is removed.
    ///
    /// # Errors
    /// Errors if there is no such light.
    pub fn index_of(&self, id: LightId) -> Result<u32, Invalid> {
        let key = self.light_key(id)?;
        Ok(self.lights[key].index)
    }

    /// Returns the lights without shadows as of the last [`prepare`](Self::prepare), with reasons;
    /// without those that are switched off.
    pub fn unserved_lights(&self) -> impl Iterator<Item = (LightId, Unserved)> + '_ {
        self.lights
            .iter()
            .filter(|(_, light)| light.is_enabled)
            .filter_map(|(key, light)| {
                let id = LightId::new(self.number, key);
                let reason = light.state.unserved_reason()?;
                let waits = reason == Unserved::Waiting && !self.is_prepared;
                Some((id, if waits { Unserved::NotPrepared } else { reason }))
            })
    }

    /// Returns the statistics of the last [`prepare`](Self::prepare).
    pub fn report(&self) -> &SetReport {
        &self.report
    }

    /// Returns the box for which lights are planned: a box around all casters whose sides are on a
    /// coarse grid. It doesn't change when casters move a little, and neither do maps fitted to it.
    /// Without [`SetFrame::geometry`] maps end at this box.
    pub fn casters_box(&self) -> Aabb {
        steady_box::steady_box_around(&self.casters.bounds())
    }

    /// Returns the view for which a light is planned, for a program that computes the same recipe.
    /// While the program draws casters itself ([`add_own_caster`](Self::add_own_caster)), remove
    /// [`View::geometry`] for techniques with maps, as the set does.
    pub fn view<'a>(&self, frame: &SetFrame<'a>, light: &'a Light) -> View<'a> {
        frame.view_of(light, self.casters_box(), self.casters.distance_from(light))
    }

    /// Returns the number of casters, with those that the program draws; a part of the alpha-tested
    /// ones counts as one.
    pub fn caster_count(&self) -> usize {
        self.casters.count()
    }

    /// Returns the WGSL to insert before your shader. `fn shadow(light: u32, position: vec3f,
    /// normal: vec3f, pixel: vec2u) -> f32` returns the visibility of a light, 0..=1, at a position
    /// (world space) with a unit normal. Lights without shadows are lit. `pixel` varies the
    /// patterns of kernels that differ from pixel to pixel. `shadow_on` has a triangle id as an
    /// additional parameter, which ray-tracing kernels need.
    ///
    /// The text changes with the kinds of kernels and the number of sizes of maps that lights use,
    /// as reported by [`wgsl_revision`](Self::wgsl_revision).
    pub fn wgsl(&self) -> &str {
        self.shader.prefixed_text()
    }

    /// Returns the number of the [text](Self::wgsl) and of the bind group's layout: equal numbers
    /// mean equal texts. Keep pipelines by this number. The graphics API refuses to draw with those
    /// of another number, unless the difference is a multiple of 256.
    /// [`text_with`](Self::text_with) returns the text of other techniques beforehand.
    pub fn wgsl_revision(&self) -> u64 {
        self.shader.revision()
    }

    /// Returns the bind group of [`wgsl`](Self::wgsl): set it at [`LightSetOptions::group`]. Get it
    /// in every frame, after [`prepare`](Self::prepare).
    ///
    /// # Errors
    /// Errors if [`prepare`](Self::prepare) has not succeeded before.
    pub fn bind_group(&self) -> Result<(&BindGroup, &BindGroupLayout), BackendError> {
        self.shader
            .bind_group()
            .ok_or_else(shader::unprepared_error)
    }

    /// Returns an error of the graphics API since the last call, for
    /// [`ApiErrors::Later`](crate::ApiErrors::Later). After an error, the next frame recreates all
    /// GPU objects.
    pub fn take_error(&mut self) -> Option<BackendError> {
        let error = self.errors.take()?;
        self.forget_objects();
        Some(error)
    }

    /// Returns the key of a light.
    ///
    /// Errors if it is in another set, or removed.
    fn light_key(&self, id: LightId) -> Result<LightKey, Invalid> {
        let key = id.key_in(self.number)?;
        if self.lights.contains_key(key) {
            return Ok(key);
        }
        Err(unknown_light())
    }

    fn light_mut(&mut self, id: LightId) -> Result<&mut HeldLight, Invalid> {
        let key = id.key_in(self.number)?;
        self.lights.get_mut(key).ok_or_else(unknown_light)
    }

    /// Returns the bytes of all maps, including the layers of still casters.
    pub fn map_bytes(&self) -> u64 {
        self.pool.bytes() + still_bytes(&self.lights)
    }

    /// Returns the bytes of the buffer of all tables (triangles that kernels read, and hierarchies
    /// that the device builds), and of those for building hierarchies.
    pub fn table_bytes(&self) -> u64 {
        self.shader.tables().buffer_bytes() + self.hierarchies.scratch_bytes()
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
    unknown("light")
}

/// Returns the error for an id of something that is not in the set.
fn unknown(what: &str) -> Invalid {
    let help = "use an id that this set returned and that is not removed";
    Invalid::new(what, "is not in the light set", help)
}

/// Sets can be shared between threads.
#[cfg(not(target_arch = "wasm32"))]
const _: () = {
    const fn may_be_shared<T: Send + Sync>() {}
    may_be_shared::<LightSet>();
};
