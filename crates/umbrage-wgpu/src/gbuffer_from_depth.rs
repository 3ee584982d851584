//! [`GBufferFromDepth`]: for engines that have a depth buffer, but no positions.

use crate::{
    device::{
        error_scopes::Scopes,
        later_errors::{ApiErrors, LaterErrors},
    },
    filter::color_attachment,
    frame::{GBuffer, check_readable},
    resources::{
        bindings::{Binding, Bound, Layouts, Slot},
        counters::{Counters, ResourceFactory},
        images::{GpuImage, fit_images},
        pipelines::{Targets, fullscreen_pipeline},
    },
    wgsl::stages::depth_wgsl,
};
use encase::{ShaderType, UniformBuffer};
use glam::{DVec3, Mat4, UVec2};
use std::collections::HashMap;
use umbrage_core::{BackendError, Format, ImageDesc, Invalid, invalid};
use wgpu::{
    Buffer, BufferUsages, Color, CommandEncoder, Device, Queue, RenderPassDescriptor,
    RenderPipeline, ShaderStages, TextureFormat, TextureView,
};

/// Computes a [`GBuffer`] from the caller's depth buffer in one full-screen pass. Normals are
/// derived from neighbouring pixels, so they are inaccurate where a surface is only a pixel wide.
/// If the engine has geometric normals, use those.
#[derive(Debug)]
pub struct GBufferFromDepth {
    device: Device,
    queue: Queue,
    counters: Counters,
    layouts: Layouts,
    /// Pipelines by whether depth is multisampled.
    pipelines: HashMap<bool, RenderPipeline>,
    uniforms: Option<Buffer>,
    binding: Binding,
    images: Vec<GpuImage>,
    samples: bool,
    errors: LaterErrors,
}

/// A depth buffer and its camera.
#[derive(Clone, Copy, Debug)]
pub struct DepthBuffer<'a> {
    /// Depth texture: any depth format (with a stencil: a view with `aspect:
    /// TextureAspect::DepthOnly`) or `R32Float`, usage `TEXTURE_BINDING`. The first sample of a
    /// multisampled texture is used.
    pub depth: &'a TextureView,
    /// Inverse of the camera's clip from world. It covers handedness, reversed z and an infinite
    /// far plane.
    pub world_from_clip: Mat4,
    /// Depth of empty pixels: 1, or 0 with reversed z.
    pub empty: f32,
}

/// Twin of `DepthCamera` in depth.wgsl.
#[derive(ShaderType)]
pub(crate) struct DepthCamera {
    world_from_clip: Mat4,
    empty: f32,
    handedness: f32,
}

impl DepthCamera {
    /// Errors if the depth buffer's matrix is singular.
    pub(crate) fn of_source(source: &DepthBuffer<'_>) -> Result<Self, Invalid> {
        Ok(Self {
            world_from_clip: source.world_from_clip,
            empty: source.empty,
            handedness: source.handedness()?,
        })
    }

    /// Returns the bytes as shaders read them.
    pub(crate) fn bytes(&self) -> [u8; CAMERA_BYTES] {
        let mut bytes = UniformBuffer::new([0; CAMERA_BYTES]);
        // The struct fits: `CAMERA_BYTES` is its size.
        bytes.write(self).unwrap_or_default();
        bytes.into_inner()
    }
}

/// Bytes of the uniform struct.
const CAMERA_BYTES: usize = 80;

impl GBufferFromDepth {
    /// Returns a converter for this device. GPU objects are created with the first frame.
    pub fn new(device: &Device, queue: &Queue) -> Self {
        Self {
            device: device.clone(),
            queue: queue.clone(),
            counters: Counters::default(),
            layouts: Layouts::default(),
            pipelines: HashMap::new(),
            uniforms: None,
            binding: Binding::default(),
            images: Vec::new(),
            samples: false,
            errors: LaterErrors::default(),
        }
    }

    /// Creates missing GPU objects, and writes the camera.
    ///
    /// # Errors
    /// Errors if the matrix is singular, if `empty` is the depth of the nearest geometry, or if the
    /// depth buffer cannot be read as described.
    pub fn prepare(&mut self, source: &DepthBuffer<'_>) -> Result<(), BackendError> {
        source.validate()?;
        let camera = DepthCamera::of_source(source)?;
        let (device, queue) = (self.device.clone(), self.queue.clone());
        let scopes = Scopes::open(&device);
        let mut counters = self.counters;
        let mut factory = ResourceFactory::new(&device, &queue, &mut counters);
        self.prepare_with(&mut factory, source, &camera);
        let closed = self.errors.close(scopes, ApiErrors::default());
        if closed.is_err() {
            *self = Self::new(&self.device, &self.queue);
        }
        self.counters = counters;
        closed.map_err(|error| source.with_advice(error))
    }

    fn prepare_with(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        source: &DepthBuffer<'_>,
        camera: &DepthCamera,
    ) {
        // Fit the textures to the depth buffer.
        let texture = source.depth.texture();
        let size = UVec2::new(texture.width(), texture.height());
        self.samples = source.has_samples();
        let positions = ImageDesc {
            label: "umbrage positions",
            size,
            layers: 1,
            format: Format::Rgba32,
        };
        let normals = ImageDesc {
            label: "umbrage normals",
            ..positions
        };
        let images = &mut self.images;
        fit_images(factory, images, &[positions, normals], &[], |_| false);
        // Write the camera, and bind the inputs.
        let usage = BufferUsages::UNIFORM;
        let bytes = camera.bytes();
        let uniforms = factory.write(&mut self.uniforms, "umbrage camera", usage, &bytes);
        let entries = vec![
            (Slot::Uniform, Bound::Buffer(uniforms)),
            (source.slot(), Bound::View(source.depth.clone())),
        ];
        let layouts = &mut self.layouts;
        let stage = ShaderStages::FRAGMENT;
        let layout = self
            .binding
            .bind(factory, layouts, stage, "umbrage depth", entries);
        // Create the pipeline on first use.
        self.pipelines.entry(self.samples).or_insert_with(|| {
            factory.counters.pipelines += 1;
            let text = depth_wgsl(self.samples);
            let entries = ["umbrage_fullscreen", "unproject_pixel"];
            let targets = Targets::Colors(&[TextureFormat::Rgba32Float; 2]);
            fullscreen_pipeline(
                factory.device,
                "umbrage unproject",
                &text,
                entries,
                &targets,
                &[Some(&layout)],
            )
        });
    }

    /// Returns an error of the graphics API since the last call, for browsers, where
    /// [`prepare`](Self::prepare) can't wait for it. After an error, all GPU objects are recreated.
    pub fn take_error(&mut self) -> Option<BackendError> {
        let error = self.errors.take()?;
        *self = Self::new(&self.device, &self.queue);
        Some(error)
    }

    /// Records the pass and returns its output. Every pixel that is not empty receives shadows.
    ///
    /// # Errors
    /// Errors if [`prepare`](Self::prepare) has not succeeded before.
    pub fn encode(&self, encoder: &mut CommandEncoder) -> Result<GBuffer<'_>, BackendError> {
        let pipeline = self.pipelines.get(&self.samples);
        let (Some(pipeline), Some(gbuffer)) = (pipeline, self.gbuffer()) else {
            let help = "call `prepare` first, and check its error";
            return Err(Invalid::new("G-buffer from depth", "has nothing prepared", help).into());
        };
        let position = color_attachment(gbuffer.position, Color::TRANSPARENT);
        let normal = color_attachment(gbuffer.normal, Color::TRANSPARENT);
        let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
            label: Some("umbrage unproject"),
            color_attachments: &[Some(position), Some(normal)],
            ..RenderPassDescriptor::default()
        });
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, self.binding.group(), &[]);
        pass.draw(0..3, 0..1);
        drop(pass);
        Ok(gbuffer)
    }

    /// Returns the size of the G-buffer, pixels, for
    /// [`FrameInputs::size`](crate::FrameInputs::size); zero before the first frame.
    pub fn size(&self) -> UVec2 {
        self.images
            .first()
            .map_or(UVec2::ZERO, |image| image.desc.size)
    }

    /// Returns the textures that [`encode`](Self::encode) writes; `None` before the first frame is
    /// prepared.
    pub fn gbuffer(&self) -> Option<GBuffer<'_>> {
        let [position, normal] = &self.images[..] else {
            return None;
        };
        Some(GBuffer {
            position: &position.whole,
            normal: &normal.whole,
            triangle: None,
        })
    }

    /// Returns the number of GPU objects created so far.
    pub fn counters(&self) -> Counters {
        self.counters
    }
}

impl DepthBuffer<'_> {
    pub(crate) fn validate(&self) -> Result<(), Invalid> {
        let what = "depth buffer";
        let texture = self.depth.texture();
        check_readable(texture, what)?;
        let format = texture.format();
        if !format.has_depth_aspect() && format != TextureFormat::R32Float {
            let help = "use a depth format, or `R32Float`";
            return Err(Invalid::new(what, format!("is {format:?}"), help));
        }
        invalid::finite("world from clip", &self.world_from_clip.to_cols_array())?;
        if self.empty != 0.0 && self.empty != 1.0 {
            let why = format!("is {}", self.empty);
            return Err(Invalid::new(
                "depth where nothing was drawn",
                why,
                "use 1, or 0 with reversed z",
            ));
        }
        self.check_empty()
    }

    /// Returns an error of the graphics API, with advice if the texture has a stencil, too. A view's
    /// aspect can't be queried beforehand.
    pub(crate) fn with_advice(&self, error: BackendError) -> BackendError {
        match error {
            BackendError::Validation(why) if self.depth.texture().format().has_stencil_aspect() => {
                let help = "if its view has both aspects, create one with `aspect: TextureAspect::DepthOnly`";
                let why = format!("is not usable: {why}");
                Invalid::new("depth buffer with a stencil", why, help).into()
            }
            other => other,
        }
    }

    /// Returns whether the texture is multisampled.
    pub(crate) fn has_samples(&self) -> bool {
        self.depth.texture().sample_count() > 1
    }

    pub(crate) fn slot(&self) -> Slot {
        if self.has_samples() {
            Slot::Samples
        } else {
            Slot::Floats { layered: false }
        }
    }

    /// Errors if `empty` is the depth of the nearest geometry. Only a perspective matrix reveals
    /// which depth that is.
    fn check_empty(&self) -> Result<(), Invalid> {
        // Find the eye: all rays meet where clip x, y and w are 0.
        let eye = self.world_from_clip.as_dmat4().z_axis;
        // The fourth component is 1/far - 1/near, compared with 1/near or 1/far. Without
        // perspective it is 0, or what inverting rounds.
        if eye.w.abs() <= 1e-4 * f64::from(self.world_from_clip.w_axis.w.abs()) {
            return Ok(());
        }
        let eye = eye.truncate() / eye.w;
        let nearest = self.middle(f64::from(1.0 - self.empty)).distance(eye);
        // Compare the nearest point with the midpoint of the depths: one of the two ends may be at
        // infinity.
        let between = self.middle(0.5).distance(eye);
        if nearest < between {
            return Ok(());
        }
        let why = format!(
            "is {}, but for this camera that is the depth of the nearest geometry",
            self.empty
        );
        Err(Invalid::new(
            "depth where nothing was drawn",
            why,
            format!("use {}", 1.0 - self.empty),
        ))
    }

    /// Returns the world position of a point in clip space.
    fn unproject(&self, x: f64, y: f64, z: f64) -> DVec3 {
        self.world_from_clip
            .as_dmat4()
            .project_point3(DVec3::new(x, y, z))
    }

    /// Returns the world position at this depth in the centre of the image.
    fn middle(&self, z: f64) -> DVec3 {
        self.unproject(0.0, 0.0, z)
    }

    /// Returns 1 if right x up points to the viewer, as in right-handed worlds; otherwise -1.
    fn handedness(&self) -> Result<f32, Invalid> {
        let middle = self.middle(0.5);
        let right = self.unproject(0.5, 0.0, 0.5) - middle;
        let up = self.unproject(0.0, 0.5, 0.5) - middle;
        let to_viewer = self.middle(f64::from(1.0 - self.empty)) - middle;
        let volume = right.cross(up).dot(to_viewer);
        if volume.is_finite() && volume != 0.0 {
            return Ok(volume.signum() as f32);
        }
        let help = "use the inverse of the camera's clip from world";
        Err(Invalid::new(
            "world from clip",
            "does not unproject the centre of the image",
            help,
        ))
    }
}
