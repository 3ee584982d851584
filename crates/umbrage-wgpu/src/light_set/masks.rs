//! Masks of a set's lights, for renderers that shade from a G-buffer: one layer per light.

use crate::{
    filter::color_attachment,
    frame::{GBuffer, check_readable},
    gbuffer_from_depth::{DepthBuffer, DepthCamera},
    light_set::{
        computed_masks::{ComputedMasks, MaskGroups},
        ids::{LightId, LightKey},
        shader::{self, SetShader},
        timestamps::{PassTimer, SetPass},
    },
    receive::gbuffer_entries,
    resources::{
        bindings::{Binding, Bound, Slot},
        counters::ResourceFactory,
        images::{extent, layers_view},
        pipelines::{Pipelines, Targets, compute_pipeline, fullscreen_pipeline, shader as module},
    },
    wgsl::stages::{ReceiverSource, mask_compute_shader, mask_shader},
};
use glam::UVec2;
use umbrage_core::{BackendError, Invalid};
use wgpu::{
    BindGroupLayout, Buffer, BufferUsages, Color, CommandEncoder, Extent3d, RenderPassDescriptor,
    RenderPipeline, ShaderStages, Texture, TextureAspect, TextureFormat, TextureSampleType,
    TextureUsages, TextureView, TextureViewDimension,
};

/// The pass that writes a light's mask.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MaskPass {
    /// Clears the mask, for lights without shadows.
    Clear,
    /// Draws the mask of the light with this index in shaders.
    Draw(u32),
    /// Computes the mask of the light with this index in shaders.
    Compute(u32),
}

impl MaskPass {
    /// Returns the pass of a light with this index.
    pub(crate) fn new(in_compute: bool, light: u32) -> Self {
        if in_compute {
            Self::Compute(light)
        } else {
            Self::Draw(light)
        }
    }
}

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

/// The mask stage, prepared for encoding.
#[derive(Debug, Default)]
pub(crate) struct MaskStage {
    made_for: Option<MaskKey>,
    /// Pipeline of drawn masks.
    pipeline: Option<RenderPipeline>,
    /// Receivers of drawn masks.
    receivers: Binding,
    computed: ComputedMasks,
    /// The textures of the receivers.
    seen: Option<SeenTextures>,
    camera: Option<Buffer>,
    /// Contents of `camera`.
    camera_bytes: Vec<u8>,
    texture: Option<Texture>,
    /// View of all layers.
    whole: Option<TextureView>,
    layers: Vec<TextureView>,
    /// For each layer, the light and its pass.
    lights: Vec<(LightKey, MaskPass)>,
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
    /// Sets the lights of the layers.
    pub(crate) fn set_lights(&mut self, lights: impl Iterator<Item = (LightKey, MaskPass)>) {
        self.lights.clear();
        self.lights.extend(lights);
    }

    /// Returns whether masks are drawn.
    fn draws(&self) -> bool {
        let mut lights = self.lights.iter();
        lights.any(|(_, pass)| matches!(pass, MaskPass::Draw(_)))
    }

    /// Returns whether masks are computed.
    fn computes(&self) -> bool {
        let mut lights = self.lights.iter();
        lights.any(|(_, pass)| matches!(pass, MaskPass::Compute(_)))
    }

    /// Returns whether everything but the uniforms is up to date.
    pub(crate) fn is_made_for(&self, shader: &SetShader, inputs: &MaskInputs<'_>) -> bool {
        self.fits(inputs)
            && (self.pipeline.is_some() || !self.draws())
            && (self.computed.pipeline.is_some() || !self.computes())
            && self.made_for == Some(MaskKey::of_inputs(shader, inputs))
            && self
                .seen
                .as_ref()
                .is_some_and(|seen| seen.are(&inputs.receivers))
    }

    /// Creates missing objects, and writes the camera and the choices of lights.
    pub(crate) fn prepare(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        shader: &SetShader,
        inputs: &MaskInputs<'_>,
    ) -> Result<(), BackendError> {
        // Write the per-frame data.
        if let MaskReceivers::Depth { depth, .. } = &inputs.receivers {
            self.write_camera(factory, &DepthCamera::of_source(depth)?);
        }
        let computes = self.computes();
        let has_choices = !computes
            || self
                .computed
                .write_choices(factory, &self.lights, inputs.size);
        if has_choices && self.is_made_for(shader, inputs) {
            return Ok(());
        }
        // Replace the texture, and outdated pipelines.
        self.fit_texture(factory, inputs);
        self.seen = Some(SeenTextures::of_receivers(&inputs.receivers));
        let key = MaskKey::of_inputs(shader, inputs);
        if self.made_for != Some(key) {
            self.pipeline = None;
            self.computed.pipeline = None;
        }
        // Bind the inputs, and build the pipelines. A kind that is not used now, but has a pipeline,
        // is bound, too: it may be used again with the same inputs.
        if self.draws() || self.pipeline.is_some() {
            self.prepare_draws(factory, pipelines, shader, inputs)?;
        }
        if computes || self.computed.pipeline.is_some() {
            self.prepare_compute(factory, pipelines, shader, inputs)?;
        }
        self.made_for = Some(key);
        Ok(())
    }

    fn prepare_draws(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        shader: &SetShader,
        inputs: &MaskInputs<'_>,
    ) -> Result<(), BackendError> {
        let entries = self.receiver_entries(&inputs.receivers);
        let layouts = &mut pipelines.layouts;
        let stage = ShaderStages::FRAGMENT;
        let layout = self
            .receivers
            .bind(factory, layouts, stage, "umbrage receivers", entries);
        if self.pipeline.is_some() {
            return Ok(());
        }
        let groups = GroupLayouts::new(shader, &layout)?;
        let own_group = own_group(shader.group());
        let text = mask_shader(shader.text(), own_group, inputs.receivers.source());
        factory.counters.pipelines += 1;
        self.pipeline = Some(fullscreen_pipeline(
            factory.device,
            "umbrage masks",
            &text,
            ["umbrage_fullscreen", "umbrage_mask"],
            &Targets::Colors(&[inputs.format.texture_format()]),
            groups.list(),
        ));
        Ok(())
    }

    fn prepare_compute(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        shader: &SetShader,
        inputs: &MaskInputs<'_>,
    ) -> Result<(), BackendError> {
        let has_bytes = inputs.format == MaskFormat::Unorm8;
        self.computed.fit_bytes(factory, inputs.size, has_bytes)?;
        let mut entries = self.receiver_entries(&inputs.receivers);
        let whole = self.whole.iter();
        entries.extend(whole.flat_map(|masks| self.computed.entries(masks)));
        let layouts = &mut pipelines.layouts;
        let stage = ShaderStages::COMPUTE;
        let binding = &mut self.computed.binding;
        let layout = binding.bind(factory, layouts, stage, "umbrage masks", entries);
        if self.computed.pipeline.is_some() {
            return Ok(());
        }
        let groups = GroupLayouts::new(shader, &layout)?;
        let own_group = own_group(shader.group());
        let source = inputs.receivers.source();
        let text = mask_compute_shader(shader.text(), own_group, source, has_bytes);
        factory.counters.pipelines += 1;
        self.computed.pipeline = Some(compute_pipeline(
            factory.device,
            &module(factory.device, "umbrage masks", &text),
            "umbrage_compute_mask",
            groups.list(),
        ));
        Ok(())
    }

    /// Records one pass per light. Returns the masks.
    pub(crate) fn encode(
        &self,
        encoder: &mut CommandEncoder,
        shader: &SetShader,
        mut timer: Option<PassTimer<'_, '_>>,
    ) -> Option<&TextureView> {
        let texture = self.texture.as_ref()?;
        let (set_group, _) = shader.bind_group()?;
        let groups = MaskGroups {
            set: (shader.group(), set_group),
            own: own_group(shader.group()),
        };
        for (index, (view, (id, pass))) in (0..).zip(self.layers.iter().zip(&self.lights)) {
            if let MaskPass::Compute(_) = pass {
                let stamps = match &mut timer {
                    Some(timer) => timer.compute_writes(*id, SetPass::Mask),
                    None => None,
                };
                self.computed
                    .encode(encoder, groups, texture, index, stamps);
                continue;
            }
            let timestamp_writes = match &mut timer {
                Some(timer) => timer.writes(*id, SetPass::Mask),
                None => None,
            };
            let mut drawn = encoder.begin_render_pass(&RenderPassDescriptor {
                label: Some("umbrage mask"),
                // Pixels that don't receive, and lights without shadows, stay lit.
                color_attachments: &[Some(color_attachment(view, Color::WHITE))],
                timestamp_writes,
                ..RenderPassDescriptor::default()
            });
            let (MaskPass::Draw(light), Some(pipeline)) = (*pass, &self.pipeline) else {
                continue;
            };
            drawn.set_pipeline(pipeline);
            drawn.set_bind_group(shader.group(), set_group, &[]);
            drawn.set_bind_group(groups.own, self.receivers.group(), &[]);
            drawn.draw(0..3, light..light + 1);
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

    /// Replaces the texture if it doesn't fit.
    fn fit_texture(&mut self, factory: &mut ResourceFactory<'_>, inputs: &MaskInputs<'_>) {
        if self.fits(inputs) {
            return;
        }
        let size = mask_extent(inputs);
        let format = inputs.format.texture_format();
        // Compute passes store floats. Bytes, for which core WebGPU lacks that, are copied.
        let computed = match inputs.format {
            MaskFormat::Float32 => TextureUsages::STORAGE_BINDING,
            MaskFormat::Unorm8 => TextureUsages::COPY_DST,
        };
        let usage = computed
            | TextureUsages::RENDER_ATTACHMENT
            | TextureUsages::TEXTURE_BINDING
            | TextureUsages::COPY_SRC;
        let label = "umbrage masks";
        let texture = factory.texture(label, size, format, usage);
        let view =
            |dimension, layers| layers_view(&texture, label, dimension, TextureAspect::All, layers);
        let layers = size.depth_or_array_layers;
        self.whole = Some(view(TextureViewDimension::D2Array, 0..layers));
        self.layers = (0..layers)
            .map(|layer| view(TextureViewDimension::D2, layer..layer + 1))
            .collect();
        self.texture = Some(texture);
    }

    /// Returns the bindings of the receivers.
    fn receiver_entries(&self, receivers: &MaskReceivers<'_>) -> Vec<(Slot, Bound)> {
        match receivers {
            MaskReceivers::Positions(textures) => gbuffer_entries(textures),
            MaskReceivers::Depth { depth, normals } => self.depth_entries(depth, normals.as_ref()),
        }
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

/// Layouts of the bind groups of a pipeline: the set's, and the masks' own.
struct GroupLayouts<'a>([Option<&'a BindGroupLayout>; 4], usize);

impl<'a> GroupLayouts<'a> {
    /// Errors if the set has no bind group.
    fn new(shader: &'a SetShader, own: &'a BindGroupLayout) -> Result<Self, BackendError> {
        let (_, set) = shader.bind_group().ok_or_else(shader::unprepared_error)?;
        let mut groups = Self([None; 4], 0);
        for (group, layout) in [(shader.group(), set), (own_group(shader.group()), own)] {
            groups.0[group as usize] = Some(layout);
            groups.1 = groups.1.max(group as usize + 1);
        }
        Ok(groups)
    }

    fn list(&self) -> &[Option<&'a BindGroupLayout>] {
        &self.0[..self.1]
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
