//! [`ShadowRenderer`]: executes recipes on the caller's device, into the caller's encoder.

use crate::{
    device::{
        error_scopes::Scopes,
        later_errors::LaterErrors,
        requirements::{COMPUTE_LIMITS, check_compute, limits},
    },
    frame::{FrameInputs, RendererOptions, check_size},
    hierarchy::one::check_hierarchy,
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
use wgpu::{BindGroup, BindGroupLayout, CommandEncoder, Device, Limits, Queue, TextureView};

/// Executes recipes. It never creates a device and never submits. [`prepare`](Self::prepare)
/// creates and writes the resources of a frame, [`encode`](Self::encode) records the passes.
///
/// ```no_run
/// use umbrage_core::{BackendError, Recipe};
/// use umbrage_wgpu::{FrameInputs, ShadowRenderer, wgpu};
///
/// /// Once per frame. The renderer was created with
/// /// `ShadowRenderer::new(&device, &queue, RendererOptions::default())`.
/// fn shadows<'a>(
///     renderer: &'a mut ShadowRenderer,
///     encoder: &mut wgpu::CommandEncoder,
///     recipe: &Recipe,
///     frame: &FrameInputs<'_>,
/// ) -> Result<&'a wgpu::TextureView, BackendError> {
///     renderer.prepare(recipe, frame)?;
///     renderer.encode(encoder)
/// }
/// ```
///
/// # Several lights
/// One renderer serves several lights, whose recipes may differ: prepare and encode the first, then
/// the second. The mask, images, uniforms and bind groups of each light stay valid until the
/// encoder is submitted or dropped; meanwhile `prepare` uses others, created on first use.
/// Everything recorded between two submissions may therefore read the masks and the
/// [`receive_bind_group`](Self::receive_bind_group)s of all lights encoded there. Memory for masks,
/// maps and hierarchies grows with the number of these lights.
///
/// After the submission, the next `prepare` reuses these resources. Get masks and bind groups again
/// after each `prepare`. Submit the commands that read them before the next `prepare`, or together
/// with the encoder.
#[derive(Debug)]
pub struct ShadowRenderer {
    device: Device,
    queue: Queue,
    options: RendererOptions,
    limits: BackendLimits,
    counters: Counters,
    submissions: Submissions,
    errors: LaterErrors,
    shared: Shared,
    /// One entry for each light encoded between two submissions.
    lights: Vec<Resources>,
    /// Index of the entry that was prepared last.
    prepared: Option<usize>,
}

impl ShadowRenderer {
    /// The limits that recipes with compute passes require: those of WebGL 2, and compute shaders
    /// with a storage texture, which WebGPU guarantees. These are recipes of moment maps,
    /// and of kernels with [`in_compute`](umbrage_core::ReceiveKernel::in_compute). Larger
    /// images, or tables in storage buffers, require more. Recipes with a
    /// [`hierarchy`](Recipe::hierarchy) require the compute limits of `Limits::default()`.
    pub const REQUIRED_LIMITS: Limits = COMPUTE_LIMITS;

    /// Returns a renderer for this device. No GPU objects are created yet.
    ///
    /// # Errors
    /// Errors if the device has too few bind groups for [`RendererOptions::kernel_group`].
    pub fn new(
        device: &Device,
        queue: &Queue,
        options: RendererOptions,
    ) -> Result<Self, BackendError> {
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
            device: device.clone(),
            queue: queue.clone(),
            options,
            limits: limits(device),
            counters: Counters::default(),
            submissions: Submissions::of_device(device),
            errors: LaterErrors::default(),
            shared: Shared::default(),
            lights: Vec::new(),
            prepared: None,
        })
    }

    /// Creates missing GPU objects of the recipe, and writes uniforms and new tables to the queue.
    /// Polls the device without waiting, to detect submissions of earlier encoders.
    ///
    /// # Errors
    /// Errors if the recipe or the frame is invalid, memory runs out, or a kernel's WGSL is invalid
    /// (with the compiler's message). After an error nothing is prepared, and all GPU objects are
    /// recreated.
    pub fn prepare(
        &mut self,
        recipe: &Recipe,
        frame: &FrameInputs<'_>,
    ) -> Result<(), BackendError> {
        let frame = FrameWithHoles {
            inputs: frame,
            holes: None,
        };
        self.prepare_with_holes(recipe, frame)
    }

    /// Prepares a frame that also draws alpha-tested triangles; the frame's inputs list the others.
    pub(crate) fn prepare_with_holes(
        &mut self,
        recipe: &Recipe,
        frame: FrameWithHoles<'_>,
    ) -> Result<(), BackendError> {
        self.prepared = None;
        // Check the inputs.
        recipe.make_tables();
        recipe.validate(&self.limits)?;
        let limits = self.device.limits();
        check_counting(recipe, self.device.features())?;
        check_compute(recipe, &limits)?;
        check_faces(recipe, limits.max_buffer_size)?;
        check_hierarchy(recipe, &limits)?;
        let inputs = frame.inputs;
        check_size(inputs.size, self.limits.image_side)?;
        inputs.validate(recipe, &limits)?;
        // Choose resources that no unsubmitted encoder uses.
        let pairs = pairs(recipe)?;
        let light = self.free_resources(recipe, inputs);
        self.shared.tables.forget_unreachable();
        self.shared.faces.forget_unreachable();
        // Create and write the resources.
        let scopes = Scopes::open(&self.device);
        let mut factory = ResourceFactory::new(&self.device, &self.queue, &mut self.counters);
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
    /// fit, otherwise the first free ones, otherwise new ones.
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

    /// Records all passes, including that of the [`picture`](Self::picture) if the recipe shades.
    /// Returns the mask: `R32Float`, visibility of the light, 1 for pixels that don't receive.
    ///
    /// # Errors
    /// Errors if [`prepare`](Self::prepare) has not succeeded before.
    pub fn encode(&self, encoder: &mut CommandEncoder) -> Result<&TextureView, BackendError> {
        self.encode_timed(encoder, None)
    }

    /// Records all passes like [`encode`](Self::encode), with timestamps around the stages.
    ///
    /// # Errors
    /// Errors if [`encode`](Self::encode) does.
    pub fn encode_timed(
        &self,
        encoder: &mut CommandEncoder,
        stamps: Option<&PassTimestamps<'_>>,
    ) -> Result<&TextureView, BackendError> {
        let light = self.recorded_resources(encoder)?;
        light.casts.encode(encoder, stamps);
        light.encode_inputs(encoder, stamps);
        light
            .encode_mask(encoder, self.options, stamps)
            .ok_or_else(unprepared_error)
    }

    /// Returns the targets to draw into before
    /// [`encode_filters_and_receive`](Self::encode_filters_and_receive), for callers whose casters
    /// need their own vertex formats or shaders (skinning, displacement, alpha test). If casts
    /// peel, count or draw a technique's faces, use [`encode_casts_with`](Self::encode_casts_with),
    /// which also records the passes between them.
    ///
    /// # Errors
    /// Errors if [`encode`](Self::encode) does, or if there is such a cast.
    pub fn cast_targets(&self) -> Result<&[CastTarget], BackendError> {
        let casts = &self.light()?.casts;
        if casts.are_plain() {
            return Ok(&casts.targets);
        }
        let why = "peel, count or draw a technique's faces, which needs more than the targets";
        Err(Invalid::new("casts", why, "call `encode_casts_with` instead").into())
    }

    /// Records all casts in order. Draws a technique's faces itself, and calls `draw` for each cast
    /// of casters or all geometry, to record a pass into its target.
    ///
    /// # Errors
    /// Errors if [`encode`](Self::encode) does.
    pub fn encode_casts_with(
        &self,
        encoder: &mut CommandEncoder,
        mut draw: impl FnMut(&mut CommandEncoder, &CastTarget),
    ) -> Result<(), BackendError> {
        let casts = &self.recorded_resources(encoder)?.casts;
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
        let light = self.recorded_resources(encoder)?;
        light.encode_inputs(encoder, None);
        light
            .encode_mask(encoder, self.options, None)
            .ok_or_else(unprepared_error)
    }

    /// Records only the casts. Together with [`encode_filters`](Self::encode_filters) and
    /// [`receive_bind_group`](Self::receive_bind_group), this suffices for forward shading.
    ///
    /// # Errors
    /// Errors if [`encode`](Self::encode) does.
    pub fn encode_casts(&self, encoder: &mut CommandEncoder) -> Result<(), BackendError> {
        self.recorded_resources(encoder)?
            .casts
            .encode(encoder, None);
        Ok(())
    }

    /// Records only the filters, and the passes that build the recipe's hierarchy.
    ///
    /// # Errors
    /// Errors if [`encode`](Self::encode) does.
    pub fn encode_filters(&self, encoder: &mut CommandEncoder) -> Result<(), BackendError> {
        let light = self.recorded_resources(encoder)?;
        light.encode_inputs(encoder, None);
        Ok(())
    }

    /// Records filters without clearing unwritten images.
    #[cfg(feature = "testing")]
    pub(crate) fn encode_filters_only(
        &self,
        encoder: &mut CommandEncoder,
    ) -> Result<(), BackendError> {
        self.recorded_resources(encoder)?
            .filters
            .encode(encoder, None, 0);
        Ok(())
    }

    #[cfg(feature = "testing")]
    pub(crate) fn encode_receive(&self, encoder: &mut CommandEncoder) -> Result<(), BackendError> {
        let light = self.recorded_resources(encoder)?;
        light.hierarchy.encode(encoder, None);
        light
            .encode_mask(encoder, self.options, None)
            .map(|_| ())
            .ok_or_else(unprepared_error)
    }

    /// Returns the bind group of the receive kernel, for [`receive_wgsl`](crate::receive_wgsl) in
    /// the caller's shader: set it at [`RendererOptions::kernel_group`].
    ///
    /// # Errors
    /// Errors if [`encode`](Self::encode) does.
    pub fn receive_bind_group(&self) -> Result<(&BindGroup, &BindGroupLayout), BackendError> {
        self.light()?
            .receive
            .kernel_group()
            .ok_or_else(unprepared_error)
    }

    /// Returns an image of the recipe with all its layers, for display; counts are integers
    /// (`texture_2d<u32>`).
    pub fn image(&self, id: usize) -> Option<&TextureView> {
        self.gpu_images().get(id).map(|image| &image.whole)
    }

    /// Returns the shaded image of the recipe, `Rgba32Float`, linear; `None` before a recipe that
    /// shades is prepared.
    pub fn picture(&self) -> Option<&TextureView> {
        self.gpu_picture().map(|image| &image.whole)
    }

    /// Returns an error of the graphics API since the last call, for
    /// [`ApiErrors::Later`](crate::ApiErrors::Later). After an error, nothing is prepared, and all
    /// GPU objects are recreated.
    pub fn take_error(&mut self) -> Option<BackendError> {
        let error = self.errors.take()?;
        (self.shared, self.lights) = Default::default();
        self.prepared = None;
        Some(error)
    }

    /// Returns the number of GPU objects created so far.
    #[cfg(feature = "testing")]
    pub fn counters(&self) -> Counters {
        Counters {
            buffers: self.counters.buffers + self.submissions.made_count(),
            ..self.counters
        }
    }

    /// Returns the bytes of the hierarchy that was prepared last, without the corners, 0 if there is
    /// none.
    pub(crate) fn hierarchy_bytes(&self) -> u64 {
        self.light().map_or(0, |light| light.hierarchy.bytes())
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

    /// Returns the resources that were prepared last.
    fn light(&self) -> Result<&Resources, BackendError> {
        self.prepared
            .and_then(|i| self.lights.get(i))
            .ok_or_else(unprepared_error)
    }

    /// Returns the resources that were prepared last, and protects them from writes until the
    /// encoder's commands are submitted.
    fn recorded_resources(&self, encoder: &CommandEncoder) -> Result<&Resources, BackendError> {
        let light = self.light()?;
        self.submissions.watch(encoder, &light.pending);
        Ok(light)
    }
}

fn unprepared_error() -> BackendError {
    Invalid::new(
        "shadow renderer",
        "has nothing prepared",
        "call `prepare` first, and check its error",
    )
    .into()
}
