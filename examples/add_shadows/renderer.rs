//! A small wgpu renderer without shadows: device, scene of boxes, pipelines, and image file. The
//! programs that add shadows share it.

use anyhow::{Context as _, Result};
use std::sync::Arc;
use umbrage::{
    Camera, Light, ShadowTechnique,
    glam::{Affine3A, Mat4, Quat, UVec2, Vec3},
    gpu::wgpu::{self, util::DeviceExt as _},
    techniques::TechniquePreset,
};

/// Format of displayed images.
pub const COLOR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;
/// Format of the camera's depth.
pub const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// Format of normals. Any float or normalised format works.
pub const NORMAL: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
/// Bytes of a vertex: a position and a normal.
pub const VERTEX_BYTES: u64 = 24;

/// Bytes of an instance: three columns and a translation.
const INSTANCE_BYTES: u64 = 48;

/// The vertex buffers of the boxes: vertices and instances.
pub const BOX_BUFFERS: [Option<wgpu::VertexBufferLayout<'static>>; 2] = [
    Some(wgpu::VertexBufferLayout {
        array_stride: VERTEX_BYTES,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3],
    }),
    Some(wgpu::VertexBufferLayout {
        array_stride: INSTANCE_BYTES,
        step_mode: wgpu::VertexStepMode::Instance,
        attributes: &wgpu::vertex_attr_array![2 => Float32x4, 3 => Float32x4, 4 => Float32x4],
    }),
];

/// A uniform buffer.
pub const UNIFORMS: wgpu::BindingType = wgpu::BindingType::Buffer {
    ty: wgpu::BufferBindingType::Uniform,
    has_dynamic_offset: false,
    min_binding_size: None,
};

/// A texture of floats that is read without a sampler.
pub const fn floats(view_dimension: wgpu::TextureViewDimension) -> wgpu::BindingType {
    wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: false },
        view_dimension,
        multisampled: false,
    }
}

/// A floor with a square of boxes on it, under some lights.
pub struct BoxScene {
    /// The camera. Its size is that of the image.
    pub camera: Camera,
    /// The lights, at least one. Shaders index them in this order.
    pub lights: Vec<Light>,
    /// Number of boxes along each side of the square.
    boxes_per_side: usize,
    /// Distance between boxes, metres.
    spacing: f32,
    /// Half of a box's width, metres.
    half_width: f32,
    /// Half of the lowest box's height, and the increment for each of four higher ones, metres.
    half_heights: [f32; 2],
}

impl BoxScene {
    /// Returns 25 boxes under a sun and a spot, 640x400 pixels.
    pub fn small() -> Result<Self> {
        let sun = Light::Directional {
            direction: Vec3::new(-0.6, -1.0, 0.5),
            angular_diameter: 0.0,
        };
        let spot = Light::Spot {
            position: Vec3::new(3.0, 6.0, 5.0),
            direction: Vec3::new(-0.5, -1.0, -0.8),
            inner: 0.5,
            outer: 0.7,
            radius: 0.0,
        };
        Ok(Self {
            camera: camera(Vec3::new(6.0, 7.0, 12.0), UVec2::new(640, 400))?,
            lights: vec![sun, spot],
            boxes_per_side: 5,
            spacing: 3.0,
            half_width: 0.5,
            half_heights: [0.6, 0.2],
        })
    }

    /// Returns 10,000 boxes under the lights of [`BoxScene::large`].
    pub fn crowded_scene() -> Result<Self> {
        Ok(Self {
            boxes_per_side: 100,
            spacing: 0.4,
            half_width: 0.1,
            half_heights: [0.1, 0.0],
            ..Self::large()?
        })
    }

    /// Returns 64 boxes under the lights of [`BoxScene::large`] and two more: a spot and a point
    /// light.
    pub fn corner() -> Result<Self> {
        let mut scene = Self {
            boxes_per_side: 8,
            ..Self::large()?
        };
        scene.lights.push(Light::Spot {
            position: Vec3::new(4.0, 7.0, -8.0),
            direction: Vec3::new(-0.2, -1.0, 0.3),
            inner: 0.5,
            outer: 0.6,
            radius: 0.0,
        });
        scene.lights.push(Light::Point {
            position: Vec3::new(-2.0, 5.0, 1.0),
            radius: 0.0,
        });
        Ok(scene)
    }

    /// Returns 225 boxes under a sun and three spots, 1280x720 pixels.
    pub fn large() -> Result<Self> {
        let mut lights = vec![Light::Directional {
            direction: Vec3::new(0.5, -1.0, 0.3),
            angular_diameter: 0.0,
        }];
        for [x, z] in [[-9.0, -6.0], [9.0, -4.0], [0.0, 9.0]] {
            lights.push(Light::Spot {
                position: Vec3::new(x, 9.0, z),
                direction: Vec3::new(-0.3 * x, -9.0, -0.3 * z),
                inner: 0.5,
                outer: 0.6,
                radius: 0.0,
            });
        }
        Ok(Self {
            camera: camera(Vec3::new(9.0, 11.0, 17.0), UVec2::new(1280, 720))?,
            lights,
            boxes_per_side: 15,
            spacing: 2.2,
            half_width: 0.4,
            half_heights: [0.4, 0.35],
        })
    }

    /// Returns the placements after some seconds: the floor, then the boxes, which turn.
    pub fn placements(&self, seconds: f32) -> Vec<Affine3A> {
        let side = self.boxes_per_side;
        let floor = 0.6 * side as f32 * self.spacing;
        let mut out = vec![Affine3A::from_scale_rotation_translation(
            Vec3::new(floor, 0.1, floor),
            Quat::IDENTITY,
            Vec3::new(0.0, -0.1, 0.0),
        )];
        let middle = (side / 2) as f32;
        for i in 0..side * side {
            let x = self.spacing * ((i % side) as f32 - middle);
            let z = self.spacing * ((i / side) as f32 - middle);
            let half_height = self.half_heights[0] + self.half_heights[1] * ((i * 7) % 5) as f32;
            out.push(Affine3A::from_scale_rotation_translation(
                Vec3::new(self.half_width, half_height, self.half_width),
                Quat::from_rotation_y(seconds + i as f32),
                Vec3::new(x, half_height, z),
            ));
        }
        out
    }

    /// Returns the matrix from world to clip space.
    pub fn clip_from_world(&self) -> Mat4 {
        self.camera.clip_from_view * Mat4::from(self.camera.world_from_view.inverse())
    }

    /// Returns the part of all shaders that declares the scene.
    pub fn wgsl(&self) -> String {
        let count = self.lights.len();
        format!("const LAMPS = {count}u;\n{}", include_str!("scene.wgsl"))
    }
}

fn camera(eye: Vec3, size: UVec2) -> Result<Camera> {
    let depth_range = [0.1, 100.0];
    Ok(Camera::perspective(
        eye,
        Vec3::ZERO,
        Vec3::Y,
        0.9,
        depth_range,
        size,
    )?)
}

/// A device for the program alone.
pub struct Graphics {
    /// The device.
    pub device: wgpu::Device,
    /// The queue.
    pub queue: wgpu::Queue,
}

/// The scene's buffers.
pub struct Boxes {
    /// The scene.
    pub scene: BoxScene,
    /// A box from -1 to 1, three vertices for each triangle.
    pub vertices: wgpu::Buffer,
    /// Number of vertices of the box.
    pub vertex_count: u32,
    /// Placements of the boxes, 48 bytes each.
    pub instances: wgpu::Buffer,
    /// Layout of `group`.
    pub layout: wgpu::BindGroupLayout,
    /// Bind group 0 of all shaders: the scene's uniforms.
    pub group: wgpu::BindGroup,
}

impl Graphics {
    /// Opens the default adapter with the default limits.
    pub fn open() -> Result<Self> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let options = wgpu::RequestAdapterOptions::default();
        let adapter = pollster::block_on(instance.request_adapter(&options))
            .context("no graphics adapter: install a Vulkan driver")?;
        let desc = wgpu::DeviceDescriptor::default();
        let (device, queue) = pollster::block_on(adapter.request_device(&desc))?;
        Ok(Self { device, queue })
    }

    /// Returns a command encoder.
    pub fn encoder(&self) -> wgpu::CommandEncoder {
        self.device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
    }

    /// Waits until all submitted work is done.
    pub fn wait(&self) -> Result<()> {
        self.device.poll(wgpu::PollType::wait_indefinitely())?;
        Ok(())
    }

    /// Returns a buffer with these bytes, which can be rewritten.
    pub fn buffer(&self, usage: wgpu::BufferUsages, contents: &[u8]) -> wgpu::Buffer {
        let desc = wgpu::util::BufferInitDescriptor {
            label: None,
            contents,
            usage: usage | wgpu::BufferUsages::COPY_DST,
        };
        self.device.create_buffer_init(&desc)
    }

    /// Returns a texture to draw into, to read in shaders and to copy.
    pub fn target(&self, size: UVec2, format: wgpu::TextureFormat) -> wgpu::TextureView {
        self.target_array(size, 1, format)
            .create_view(&wgpu::TextureViewDescriptor::default())
    }

    /// Returns a texture like that of [`Graphics::target`] with several layers.
    pub fn target_array(
        &self,
        size: UVec2,
        layers: u32,
        format: wgpu::TextureFormat,
    ) -> wgpu::Texture {
        self.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d {
                width: size.x,
                height: size.y,
                depth_or_array_layers: layers,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        })
    }

    /// Returns the layout of a bind group with these types at the bindings 0, 1, ..
    pub fn layout(&self, types: &[wgpu::BindingType]) -> wgpu::BindGroupLayout {
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

    /// Returns a bind group with these resources at the bindings 0, 1, ..
    pub fn group(
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

    /// Returns a pipeline that draws the boxes, or else a full-screen triangle without a depth
    /// buffer.
    pub fn pipeline(
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
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: None,
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some(if draws_boxes { "surface" } else { "screen" }),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: if draws_boxes { &BOX_BUFFERS } else { &[] },
            },
            primitive: wgpu::PrimitiveState {
                cull_mode: draws_boxes.then_some(wgpu::Face::Back),
                ..wgpu::PrimitiveState::default()
            },
            depth_stencil: draws_boxes.then(depth_state),
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

    /// Submits the encoder, and returns the pixels of the image, four bytes each.
    pub fn read(
        &self,
        mut encoder: wgpu::CommandEncoder,
        picture: &wgpu::TextureView,
    ) -> Result<Vec<u8>> {
        let texture = picture.texture();
        // Rows of 640 or 1280 pixels are multiples of 256 bytes, which copies require.
        let row = 4 * texture.width();
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: u64::from(row * texture.height()),
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
        encoder.copy_texture_to_buffer(texture.as_image_copy(), destination, texture.size());
        self.queue.submit([encoder.finish()]);
        buffer.map_async(wgpu::MapMode::Read, .., |_| {});
        self.wait()?;
        Ok(buffer.get_mapped_range(..)?.to_vec())
    }
}

impl Boxes {
    /// Uploads a scene.
    pub fn new(graphics: &Graphics, scene: BoxScene) -> Self {
        let clip_from_world = scene.clip_from_world();
        let mut uniforms = Vec::new();
        uniforms.extend(clip_from_world.to_cols_array());
        uniforms.extend(clip_from_world.inverse().to_cols_array());
        for light in &scene.lights {
            let (place, brightness) = match light.position() {
                Some(position) => (position.extend(1.0), 30.0),
                None => (light.direction_from(Vec3::ZERO).extend(0.0), 1.0),
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
        let uniforms = bytemuck::cast_slice(&uniforms);
        let uniforms = graphics.buffer(wgpu::BufferUsages::UNIFORM, uniforms);
        let layout = graphics.layout(&[UNIFORMS]);
        let vertices = box_vertices();
        let instances = columns(&scene.placements(0.0));
        let buffer = |contents| graphics.buffer(wgpu::BufferUsages::VERTEX, contents);
        Self {
            scene,
            vertex_count: vertices.len() as u32,
            vertices: buffer(bytemuck::cast_slice(&vertices)),
            instances: buffer(bytemuck::cast_slice(&instances)),
            group: graphics.group(&layout, &[uniforms.as_entire_binding()]),
            layout,
        }
    }

    /// Sets the placements of the boxes.
    pub fn place(&self, graphics: &Graphics, placements: &[Affine3A]) {
        let columns = columns(placements);
        let bytes = bytemuck::cast_slice(&columns);
        graphics.queue.write_buffer(&self.instances, 0, bytes);
    }

    /// Draws all boxes with the scene's bind group.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>) {
        self.draw_with(pass, &self.group);
    }

    /// Draws all boxes with another bind group 0.
    pub fn draw_with(&self, pass: &mut wgpu::RenderPass<'_>, group: &wgpu::BindGroup) {
        pass.set_bind_group(0, group, &[]);
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.set_vertex_buffer(1, self.instances.slice(..));
        let instances = self.instances.size() / INSTANCE_BYTES;
        pass.draw(0..self.vertex_count, 0..instances as u32);
    }
}

/// Returns placements in the layout of vertex buffers.
fn columns(placements: &[Affine3A]) -> Vec<[f32; 12]> {
    placements.iter().map(Affine3A::to_cols_array).collect()
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

/// Returns the state of a depth buffer that keeps the nearest surface.
pub fn depth_state() -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format: DEPTH,
        depth_write_enabled: Some(true),
        depth_compare: Some(wgpu::CompareFunction::Less),
        stencil: wgpu::StencilState::default(),
        bias: wgpu::DepthBiasState::default(),
    }
}

/// Returns a colour attachment that is cleared to black.
pub fn color_attachment(view: &wgpu::TextureView) -> Option<wgpu::RenderPassColorAttachment<'_>> {
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

/// Returns a depth attachment that is cleared to the far plane.
pub fn depth_attachment(
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

/// Returns the technique in the preset file that the program's first argument names, if there is
/// one.
pub fn technique_by_argument() -> Result<Option<Arc<dyn ShadowTechnique>>> {
    let Some(file) = std::env::args().nth(1) else {
        return Ok(None);
    };
    let text = std::fs::read_to_string(&file).with_context(|| format!("can't read `{file}`"))?;
    let preset = TechniquePreset::from_toml(&text).with_context(|| format!("in `{file}`"))?;
    Ok(Some(preset.technique()))
}

/// Writes an image of a scene and reports it.
pub fn save(file: &str, pixels: &[u8], scene: &BoxScene, label: &str) -> Result<()> {
    let size = scene.camera.size;
    image::save_buffer(file, pixels, size.x, size.y, image::ColorType::Rgba8)
        .with_context(|| format!("can't write `{file}`"))?;
    println!("{file}, {} x {}, {label}", size.x, size.y);
    Ok(())
}
