//! The camera's G-buffer on the GPU: rasterised from geometry, or uploaded.

use crate::{
    filter::color_attachment,
    frame::GBuffer,
    resources::{
        bindings::{Binding, Bound, Layouts, Slot},
        counters::ResourceFactory,
        cut_outs::GpuCutOuts,
        geometry::GpuGeometry,
        images::extent,
        pipelines::{Targets, fullscreen_pipeline, pipeline_layout, shader},
    },
    targets::{DepthState, attachment},
    wgsl::stages::{HoleRule, ids_wgsl, shader_of},
};
use encase::{ShaderType, UniformBuffer};
use glam::{Mat4, UVec2};
use std::ops::Range;
use umbrage_core::{Camera, CameraRays, Format, Receivers};
use wgpu::{
    BindGroupLayout, Buffer, BufferUsages, Color, CommandEncoder, Device, FragmentState,
    MultisampleState, PipelineCompilationOptions, QuerySet, Queue, RenderPass,
    RenderPassDescriptor, RenderPassTimestampWrites, RenderPipeline, RenderPipelineDescriptor,
    ShaderStages, TexelCopyBufferLayout, Texture, TextureFormat, TextureUsages, TextureView,
    VertexState,
};

/// Twin of `Seen` in gbuffer_visibility.wgsl.
#[derive(ShaderType)]
struct Seen {
    clip_from_world: Mat4,
    rays: CameraRays,
    first_receiver: u32,
    end_receiver: u32,
}

/// Receiver textures, all of one size.
#[derive(Debug)]
pub(crate) struct ReceiverTextures {
    size: UVec2,
    pub(crate) position: (Texture, TextureView),
    pub(crate) normal: (Texture, TextureView),
    pub(crate) triangle: (Texture, TextureView),
    pub(crate) depth: (Texture, TextureView),
    /// The contents of the textures, if they were uploaded.
    uploaded: Option<UploadedReceivers>,
}

/// The part of receivers that is uploaded.
#[derive(Debug, PartialEq)]
struct UploadedReceivers {
    floats: [Vec<f32>; 6],
    triangle: Vec<u32>,
    receives: Vec<bool>,
}

impl UploadedReceivers {
    fn new(r: &Receivers) -> Self {
        Self {
            floats: floats(r).map(Vec::clone),
            triangle: r.triangle.clone(),
            receives: r.receives.clone(),
        }
    }

    /// Returns whether these are the receivers. Compares bit patterns: a NaN equals itself, and 0
    /// is not -0.
    fn are(&self, r: &Receivers) -> bool {
        let same_words = |a: &Vec<f32>, b: &Vec<f32>| -> bool {
            let a: &[u32] = bytemuck::cast_slice(a);
            let b: &[u32] = bytemuck::cast_slice(b);
            a == b
        };
        self.receives == r.receives
            && self.triangle == r.triangle
            && self
                .floats
                .iter()
                .zip(floats(r))
                .all(|(a, b)| same_words(a, b))
    }
}

/// Returns positions and normals, one list per coordinate.
fn floats(r: &Receivers) -> [&Vec<f32>; 6] {
    [&r.x, &r.y, &r.z, &r.nx, &r.ny, &r.nz]
}

impl ReceiverTextures {
    fn new(factory: &mut ResourceFactory<'_>, size: UVec2) -> Self {
        let drawn_and_read = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING;
        let copied = TextureUsages::COPY_SRC | TextureUsages::COPY_DST;
        let mut make = |label, format| {
            let usage = drawn_and_read | copied;
            let texture = factory.texture(label, extent(size, 1), format, usage);
            let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
            (texture, view)
        };
        Self {
            size,
            position: make("umbrage receivers' positions", TextureFormat::Rgba32Float),
            normal: make("umbrage receivers' normals", TextureFormat::Rgba32Float),
            triangle: make("umbrage receivers' triangles", TextureFormat::R32Uint),
            depth: make("umbrage camera depth", TextureFormat::Depth32Float),
            uploaded: None,
        }
    }

    /// Returns textures of this size: `held` if it fits, otherwise new ones, which replace it.
    pub(crate) fn fit<'a>(
        held: &'a mut Option<Self>,
        factory: &mut ResourceFactory<'_>,
        size: UVec2,
    ) -> &'a mut Self {
        let fitting = held.take().filter(|t| t.size == size);
        held.insert(fitting.unwrap_or_else(|| Self::new(factory, size)))
    }

    pub(crate) fn gbuffer(&self) -> GBuffer<'_> {
        GBuffer {
            position: &self.position.1,
            normal: &self.normal.1,
            triangle: Some(&self.triangle.1),
        }
    }

    /// Marks the textures as drawn into, so that they no longer count as uploaded.
    pub(crate) fn forget_upload(&mut self) {
        self.uploaded = None;
    }

    /// Bytes per pixel: position, normal, triangle and depth.
    pub(crate) const BYTES: u64 = 16 + 16 + 4 + 4;

    /// Writes positions, normals and triangle ids, but no depth, which nothing reads. Skips the
    /// upload if the textures already contain them: comparisons execute many recipes with the same
    /// receivers.
    pub(crate) fn upload(&mut self, factory: &ResourceFactory<'_>, r: &Receivers) {
        if self.uploaded.as_ref().is_some_and(|held| held.are(r)) {
            return;
        }
        self.uploaded = Some(UploadedReceivers::new(r));
        let mut positions: Vec<[f32; 4]> = Vec::with_capacity(r.len());
        let mut normals: Vec<[f32; 4]> = Vec::with_capacity(r.len());
        for i in 0..r.len() {
            let receives = if r.receives[i] { 1.0 } else { 0.0 };
            positions.push([r.x[i], r.y[i], r.z[i], receives]);
            normals.push([r.nx[i], r.ny[i], r.nz[i], 0.0]);
        }
        let queue = factory.queue;
        write(queue, &self.position.0, bytemuck::cast_slice(&positions));
        write(queue, &self.normal.0, bytemuck::cast_slice(&normals));
        write(queue, &self.triangle.0, bytemuck::cast_slice(&r.triangle));
    }
}

/// Writes all texels of all layers of a texture.
pub(crate) fn write(queue: &Queue, texture: &Texture, bytes: &[u8]) {
    let texel = texture.format().block_copy_size(None).unwrap_or(4);
    let layout = TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(texel * texture.width()),
        rows_per_image: Some(texture.height()),
    };
    queue.write_texture(texture.as_image_copy(), bytes, layout, texture.size());
}

/// Computes receivers in two passes: ids, then points.
#[derive(Debug)]
pub(crate) struct GBufferPass {
    uniforms: Option<Buffer>,
    ids: IdsPass,
    /// Draws alpha-tested triangles. Created on first use, and again when a geometry first has
    /// another rule.
    ids_with_holes: Option<IdsPass>,
    points: RenderPipeline,
    points_layout: BindGroupLayout,
    points_binding: Binding,
    /// Ranges of alpha-tested triangles to draw; both empty if there are none.
    cut_out: [Range<u32>; 2],
}

/// Draws the ids of opaque or alpha-tested triangles.
#[derive(Debug)]
struct IdsPass {
    holes: Option<HoleRule>,
    pipeline: RenderPipeline,
    layout: BindGroupLayout,
    binding: Binding,
}

impl IdsPass {
    fn new(factory: &ResourceFactory<'_>, holes: Option<HoleRule>) -> Self {
        // Bind camera, positions and indices; for alpha tests also records, and possibly coverages.
        let tables = match holes {
            None => 2,
            Some(HoleRule::Nearest) => 3,
            Some(HoleRule::Hashed) => 4,
        };
        let mut slots = vec![Slot::Uniform];
        slots.extend(vec![Slot::Table; tables]);
        let entry = match holes {
            None => "write_id",
            Some(_) => "write_id_outside_holes",
        };
        let stages = ShaderStages::VERTEX_FRAGMENT;
        let layout = Layouts::default().get(factory, stages, &slots);
        Self {
            holes,
            pipeline: ids_pipeline(factory.device, &ids_wgsl(holes), entry, &layout),
            layout,
            binding: Binding::default(),
        }
    }

    fn draw(&self, pass: &mut RenderPass<'_>, triangles: Range<u32>) {
        if triangles.is_empty() {
            return;
        }
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, self.binding.group(), &[]);
        pass.draw(3 * triangles.start..3 * triangles.end, 0..1);
    }
}

impl GBufferPass {
    pub(crate) fn new(factory: &ResourceFactory<'_>) -> Self {
        // The ids drawn by the first pass come last.
        let ids = Slot::Whole { layered: false };
        let slots = [Slot::Uniform, Slot::Table, Slot::Table, ids];
        let stage = ShaderStages::FRAGMENT;
        let points_layout = Layouts::default().get(factory, stage, &slots);
        Self {
            uniforms: None,
            ids: IdsPass::new(factory, None),
            ids_with_holes: None,
            points: points_pipeline(factory.device, &points_layout),
            points_layout,
            points_binding: Binding::default(),
            cut_out: [0..0, 0..0],
        }
    }

    pub(crate) fn prepare(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        camera: &Camera,
        geometry: &GpuGeometry,
        textures: &ReceiverTextures,
    ) {
        let seen = Seen {
            clip_from_world: camera.space().clip_from_world(),
            rays: camera.rays(),
            first_receiver: geometry.receivers.start,
            end_receiver: geometry.receivers.end,
        };
        let mut bytes = UniformBuffer::new(Vec::new());
        // Writing to a growing vector cannot fail.
        bytes.write(&seen).unwrap_or_default();
        let uniforms = factory.write(
            &mut self.uniforms,
            "umbrage camera",
            BufferUsages::UNIFORM,
            &bytes.into_inner(),
        );
        let mut bound = vec![
            Bound::Buffer(uniforms),
            Bound::Buffer(geometry.positions.clone()),
            Bound::Buffer(geometry.indices.clone()),
        ];
        let ids = &mut self.ids;
        ids.binding
            .set(factory, "umbrage visibility", &ids.layout, bound.clone());
        self.prepare_holes(factory, geometry.cut_outs.as_ref(), &bound);
        bound.push(Bound::View(textures.triangle.1.clone()));
        self.points_binding
            .set(factory, "umbrage resolve", &self.points_layout, bound);
    }

    /// Prepares the alpha-tested draws. `bound` are the bindings of the opaque draws.
    fn prepare_holes(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        cut_outs: Option<&GpuCutOuts>,
        bound: &[Bound],
    ) {
        let Some(cut_outs) = cut_outs else {
            self.cut_out = [0..0, 0..0];
            return;
        };
        self.cut_out = cut_outs.cut_outs.runs().clone();
        let holes = Some(cut_outs.rule());
        self.ids_with_holes.take_if(|pass| pass.holes != holes);
        let pass = self.ids_with_holes.get_or_insert_with(|| {
            factory.counters.pipelines += 1;
            IdsPass::new(factory, holes)
        });
        let mut bound = bound.to_vec();
        bound.push(Bound::Buffer(cut_outs.rows.clone()));
        bound.extend(cut_outs.coverage.clone().map(Bound::Buffer));
        pass.binding.set(
            factory,
            "umbrage visibility with holes",
            &pass.layout,
            bound,
        );
    }

    /// Draws all triangles in the order of ids, so that the first of equally near ones is visible.
    fn draw_ids(&self, pass: &mut RenderPass<'_>, triangles: u32) {
        let mut next = 0;
        for run in &self.cut_out {
            self.ids.draw(pass, next..run.start.max(next));
            if let Some(holes) = &self.ids_with_holes {
                holes.draw(pass, run.clone());
            }
            next = run.end.max(next);
        }
        self.ids.draw(pass, next..triangles);
    }

    /// Records both passes; `queries` receive timestamps 0 and 1.
    pub(crate) fn encode(
        &self,
        encoder: &mut CommandEncoder,
        textures: &ReceiverTextures,
        triangles: u32,
        queries: Option<&QuerySet>,
    ) {
        // Clear the ids to `NO_TRIANGLE`.
        let none = Color {
            r: f64::from(u32::MAX),
            ..Color::TRANSPARENT
        };
        let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
            label: Some("umbrage visibility"),
            color_attachments: &[Some(color_attachment(&textures.triangle.1, none))],
            depth_stencil_attachment: Some(attachment(&textures.depth.1, Format::Depth32, true)),
            timestamp_writes: queries.map(|q| stamp(q, Some(0), None)),
            ..RenderPassDescriptor::default()
        });
        self.draw_ids(&mut pass, triangles);
        drop(pass);
        let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
            label: Some("umbrage resolve"),
            color_attachments: &[&textures.position.1, &textures.normal.1]
                .map(|view| Some(color_attachment(view, Color::TRANSPARENT))),
            timestamp_writes: queries.map(|q| stamp(q, None, Some(1))),
            ..RenderPassDescriptor::default()
        });
        pass.set_pipeline(&self.points);
        pass.set_bind_group(0, self.points_binding.group(), &[]);
        pass.draw(0..3, 0..1);
    }
}

/// Returns the timestamp writes of a pass; only the given indices are written.
fn stamp(
    query_set: &QuerySet,
    begin: Option<u32>,
    end: Option<u32>,
) -> RenderPassTimestampWrites<'_> {
    RenderPassTimestampWrites {
        query_set,
        beginning_of_pass_write_index: begin,
        end_of_pass_write_index: end,
    }
}

fn ids_pipeline(
    device: &Device,
    text: &str,
    entry: &str,
    layout: &BindGroupLayout,
) -> RenderPipeline {
    let module = &shader(device, "umbrage visibility", text);
    let options = PipelineCompilationOptions::default;
    device.create_render_pipeline(&RenderPipelineDescriptor {
        label: Some("umbrage visibility"),
        layout: Some(&pipeline_layout(device, &[Some(layout)])),
        vertex: VertexState {
            module,
            entry_point: Some("show"),
            compilation_options: options(),
            buffers: &[],
        },
        primitive: DepthState::DEPTH_LESS.primitive(),
        depth_stencil: Some(DepthState::DEPTH_LESS.depth_stencil()),
        multisample: MultisampleState::default(),
        fragment: Some(FragmentState {
            module,
            entry_point: Some(entry),
            compilation_options: options(),
            targets: &[Some(TextureFormat::R32Uint.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

fn points_pipeline(device: &Device, layout: &BindGroupLayout) -> RenderPipeline {
    let entries = ["umbrage_fullscreen", "resolve_pixel"];
    let targets = Targets::Colors(&[TextureFormat::Rgba32Float; 2]);
    fullscreen_pipeline(
        device,
        "umbrage resolve",
        &shader_of(&["gbuffer_resolve"]),
        entries,
        &targets,
        &[Some(layout)],
    )
}
