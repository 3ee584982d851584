//! [`ShadowRenderer`]: executes recipes on the caller's device, into the caller's encoder.

use crate::{
    device::{
        error_scopes::Scopes,
        later_errors::LaterErrors,
        requirements::{check_device, limits},
    },
    frame::{FrameInputs, RendererOptions, check_size},
    resources::{
        counters::{Counters, ResourceFactory},
        counts::{check_counting, pairs},
        cut_outs::FrameWithHoles,
        faces::check_faces,
        images::GpuImage,
        renderer_state::{Resources, Shared},
        submissions::Submissions,
        timestamps::PassTimestamps,
    },
    targets::CastTarget,
};
use umbrage_core::{BackendError, BackendLimits, Invalid, Recipe};
use wgpu::{BindGroup, BindGroupLayout, CommandEncoder, Device, Queue, TextureView};

/// Executes recipes. It never makes a device and never submits: [`prepare`](Self::prepare) makes
/// and writes what a frame needs, [`encode`](Self::encode) records the passes.
///
/// ```no_run
/// use umbrage_core::{BackendError, Recipe};
/// use umbrage_wgpu::{FrameInputs, ShadowRenderer, wgpu};
///
/// /// Once a frame; the renderer was made by `ShadowRenderer::new(&device, RendererOptions::default())`.
/// fn shadows<'a>(
///     renderer: &'a mut ShadowRenderer,
///     device: &wgpu::Device,
///     queue: &wgpu::Queue,
///     encoder: &mut wgpu::CommandEncoder,
///     recipe: &Recipe,
///     frame: &FrameInputs<'_>,
/// ) -> Result<&'a wgpu::TextureView, BackendError> {
///     renderer.prepare(device, queue, recipe, frame)?;
///     renderer.encode(encoder)
/// }
/// ```
///
/// # Several lights
/// One renderer serves several lights, whose recipes may differ: prepare and encode the first, then
/// the second. What was recorded for one keeps its mask, images, uniforms and bind groups until the
/// encoder is submitted or dropped; meanwhile `prepare` uses others, made when they are first
/// needed. So all that is recorded between two submissions may read the masks and the
/// [`receive_bind_group`](Self::receive_bind_group)s of all lights that were encoded there, and
/// that many lights take that many masks and maps. After the submission the next `prepare` uses
/// them again: take masks and bind groups again after each, and submit all that reads them before
/// it or together with the encoder.
#[derive(Debug)]
pub struct ShadowRenderer {
    options: RendererOptions,
    limits: BackendLimits,
    counters: Counters,
    submissions: Submissions,
    errors: LaterErrors,
    shared: Shared,
    /// One entry for each light that was ever encoded between two submissions.
    lights: Vec<Resources>,
    /// Index of the entry that was prepared last.
    prepared: Option<usize>,
}

impl ShadowRenderer {
    /// Returns a renderer for this device. Nothing is made yet: shaders come with recipes.
    ///
    /// # Errors
    /// Errors if the device has too few bind groups for [`RendererOptions::kernel_group`].
    pub fn new(device: &Device, options: RendererOptions) -> Result<Self, BackendError> {
        let groups = device.limits().max_bind_groups;
        if options.kernel_group >= groups {
            let why = format!("is {}", options.kernel_group);
            return Err(Invalid::new(
                "bind group of the kernel",
                why,
                format!("use 0 to {}", groups - 1),
            )
            .into());
        }
        Ok(Self {
            options,
            limits: limits(device),
            counters: Counters::default(),
            submissions: Submissions::of(device),
            errors: LaterErrors::default(),
            shared: Shared::default(),
            lights: Vec::new(),
            prepared: None,
        })
    }

    /// Makes the GPU objects that the recipe needs and that don't exist yet, and writes uniforms
    /// and new tables to the queue. To find out whether what was encoded before has been submitted,
    /// it polls the device without waiting.
    ///
    /// # Errors
    /// Errors if the recipe or the frame cannot be used, the device is another than the renderer's,
    /// memory runs out, or a kernel's WGSL is at fault (with the compiler's message). After an
    /// error nothing is prepared, and all GPU objects are made again.
    pub fn prepare(
        &mut self,
        device: &Device,
        queue: &Queue,
        recipe: &Recipe,
        frame: &FrameInputs<'_>,
    ) -> Result<(), BackendError> {
        let frame = FrameWithHoles {
            inputs: frame,
            holes: None,
        };
        self.prepare_with_holes(device, queue, recipe, frame)
    }

    /// The same where triangles with holes are drawn, too; the frame's inputs list the others.
    pub(crate) fn prepare_with_holes(
        &mut self,
        device: &Device,
        queue: &Queue,
        recipe: &Recipe,
        frame: FrameWithHoles<'_>,
    ) -> Result<(), BackendError> {
        self.prepared = None;
        check_device(device, self.submissions.device())?;
        recipe.make_tables();
        recipe.validate(&self.limits)?;
        check_counting(recipe, device.features())?;
        check_faces(recipe, device.limits().max_buffer_size)?;
        let inputs = frame.inputs;
        check_size(inputs.size, self.limits.image_side)?;
        inputs.validate(recipe, &device.limits())?;
        let pairs = pairs(recipe)?;
        let light = self.free_resources(recipe, inputs);
        self.shared.tables.forget_unreachable();
        self.shared.faces.forget_unreachable();
        let scopes = Scopes::open(device);
        let mut factory = ResourceFactory {
            device,
            queue,
            counters: &mut self.counters,
        };
        self.lights[light].prepare(
            &mut factory,
            &mut self.shared,
            self.options,
            recipe,
            &pairs,
            frame,
        );
        if let Err(e) = self.errors.close(scopes, self.options.errors) {
            (self.shared, self.lights) = Default::default();
            return Err(e);
        }
        self.prepared = Some(light);
        Ok(())
    }

    /// Returns the index of resources that no unsubmitted encoder reads: the first whose textures
    /// fit, else the first, else new ones.
    fn free_resources(&mut self, recipe: &Recipe, frame: &FrameInputs<'_>) -> usize {
        if self.lights.iter().any(|light| !light.pending.is_over()) {
            self.submissions.poll();
        }
        for light in &mut self.lights {
            light.release();
        }
        let mut first_free = None;
        for (i, light) in self.lights.iter().enumerate() {
            if !light.pending.is_over() {
                continue;
            }
            if light.fits(&recipe.images, frame.size) {
                return i;
            }
            first_free = first_free.or(Some(i));
        }
        first_free.unwrap_or_else(|| {
            self.lights.push(Resources::default());
            self.lights.len() - 1
        })
    }

    /// Records all passes, and that of the [`picture`](Self::picture) if the recipe shades. Returns
    /// the mask: `R32Float`, visibility of the light, 1 where nothing receives.
    ///
    /// # Errors
    /// Errors if [`prepare`](Self::prepare) has not succeeded before.
    pub fn encode(&self, encoder: &mut CommandEncoder) -> Result<&TextureView, BackendError> {
        self.encode_timed(encoder, None)
    }

    /// Records all passes as [`encode`](Self::encode) does, with timestamps around the stages.
    ///
    /// # Errors
    /// Errors if [`encode`](Self::encode) does.
    pub fn encode_timed(
        &self,
        encoder: &mut CommandEncoder,
        stamps: Option<&PassTimestamps<'_>>,
    ) -> Result<&TextureView, BackendError> {
        let light = self.recorded(encoder)?;
        light.casts.encode(encoder, stamps);
        light.filters.clear(encoder);
        light.filters.encode(encoder, stamps);
        light
            .encode_mask(encoder, self.options, stamps)
            .ok_or_else(unprepared)
    }

    /// Returns the targets to draw into before
    /// [`encode_filters_and_receive`](Self::encode_filters_and_receive), for callers whose casters
    /// need their own vertex formats or shaders (skinning, displacement, alpha test). For recipes
    /// whose casts peel or count, or draw faces that the technique made, use
    /// [`encode_casts_with`](Self::encode_casts_with), which also records what has to happen
    /// between them.
    ///
    /// # Errors
    /// Errors if [`encode`](Self::encode) does; and if there is such a cast.
    pub fn cast_targets(&self) -> Result<&[CastTarget], BackendError> {
        let casts = &self.light()?.casts;
        if casts.are_plain() {
            return Ok(&casts.targets);
        }
        let why = "peel, count or draw faces of the technique's own, so targets alone don't tell what to draw";
        Err(Invalid::new(
            "casts",
            why,
            "call `encode_casts_with`, which draws what callers can't",
        )
        .into())
    }

    /// Records all casts in order: those of faces that the technique made itself, and for each that
    /// draws casters or everything, `draw` is called to record a pass into its target.
    ///
    /// # Errors
    /// Errors if [`encode`](Self::encode) does.
    pub fn encode_casts_with(
        &self,
        encoder: &mut CommandEncoder,
        mut draw: impl FnMut(&mut CommandEncoder, &CastTarget),
    ) -> Result<(), BackendError> {
        let casts = &self.recorded(encoder)?.casts;
        casts.clear(encoder);
        for (i, target) in casts.targets.iter().enumerate() {
            if casts.draws_faces(i) {
                casts.encode_one(encoder, i, None);
            } else {
                draw(encoder, target);
            }
        }
        Ok(())
    }

    /// Records the passes after the casts, which the caller has drawn, and returns the mask.
    ///
    /// # Errors
    /// Errors if [`encode`](Self::encode) does.
    pub fn encode_filters_and_receive(
        &self,
        encoder: &mut CommandEncoder,
    ) -> Result<&TextureView, BackendError> {
        let light = self.recorded(encoder)?;
        light.filters.clear(encoder);
        light.filters.encode(encoder, None);
        light
            .encode_mask(encoder, self.options, None)
            .ok_or_else(unprepared)
    }

    /// Records casts alone; with [`encode_filters`](Self::encode_filters) and
    /// [`receive_bind_group`](Self::receive_bind_group) this is all that forward shading needs.
    ///
    /// # Errors
    /// Errors if [`encode`](Self::encode) does.
    pub fn encode_casts(&self, encoder: &mut CommandEncoder) -> Result<(), BackendError> {
        self.recorded(encoder)?.casts.encode(encoder, None);
        Ok(())
    }

    /// Records filters alone.
    ///
    /// # Errors
    /// Errors if [`encode`](Self::encode) does.
    pub fn encode_filters(&self, encoder: &mut CommandEncoder) -> Result<(), BackendError> {
        let light = self.recorded(encoder)?;
        light.filters.clear(encoder);
        light.filters.encode(encoder, None);
        Ok(())
    }

    /// Records filters without clearing the images that nothing writes.
    #[cfg(feature = "testing")]
    pub(crate) fn encode_filters_only(
        &self,
        encoder: &mut CommandEncoder,
    ) -> Result<(), BackendError> {
        self.recorded(encoder)?.filters.encode(encoder, None);
        Ok(())
    }

    #[cfg(feature = "testing")]
    pub(crate) fn encode_receive(&self, encoder: &mut CommandEncoder) -> Result<(), BackendError> {
        self.recorded(encoder)?
            .encode_mask(encoder, self.options, None)
            .map(|_| ())
            .ok_or_else(unprepared)
    }

    /// Returns what the receive kernel reads, for [`receive_wgsl`](crate::receive_wgsl) in the
    /// caller's own shader: set it at [`RendererOptions::kernel_group`].
    ///
    /// # Errors
    /// Errors if [`encode`](Self::encode) does.
    pub fn receive_bind_group(&self) -> Result<(&BindGroup, &BindGroupLayout), BackendError> {
        self.light()?.receive.kernel_group().ok_or_else(unprepared)
    }

    /// Returns an image of the recipe with all its layers, for showing it; counts are whole numbers
    /// (`texture_2d<u32>`).
    pub fn image(&self, id: usize) -> Option<&TextureView> {
        self.gpu_images().get(id).map(|image| &image.whole)
    }

    /// Returns the recipe's colours, `Rgba32Float`, linear; `None` before a recipe that shades is
    /// prepared.
    pub fn picture(&self) -> Option<&TextureView> {
        self.gpu_picture().map(|image| &image.whole)
    }

    /// Returns an error of the graphics API that came since the last call, with
    /// [`ApiErrors::Later`](crate::ApiErrors::Later). After one, nothing is prepared, and all GPU
    /// objects are made again.
    pub fn take_error(&mut self) -> Option<BackendError> {
        let error = self.errors.take()?;
        (self.shared, self.lights) = Default::default();
        self.prepared = None;
        Some(error)
    }

    /// Returns how many GPU objects were made so far.
    #[cfg(feature = "testing")]
    pub fn counters(&self) -> Counters {
        Counters {
            buffers: self.counters.buffers + self.submissions.made(),
            ..self.counters
        }
    }

    /// Returns the largest images, layers and tables that recipes may use on this device.
    pub fn limits(&self) -> BackendLimits {
        self.limits
    }

    pub(crate) fn gpu_images(&self) -> &[GpuImage] {
        self.light().map_or(&[], |light| &light.images)
    }

    pub(crate) fn mask(&self) -> Option<&GpuImage> {
        self.light().ok()?.receive.image()
    }

    pub(crate) fn gpu_picture(&self) -> Option<&GpuImage> {
        self.light().ok()?.shading.image()
    }

    /// Returns what was prepared last.
    fn light(&self) -> Result<&Resources, BackendError> {
        self.prepared
            .and_then(|i| self.lights.get(i))
            .ok_or_else(unprepared)
    }

    /// Returns what was prepared last, and keeps it from being written before the encoder's
    /// commands are submitted.
    fn recorded(&self, encoder: &CommandEncoder) -> Result<&Resources, BackendError> {
        let light = self.light()?;
        self.submissions.watch(encoder, &light.pending);
        Ok(light)
    }
}

fn unprepared() -> BackendError {
    Invalid::new(
        "shadow renderer",
        "has nothing prepared",
        "call `prepare` first, and look at its error",
    )
    .into()
}
