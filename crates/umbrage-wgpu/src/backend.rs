//! [`Gpu`]: a backend with a device of its own.

use crate::{
    FrameInputs, RendererOptions, ShadowRenderer,
    device::{
        adapter::AdapterChoice,
        convert::Converter,
        device_errors::DeviceErrors,
        error_scopes::Scopes,
        probe::probe_snapping,
        readback::{ReadBack, Spare},
        requirements::{self, check_adapter},
        results::Tickets,
        timestamp_queries::{StagesWithPasses, TimestampQueries},
    },
    gbuffer::{GBufferPass, ReceiverTextures},
    renderer::check_size,
    resources::{
        counters::{Counters, ResourceFactory},
        counts::COUNTING,
        geometry::Geometries,
        images::GpuImage,
    },
};
use std::sync::{Mutex, PoisonError};
use umbrage_core::{
    Backend, BackendError, BackendLimits, Invalid, Receivers, Recipe, Shadows, Snapping, Source,
    View,
};
use wgpu::{Adapter, AdapterInfo, CommandEncoder, Device, DeviceDescriptor, Features, Queue};

/// Borrows only the fields needed, so that the others stay free.
macro_rules! maker {
    ($gpu:expr) => {
        $crate::resources::counters::ResourceFactory {
            device: &$gpu.device,
            queue: &$gpu.queue,
            counters: &mut $gpu.counters,
        }
    };
}
#[cfg(feature = "testing")]
pub(crate) use maker;

/// Plays recipes on a graphics adapter, uploads what they need and reads the mask back.
///
/// [`Shadows::timings`] are timestamps of the graphics adapter around the passes, so they hold no upload, compilation or
/// read-back of ours; but drivers finish compiling a shader when it is first drawn with, so leave the first runs of a
/// measurement out. Where the adapter has no timestamps, there are no timings.
#[derive(Debug)]
pub struct Gpu {
    pub(crate) name: String,
    pub(crate) adapter: Adapter,
    pub(crate) device: Device,
    pub(crate) queue: Queue,
    pub(crate) faults: DeviceErrors,
    pub(crate) renderer: ShadowRenderer,
    pub(crate) finder: GBufferPass,
    pub(crate) clock: Option<TimestampQueries>,
    pub(crate) geometries: Geometries,
    pub(crate) receivers: Option<ReceiverTextures>,
    pub(crate) spare: Spare,
    pub(crate) converter: Converter,
    pub(crate) counters: Counters,
    pub(crate) snapping: Snapping,
}

impl Gpu {
    /// Opens the adapter that fits the choice best.
    ///
    /// # Errors
    /// `NoAdapter` with what there is and what to install; or when the adapter cannot draw into float images.
    pub fn new(choice: &AdapterChoice) -> Result<Self, BackendError> {
        let adapter = choice.find()?;
        requirements::check_player(&adapter)?;
        let desc = DeviceDescriptor {
            label: Some("umbrage"),
            required_features: adapter.features() & (Features::TIMESTAMP_QUERY | COUNTING),
            // All that there is, so that large scenes fit.
            required_limits: adapter.limits(),
            ..DeviceDescriptor::default()
        };
        let opened = pollster::block_on(adapter.request_device(&desc));
        let (device, queue) = opened.map_err(|e| BackendError::DeviceLost(e.to_string()))?;
        let faults = DeviceErrors::of(&device);
        let info = adapter.get_info();
        let scopes = Scopes::open(&device);
        let mut counters = Counters::default();
        let gpu = Self {
            name: format!("wgpu: {} ({})", info.name, info.backend),
            finder: GBufferPass::new(&ResourceFactory {
                device: &device,
                queue: &queue,
                counters: &mut counters,
            }),
            clock: TimestampQueries::new(&device, &queue),
            renderer: ShadowRenderer::new(&device, RendererOptions::default())?,
            geometries: Geometries::default(),
            receivers: None,
            spare: Spare::default(),
            converter: Converter::default(),
            counters,
            snapping: snapping_of(&info, &device, &queue)?,
            adapter,
            device,
            queue,
            faults,
        };
        scopes.close()?;
        Ok(gpu)
    }

    /// The adapter's name, type, API, driver and driver version.
    pub fn adapter_info(&self) -> AdapterInfo {
        self.adapter.get_info()
    }

    /// The device and its queue, to share them with a renderer of your own.
    pub fn device(&self) -> (&Device, &Queue) {
        (&self.device, &self.queue)
    }

    /// What recipes may ask of this adapter.
    pub fn limits(&self) -> BackendLimits {
        self.renderer.limits()
    }

    /// What was made so far, for recipes and for receivers.
    #[cfg(feature = "testing")]
    pub fn counters(&self) -> Counters {
        let a = self.counters;
        let b = self.renderer.counters();
        Counters {
            pipelines: a.pipelines + b.pipelines,
            textures: a.textures + b.textures,
            buffers: a.buffers + b.buffers,
            bind_groups: a.bind_groups + b.bind_groups,
        }
    }

    /// Runs `f` with every error of the device turned into `Err`.
    pub(crate) fn guarded<R>(
        &mut self,
        f: impl FnOnce(&mut Self) -> Result<R, BackendError>,
    ) -> Result<R, BackendError> {
        self.faults.check()?;
        let scopes = Scopes::open(&self.device);
        let result = f(self);
        let closed = scopes.close();
        // A lost device explains all other errors, and errors of the device those that follow from them.
        let outcome = self.faults.check().and(closed).and(result);
        if outcome.is_err() {
            // What was made may be unusable.
            (self.receivers, self.geometries, self.converter) = Default::default();
        }
        outcome
    }

    fn play(&mut self, view: &View<'_>, recipe: &Recipe) -> Result<Shadows, BackendError> {
        let found = self.prepare(view, recipe)?;
        let mut encoder = self.begin(found);
        self.renderer.encode_timed(
            &mut encoder,
            self.clock.as_ref().map(TimestampQueries::stamps).as_ref(),
        )?;
        self.finish(encoder, view, recipe, found.is_some())
    }

    /// Uploads and compiles. Returns how many triangles are to be drawn to find receivers, if they aren't known.
    pub(crate) fn prepare(
        &mut self,
        view: &View<'_>,
        recipe: &Recipe,
    ) -> Result<Option<u32>, BackendError> {
        let mut maker = maker!(self);
        let textures = ReceiverTextures::fit(&mut self.receivers, &mut maker, view.camera.size);
        let geometry = view
            .geometry
            .map(|g| self.geometries.get(&mut maker, g))
            .transpose()?;
        match (view.receivers, geometry) {
            (Some(receivers), _) => textures.upload(&maker, receivers),
            (None, Some(geometry)) => {
                self.finder
                    .prepare(&mut maker, view.camera, geometry, textures)
            }
            (None, None) => return Err(blind()),
        }
        let casters: Vec<_> = geometry.iter().map(|g| g.casters()).collect();
        let everything: Vec<_> = geometry.iter().map(|g| g.everything()).collect();
        let size = view.camera.size;
        let receivers = textures.gbuffer();
        let frame = FrameInputs {
            size,
            casters: &casters,
            everything: &everything,
            receivers,
        };
        self.renderer
            .prepare(&self.device, &self.queue, recipe, &frame)?;
        Ok(geometry
            .filter(|_| view.receivers.is_none())
            .map(|g| g.triangles))
    }

    /// An encoder, with the passes that find receivers if they are to be found.
    pub(crate) fn begin(&self, found: Option<u32>) -> CommandEncoder {
        let mut encoder = self
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        if let (Some(triangles), Some(textures)) = (found, &self.receivers) {
            let queries = self.clock.as_ref().map(|c| &c.queries);
            self.finder
                .encode(&mut encoder, textures, triangles, queries);
        }
        encoder
    }

    /// The recipe's images, or floats in their place, as copies of memory can read them.
    pub(crate) fn readable_images(&mut self, encoder: &mut CommandEncoder) -> Vec<GpuImage> {
        self.converter
            .read(&mut maker!(self), encoder, self.renderer.gpu_images())
    }

    /// Submits, waits, and reads back.
    fn finish(
        &mut self,
        mut encoder: CommandEncoder,
        view: &View<'_>,
        recipe: &Recipe,
        found: bool,
    ) -> Result<Shadows, BackendError> {
        let played = StagesWithPasses::new(recipe, found);
        let kept = if recipe.keep_images {
            self.readable_images(&mut encoder)
        } else {
            Vec::new()
        };
        let mut back = ReadBack::new(&self.device, &mut self.counters, &mut self.spare);
        let tickets = Tickets::record(&mut encoder, &mut back, &self.renderer, &kept);
        let receivers = self
            .receivers
            .as_ref()
            .filter(|_| found)
            .map(|t| t.record(&mut encoder, &mut back));
        let clock = self
            .clock
            .as_ref()
            .map(|c| (c, c.read(&mut encoder, played, &mut back)));
        self.queue.submit([encoder.finish()]);
        back.wait()?;
        let pixels = u64::from(view.camera.size.x) * u64::from(view.camera.size.y);
        Ok(Shadows {
            size: view.camera.size,
            mask: tickets.mask(&back)?,
            picture: tickets.picture(&back)?,
            images: tickets.images(&back, recipe)?,
            receivers: receivers.map(|t| t.read(&back, view)).transpose()?,
            timings: clock
                .map(|(c, t)| c.timings(played, &back, t))
                .transpose()?
                .unwrap_or_default(),
            bytes: recipe.image_bytes() + recipe.table_bytes() + pixels * bytes_a_pixel(recipe),
        })
    }
}

/// How an adapter rounds vertices: probed once a process.
fn snapping_of(
    info: &AdapterInfo,
    device: &Device,
    queue: &Queue,
) -> Result<Snapping, BackendError> {
    static KNOWN: Mutex<Vec<(AdapterInfo, Snapping)>> = Mutex::new(Vec::new());
    // RendererState while it is probed, so that others wait rather than probe, too.
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((_, snapping)) = known.iter().find(|(of, _)| of == info) {
        return Ok(*snapping);
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
        self.guarded(|gpu| gpu.play(view, recipe))
    }
}

pub(crate) fn check(view: &View<'_>, recipe: &Recipe) -> Result<(), BackendError> {
    view.camera.validate()?;
    if let Some(r) = view.receivers.filter(|r| r.size != view.camera.size) {
        let why = format!("are an image of {} x {} pixels", r.size.x, r.size.y);
        let help = format!(
            "make them for this camera, {} x {}",
            view.camera.size.x, view.camera.size.y
        );
        return Err(Invalid::new("receivers", why, help).into());
    }
    view.receivers.map_or(Ok(()), Receivers::validate)?;
    if view.geometry.is_none()
        && recipe
            .casts
            .iter()
            .any(|c| !matches!(c.source, Source::Faces(_)))
    {
        let help = "give the view its geometry, or draw yours with `ShadowRenderer`";
        return Err(Invalid::new("view", "has no geometry, but the recipe casts", help).into());
    }
    Ok(())
}

/// Mask, receivers, and the picture if there is one.
fn bytes_a_pixel(recipe: &Recipe) -> u64 {
    4 + ReceiverTextures::BYTES + if recipe.shade.is_some() { 16 } else { 0 }
}

fn blind() -> BackendError {
    Invalid::new(
        "view",
        "has neither geometry nor receivers",
        "give it one of them",
    )
    .into()
}
