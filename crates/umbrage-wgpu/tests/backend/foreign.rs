//! A small wgpu program, written like an application: it doesn't use the backend's internals.

use glam::{Mat4, UVec2, Vec4};
use umbrage_core::Geometry;
use umbrage_wgpu::{CastTarget, wgpu};
use wgpu::{util::DeviceExt, *};

pub(crate) struct Foreign {
    pub(crate) device: Device,
    pub(crate) queue: Queue,
}

impl Foreign {
    pub(crate) fn new() -> Self {
        Self::with(Features::empty(), Limits::default())
    }

    pub(crate) fn with(required_features: Features, required_limits: Limits) -> Self {
        let options = RequestAdapterOptions::default();
        let adapter = pollster::block_on(Instance::default().request_adapter(&options))
            .expect("install a driver");
        let desc = DeviceDescriptor {
            required_features,
            required_limits,
            ..DeviceDescriptor::default()
        };
        let (device, queue) =
            pollster::block_on(adapter.request_device(&desc)).expect("small limits");
        Self { device, queue }
    }

    /// Returns two devices of one adapter.
    pub(crate) fn two() -> [Self; 2] {
        let options = RequestAdapterOptions::default();
        let adapter = pollster::block_on(Instance::default().request_adapter(&options))
            .expect("install a driver");
        let open = || {
            pollster::block_on(adapter.request_device(&DeviceDescriptor::default()))
                .expect("small limits")
        };
        [open(), open()].map(|(device, queue)| Self { device, queue })
    }

    pub(crate) fn encoder(&self) -> CommandEncoder {
        self.device
            .create_command_encoder(&CommandEncoderDescriptor::default())
    }

    pub(crate) fn buffer(&self, usage: BufferUsages, contents: &[u8]) -> Buffer {
        self.device.create_buffer_init(&util::BufferInitDescriptor {
            label: None,
            contents,
            usage,
        })
    }

    pub(crate) fn texture(&self, format: TextureFormat, size: UVec2, bytes: &[u8]) -> TextureView {
        let usage =
            TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST | TextureUsages::COPY_SRC;
        self.texture_for(usage, format, size, bytes)
    }

    pub(crate) fn texture_for(
        &self,
        usage: TextureUsages,
        format: TextureFormat,
        size: UVec2,
        bytes: &[u8],
    ) -> TextureView {
        let desc = descriptor(format, size, usage);
        let order = util::TextureDataOrder::LayerMajor;
        let texture = self
            .device
            .create_texture_with_data(&self.queue, &desc, order, bytes);
        texture.create_view(&TextureViewDescriptor::default())
    }

    /// Draws all triangles into a cast target with its own pipeline: no vertex buffer, vertices
    /// generated in the shader.
    pub(crate) fn draw_casters(
        &self,
        encoder: &mut CommandEncoder,
        target: &CastTarget,
        geometry: &Geometry,
    ) {
        let corners: Vec<_> = geometry
            .vertices_of(geometry.casters())
            .map(|p| p.extend(1.0))
            .collect();
        let text = "
            @group(0) @binding(0) var<uniform> clip_from_world: mat4x4f;
            @group(0) @binding(1) var<storage> corners: array<vec4f>;
            @vertex fn main(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
                let m = clip_from_world;
                let p = corners[i];
                return m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3];
            }
            @group(1) @binding(0) var other: texture_2d<f32>;
            @fragment fn peel(@builtin(position) at: vec4f) {
                if at.z <= textureLoad(other, vec2i(at.xy), 0).x { discard; }
            }";
        let pipeline = self.cast_pipeline(target, text);
        let matrix: Mat4 = target.clip_from_world;
        let buffers = [
            self.buffer(BufferUsages::UNIFORM, bytemuck::bytes_of(&matrix)),
            self.buffer(BufferUsages::STORAGE, bytemuck::cast_slice(&corners)),
        ];
        let resources = buffers.each_ref().map(Buffer::as_entire_binding);
        let group = self.bind(&pipeline.get_bind_group_layout(0), resources);
        let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
            depth_stencil_attachment: Some(target.attachment()),
            ..RenderPassDescriptor::default()
        });
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        if let Some(other) = &target.behind {
            let resources = [BindingResource::TextureView(other)];
            pass.set_bind_group(
                1,
                &self.bind(&pipeline.get_bind_group_layout(1), resources),
                &[],
            );
        }
        pass.draw(0..corners.len() as u32, 0..1);
    }

    fn cast_pipeline(&self, target: &CastTarget, text: &str) -> RenderPipeline {
        let module = &self.module(text);
        let options = PipelineCompilationOptions::default;
        let entry_point = None;
        let compilation_options = options();
        let peel = FragmentState {
            module,
            entry_point,
            compilation_options,
            targets: &[],
        };
        self.device
            .create_render_pipeline(&RenderPipelineDescriptor {
                label: None,
                layout: None,
                vertex: VertexState {
                    module,
                    entry_point: None,
                    compilation_options: options(),
                    buffers: &[],
                },
                primitive: target.primitive(),
                depth_stencil: Some(target.depth_stencil()),
                multisample: MultisampleState::default(),
                fragment: target.behind.is_some().then_some(peel),
                multiview_mask: None,
                cache: None,
            })
    }

    /// Calls `receive` from a separate compute shader, at the positions of a texture.
    pub(crate) fn shade(
        &self,
        encoder: &mut CommandEncoder,
        receive: &str,
        kernel_group: (&BindGroup, &BindGroupLayout),
        positions: &TextureView,
        size: UVec2,
    ) -> Texture {
        let (kernel, kernel_layout) = kernel_group;
        let text = format!(
            "{receive}
            @group(0) @binding(0) var positions: texture_2d<f32>;
            @group(0) @binding(1) var shaded: texture_storage_2d<r32float, write>;
            @compute @workgroup_size(8, 8) fn main(@builtin(global_invocation_id) id: vec3u) {{
                let p = textureLoad(positions, id.xy, 0);
                var lit = 1.0;
                if p.w != 0.0 {{
                    lit = receive(Receiver(p.xyz, vec3f(0.0, 1.0, 0.0), id.xy, 0u));
                }}
                textureStore(shaded, id.xy, vec4f(lit));
            }}"
        );
        let usage = TextureUsages::STORAGE_BINDING | TextureUsages::COPY_SRC;
        let shaded = self
            .device
            .create_texture(&descriptor(TextureFormat::R32Float, size, usage));
        let target = shaded.create_view(&TextureViewDescriptor::default());
        let mine = self.device.create_bind_group_layout(&shade_layout());
        let resources = [
            BindingResource::TextureView(positions),
            BindingResource::TextureView(&target),
        ];
        let group = self.bind(&mine, resources);
        let groups = [Some(&mine), Some(kernel_layout)];
        let layout = PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &groups,
            immediate_size: 0,
        };
        let pipeline = self
            .device
            .create_compute_pipeline(&ComputePipelineDescriptor {
                label: None,
                layout: Some(&self.device.create_pipeline_layout(&layout)),
                module: &self.module(&text),
                entry_point: None,
                compilation_options: PipelineCompilationOptions::default(),
                cache: None,
            });
        let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.set_bind_group(1, kernel, &[]);
        pass.dispatch_workgroups(size.x.div_ceil(8), size.y.div_ceil(8), 1);
        drop(pass);
        shaded
    }

    fn bind<const N: usize>(
        &self,
        layout: &BindGroupLayout,
        resources: [BindingResource<'_>; N],
    ) -> BindGroup {
        let entries: Vec<_> = (0..)
            .zip(resources)
            .map(|(binding, resource)| BindGroupEntry { binding, resource })
            .collect();
        self.device.create_bind_group(&BindGroupDescriptor {
            label: None,
            layout,
            entries: &entries,
        })
    }

    fn module(&self, text: &str) -> ShaderModule {
        let source = ShaderSource::Wgsl(text.into());
        self.device.create_shader_module(ShaderModuleDescriptor {
            label: None,
            source,
        })
    }
}

fn shade_layout() -> BindGroupLayoutDescriptor<'static> {
    const fn entry(binding: u32, ty: BindingType) -> BindGroupLayoutEntry {
        BindGroupLayoutEntry {
            binding,
            visibility: ShaderStages::COMPUTE,
            ty,
            count: None,
        }
    }
    const D2: TextureViewDimension = TextureViewDimension::D2;
    const FLOATS: TextureSampleType = TextureSampleType::Float { filterable: false };
    const POSITIONS: BindingType = BindingType::Texture {
        sample_type: FLOATS,
        view_dimension: D2,
        multisampled: false,
    };
    const SHADED: BindingType = BindingType::StorageTexture {
        access: StorageTextureAccess::WriteOnly,
        format: TextureFormat::R32Float,
        view_dimension: D2,
    };
    const ENTRIES: &[BindGroupLayoutEntry] = &[entry(0, POSITIONS), entry(1, SHADED)];
    BindGroupLayoutDescriptor {
        label: None,
        entries: ENTRIES,
    }
}

fn descriptor(
    format: TextureFormat,
    size: UVec2,
    usage: TextureUsages,
) -> TextureDescriptor<'static> {
    TextureDescriptor {
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
        usage,
        view_formats: &[],
    }
}

/// Submits and reads a texture of single floats.
pub(crate) fn read(foreign: &Foreign, encoder: CommandEncoder, texture: &Texture) -> Vec<f32> {
    read_texels(foreign, encoder, texture)
}

/// Submits and reads a texture of four floats per texel.
pub(crate) fn read_four(
    foreign: &Foreign,
    encoder: CommandEncoder,
    texture: &Texture,
) -> Vec<Vec4> {
    read_texels(foreign, encoder, texture)
}

fn read_texels<T: bytemuck::Pod>(
    foreign: &Foreign,
    mut encoder: CommandEncoder,
    texture: &Texture,
) -> Vec<T> {
    let row = texture.width() * size_of::<T>() as u32;
    let padded = row.next_multiple_of(COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = foreign.device.create_buffer(&BufferDescriptor {
        label: None,
        size: u64::from(padded * texture.height()),
        usage: BufferUsages::COPY_DST | BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let layout = TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(padded),
        rows_per_image: None,
    };
    let into = TexelCopyBufferInfo {
        buffer: &buffer,
        layout,
    };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), into, texture.size());
    foreign.queue.submit([encoder.finish()]);
    buffer.map_async(MapMode::Read, .., |result| {
        result.expect("the device is there")
    });
    foreign
        .device
        .poll(PollType::wait_indefinitely())
        .expect("the device is there");
    let view = buffer.get_mapped_range(..).expect("it is mapped");
    let texels = |bytes: &[u8]| bytemuck::cast_slice::<u8, T>(&bytes[..row as usize]).to_vec();
    view.chunks_exact(padded as usize)
        .flat_map(texels)
        .collect()
}
