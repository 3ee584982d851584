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
    wgsl::stages::{HoleRule, ids_wgsl, points_wgsl},
};
use encase::{ShaderType, UniformBuffer};
use glam::{Mat4, UVec2};
use std::ops::Range;
use umbrage_core::{Camera, CameraRays, Format, Receivers};
use wgpu::{
    BindGroupLayout, Buffer, BufferUsages, Color, CommandEncoder, Device, FragmentState,
    MultisampleState, PipelineCompilationOptions, QuerySet, Queue, RenderPass,
    RenderPassDescriptor, RenderPassTimestampWrites, RenderPipeline, RenderPipelineDescriptor,
    ShaderStages, TexelCopyBufferLayout, Texture, TextureDescriptor, TextureDimension,
    TextureFormat, TextureUsages, TextureView, VertexState,
};

/// Twin of `Seen` in visibility.wgsl.
#[derive(ShaderType)]
struct Seen {
    clip_from_world: Mat4,
    rays: CameraRays,
    first_receiver: u32,
    end_receiver: u32,
}

/// Textures of one size.
#[derive(Debug)]
pub(crate) struct ReceiverTextures {
    size: UVec2,
    pub(crate) position: (Texture, TextureView),
    pub(crate) normal: (Texture, TextureView),
    pub(crate) triangle: (Texture, TextureView),
    pub(crate) depth: (Texture, TextureView),
    /// What the textures hold, where they were uploaded.
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

    /// Returns whether these are the receivers. Numbers are compared as words: a NaN equals itself, and 0 is not -0.
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

/// Returns positions and normals, one list a coordinate.
fn floats(r: &Receivers) -> [&Vec<f32>; 6] {
    [&r.x, &r.y, &r.z, &r.nx, &r.ny, &r.nz]
}

impl ReceiverTextures {
    fn new(factory: &mut ResourceFactory<'_>, size: UVec2) -> Self {
        let drawn_and_read = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING;
        let copied = TextureUsages::COPY_SRC | TextureUsages::COPY_DST;
        let mut make = |label, format| {
            let texture = factory.texture(&TextureDescriptor {
                label: Some(label),
                size: extent(size, 1),
                mip_level_count: 1,
                sample_count: 1,
                dimension: TextureDimension::D2,
                format,
                usage: drawn_and_read | copied,
                view_formats: &[],
            });
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

    /// Returns textures of this size: those held, if they fit, else new ones, which are held from now on.
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

    /// Says that the textures are drawn into, so that they no longer hold what was uploaded.
    pub(crate) fn forget_upload(&mut self) {
        self.uploaded = None;
    }

    /// Bytes per pixel: position, normal, triangle and depth.
    pub(crate) const BYTES: u64 = 16 + 16 + 4 + 4;

    /// Writes positions, normals and triangle ids, but no depth, which nothing reads. Nothing is written where they are there already:
    /// whoever compares many settings plays all of them on the same receivers.
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

/// Finds receivers in two passes: ids, then points.
#[derive(Debug)]
pub(crate) struct GBufferPass {
    ids: RenderPipeline,
    points: RenderPipeline,
    ids_layout: BindGroupLayout,
    points_layout: BindGroupLayout,
    uniforms: Option<Buffer>,
    ids_binding: Binding,
    points_binding: Binding,
    /// Made when a geometry first has holes, and when one first has another rule.
    holes: Option<HolesPass>,
    /// The triangles with holes that are drawn; both empty if there are none.
    cut_out: [Range<u32>; 2],
}

/// Draws ids of triangles with holes.
#[derive(Debug)]
struct HolesPass {
    rule: HoleRule,
    ids: RenderPipeline,
    layout: BindGroupLayout,
    binding: Binding,
}

impl HolesPass {
    fn new(factory: &ResourceFactory<'_>, rule: HoleRule) -> Self {
        let mut slots = vec![Slot::Uniform, Slot::Table, Slot::Table, Slot::Table];
        if rule == HoleRule::Hashed {
            slots.push(Slot::Table);
        }
        let text = ids_wgsl(Some(rule));
        let layout = Layouts::default().get(factory, ShaderStages::VERTEX_FRAGMENT, &slots);
        Self {
            rule,
            ids: ids_pipeline(factory.device, &text, "write_id_outside_holes", &layout),
            layout,
            binding: Binding::default(),
        }
    }
}

impl GBufferPass {
    pub(crate) fn new(factory: &ResourceFactory<'_>) -> Self {
        let mut layouts = Layouts::default();
        // Camera, positions and indices; the second pass also reads the ids that the first one drew.
        let mut slots = vec![Slot::Uniform, Slot::Table, Slot::Table];
        let ids_layout = layouts.get(factory, ShaderStages::VERTEX, &slots);
        slots.push(Slot::Whole { layered: false });
        let points_layout = layouts.get(factory, ShaderStages::FRAGMENT, &slots);
        Self {
            ids: ids_pipeline(factory.device, &ids_wgsl(None), "write_id", &ids_layout),
            points: points_pipeline(factory.device, &points_wgsl(), &points_layout),
            ids_layout,
            points_layout,
            uniforms: None,
            ids_binding: Binding::default(),
            points_binding: Binding::default(),
            holes: None,
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
        self.ids_binding.set(
            factory,
            "umbrage visibility",
            &self.ids_layout,
            bound.clone(),
        );
        self.prepare_holes(factory, geometry.cut_outs.as_ref(), &bound);
        bound.push(Bound::View(textures.triangle.1.clone()));
        self.points_binding
            .set(factory, "umbrage resolve", &self.points_layout, bound);
    }

    /// `bound` is what the draws of other triangles read.
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
        let rule = cut_outs.rule();
        self.holes.take_if(|pass| pass.rule != rule);
        let pass = self.holes.get_or_insert_with(|| {
            factory.counters.pipelines += 1;
            HolesPass::new(factory, rule)
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

    /// Draws all triangles in the order of ids, so that of equally near ones the first is seen.
    fn draw_ids(&self, pass: &mut RenderPass<'_>, triangles: u32) {
        let mut next = 0;
        for run in &self.cut_out {
            self.draw_whole(pass, next..run.start.max(next));
            if let Some(holes) = &self.holes
                && !run.is_empty()
            {
                pass.set_pipeline(&holes.ids);
                pass.set_bind_group(0, holes.binding.group(), &[]);
                pass.draw(3 * run.start..3 * run.end, 0..1);
            }
            next = run.end.max(next);
        }
        self.draw_whole(pass, next..triangles);
    }

    /// Draws triangles without holes.
    fn draw_whole(&self, pass: &mut RenderPass<'_>, run: Range<u32>) {
        if run.is_empty() {
            return;
        }
        pass.set_pipeline(&self.ids);
        pass.set_bind_group(0, self.ids_binding.group(), &[]);
        pass.draw(3 * run.start..3 * run.end, 0..1);
    }

    /// Records both passes; `queries` get timestamps 0 and 1.
    pub(crate) fn encode(
        &self,
        encoder: &mut CommandEncoder,
        textures: &ReceiverTextures,
        triangles: u32,
        queries: Option<&QuerySet>,
    ) {
        // Clears the ids to `NO_TRIANGLE`.
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

/// Returns the timestamps of a pass, which writes those of the two that have an index.
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

fn points_pipeline(device: &Device, text: &str, layout: &BindGroupLayout) -> RenderPipeline {
    let entries = ["umbrage_fullscreen", "resolve_pixel"];
    let targets = Targets::Colors(&[TextureFormat::Rgba32Float; 2]);
    fullscreen_pipeline(
        device,
        "umbrage resolve",
        text,
        entries,
        &targets,
        &[Some(layout)],
    )
}
