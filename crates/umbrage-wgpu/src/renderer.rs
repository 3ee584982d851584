//! [`ShadowRenderer`]: plays recipes on the caller's device, into the caller's encoder.

use crate::{
    bindings::{Binding, Bound, Slot},
    casts::CastStage,
    counters::{Counters, Maker},
    filters::{FilterStage, color_attachment},
    frame::{Frame, GBuffer},
    images::{GpuImage, fit_images},
    kernels::{KernelStage, Sources},
    pipelines::Pipelines,
    scopes::Scopes,
    stamps::{Stage, Stamps, pass_stamps},
    tables::Tables,
    targets::CastTarget,
    wgsl::{kernel_wgsl, receive_shader},
};
use glam::UVec2;
use umbrage_core::{BackendError, Format, ImageDesc, Invalid, Limits, Recipe};
use wgpu::{
    BindGroup, BindGroupLayout, Color, CommandEncoder, Device, Queue, RenderPassDescriptor, ShaderStages,
    TextureFormat, TextureView,
};

/// What the caller chooses once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// The bind group index at which the lookup's kernel finds what it reads, so that
    /// [`receive_wgsl`](crate::receive_wgsl) and [`ShadowRenderer::receive_bind_group`] fit into the caller's own shaders.
    pub kernel_group: u32,
}

/// Plays recipes. It never makes a device and never submits: [`prepare`](Self::prepare) makes and writes what a frame
/// needs, [`encode`](Self::encode) records the passes.
///
/// ```no_run
/// use umbrage_core::{BackendError, Recipe};
/// use umbrage_wgpu::{Frame, ShadowRenderer, wgpu};
///
/// /// Once a frame; the renderer was made by `ShadowRenderer::new(&device, Options::default())`.
/// fn shadows<'a>(
///     renderer: &'a mut ShadowRenderer,
///     (device, queue): (&wgpu::Device, &wgpu::Queue),
///     encoder: &mut wgpu::CommandEncoder,
///     recipe: &Recipe,
///     frame: &Frame<'_>,
/// ) -> Result<&'a wgpu::TextureView, BackendError> {
///     renderer.prepare(device, queue, recipe, frame)?;
///     renderer.encode(encoder)
/// }
/// ```
#[derive(Debug)]
pub struct ShadowRenderer {
    options: Options,
    limits: Limits,
    counters: Counters,
    held: Held,
}

/// What is kept from frame to frame.
#[derive(Debug, Default)]
struct Held {
    pipelines: Pipelines,
    tables: Tables,
    images: Vec<GpuImage>,
    mask: Vec<GpuImage>,
    casts: CastStage,
    filters: FilterStage,
    receive: KernelStage,
    gbuffer: Binding,
    prepared: bool,
}

impl ShadowRenderer {
    /// A renderer for this device. Nothing is made yet: shaders come with recipes.
    ///
    /// # Errors
    /// If the device has too few bind groups for [`Options::kernel_group`].
    pub fn new(device: &Device, options: Options) -> Result<Self, BackendError> {
        let groups = device.limits().max_bind_groups;
        if options.kernel_group >= groups {
            let why = format!("is {}", options.kernel_group);
            return Err(Invalid::new("bind group of the kernel", why, format!("use 0 to {}", groups - 1)).into());
        }
        Ok(Self { options, limits: limits(device), counters: Counters::default(), held: Held::default() })
    }

    /// Makes whatever the recipe needs and isn't there yet, and writes uniforms and new tables to the queue.
    ///
    /// # Errors
    /// When the recipe or the frame cannot be used, memory runs out, or a kernel's WGSL is at fault (with the
    /// compiler's message). After an error nothing is prepared, and everything is made anew.
    pub fn prepare(
        &mut self,
        device: &Device,
        queue: &Queue,
        recipe: &Recipe,
        frame: &Frame<'_>,
    ) -> Result<(), BackendError> {
        self.held.prepared = false;
        recipe.validate(&self.limits)?;
        check_size(frame.size, self.limits.image_side)?;
        frame.validate()?;
        let scopes = Scopes::open(device);
        let mut maker = Maker { device, queue, counters: &mut self.counters };
        self.held.prepare(&mut maker, self.options, recipe, frame);
        if let Err(e) = scopes.close() {
            self.held = Held::default();
            return Err(e);
        }
        self.held.prepared = true;
        Ok(())
    }

    /// Records all passes and returns the mask: `R32Float`, visibility of the light, 1 where nothing receives.
    ///
    /// # Errors
    /// If [`prepare`](Self::prepare) has not succeeded before.
    pub fn encode(&self, encoder: &mut CommandEncoder) -> Result<&TextureView, BackendError> {
        self.encode_timed(encoder, None)
    }

    /// As [`encode`](Self::encode), with timestamps around the stages.
    ///
    /// # Errors
    /// As [`encode`](Self::encode).
    pub fn encode_timed(
        &self,
        encoder: &mut CommandEncoder,
        stamps: Option<&Stamps<'_>>,
    ) -> Result<&TextureView, BackendError> {
        let held = self.held()?;
        held.casts.encode(encoder, stamps);
        held.filters.clear(encoder);
        held.filters.encode(encoder, stamps);
        Ok(held.encode_receive(encoder, self.options, stamps))
    }

    /// What is to be drawn into before [`encode_filters_and_receive`](Self::encode_filters_and_receive), for callers
    /// whose casters need their own vertex formats or shaders (skinning, displacement, alpha test).
    ///
    /// # Errors
    /// As [`encode`](Self::encode).
    pub fn cast_targets(&self) -> Result<&[CastTarget], BackendError> {
        Ok(&self.held()?.casts.targets)
    }

    /// Records the passes after the casts, which the caller has drawn, and returns the mask.
    ///
    /// # Errors
    /// As [`encode`](Self::encode).
    pub fn encode_filters_and_receive(&self, encoder: &mut CommandEncoder) -> Result<&TextureView, BackendError> {
        self.encode_filters(encoder)?;
        Ok(self.held()?.encode_receive(encoder, self.options, None))
    }

    /// Records casts alone; with [`encode_filters`](Self::encode_filters) and [`receive_bind_group`](Self::receive_bind_group)
    /// this is all that forward shading needs.
    ///
    /// # Errors
    /// As [`encode`](Self::encode).
    pub fn encode_casts(&self, encoder: &mut CommandEncoder) -> Result<(), BackendError> {
        self.held()?.casts.encode(encoder, None);
        Ok(())
    }

    /// Records filters alone.
    ///
    /// # Errors
    /// As [`encode`](Self::encode).
    pub fn encode_filters(&self, encoder: &mut CommandEncoder) -> Result<(), BackendError> {
        self.held()?.filters.clear(encoder);
        self.encode_filters_only(encoder)
    }

    /// Filters without the clearing of images that nothing writes.
    pub(crate) fn encode_filters_only(&self, encoder: &mut CommandEncoder) -> Result<(), BackendError> {
        self.held()?.filters.encode(encoder, None);
        Ok(())
    }

    pub(crate) fn encode_receive(&self, encoder: &mut CommandEncoder) -> Result<(), BackendError> {
        self.held()?.encode_receive(encoder, self.options, None);
        Ok(())
    }

    /// What the lookup reads, for [`receive_wgsl`](crate::receive_wgsl) in the caller's own shader: set it at
    /// [`Options::kernel_group`].
    ///
    /// # Errors
    /// As [`encode`](Self::encode).
    pub fn receive_bind_group(&self) -> Result<(&BindGroup, &BindGroupLayout), BackendError> {
        let binding = &self.held()?.receive.binding;
        binding.group().zip(binding.layout()).ok_or_else(unprepared)
    }

    /// An image of the recipe, all its layers, for showing it.
    pub fn image(&self, id: usize) -> Option<&TextureView> {
        self.held.images.get(id).map(|image| &image.whole)
    }

    /// What was made so far.
    pub fn counters(&self) -> Counters {
        self.counters
    }

    /// What recipes may ask of this device.
    pub fn limits(&self) -> Limits {
        self.limits
    }

    pub(crate) fn gpu_images(&self) -> &[GpuImage] {
        &self.held.images
    }

    pub(crate) fn mask(&self) -> Option<&GpuImage> {
        self.held.mask.first()
    }

    fn held(&self) -> Result<&Held, BackendError> {
        if self.held.prepared { Ok(&self.held) } else { Err(unprepared()) }
    }
}

impl Held {
    fn prepare(&mut self, maker: &mut Maker<'_>, options: Options, recipe: &Recipe, frame: &Frame<'_>) {
        self.tables.forget_unreachable();
        fit_images(maker, &mut self.images, &recipe.images);
        let mask = ImageDesc { label: "umbrage mask", size: frame.size, layers: 1, format: Format::R32 };
        fit_images(maker, &mut self.mask, &[mask]);
        self.casts.prepare(maker, &mut self.pipelines, &recipe.casts, &self.images, frame.casters);
        let mut sources = Sources { recipe, images: &self.images, tables: &mut self.tables };
        self.filters.prepare(maker, &mut self.pipelines, &mut sources);
        let receive = &recipe.receive;
        let reads = (&receive.inputs[..], &receive.tables[..]);
        let shape = self.receive.bind(maker, &mut self.pipelines, &mut sources, &*receive.kernel, reads);
        let text = kernel_wgsl(&*receive.kernel, &shape, options.kernel_group);
        self.prepare_lookup(maker, options, text, &frame.receivers);
    }

    fn prepare_lookup(&mut self, maker: &mut Maker<'_>, options: Options, kernel: String, receivers: &GBuffer<'_>) {
        let views = [Some(receivers.position), Some(receivers.normal), receivers.triangle];
        let bound = views.into_iter().flatten().map(|v| Bound::View(v.clone())).collect();
        let floats = Slot::Floats { layered: false };
        let slots = [floats, floats, Slot::Ids];
        let slots = &slots[..if receivers.triangle.is_some() { 3 } else { 2 }];
        let layout = self.pipelines.layouts.get(maker, ShaderStages::FRAGMENT, slots);
        self.gbuffer.set(maker, "umbrage receivers", &layout, bound);
        let text = receive_shader(&kernel, options.gbuffer_group(), receivers.triangle.is_some());
        let mut groups = vec![None; options.kernel_group.max(1) as usize + 1];
        groups[options.kernel_group as usize] = self.receive.binding.layout();
        groups[options.gbuffer_group() as usize] = Some(&layout);
        let (label, text) = ("umbrage receive", (text, "umbrage_receive"));
        let pipeline = self.pipelines.kernel(maker, label, text, TextureFormat::R32Float, &groups);
        self.receive.pipeline = Some(pipeline);
    }

    fn encode_receive(
        &self,
        encoder: &mut CommandEncoder,
        options: Options,
        stamps: Option<&Stamps<'_>>,
    ) -> &TextureView {
        let mask = &self.mask[0].whole;
        let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
            label: Some("umbrage receive"),
            color_attachments: &[Some(color_attachment(mask, Color::WHITE))],
            timestamp_writes: pass_stamps(stamps, Stage::Receive, 0, 1),
            ..RenderPassDescriptor::default()
        });
        if let Some(pipeline) = &self.receive.pipeline {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(options.kernel_group, self.receive.binding.group(), &[]);
            pass.set_bind_group(options.gbuffer_group(), self.gbuffer.group(), &[]);
            pass.draw(0..3, 0..1);
        }
        drop(pass);
        mask
    }
}

impl Options {
    /// Any group but the kernel's.
    fn gbuffer_group(self) -> u32 {
        u32::from(self.kernel_group == 0)
    }
}

/// What recipes may ask of a device.
fn limits(device: &Device) -> Limits {
    let limits = device.limits();
    Limits {
        image_side: limits.max_texture_dimension_2d,
        layers: limits.max_texture_array_layers,
        table_bytes: limits.max_storage_buffer_binding_size.min(limits.max_buffer_size),
    }
}

pub(crate) fn check_size(size: UVec2, most: u32) -> Result<(), BackendError> {
    if size.min_element() > 0 && size.max_element() <= most {
        return Ok(());
    }
    let why = format!("is {} x {} pixels", size.x, size.y);
    Err(Invalid::new("frame", why, format!("use 1 to {most} on each side")).into())
}

fn unprepared() -> BackendError {
    Invalid::new("shadow renderer", "has nothing prepared", "call `prepare` first, and look at its error").into()
}
