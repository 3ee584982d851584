//! A program for one technique, written directly on wgpu: the reference for the wgpu backend.

use std::{borrow::Cow, time::Duration};
use umbrage_core::{
    Geometry, LightSpace, Receivers,
    glam::{UVec2, Vec3},
};
use umbrage_wgpu::wgpu::{self, util::DeviceExt, *};

/// Times of one frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct FrameTimes {
    /// The depth pass.
    pub(super) cast: Duration,
    /// The full-screen pass.
    pub(super) receive: Duration,
}

/// Settings of a frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct FrameSettings {
    /// The light space of the map.
    pub(super) space: LightSpace,
    /// The unit direction to the light.
    pub(super) to_light: Vec3,
    /// Side of the map, texels.
    pub(super) map_size: u32,
    /// Reach of the kernel beyond the receiver's texel, texels.
    pub(super) radius: i32,
}

/// Pipelines and resources, created once.
pub(super) struct HandWritten {
    device: Device,
    queue: Queue,
    cast: RenderPipeline,
    shade: RenderPipeline,
    cast_group: BindGroup,
    shade_group: BindGroup,
    vertices: Buffer,
    indices: Buffer,
    count: u32,
    map: TextureView,
    mask: TextureView,
    stamps: QuerySet,
    resolved: Buffer,
    read_back: Buffer,
}

impl HandWritten {
    /// Returns a program that draws `geometry` into its map and shades `receivers`.
    pub(super) fn new(
        device: &Device,
        queue: &Queue,
        geometry: &Geometry,
        receivers: &Receivers,
        settings: &FrameSettings,
    ) -> Self {
        let source = ShaderSource::Wgsl(Cow::Borrowed(include_str!("handwritten.wgsl")));
        let module = device.create_shader_module(ShaderModuleDescriptor {
            label: Some("by hand"),
            source,
        });
        let cast = cast_pipeline(device, &module);
        let shade = shade_pipeline(device, &module);
        let uniforms = buffer(device, BufferUsages::UNIFORM, &uniform_bytes(settings));
        let map_size = UVec2::splat(settings.map_size);
        let map = texture(device, map_size, TextureFormat::Depth32Float);
        let mask = texture(device, receivers.size, TextureFormat::R32Float);
        let position = upload(device, queue, receivers.size, &positions(receivers));
        let normal = upload(device, queue, receivers.size, &normals(receivers));
        let vertices = bytemuck::cast_slice(geometry.positions());
        let triangles = geometry.casters().start as usize..geometry.casters().end as usize;
        let casters = &geometry.triangles()[triangles];
        let indices = bytemuck::cast_slice(casters);
        Self {
            cast_group: bind_group(device, &cast, &uniforms, &[]),
            shade_group: bind_group(device, &shade, &uniforms, &[&map, &position, &normal]),
            vertices: buffer(device, BufferUsages::VERTEX, vertices),
            indices: buffer(device, BufferUsages::INDEX, indices),
            count: 3 * casters.len() as u32,
            stamps: device.create_query_set(&QuerySetDescriptor {
                label: None,
                ty: QueryType::Timestamp,
                count: 4,
            }),
            resolved: stamp_buffer(device, BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC),
            read_back: stamp_buffer(device, BufferUsages::MAP_READ | BufferUsages::COPY_DST),
            device: device.clone(),
            queue: queue.clone(),
            cast,
            shade,
            map,
            mask,
        }
    }

    /// Draws one frame and waits for it.
    pub(super) fn frame(&self) -> Result<FrameTimes, String> {
        let mut encoder = self
            .device
            .create_command_encoder(&CommandEncoderDescriptor::default());
        self.encode_cast(&mut encoder);
        self.encode_shade(&mut encoder);
        encoder.resolve_query_set(&self.stamps, 0..4, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.read_back, 0, 32);
        self.queue.submit([encoder.finish()]);
        self.times()
    }

    fn encode_cast(&self, encoder: &mut CommandEncoder) {
        let depth_ops = Some(Operations {
            load: LoadOp::Clear(1.0),
            store: StoreOp::Store,
        });
        let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
            depth_stencil_attachment: Some(RenderPassDepthStencilAttachment {
                view: &self.map,
                depth_ops,
                stencil_ops: None,
            }),
            timestamp_writes: Some(self.writes(0)),
            ..Default::default()
        });
        pass.set_pipeline(&self.cast);
        pass.set_bind_group(0, &self.cast_group, &[]);
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.set_index_buffer(self.indices.slice(..), IndexFormat::Uint32);
        pass.draw_indexed(0..self.count, 0, 0..1);
    }

    fn encode_shade(&self, encoder: &mut CommandEncoder) {
        let ops = Operations {
            load: LoadOp::Clear(Color::BLACK),
            store: StoreOp::Store,
        };
        let target = RenderPassColorAttachment {
            view: &self.mask,
            depth_slice: None,
            resolve_target: None,
            ops,
        };
        let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
            color_attachments: &[Some(target)],
            timestamp_writes: Some(self.writes(2)),
            ..Default::default()
        });
        pass.set_pipeline(&self.shade);
        pass.set_bind_group(0, &self.shade_group, &[]);
        pass.draw(0..3, 0..1);
    }

    /// Writes timestamps `first` and `first` + 1 at the beginning and end of a pass.
    fn writes(&self, first: u32) -> RenderPassTimestampWrites<'_> {
        RenderPassTimestampWrites {
            query_set: &self.stamps,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(first + 1),
        }
    }

    fn times(&self) -> Result<FrameTimes, String> {
        self.read_back.map_async(MapMode::Read, .., |_| {});
        self.device
            .poll(PollType::wait_indefinitely())
            .map_err(|e| e.to_string())?;
        let stamps: Vec<u64> = {
            let bytes = self
                .read_back
                .get_mapped_range(..)
                .map_err(|e| e.to_string())?;
            bytemuck::pod_collect_to_vec(&bytes)
        };
        self.read_back.unmap();
        let period = self.queue.get_timestamp_period();
        Ok(FrameTimes {
            cast: time_between(stamps[0], stamps[1], period),
            receive: time_between(stamps[2], stamps[3], period),
        })
    }
}

/// Returns the time between two timestamps with a unit of `period` nanoseconds.
fn time_between(begin: u64, end: u64, period: f32) -> Duration {
    let ticks = end.saturating_sub(begin) as f64;
    Duration::from_nanos((ticks * f64::from(period)) as u64)
}

fn buffer(device: &Device, usage: BufferUsages, contents: &[u8]) -> Buffer {
    device.create_buffer_init(&util::BufferInitDescriptor {
        label: None,
        contents,
        usage,
    })
}

/// Binds the uniforms at 0 and the views from 1 on.
fn bind_group(
    device: &Device,
    pipeline: &RenderPipeline,
    uniforms: &Buffer,
    views: &[&TextureView],
) -> BindGroup {
    let mut entries = vec![BindGroupEntry {
        binding: 0,
        resource: uniforms.as_entire_binding(),
    }];
    for (binding, view) in (1..).zip(views) {
        entries.push(BindGroupEntry {
            binding,
            resource: BindingResource::TextureView(view),
        });
    }
    device.create_bind_group(&BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &entries,
    })
}

/// Returns the receivers' positions. w is 1 at receivers, else 0.
fn positions(receivers: &Receivers) -> Vec<[f32; 4]> {
    let mut out = Vec::with_capacity(receivers.len());
    for i in 0..receivers.len() {
        let covered = f32::from(u8::from(receivers.receives[i]));
        out.push(receivers.position(i).extend(covered).to_array());
    }
    out
}

/// Returns the receivers' normals; w is 0.
fn normals(receivers: &Receivers) -> Vec<[f32; 4]> {
    let mut out = Vec::with_capacity(receivers.len());
    for i in 0..receivers.len() {
        out.push(receivers.normal(i).extend(0.0).to_array());
    }
    out
}

fn stamp_buffer(device: &Device, usage: BufferUsages) -> Buffer {
    device.create_buffer(&BufferDescriptor {
        label: None,
        size: 32,
        usage,
        mapped_at_creation: false,
    })
}

/// Returns the bytes of the shader's `Uniforms`.
fn uniform_bytes(settings: &FrameSettings) -> Vec<u8> {
    let mut out = Vec::new();
    for value in settings.space.clip_from_world().to_cols_array() {
        out.extend(value.to_le_bytes());
    }
    for value in settings.to_light.to_array() {
        out.extend(value.to_le_bytes());
    }
    out.extend(settings.radius.to_le_bytes());
    out
}

fn texture(device: &Device, size: UVec2, format: TextureFormat) -> TextureView {
    let desc = TextureDescriptor {
        label: None,
        size: Extent3d {
            width: size.x,
            height: size.y,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: TextureDimension::D2,
        format,
        usage: TextureUsages::RENDER_ATTACHMENT
            | TextureUsages::TEXTURE_BINDING
            | TextureUsages::COPY_DST,
        view_formats: &[],
    };
    device
        .create_texture(&desc)
        .create_view(&TextureViewDescriptor::default())
}

fn upload(device: &Device, queue: &Queue, size: UVec2, texels: &[[f32; 4]]) -> TextureView {
    let view = texture(device, size, TextureFormat::Rgba32Float);
    let layout = TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(16 * size.x),
        rows_per_image: None,
    };
    queue.write_texture(
        view.texture().as_image_copy(),
        bytemuck::cast_slice(texels),
        layout,
        view.texture().size(),
    );
    view
}

fn cast_pipeline(device: &Device, module: &ShaderModule) -> RenderPipeline {
    let attributes = &wgpu::vertex_attr_array![0 => Float32x3];
    let buffer = VertexBufferLayout {
        array_stride: 12,
        step_mode: VertexStepMode::Vertex,
        attributes,
    };
    device.create_render_pipeline(&RenderPipelineDescriptor {
        label: Some("cast by hand"),
        layout: None,
        vertex: VertexState {
            module,
            entry_point: Some("draw_depth"),
            compilation_options: PipelineCompilationOptions::default(),
            buffers: &[Some(buffer)],
        },
        primitive: PrimitiveState::default(),
        depth_stencil: Some(DepthStencilState {
            format: TextureFormat::Depth32Float,
            depth_write_enabled: Some(true),
            depth_compare: Some(CompareFunction::Less),
            stencil: StencilState::default(),
            bias: DepthBiasState::default(),
        }),
        multisample: MultisampleState::default(),
        fragment: None,
        multiview_mask: None,
        cache: None,
    })
}

fn shade_pipeline(device: &Device, module: &ShaderModule) -> RenderPipeline {
    device.create_render_pipeline(&RenderPipelineDescriptor {
        label: Some("shade by hand"),
        layout: None,
        vertex: VertexState {
            module,
            entry_point: Some("fullscreen"),
            compilation_options: PipelineCompilationOptions::default(),
            buffers: &[],
        },
        primitive: PrimitiveState::default(),
        depth_stencil: None,
        multisample: MultisampleState::default(),
        fragment: Some(FragmentState {
            module,
            entry_point: Some("shade"),
            compilation_options: PipelineCompilationOptions::default(),
            targets: &[Some(TextureFormat::R32Float.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}
