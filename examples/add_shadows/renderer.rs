//! What the two programs have before they have shadows, as any wgpu program does: a device, a scene of boxes, a camera, two lights,
//! pipelines, and a file to write to.

use anyhow::{Context as _, Result};
use umbrage::{
    Camera, Light,
    glam::{Affine3A, Mat4, Quat, UVec2, Vec3},
    wgpu::wgpu::{self, util::DeviceExt as _},
};

/// Size of the picture, pixels.
pub(crate) const SIZE: UVec2 = UVec2::new(640, 400);
pub(crate) const COLOR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;
pub(crate) const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// Bytes of a vertex: a position and a normal.
pub(crate) const VERTEX_BYTES: u64 = 24;
/// Boxes, the floor among them.
const BOXES: usize = 26;

/// The scene's part of every shader.
pub(crate) const SCENE_WGSL: &str = include_str!("scene.wgsl");

/// A device of the program's own.
pub(crate) struct Graphics {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
}

/// The scene's buffers.
pub(crate) struct Boxes {
    /// A box from -1 to 1, every three vertices a triangle.
    pub(crate) vertices: wgpu::Buffer,
    pub(crate) vertex_count: u32,
    instances: wgpu::Buffer,
    pub(crate) layout: wgpu::BindGroupLayout,
    pub(crate) group: wgpu::BindGroup,
}

/// A sun and a spot.
pub(crate) fn lights() -> [Light; 2] {
    [
        Light::Directional {
            direction: Vec3::new(-0.6, -1.0, 0.5),
            angular_diameter: 0.0,
        },
        Light::Spot {
            position: Vec3::new(3.0, 6.0, 5.0),
            direction: Vec3::new(-0.5, -1.0, -0.8),
            inner: 0.5,
            outer: 0.7,
            radius: 0.0,
        },
    ]
}

/// Where the boxes are after some seconds: the floor, then a grid whose boxes turn.
pub(crate) fn placements(seconds: f32) -> Vec<Affine3A> {
    let mut out = vec![Affine3A::from_scale_rotation_translation(
        Vec3::new(9.0, 0.1, 9.0),
        Quat::IDENTITY,
        Vec3::new(0.0, -0.1, 0.0),
    )];
    for i in 1..BOXES {
        let column = ((i - 1) % 5) as f32 - 2.0;
        let row = ((i - 1) / 5) as f32 - 2.0;
        let height = 0.6 + 0.2 * ((i * 3) % 5) as f32;
        out.push(Affine3A::from_scale_rotation_translation(
            Vec3::new(0.5, height, 0.5),
            Quat::from_rotation_y(seconds + i as f32),
            Vec3::new(3.0 * column, height, 3.0 * row),
        ));
    }
    out
}

pub(crate) fn camera() -> Result<Camera> {
    let eye = Vec3::new(6.0, 7.0, 12.0);
    let camera = Camera::perspective(eye, Vec3::ZERO, Vec3::Y, 0.9, [0.1, 100.0], SIZE)?;
    Ok(camera)
}

pub(crate) fn clip_from_world(camera: &Camera) -> Mat4 {
    camera.clip_from_view * Mat4::from(camera.world_from_view.inverse())
}

impl Graphics {
    pub(crate) fn open() -> Result<Self> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let options = wgpu::RequestAdapterOptions::default();
        let adapter = pollster::block_on(instance.request_adapter(&options))
            .context("no graphics adapter: install a Vulkan driver")?;
        let desc = wgpu::DeviceDescriptor::default();
        let (device, queue) = pollster::block_on(adapter.request_device(&desc))?;
        Ok(Self { device, queue })
    }

    pub(crate) fn encoder(&self) -> wgpu::CommandEncoder {
        self.device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
    }

    fn buffer(&self, usage: wgpu::BufferUsages, floats: &[f32]) -> wgpu::Buffer {
        let desc = wgpu::util::BufferInitDescriptor {
            label: None,
            contents: bytemuck::cast_slice(floats),
            usage: usage | wgpu::BufferUsages::COPY_DST,
        };
        self.device.create_buffer_init(&desc)
    }

    /// Returns a texture of the picture's size, to draw into, to read in shaders and to copy.
    pub(crate) fn target(&self, format: wgpu::TextureFormat) -> wgpu::TextureView {
        let texture = self.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d {
                width: SIZE.x,
                height: SIZE.y,
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        texture.create_view(&wgpu::TextureViewDescriptor::default())
    }

    pub(crate) fn layout(&self, types: &[wgpu::BindingType]) -> wgpu::BindGroupLayout {
        let entries: Vec<_> = (0..)
            .zip(types)
            .map(|(binding, &ty)| wgpu::BindGroupLayoutEntry {
                binding,
                visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
                ty,
                count: None,
            })
            .collect();
        let desc = wgpu::BindGroupLayoutDescriptor {
            label: None,
            entries: &entries,
        };
        self.device.create_bind_group_layout(&desc)
    }

    pub(crate) fn group(
        &self,
        layout: &wgpu::BindGroupLayout,
        resources: &[wgpu::BindingResource<'_>],
    ) -> wgpu::BindGroup {
        let entries: Vec<_> = (0..)
            .zip(resources)
            .map(|(binding, resource)| wgpu::BindGroupEntry {
                binding,
                resource: resource.clone(),
            })
            .collect();
        let desc = wgpu::BindGroupDescriptor {
            label: None,
            layout,
            entries: &entries,
        };
        self.device.create_bind_group(&desc)
    }

    /// Returns a pipeline that draws the boxes, or else a triangle around the screen without a depth buffer.
    pub(crate) fn pipeline(
        &self,
        text: String,
        fragment: &str,
        draws_boxes: bool,
        groups: &[Option<&wgpu::BindGroupLayout>],
        targets: &[wgpu::TextureFormat],
    ) -> wgpu::RenderPipeline {
        let device = &self.device;
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(text.into()),
        });
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            bind_group_layouts: groups,
            ..wgpu::PipelineLayoutDescriptor::default()
        });
        let targets: Vec<_> = targets.iter().map(|&t| Some(t.into())).collect();
        let of_boxes = [
            Some(wgpu::VertexBufferLayout {
                array_stride: VERTEX_BYTES,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3],
            }),
            Some(wgpu::VertexBufferLayout {
                array_stride: 48,
                step_mode: wgpu::VertexStepMode::Instance,
                attributes: &wgpu::vertex_attr_array![2 => Float32x4, 3 => Float32x4, 4 => Float32x4],
            }),
        ];
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: None,
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some(if draws_boxes { "surface" } else { "screen" }),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: if draws_boxes { &of_boxes } else { &[] },
            },
            primitive: wgpu::PrimitiveState {
                cull_mode: draws_boxes.then_some(wgpu::Face::Back),
                ..wgpu::PrimitiveState::default()
            },
            depth_stencil: draws_boxes.then(|| wgpu::DepthStencilState {
                format: DEPTH,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Less),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some(fragment),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &targets,
            }),
            multiview_mask: None,
            cache: None,
        })
    }

    /// Submits the encoder, and returns the picture's pixels, four bytes each.
    pub(crate) fn read(
        &self,
        mut encoder: wgpu::CommandEncoder,
        picture: &wgpu::TextureView,
    ) -> Result<Vec<u8>> {
        // Rows of 640 pixels are multiples of 256 bytes, as copies ask.
        let row = 4 * SIZE.x;
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: u64::from(row * SIZE.y),
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let destination = wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(row),
                rows_per_image: None,
            },
        };
        let texture = picture.texture();
        encoder.copy_texture_to_buffer(texture.as_image_copy(), destination, texture.size());
        self.queue.submit([encoder.finish()]);
        buffer.map_async(wgpu::MapMode::Read, .., |_| {});
        self.device.poll(wgpu::PollType::wait_indefinitely())?;
        Ok(buffer.get_mapped_range(..)?.to_vec())
    }
}

impl Boxes {
    pub(crate) fn new(graphics: &Graphics, camera: &Camera) -> Self {
        let clip_from_world = clip_from_world(camera);
        let mut uniforms = Vec::new();
        uniforms.extend(clip_from_world.to_cols_array());
        uniforms.extend(clip_from_world.inverse().to_cols_array());
        for (light, brightness) in lights().iter().zip([1.0, 30.0]) {
            let place = match light.position() {
                Some(position) => position.extend(1.0),
                None => light.direction_from(Vec3::ZERO).extend(0.0),
            };
            // Cosines of the cone's angles.
            let (axis, inner, outer) = match *light {
                Light::Spot {
                    direction,
                    inner,
                    outer,
                    ..
                } => (direction.normalize(), inner.cos(), outer.cos()),
                _ => (Vec3::ZERO, -1.0, -2.0),
            };
            uniforms.extend(place.to_array());
            uniforms.extend(axis.extend(brightness).to_array());
            uniforms.extend([inner, outer, 0.0, 0.0]);
        }
        let uniforms = graphics.buffer(wgpu::BufferUsages::UNIFORM, &uniforms);
        let layout = graphics.layout(&[wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        }]);
        let vertices = box_vertices();
        Self {
            vertex_count: vertices.len() as u32,
            vertices: graphics.buffer(wgpu::BufferUsages::VERTEX, vertices.as_flattened()),
            instances: graphics.buffer(wgpu::BufferUsages::VERTEX, &[0.0; 12 * BOXES]),
            group: graphics.group(&layout, &[uniforms.as_entire_binding()]),
            layout,
        }
    }

    /// Moves what is drawn.
    pub(crate) fn place(&self, graphics: &Graphics, placements: &[Affine3A]) {
        let columns: Vec<[f32; 12]> = placements.iter().map(Affine3A::to_cols_array).collect();
        graphics
            .queue
            .write_buffer(&self.instances, 0, bytemuck::cast_slice(&columns));
    }

    /// Draws all boxes.
    pub(crate) fn draw(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_bind_group(0, &self.group, &[]);
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.set_vertex_buffer(1, self.instances.slice(..));
        pass.draw(0..self.vertex_count, 0..BOXES as u32);
    }
}

/// Position and normal of the corners of a box from -1 to 1.
fn box_vertices() -> Vec<[f32; 6]> {
    let mut out = Vec::new();
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let normal = Vec3::AXES[axis] * side;
            let u = Vec3::AXES[(axis + 1) % 3] * side;
            let v = Vec3::AXES[(axis + 2) % 3];
            for (along_u, along_v) in [
                (-1.0, -1.0),
                (1.0, -1.0),
                (1.0, 1.0),
                (-1.0, -1.0),
                (1.0, 1.0),
                (-1.0, 1.0),
            ] {
                let p = normal + u * along_u + v * along_v;
                out.push([p.x, p.y, p.z, normal.x, normal.y, normal.z]);
            }
        }
    }
    out
}

pub(crate) fn color_attachment(
    view: &wgpu::TextureView,
) -> Option<wgpu::RenderPassColorAttachment<'_>> {
    Some(wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations {
            load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
            store: wgpu::StoreOp::Store,
        },
    })
}

pub(crate) fn depth_attachment(
    view: &wgpu::TextureView,
) -> Option<wgpu::RenderPassDepthStencilAttachment<'_>> {
    Some(wgpu::RenderPassDepthStencilAttachment {
        view,
        depth_ops: Some(wgpu::Operations {
            load: wgpu::LoadOp::Clear(1.0),
            store: wgpu::StoreOp::Store,
        }),
        stencil_ops: None,
    })
}

/// Writes the picture, and says so.
pub(crate) fn save(file: &str, pixels: &[u8]) -> Result<()> {
    image::save_buffer(file, pixels, SIZE.x, SIZE.y, image::ColorType::Rgba8)
        .with_context(|| format!("can't write `{file}`"))?;
    println!("{file}, {} x {}", SIZE.x, SIZE.y);
    Ok(())
}
