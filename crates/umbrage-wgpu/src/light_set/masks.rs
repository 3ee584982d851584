//! Masks of a set's lights, for renderers that shade from a G-buffer: one layer per light.

use crate::{
    frame::{GBuffer, check_readable},
    gbuffer_from_depth::{DepthBuffer, DepthCamera},
    light_set::{
        ids::{LightId, LightKey},
        shader::{self, SetShader},
        timestamps::{PassTimer, SetPass},
    },
    receive::{gbuffer_entries, pixel_groups},
    resources::{
        bindings::{Binding, Bound, Slot},
        counters::ResourceFactory,
        images::{extent, layers_view},
        pipelines::{Pipelines, compute_pipeline, shader as shader_module},
        windows::Windows,
    },
    wgsl::stages::{ReceiverSource, mask_shader},
};
use bytemuck::{Pod, Zeroable};
use glam::UVec2;
use std::num::NonZeroU64;
use umbrage_core::{BackendError, Invalid};
use wgpu::{
    BindGroupLayout, Buffer, BufferUsages, COPY_BYTES_PER_ROW_ALIGNMENT, CommandEncoder,
    ComputePassDescriptor, ComputePipeline, Extent3d, ShaderStages, TexelCopyBufferInfo,
    TexelCopyBufferLayout, Texture, TextureAspect, TextureFormat, TextureSampleType, TextureUsages,
    TextureView, TextureViewDimension,
};

/// Inputs of the masks.
#[derive(Clone, Copy, Debug)]
pub struct MaskInputs<'a> {
    /// Size of the masks and of the receivers' textures, pixels.
    pub size: UVec2,
    /// The visible surface points.
    pub receivers: MaskReceivers<'a>,
    /// The lights, one layer each, in this order.
    pub lights: &'a [LightId],
    /// Texture format of visibility.
    pub format: MaskFormat,
}

/// The visible surface points, in the caller's textures with usage `TEXTURE_BINDING`.
#[derive(Clone, Copy, Debug)]
pub enum MaskReceivers<'a> {
    /// World positions and normals.
    Positions(GBuffer<'a>),
    /// A depth buffer, from which positions are computed on the fly.
    Depth {
        /// The depth buffer, and its camera.
        depth: DepthBuffer<'a>,
        /// Normals. `None` to derive them from neighbouring pixels, which is inaccurate where a
        /// surface is only a pixel wide.
        normals: Option<SetNormals<'a>>,
    },
}

/// The former name of [`MaskReceivers`].
#[deprecated(since = "0.1.0", note = "renamed to `MaskReceivers`")]
pub type SetReceivers<'a> = MaskReceivers<'a>;

/// Normals in world space, in a texture of any float or normalised format.
#[derive(Clone, Copy, Debug)]
pub struct SetNormals<'a> {
    /// The texture.
    pub texture: &'a TextureView,
    /// Encoding of the normals.
    pub coding: NormalCoding,
}

/// Encoding of unit normals in a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NormalCoding {
    /// x, y and z, each in -1..=1.
    Components,
    /// x, y and z, each as half its value plus 0.5, in 0..=1.
    Halved,
    /// Octahedral coordinates, two components in -1..=1: Meyer, Suessmuth, Sussner, Stamminger and
    /// Greiner 2010, "On floating-point normal vectors".
    Octahedral,
    /// Octahedral coordinates, each as half its value plus 0.5, in 0..=1.
    OctahedralHalved,
}

/// Texture format of visibility, 0..=1, in masks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MaskFormat {
    /// `R8Unorm`: in steps of 1/255, one byte per pixel and light.
    #[default]
    Unorm8,
    /// `R32Float`: unrounded.
    Float32,
}

impl MaskFormat {
    const fn texture_format(self) -> TextureFormat {
        match self {
            Self::Unorm8 => TextureFormat::R8Unorm,
            Self::Float32 => TextureFormat::R32Float,
        }
    }
}

/// Parameters of the mask shader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct MaskKey {
    revision: u64,
    receivers: ReceiverSource,
    format: MaskFormat,
}

/// Inputs of one mask in shaders: `UmbrageMask` is its twin.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct MaskChoice {
    /// Index of the light; any number beyond all indices for lights without shadows.
    light: u32,
    /// Layer of the masks.
    layer: u32,
    /// Size of the mask, pixels.
    size: [u32; 2],
}

/// A [`MaskChoice`].
const CHOICE_SLOT: Slot = Slot::Window(NonZeroU64::new(size_of::<MaskChoice>() as u64).unwrap());

/// The mask stage, prepared for encoding.
#[derive(Debug, Default)]
pub(crate) struct MaskStage {
    made_for: Option<MaskKey>,
    pipeline: Option<ComputePipeline>,
    /// The receivers, the choice of a light, and the output.
    binding: Binding,
    /// The textures of the receivers.
    seen: Option<SeenTextures>,
    camera: Option<Buffer>,
    /// Contents of `camera`.
    camera_bytes: Vec<u8>,
    /// The choice of each mask.
    choices: Windows,
    /// Buffer of `choices`.
    choices_buffer: Option<Buffer>,
    texture: Option<Texture>,
    /// View of all layers.
    whole: Option<TextureView>,
    /// A mask in bytes, which is copied to its layer.
    bytes: Option<Buffer>,
    /// For each layer, the light and its index in shaders; `None` for lights without shadows.
    lights: Vec<(LightKey, Option<u32>)>,
}

/// The caller's bound textures: depth and normals, or positions, normals and triangles.
#[derive(Debug)]
struct SeenTextures([Option<TextureView>; 3]);

impl SeenTextures {
    fn of_receivers(receivers: &MaskReceivers<'_>) -> Self {
        Self(views(receivers).map(Option::<&TextureView>::cloned))
    }

    fn are(&self, receivers: &MaskReceivers<'_>) -> bool {
        self.0.each_ref().map(Option::as_ref) == views(receivers)
    }
}

fn views<'a>(receivers: &MaskReceivers<'a>) -> [Option<&'a TextureView>; 3] {
    match receivers {
        MaskReceivers::Positions(gbuffer) => [
            Some(gbuffer.position),
            Some(gbuffer.normal),
            gbuffer.triangle,
        ],
        MaskReceivers::Depth { depth, normals } => [
            Some(depth.depth),
            normals.map(|normals| normals.texture),
            None,
        ],
    }
}

impl SetNormals<'_> {
    /// Errors if the texture's format can't hold normals in this coding.
    fn check_format(&self) -> Result<(), Invalid> {
        let format = self.texture.texture().format();
        let is_float = matches!(
            format.sample_type(None, None),
            Some(TextureSampleType::Float { .. })
        );
        if !is_float {
            let why = format!("have the format `{format:?}`, which is not read as floats");
            let help = "use a float or normalised format, such as `Rgba16Float`";
            return Err(Invalid::new("receivers' normals", why, help));
        }
        let needed = match self.coding {
            NormalCoding::Components | NormalCoding::Halved => 3,
            NormalCoding::Octahedral | NormalCoding::OctahedralHalved => 2,
        };
        if format.components() < needed || format.is_srgb() {
            let coding = self.coding;
            let why = format!("are `{coding:?}` in the format `{format:?}`");
            let help = format!("use a linear format with at least {needed} channels");
            return Err(Invalid::new("receivers' normals", why, help));
        }
        let halved = match self.coding {
            NormalCoding::Halved | NormalCoding::OctahedralHalved => return Ok(()),
            NormalCoding::Components => NormalCoding::Halved,
            NormalCoding::Octahedral => NormalCoding::OctahedralHalved,
        };
        if is_unsigned(format) {
            let coding = self.coding;
            let why = format!("are `{coding:?}` in the format `{format:?}`, which holds 0 to 1");
            let help = format!("use `NormalCoding::{halved:?}`, or a signed format");
            return Err(Invalid::new("receivers' normals", why, help));
        }
        Ok(())
    }
}

/// Returns whether a format of floats has no negative numbers.
fn is_unsigned(format: TextureFormat) -> bool {
    use TextureFormat as F;
    matches!(
        format,
        F::R8Unorm
            | F::Rg8Unorm
            | F::Rgba8Unorm
            | F::Bgra8Unorm
            | F::Rgb10a2Unorm
            | F::R16Unorm
            | F::Rg16Unorm
            | F::Rgba16Unorm
            | F::Rg11b10Ufloat
            | F::Rgb9e5Ufloat
    )
}

impl MaskInputs<'_> {
    pub(crate) fn validate(&self) -> Result<(), BackendError> {
        if self.size.min_element() == 0 {
            let why = format!("are {} x {} pixels", self.size.x, self.size.y);
            return Err(
                Invalid::new("masks", why, "use at least one pixel in each direction").into(),
            );
        }
        match &self.receivers {
            MaskReceivers::Positions(gbuffer) => gbuffer.validate(self.size)?,
            MaskReceivers::Depth { depth, normals } => {
                depth.validate()?;
                self.check_texture(depth.depth.texture(), "depth buffer")?;
                if let Some(normals) = normals {
                    let texture = normals.texture.texture();
                    check_readable(texture, "receivers' normals")?;
                    self.check_texture(texture, "receivers' normals")?;
                    normals.check_format()?;
                }
            }
        }
        Ok(())
    }

    /// Errors if the size of a texture is not that of the masks.
    fn check_texture(&self, texture: &Texture, what: &str) -> Result<(), Invalid> {
        let size = UVec2::new(texture.width(), texture.height());
        if size == self.size {
            return Ok(());
        }
        let why = format!("has {} x {} pixels", size.x, size.y);
        let help = format!("make it {} x {}, like the masks", self.size.x, self.size.y);
        Err(Invalid::new(what, why, help))
    }
}

impl MaskStage {
    /// Returns whether everything but the camera uniforms is up to date.
    pub(crate) fn is_made_for(&self, shader: &SetShader, inputs: &MaskInputs<'_>) -> bool {
        self.fits(inputs)
            && self.pipeline.is_some()
            && self.made_for == Some(MaskKey::of_inputs(shader, inputs))
            && self
                .seen
                .as_ref()
                .is_some_and(|seen| seen.are(&inputs.receivers))
    }

    /// Creates missing objects, and writes the camera. `lights` are the lights with their indices
    /// in shaders, `None` for lights without shadows.
    pub(crate) fn prepare(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        shader: &SetShader,
        inputs: &MaskInputs<'_>,
        lights: impl Iterator<Item = (LightKey, Option<u32>)>,
    ) -> Result<(), BackendError> {
        // Write the per-frame data.
        self.lights.clear();
        self.lights.extend(lights);
        if let MaskReceivers::Depth { depth, .. } = &inputs.receivers {
            self.write_camera(factory, &DepthCamera::of_source(depth)?);
        }
        let has_choices = self.write_choices(factory, inputs.size);
        if has_choices && self.is_made_for(shader, inputs) {
            return Ok(());
        }
        // Replace texture and bindings.
        self.fit_texture(factory, inputs)?;
        let key = MaskKey::of_inputs(shader, inputs);
        let layout = self.bind(factory, pipelines, &inputs.receivers);
        self.seen = Some(SeenTextures::of_receivers(&inputs.receivers));
        if self.made_for == Some(key) && self.pipeline.is_some() {
            return Ok(());
        }
        // Build the pipeline.
        let (_, set_layout) = shader.bind_group().ok_or_else(shader::unprepared_error)?;
        let own_group = own_group(shader.group());
        let mut groups = [None, None, None, None];
        let mut count = 0;
        for (group, layout) in [(shader.group(), set_layout), (own_group, &layout)] {
            groups[group as usize] = Some(layout);
            count = count.max(group as usize + 1);
        }
        let bytes = inputs.format == MaskFormat::Unorm8;
        let text = mask_shader(shader.text(), own_group, key.receivers, bytes);
        factory.counters.pipelines += 1;
        self.pipeline = Some(compute_pipeline(
            factory.device,
            &shader_module(factory.device, "umbrage masks", &text),
            "umbrage_compute_mask",
            &[],
            &groups[..count],
        ));
        self.made_for = Some(key);
        Ok(())
    }

    /// Records one pass per light. Returns the masks.
    pub(crate) fn encode(
        &self,
        encoder: &mut CommandEncoder,
        shader: &SetShader,
        mut timer: Option<PassTimer<'_, '_>>,
    ) -> Option<&TextureView> {
        let pipeline = self.pipeline.as_ref()?;
        let texture = self.texture.as_ref()?;
        let (set_group, _) = shader.bind_group()?;
        let size = UVec2::new(texture.width(), texture.height());
        let [columns, rows] = pixel_groups(size);
        for (layer, (id, _)) in self.lights.iter().enumerate() {
            let timestamp_writes = match &mut timer {
                Some(timer) => timer.compute_writes(*id, SetPass::Mask),
                None => None,
            };
            let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor {
                label: Some("umbrage mask"),
                timestamp_writes,
            });
            pass.set_pipeline(pipeline);
            pass.set_bind_group(shader.group(), set_group, &[]);
            let own_group = own_group(shader.group());
            let choice = self.choices.offset(layer);
            pass.set_bind_group(own_group, self.binding.group(), &[choice]);
            pass.dispatch_workgroups(columns, rows, 1);
            drop(pass);
            if let Some(bytes) = &self.bytes {
                copy_mask(encoder, bytes, texture, layer as u32);
            }
        }
        self.whole.as_ref()
    }

    /// Returns whether the texture fits.
    fn fits(&self, inputs: &MaskInputs<'_>) -> bool {
        let format = inputs.format.texture_format();
        self.texture
            .as_ref()
            .is_some_and(|held| held.size() == mask_extent(inputs) && held.format() == format)
    }

    /// Replaces the texture and the buffer of bytes if they don't fit.
    ///
    /// Errors if shaders can't bind the bytes of a mask.
    fn fit_texture(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        inputs: &MaskInputs<'_>,
    ) -> Result<(), Invalid> {
        if self.fits(inputs) {
            return Ok(());
        }
        let label = "umbrage masks";
        let size = mask_extent(inputs);
        let written = match inputs.format {
            MaskFormat::Float32 => {
                self.bytes = None;
                TextureUsages::STORAGE_BINDING
            }
            MaskFormat::Unorm8 => {
                let bytes = u64::from(row_bytes(size.width)) * u64::from(size.height);
                let limits = factory.device.limits();
                let most = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
                if bytes > most {
                    let why = format!("of {bytes} bytes exceed this device's {most}");
                    let help = "use smaller masks, or `MaskFormat::Float32`";
                    return Err(Invalid::new("masks", why, help));
                }
                let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
                self.bytes = Some(factory.buffer(label, usage, bytes));
                TextureUsages::COPY_DST
            }
        };
        let usage = written | TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_SRC;
        let format = inputs.format.texture_format();
        let texture = factory.texture(label, size, format, usage);
        let layers = 0..size.depth_or_array_layers;
        let dimension = TextureViewDimension::D2Array;
        self.whole = Some(layers_view(&texture, label, dimension, TextureAspect::All, layers));
        self.texture = Some(texture);
        Ok(())
    }

    /// Writes the choice of each mask. Returns whether the buffer is that of the last frame.
    fn write_choices(&mut self, factory: &mut ResourceFactory<'_>, size: UVec2) -> bool {
        let choice = |(layer, (_, light)): (u32, &(LightKey, Option<u32>))| MaskChoice {
            light: light.unwrap_or(u32::MAX),
            layer,
            size: size.to_array(),
        };
        let choices = (0..).zip(&self.lights).map(choice);
        let Some((buffer, _)) = self.choices.write(factory, "umbrage masks", choices) else {
            // Without lights, no pass reads the buffer, but it must be bound.
            let empty = || factory.buffer("umbrage masks", BufferUsages::UNIFORM, 16);
            self.choices_buffer.get_or_insert_with(empty);
            return true;
        };
        let is_kept = self.choices_buffer.as_ref() == Some(&buffer);
        self.choices_buffer = Some(buffer);
        is_kept
    }

    /// Binds the receivers, the choices and the output. Returns the layout.
    fn bind(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        receivers: &MaskReceivers<'_>,
    ) -> BindGroupLayout {
        let mut entries = match receivers {
            MaskReceivers::Positions(textures) => gbuffer_entries(textures),
            MaskReceivers::Depth { depth, normals } => self.depth_entries(depth, normals.as_ref()),
        };
        let choices = self.choices_buffer.iter().cloned();
        entries.extend(choices.map(|buffer| (CHOICE_SLOT, Bound::of_slot(CHOICE_SLOT, buffer))));
        match &self.bytes {
            Some(bytes) => entries.push((Slot::Written, Bound::Buffer(bytes.clone()))),
            None => {
                let slot = Slot::Stored {
                    format: TextureFormat::R32Float,
                    layered: true,
                };
                let whole = self.whole.iter().cloned();
                entries.extend(whole.map(|view| (slot, Bound::View(view))));
            }
        }
        let layouts = &mut pipelines.layouts;
        let stage = ShaderStages::COMPUTE;
        self.binding
            .bind(factory, layouts, stage, "umbrage masks", entries)
    }

    /// Writes the depth buffer's camera if it changed.
    fn write_camera(&mut self, factory: &mut ResourceFactory<'_>, camera: &DepthCamera) {
        let bytes = camera.bytes();
        if self.camera.is_some() && self.camera_bytes == bytes {
            return;
        }
        self.camera_bytes.clear();
        self.camera_bytes.extend(bytes);
        let usage = BufferUsages::UNIFORM;
        factory.write(&mut self.camera, "umbrage camera", usage, &bytes);
    }

    fn depth_entries(
        &self,
        depth: &DepthBuffer<'_>,
        normals: Option<&SetNormals<'_>>,
    ) -> Vec<(Slot, Bound)> {
        let camera = self.camera.iter().cloned().map(Bound::Buffer);
        let mut entries: Vec<_> = camera.map(|camera| (Slot::Uniform, camera)).collect();
        entries.push((depth.slot(), Bound::View(depth.depth.clone())));
        if let Some(normals) = normals {
            let floats = Slot::Floats { layered: false };
            entries.push((floats, Bound::View(normals.texture.clone())));
        }
        entries
    }
}

impl MaskKey {
    fn of_inputs(shader: &SetShader, inputs: &MaskInputs<'_>) -> Self {
        Self {
            revision: shader.revision(),
            receivers: inputs.receivers.source(),
            format: inputs.format,
        }
    }
}

/// Returns the bytes from one row of a mask in bytes to the next.
fn row_bytes(width: u32) -> u32 {
    width.next_multiple_of(COPY_BYTES_PER_ROW_ALIGNMENT)
}

/// Records the copy of a mask's bytes into its layer.
fn copy_mask(encoder: &mut CommandEncoder, bytes: &Buffer, texture: &Texture, layer: u32) {
    let from = TexelCopyBufferInfo {
        buffer: bytes,
        layout: TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(row_bytes(texture.width())),
            rows_per_image: None,
        },
    };
    let mut to = texture.as_image_copy();
    to.origin.z = layer;
    let size = UVec2::new(texture.width(), texture.height());
    encoder.copy_buffer_to_texture(from, to, extent(size, 1));
}

/// Returns the size of the masks' texture.
fn mask_extent(inputs: &MaskInputs<'_>) -> Extent3d {
    extent(inputs.size, inputs.lights.len().max(1) as u32)
}

impl MaskReceivers<'_> {
    fn source(&self) -> ReceiverSource {
        match self {
            Self::Positions(gbuffer) => ReceiverSource::GBuffer {
                triangles: gbuffer.triangle.is_some(),
            },
            Self::Depth { depth, normals } => {
                let samples = depth.has_samples();
                let Some(SetNormals { coding, .. }) = normals else {
                    return ReceiverSource::Depth { samples };
                };
                ReceiverSource::DepthAndNormals {
                    samples,
                    halved: matches!(
                        coding,
                        NormalCoding::Halved | NormalCoding::OctahedralHalved
                    ),
                    octahedral: matches!(
                        coding,
                        NormalCoding::Octahedral | NormalCoding::OctahedralHalved
                    ),
                }
            }
        }
    }
}

/// Returns the index of the receivers' bind group: 0, or 1 if the set's is 0.
fn own_group(set_group: u32) -> u32 {
    u32::from(set_group == 0)
}

/// Returns the error of masks that are not prepared.
pub(crate) fn unprepared_error() -> BackendError {
    let help = "call `prepare_masks` first, and check its error";
    Invalid::new("masks", "have nothing prepared", help).into()
}
