//! The same shadows by a program that was written by hand for this picture alone.

use super::deferred::{HandMasks, MaskShading, Picture};
use super::scene::{
    DEPTH, Device, INSTANCES, LIGHTS, MAP, Shared, depth_attachment, depth_state, layer_views,
    lights, placements, uniform_entry,
};
use anyhow::Result;
use umbrage::{Aabb, ShadowTechnique, View, glam::Mat4, wgpu::wgpu};

/// Bytes from one matrix to the next, as dynamic offsets ask.
const STRIDE: usize = 256;

/// All that it keeps from frame to frame.
pub(crate) struct ByHand {
    pub(crate) shared: Shared,
    cast: wgpu::RenderPipeline,
    pipeline: wgpu::RenderPipeline,
    spaces: wgpu::BindGroup,
    shadows: wgpu::BindGroup,
    layers: Vec<wgpu::TextureView>,
    masks: Option<HandMasks>,
    shading: MaskShading,
}

/// The bias and the reach of the kernel.
#[derive(Clone, Copy)]
pub(crate) struct Kernel {
    pub(crate) bias: f32,
    pub(crate) radius: i32,
}

impl ByHand {
    /// Makes maps where the technique puts them: what is compared is the work, not where maps lie.
    pub(crate) fn new(
        d: &Device,
        technique: &dyn ShadowTechnique,
        casters: Aabb,
        kernel: Kernel,
        picture: Picture<'_>,
    ) -> Result<Self> {
        let shared = Shared::new(d)?;
        let mut spaces: Vec<Mat4> = Vec::new();
        for light in &lights() {
            let view = View {
                camera: &shared.camera,
                light,
                casters,
                geometry: None,
                receivers: None,
                fits: None,
            };
            let recipe = technique.recipe(&view)?;
            spaces.push(recipe.casts[0].space.clip_from_world());
        }
        let maps = d.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d {
                width: MAP,
                height: MAP,
                depth_or_array_layers: LIGHTS as u32,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: DEPTH,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        let matrix_layout = bind_group_layout(d, &[uniform_entry(0, true)]);
        let spaces_group = spaces_group(d, &matrix_layout, &spaces);
        let cast = cast_pipeline(d, &matrix_layout);
        let shadow_layout = bind_group_layout(d, &[uniform_entry(0, false), maps_entry()]);
        let shadows = shadow_group(d, &shadow_layout, &spaces, kernel, &maps);
        let radius = kernel.radius;
        let lit = format!("const RADIUS = {radius};\n{}", include_str!("by_hand.wgsl"));
        let pipeline = picture.pipeline(d, &shared, &lit, &shadow_layout);
        let masks = match picture {
            Picture::Masks(gbuffer) => Some(HandMasks::new(d, gbuffer, &lit, &shadow_layout)),
            Picture::Forward | Picture::Deferred(_) => None,
        };
        Ok(Self {
            shared,
            cast,
            pipeline,
            spaces: spaces_group,
            shadows,
            layers: layer_views(&maps),
            masks,
            shading: MaskShading::default(),
        })
    }

    /// Moves all casters to where they are at a time, and draws a frame.
    pub(crate) fn frame(&mut self, d: &Device, time: f32, picture: Picture<'_>) {
        self.shared.place(d, &placements(time));
        self.still_frame(d, picture);
    }

    /// Draws a frame in which nothing moved: it keeps nothing, so it draws all maps again.
    pub(crate) fn still_frame(&mut self, d: &Device, picture: Picture<'_>) {
        let mut encoder = d
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        for (i, layer) in self.layers.iter().enumerate() {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                depth_stencil_attachment: Some(depth_attachment(layer)),
                ..wgpu::RenderPassDescriptor::default()
            });
            pass.set_pipeline(&self.cast);
            pass.set_bind_group(0, &self.spaces, &[(STRIDE * i) as u32]);
            pass.set_vertex_buffer(0, self.shared.vertices.slice(..));
            pass.set_vertex_buffer(1, self.shared.instances.slice(..));
            let instances = self.shared.instances.size() / 48;
            pass.draw(0..self.shared.vertex_count, 0..instances as u32);
        }
        match (picture, &self.masks) {
            (Picture::Masks(gbuffer), Some(masks)) => {
                gbuffer.draw(&mut encoder, &self.shared);
                masks.encode(&mut encoder, gbuffer, &self.shadows);
                let (shared, layers) = (&self.shared, &masks.whole);
                self.shading.shade(d, &mut encoder, gbuffer, shared, layers);
            }
            _ => picture.draw(&mut encoder, &self.shared, &self.pipeline, &self.shadows),
        }
        d.queue.submit([encoder.finish()]);
    }
}

pub(crate) fn bind_group_layout(
    d: &Device,
    entries: &[wgpu::BindGroupLayoutEntry],
) -> wgpu::BindGroupLayout {
    d.device
        .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: None,
            entries,
        })
}

fn maps_entry() -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding: 1,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty: wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: false },
            view_dimension: wgpu::TextureViewDimension::D2Array,
            multisampled: false,
        },
        count: None,
    }
}

fn spaces_group(d: &Device, layout: &wgpu::BindGroupLayout, spaces: &[Mat4]) -> wgpu::BindGroup {
    let mut bytes = vec![0_u8; STRIDE * spaces.len()];
    for (i, space) in spaces.iter().enumerate() {
        let matrix: &[u8] = bytemuck::bytes_of(space);
        bytes[i * STRIDE..][..matrix.len()].copy_from_slice(matrix);
    }
    let buffer = d.buffer(wgpu::BufferUsages::UNIFORM, &bytes);
    d.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout,
        entries: &[wgpu::BindGroupEntry {
            binding: 0,
            resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                buffer: &buffer,
                offset: 0,
                size: std::num::NonZero::new(64),
            }),
        }],
    })
}

fn shadow_group(
    d: &Device,
    layout: &wgpu::BindGroupLayout,
    spaces: &[Mat4],
    kernel: Kernel,
    maps: &wgpu::Texture,
) -> wgpu::BindGroup {
    let mut words: Vec<f32> = spaces.iter().flat_map(Mat4::to_cols_array).collect();
    words.extend([MAP as f32, kernel.bias, 0.0, 0.0]);
    let uniforms = d.buffer(wgpu::BufferUsages::UNIFORM, bytemuck::cast_slice(&words));
    let whole = maps.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..wgpu::TextureViewDescriptor::default()
    });
    d.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout,
        entries: &[
            wgpu::BindGroupEntry {
                binding: 0,
                resource: uniforms.as_entire_binding(),
            },
            wgpu::BindGroupEntry {
                binding: 1,
                resource: wgpu::BindingResource::TextureView(&whole),
            },
        ],
    })
}

fn cast_pipeline(d: &Device, layout: &wgpu::BindGroupLayout) -> wgpu::RenderPipeline {
    let module = d.shader(include_str!("by_hand_cast.wgsl").to_owned());
    let layout = d
        .device
        .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            bind_group_layouts: &[Some(layout)],
            ..wgpu::PipelineLayoutDescriptor::default()
        });
    let positions = wgpu::VertexBufferLayout {
        array_stride: 24,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &wgpu::vertex_attr_array![0 => Float32x3],
    };
    d.device
        .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: None,
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("cast_box"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[Some(positions), Some(INSTANCES)],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: Some(depth_state()),
            multisample: wgpu::MultisampleState::default(),
            fragment: None,
            multiview_mask: None,
            cache: None,
        })
}
