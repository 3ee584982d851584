//! A program with a forward renderer that uses a light set.

use crate::{
    adapter::{TestDevice, device},
    foreign,
};
use bytemuck::cast_slice;
use glam::{UVec2, Vec3};
use umbrage_core::Receivers;
use umbrage_wgpu::{
    ApiErrors, GBuffer, LightSet, LightSetOptions, SetBudget, SetFrame, StillLayers,
};
use wgpu::{
    BindGroup, BindGroupLayout, BindingResource, Color, CommandEncoder, LoadOp, Operations,
    RenderPassColorAttachment, RenderPassDescriptor, RenderPipeline, StoreOp, TextureFormat,
    TextureUsages, TextureView,
};

/// The set's bind group in the program's shader. The program's own is 0.
const GROUP: u32 = 1;

/// Draws a light's visibility at every receiver. The light's index is that of the instance.
const OWN_SHADER: &str = "
@group(0) @binding(0) var own_position: texture_2d<f32>;
@group(0) @binding(1) var own_normal: texture_2d<f32>;
@group(0) @binding(2) var own_triangle: texture_2d<u32>;
struct OwnPixel {
    @builtin(position) at: vec4f,
    @location(0) @interpolate(flat) light: u32,
}
@vertex fn own_vertex(@builtin(vertex_index) i: u32, @builtin(instance_index) light: u32) -> OwnPixel {
    return OwnPixel(vec4f(f32(i32(i & 1u) * 4 - 1), f32(i32(i & 2u) * 2 - 1), 0.0, 1.0), light);
}
@fragment fn own_fragment(pixel: OwnPixel) -> @location(0) f32 {
    let texel = vec2i(pixel.at.xy);
    let position = textureLoad(own_position, texel, 0);
    if position.w == 0.0 {
        return 1.0;
    }
    let normal = textureLoad(own_normal, texel, 0).xyz;
    let triangle = textureLoad(own_triangle, texel, 0).x;
    return shadow_on(pixel.light, position.xyz, normal, vec2u(texel), triangle);
}
";

/// The program's visible surfaces.
#[derive(Debug)]
pub struct ForwardProgram {
    /// The device.
    pub d: &'static TestDevice,
    position: TextureView,
    normal: TextureView,
    triangle: TextureView,
    size: UVec2,
}

/// A pipeline that contains a set's text.
#[derive(Debug)]
struct SetPipeline {
    revision: u64,
    pipeline: RenderPipeline,
}

/// A program's renderer of one set.
#[derive(Debug, Default)]
pub struct Forward {
    drawn: Option<SetPipeline>,
    /// True to keep the pipeline of a past revision, as programs must not.
    pub keeps_stale_pipelines: bool,
}

impl ForwardProgram {
    /// Returns a program with these receivers.
    pub fn new(receivers: &Receivers) -> Self {
        let mut positions: Vec<[f32; 4]> = Vec::new();
        let mut normals: Vec<[f32; 4]> = Vec::new();
        for i in 0..receivers.len() {
            let receives = if receivers.receives[i] { 1.0 } else { 0.0 };
            positions.push(receivers.position(i).extend(receives).to_array());
            normals.push(receivers.normal(i).extend(0.0).to_array());
        }
        let size = receivers.size;
        Self::of_texels(device(), size, &positions, &normals, &receivers.triangle)
    }

    /// Returns a program with a floor of `size` points, a quarter of a metre apart, around the
    /// origin.
    pub fn floor(d: &'static TestDevice, size: UVec2) -> Self {
        let mut positions: Vec<[f32; 4]> = Vec::new();
        for y in 0..size.y {
            for x in 0..size.x {
                let x = (x as f32 - size.x as f32 * 0.5) * 0.25 + 0.03;
                let z = (y as f32 - size.y as f32 * 0.5) * 0.25 + 0.01;
                positions.push([x, 0.0, z, 1.0]);
            }
        }
        let count = positions.len();
        let normals = vec![Vec3::Y.extend(0.0).to_array(); count];
        Self::of_texels(d, size, &positions, &normals, &vec![u32::MAX; count])
    }

    /// Returns a program with these positions (w is 1 where a shadow may fall), normals and
    /// triangles.
    pub fn of_texels(
        d: &'static TestDevice,
        size: UVec2,
        positions: &[[f32; 4]],
        normals: &[[f32; 4]],
        triangles: &[u32],
    ) -> Self {
        let floats = TextureFormat::Rgba32Float;
        Self {
            d,
            position: foreign::upload(d, size, floats, cast_slice(positions)),
            normal: foreign::upload(d, size, floats, cast_slice(normals)),
            triangle: foreign::upload(d, size, TextureFormat::R32Uint, cast_slice(triangles)),
            size,
        }
    }

    /// Returns an empty set that reports errors at once.
    ///
    /// # Panics
    /// Panics if the device has one bind group only.
    pub fn set(&self, budget: SetBudget, still_layers: StillLayers) -> LightSet {
        let options = LightSetOptions {
            group: GROUP,
            errors: ApiErrors::AtOnce,
            budget,
            still_layers,
            ..LightSetOptions::default()
        };
        LightSet::new(&self.d.device, &self.d.queue, options)
            .expect("the device has two bind groups")
    }

    /// Returns the textures of the visible surfaces.
    pub fn gbuffer(&self) -> GBuffer<'_> {
        GBuffer {
            position: &self.position,
            normal: &self.normal,
            triangle: Some(&self.triangle),
        }
    }

    /// Returns the size in pixels.
    pub const fn size(&self) -> UVec2 {
        self.size
    }

    /// Returns a new encoder.
    pub fn encoder(&self) -> CommandEncoder {
        self.d
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
    }

    /// Prepares, encodes and submits a frame of the set, without reading it back.
    ///
    /// # Panics
    /// Panics if the set reports an error.
    pub fn update(&self, set: &mut LightSet, frame: &SetFrame<'_>) {
        set.prepare(frame).expect("prepares");
        let mut encoder = self.encoder();
        set.encode(&mut encoder).expect("was prepared");
        self.d.queue.submit([encoder.finish()]);
    }
}

impl Forward {
    /// Returns the visibility of the light with this index at every receiver in the set's last
    /// frame.
    ///
    /// # Panics
    /// Panics if the set was not prepared.
    pub fn mask(&mut self, program: &ForwardProgram, set: &LightSet, light: u32) -> Vec<f32> {
        let (group, layout) = set.bind_group().expect("was prepared");
        let revision = set.wgsl_revision();
        let drawn = match self.drawn.take() {
            Some(drawn) if drawn.revision == revision || self.keeps_stale_pipelines => drawn,
            _ => program.compile(set.wgsl(), revision, layout),
        };
        let d = program.d;
        let own_group = program.own_group();
        let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC;
        let target = foreign::texture(d, program.size, TextureFormat::R32Float, usage);
        let view = target.create_view(&wgpu::TextureViewDescriptor::default());
        let mut encoder = program.encoder();
        let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
            color_attachments: &[Some(RenderPassColorAttachment {
                view: &view,
                depth_slice: None,
                resolve_target: None,
                ops: Operations {
                    load: LoadOp::Clear(Color::WHITE),
                    store: StoreOp::Store,
                },
            })],
            ..RenderPassDescriptor::default()
        });
        pass.set_pipeline(&drawn.pipeline);
        pass.set_bind_group(0, &own_group, &[]);
        pass.set_bind_group(GROUP, group, &[]);
        pass.draw(0..3, light..light + 1);
        drop(pass);
        self.drawn = Some(drawn);
        foreign::read(d, encoder, &view)
    }
}

impl ForwardProgram {
    fn compile(&self, set_text: &str, revision: u64, set_layout: &BindGroupLayout) -> SetPipeline {
        // Compile the set's text with the program's shader.
        let device = &self.d.device;
        let text = format!("{set_text}{OWN_SHADER}");
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(text.into()),
        });
        let own_layout = self.own_layout();
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            bind_group_layouts: &[Some(&own_layout), Some(set_layout)],
            ..wgpu::PipelineLayoutDescriptor::default()
        });
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: None,
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("own_vertex"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("own_fragment"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(TextureFormat::R32Float.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        SetPipeline { revision, pipeline }
    }

    /// Binds the receivers.
    fn own_group(&self) -> BindGroup {
        let entries: Vec<_> = (0..)
            .zip([&self.position, &self.normal, &self.triangle])
            .map(|(binding, view)| wgpu::BindGroupEntry {
                binding,
                resource: BindingResource::TextureView(view),
            })
            .collect();
        self.d.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &self.own_layout(),
            entries: &entries,
        })
    }

    fn own_layout(&self) -> BindGroupLayout {
        let entry = |binding: u32, sample_type| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty: wgpu::BindingType::Texture {
                sample_type,
                view_dimension: wgpu::TextureViewDimension::D2,
                multisampled: false,
            },
            count: None,
        };
        let floats = wgpu::TextureSampleType::Float { filterable: false };
        self.d
            .device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: None,
                entries: &[
                    entry(0, floats),
                    entry(1, floats),
                    entry(2, wgpu::TextureSampleType::Uint),
                ],
            })
    }
}
