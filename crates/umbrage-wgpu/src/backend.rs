//! [`Gpu`]: a backend with its own device.

use crate::{
    device::{
        adapter::AdapterChoice,
        convert::Converter,
        device_errors::DeviceErrors,
        error_scopes::Scopes,
        probe::probe_snapping,
        probe_fusing::probe_fusing,
        readback::{ReadBack, Spare},
        requirements::{self, check_adapter},
        results::Tickets,
        timestamp_queries::{StagesWithPasses, TimestampQueries},
    },
    frame::{FrameInputs, RendererOptions, check_size},
    gbuffer::{GBufferPass, ReceiverTextures},
    renderer::ShadowRenderer,
    resources::{
        counters::{Counters, ResourceFactory},
        counts::COUNTING,
        cut_outs::FrameWithHoles,
        geometry::{Geometries, GpuGeometry},
        images::GpuImage,
    },
};
use std::sync::{Mutex, PoisonError};
use umbrage_core::{
    Backend, BackendError, BackendLimits, Fusing, Invalid, Receivers, Recipe, Shadows, Snapping,
    Source, Timings, View,
};
use wgpu::{Adapter, AdapterInfo, CommandEncoder, Device, DeviceDescriptor, Features, Queue};

/// Builds a [`ResourceFactory`] from a [`Gpu`]. It is a macro because a method would borrow all
/// fields.
macro_rules! factory {
    ($gpu:expr) => {
        $crate::resources::counters::ResourceFactory {
            device: &$gpu.device,
            queue: &$gpu.queue,
            counters: &mut $gpu.counters,
        }
    };
}
#[cfg(feature = "testing")]
pub(crate) use factory;

/// Executes recipes on a graphics adapter: uploads inputs and reads the mask back.
///
/// [`Shadows::timings`] are GPU timestamps around the passes, without upload, compilation or
/// readback. Drivers may finish compiling a shader at its first draw, so exclude the first runs
/// from a measurement. There are no timings if the adapter has no timestamps.
#[derive(Debug)]
pub struct Gpu {
    pub(crate) name: String,
    pub(crate) adapter: Adapter,
    pub(crate) device: Device,
    pub(crate) queue: Queue,
    pub(crate) errors: DeviceErrors,
    pub(crate) renderer: ShadowRenderer,
    pub(crate) gbuffer_pass: GBufferPass,
    pub(crate) timestamps: Option<TimestampQueries>,
    pub(crate) geometries: Geometries,
    pub(crate) receivers: Option<ReceiverTextures>,
    pub(crate) spare: Spare,
    pub(crate) converter: Converter,
    pub(crate) counters: Counters,
    pub(crate) snapping: Snapping,
}

impl Gpu {
    /// Opens the adapter that matches the choice best.
    ///
    /// # Errors
    /// Errors with `NoAdapter`, the available adapters and advice if none matches. Errors if the
    /// adapter cannot draw into float images.
    pub fn new(choice: &AdapterChoice) -> Result<Self, BackendError> {
        let adapter = choice.find()?;
        requirements::check_receivers(&adapter)?;
        // Open the device with the optional features of the adapter.
        #[cfg(feature = "testing")]
        let of_tests = crate::driver_model::features();
        #[cfg(not(feature = "testing"))]
        let of_tests = Features::empty();
        let desc = DeviceDescriptor {
            label: Some("umbrage"),
            required_features: adapter.features()
                & (Features::TIMESTAMP_QUERY | COUNTING | of_tests),
            // Request the adapter's full limits, so that large scenes fit.
            required_limits: adapter.limits(),
            ..DeviceDescriptor::default()
        };
        let opened = pollster::block_on(adapter.request_device(&desc));
        let (device, queue) = opened.map_err(|e| BackendError::DeviceLost(e.to_string()))?;
        let errors = DeviceErrors::of_device(&device);
        let info = adapter.get_info();
        // Create the resources that all recipes share.
        let scopes = Scopes::open(&device);
        let mut counters = Counters::default();
        let gpu = Self {
            name: format!("wgpu: {} ({})", info.name, info.backend),
            gbuffer_pass: GBufferPass::new(&ResourceFactory {
                device: &device,
                queue: &queue,
                counters: &mut counters,
            }),
            timestamps: TimestampQueries::new(&device, &queue),
            renderer: ShadowRenderer::new(&device, &queue, RendererOptions::default())?,
            geometries: Geometries::default(),
            receivers: None,
            spare: Spare::default(),
            converter: Converter::default(),
            counters,
            snapping: snapping_of(&info, &device, &queue)?,
            adapter,
            device,
            queue,
            errors,
        };
        scopes.close()?;
        Ok(gpu)
    }

    /// Returns the adapter's name, type, API, driver and driver version.
    pub fn adapter_info(&self) -> AdapterInfo {
        self.adapter.get_info()
    }

    /// Returns the device and its queue, to share them with another renderer.
    pub fn device(&self) -> (&Device, &Queue) {
        (&self.device, &self.queue)
    }

    /// Returns the device's rounding of products in sums. Draws a few pixels to determine it.
    ///
    /// # Errors
    /// Errors if the device fails.
    pub fn fusing(&self) -> Result<Fusing, BackendError> {
        probe_fusing(&self.device, &self.queue)
    }

    /// Returns the largest images, layers and tables that recipes may use on this adapter.
    pub fn limits(&self) -> BackendLimits {
        self.renderer.limits()
    }

    /// Returns the number of GPU objects created so far, for recipes and for receivers.
    #[cfg(feature = "testing")]
    pub fn counters(&self) -> Counters {
        let own = self.counters;
        let renderer = self.renderer.counters();
        Counters {
            pipelines: own.pipelines + renderer.pipelines,
            textures: own.textures + renderer.textures,
            buffers: own.buffers + renderer.buffers,
            bind_groups: own.bind_groups + renderer.bind_groups,
        }
    }

    /// Runs `f` and converts all device errors to `Err`.
    pub(crate) fn catch_errors<R>(
        &mut self,
        f: impl FnOnce(&mut Self) -> Result<R, BackendError>,
    ) -> Result<R, BackendError> {
        self.errors.check()?;
        let scopes = Scopes::open(&self.device);
        let result = f(self);
        let closed = scopes.close();
        // Report a lost device first, then errors of the device: they cause the others.
        let outcome = self.errors.check().and(closed).and(result);
        if outcome.is_err() {
            // Drop cached objects, which may be unusable.
            self.receivers = None;
            self.geometries = Geometries::default();
            self.converter = Converter::default();
        }
        outcome
    }

    fn execute(&mut self, view: &View<'_>, recipe: &Recipe) -> Result<Shadows, BackendError> {
        let triangles = self.prepare(view, recipe)?;
        let mut encoder = self.begin(triangles);
        let stamps = self.timestamps.as_ref().map(TimestampQueries::stamps);
        self.renderer.encode_timed(&mut encoder, stamps.as_ref())?;
        self.finish(encoder, view, recipe, triangles.is_some())
    }

    /// Uploads and compiles. Returns the number of triangles to draw to compute receivers; `None`
    /// if the view provides receivers.
    pub(crate) fn prepare(
        &mut self,
        view: &View<'_>,
        recipe: &Recipe,
    ) -> Result<Option<u32>, BackendError> {
        let mut factory = factory!(self);
        // Upload the geometry, and the receivers if known.
        let textures = ReceiverTextures::fit(&mut self.receivers, &mut factory, view.camera.size);
        let geometry = match view.geometry {
            Some(geometry) => Some(self.geometries.get(&mut factory, geometry)?),
            None => None,
        };
        match (view.receivers, geometry) {
            (Some(receivers), _) => textures.upload(&factory, receivers),
            (None, Some(geometry)) => {
                textures.forget_upload();
                self.gbuffer_pass
                    .prepare(&mut factory, view.camera, geometry, textures);
            }
            (None, None) => return Err(blind()),
        }
        // Prepare the recipe.
        let casters = geometry.map_or_else(Vec::new, GpuGeometry::casters);
        let everything = geometry.map_or_else(Vec::new, GpuGeometry::everything);
        let holes = geometry.and_then(|g| g.cut_outs.as_ref());
        let size = view.camera.size;
        let receivers = textures.gbuffer();
        let frame = FrameInputs {
            size,
            casters: &casters,
            everything: &everything,
            receivers,
        };
        let frame = FrameWithHoles {
            inputs: &frame,
            holes,
        };
        self.renderer.prepare_with_holes(recipe, frame)?;
        match view.receivers {
            Some(_) => Ok(None),
            None => Ok(geometry.map(|g| g.triangles)),
        }
    }

    /// Returns an encoder. If `triangles` is given, records the passes that compute receivers by
    /// drawing that many triangles.
    pub(crate) fn begin(&self, triangles: Option<u32>) -> CommandEncoder {
        let mut encoder = self
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        if let (Some(triangles), Some(textures)) = (triangles, &self.receivers) {
            let queries = self.timestamps.as_ref().map(TimestampQueries::queries);
            self.gbuffer_pass
                .encode(&mut encoder, textures, triangles, queries);
        }
        encoder
    }

    /// Returns the recipe's images, or float copies of those whose format can't be read back.
    pub(crate) fn readable_images(&mut self, encoder: &mut CommandEncoder) -> Vec<GpuImage> {
        self.converter
            .read(&mut factory!(self), encoder, self.renderer.gpu_images())
    }

    /// Submits, waits, and reads back. `finds_receivers` is true if the encoder contains the passes
    /// that compute receivers.
    fn finish(
        &mut self,
        mut encoder: CommandEncoder,
        view: &View<'_>,
        recipe: &Recipe,
        finds_receivers: bool,
    ) -> Result<Shadows, BackendError> {
        // Record the copies.
        let stages = StagesWithPasses::new(recipe, finds_receivers);
        let kept = if recipe.keep_images {
            self.readable_images(&mut encoder)
        } else {
            Vec::new()
        };
        let mut back = ReadBack::new(&self.device, &mut self.counters, &mut self.spare);
        let tickets = Tickets::record(&mut encoder, &mut back, &self.renderer, &kept);
        let receiver_tickets = match &self.receivers {
            Some(textures) if finds_receivers => Some(textures.record(&mut encoder, &mut back)),
            _ => None,
        };
        let time_ticket = self
            .timestamps
            .as_ref()
            .map(|queries| queries.read(&mut encoder, stages, &mut back));
        // Submit, and read the results.
        self.queue.submit([encoder.finish()]);
        back.wait()?;
        let receivers = match receiver_tickets {
            Some(tickets) => Some(tickets.read(&back, view)?),
            None => None,
        };
        let timings = match (&self.timestamps, time_ticket) {
            (Some(queries), Some(ticket)) => queries.timings(stages, &back, ticket)?,
            _ => Timings::default(),
        };
        let pixels = u64::from(view.camera.size.x) * u64::from(view.camera.size.y);
        Ok(Shadows {
            size: view.camera.size,
            mask: tickets.mask(&back)?,
            picture: tickets.picture(&back)?,
            images: tickets.images(&back, recipe)?,
            receivers,
            timings,
            bytes: recipe.image_bytes()
                + recipe.table_bytes()
                + self.renderer.hierarchy_bytes()
                + pixels * bytes_per_pixel(recipe),
        })
    }
}

/// Returns the vertex rounding of an adapter. Each adapter is probed once per process.
fn snapping_of(
    info: &AdapterInfo,
    device: &Device,
    queue: &Queue,
) -> Result<Snapping, BackendError> {
    static KNOWN: Mutex<Vec<(AdapterInfo, Snapping)>> = Mutex::new(Vec::new());
    // Hold the lock during the probe, so that other threads wait instead of probing the adapter,
    // too.
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    for (adapter, snapping) in known.iter() {
        if adapter == info {
            return Ok(*snapping);
        }
    }
    let snapping = probe_snapping(device, queue)?;
    known.push((info.clone(), snapping));
    Ok(snapping)
}

impl Backend for Gpu {
    fn name(&self) -> &str {
        &self.name
    }

    fn kind(&self) -> &'static str {
        "wgpu"
    }

    fn snapping(&self) -> Snapping {
        self.snapping
    }

    fn render(&mut self, view: &View<'_>, recipe: &Recipe) -> Result<Shadows, BackendError> {
        check(view, recipe)?;
        check_size(view.camera.size, self.limits().image_side)?;
        check_adapter(&self.adapter, recipe)?;
        self.catch_errors(|gpu| gpu.execute(view, recipe))
    }
}

/// Errors if the view lacks an input of the recipe, or contains invalid numbers.
pub(crate) fn check(view: &View<'_>, recipe: &Recipe) -> Result<(), BackendError> {
    view.camera.validate()?;
    if let Some(r) = view.receivers.filter(|r| r.size != view.camera.size) {
        let why = format!("are for an image of {} x {} pixels", r.size.x, r.size.y);
        let help = format!(
            "compute them for this camera, {} x {}",
            view.camera.size.x, view.camera.size.y
        );
        return Err(Invalid::new("receivers", why, help).into());
    }
    view.receivers.map_or(Ok(()), Receivers::validate)?;
    if let Some(geometry) = view.geometry {
        recipe.check_holes(geometry)?;
    }
    let casts_geometry = recipe
        .casts
        .iter()
        .any(|c| !matches!(c.source, Source::Faces(_)));
    if view.geometry.is_none() && casts_geometry {
        let help = "add geometry to the view, or draw your own with `ShadowRenderer`";
        return Err(Invalid::new("view", "has no geometry, but the recipe casts", help).into());
    }
    Ok(())
}

/// Returns the bytes per pixel of the mask, the receivers and the colour image, if any.
fn bytes_per_pixel(recipe: &Recipe) -> u64 {
    let mask = 4;
    let picture = if recipe.shade.is_some() { 16 } else { 0 };
    mask + ReceiverTextures::BYTES + picture
}

fn blind() -> BackendError {
    Invalid::new(
        "view",
        "has neither geometry nor receivers",
        "add one of them",
    )
    .into()
}
