//! The scene, the device, and the renderer that asks a light set.

use super::deferred::{MaskShading, Picture};
use anyhow::Result;
use std::sync::Arc;
use umbrage::{
    Aabb, Camera, Light, ShadowTechnique,
    glam::{Affine3A, Mat4, Quat, UVec2, Vec3, Vec4},
    techniques::{Bias, Hard, MapFilter as _, Pcf, ShadowMap},
    wgpu::{
        AdapterChoice, CasterId, CasterMesh, Gpu, LightId, LightSet, LightSetOptions,
        PositionFormat, SetFrame, SetLight, StillLayers, VertexLayout,
        wgpu::{self, util::DeviceExt as _},
    },
};

/// Size of the picture, pixels.
pub(crate) const SIZE: UVec2 = UVec2::new(1280, 720);
/// Side of the maps, texels.
pub(crate) const MAP: u32 = 1024;
/// How many lights there are.
pub(crate) const LIGHTS: usize = 4;
/// Boxes along each side of the floor.
const BOXES: i32 = 15;
pub(crate) const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
pub(crate) const COLOR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;

/// A placement as three columns and a translation.
pub(crate) type Columns = [f32; 12];

/// A device of the program's own.
pub(crate) struct Device {
    pub(crate) name: String,
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
}

impl Device {
    /// Opens the device of an adapter, with all that the adapter can hold: lists of many triangles are long.
    pub(crate) fn open(choice: &AdapterChoice) -> Result<Self> {
        let gpu = Gpu::new(choice)?;
        let (device, queue) = gpu.device();
        Ok(Self {
            name: gpu.adapter_info().name,
            device: device.clone(),
            queue: queue.clone(),
        })
    }

    pub(crate) fn buffer(&self, usage: wgpu::BufferUsages, contents: &[u8]) -> wgpu::Buffer {
        let usage = usage | wgpu::BufferUsages::COPY_DST;
        let desc = wgpu::util::BufferInitDescriptor {
            label: None,
            contents,
            usage,
        };
        self.device.create_buffer_init(&desc)
    }

    /// Returns a texture with these texels, to be read.
    pub(crate) fn upload(
        &self,
        size: UVec2,
        format: wgpu::TextureFormat,
        texels: &[u8],
    ) -> wgpu::TextureView {
        let desc = wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d {
                width: size.x,
                height: size.y,
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        };
        let order = wgpu::util::TextureDataOrder::LayerMajor;
        let texture = self
            .device
            .create_texture_with_data(&self.queue, &desc, order, texels);
        texture.create_view(&wgpu::TextureViewDescriptor::default())
    }

    pub(crate) fn shader(&self, text: String) -> wgpu::ShaderModule {
        self.device
            .create_shader_module(wgpu::ShaderModuleDescriptor {
                label: None,
                source: wgpu::ShaderSource::Wgsl(text.into()),
            })
    }

    /// Waits until all that was submitted is done.
    pub(crate) fn wait(&self) -> Result<()> {
        self.device.poll(wgpu::PollType::wait_indefinitely())?;
        Ok(())
    }
}

/// One comparison with a constant bias.
pub(crate) fn hard() -> Arc<dyn ShadowTechnique> {
    Arc::new(Hard {}.on(map()))
}

/// 3x3 comparisons with a constant bias.
pub(crate) fn pcf() -> Arc<dyn ShadowTechnique> {
    Arc::new(Pcf { radius: 1 }.on(map()))
}

fn map() -> ShadowMap {
    ShadowMap {
        size: MAP,
        bias: Bias {
            constant: 0.002,
            ..Bias::NONE
        },
        ..ShadowMap::default()
    }
}

/// A sun and three spots.
pub(crate) fn lights() -> [Light; LIGHTS] {
    let spot = |x: f32, z: f32| Light::Spot {
        position: Vec3::new(x, 9.0, z),
        direction: Vec3::new(-0.3 * x, -9.0, -0.3 * z),
        inner: 0.5,
        outer: 0.6,
        radius: 0.0,
    };
    [
        Light::Directional {
            direction: Vec3::new(0.5, -1.0, 0.3),
            angular_diameter: 0.0,
        },
        spot(-9.0, -6.0),
        spot(9.0, -4.0),
        spot(0.0, 9.0),
    ]
}

/// Where the boxes stand at a time; the first caster is the floor.
pub(crate) fn placements(time: f32) -> Vec<Affine3A> {
    let floor = Affine3A::from_scale_rotation_translation(
        Vec3::new(20.0, 0.1, 20.0),
        Quat::IDENTITY,
        Vec3::new(0.0, -0.1, 0.0),
    );
    let mut out = vec![floor];
    for i in 0..BOXES * BOXES {
        let x = (i % BOXES - BOXES / 2) as f32 * 2.2;
        let z = (i / BOXES - BOXES / 2) as f32 * 2.2;
        let height = 0.4 + 0.35 * ((i * 7) % 5) as f32;
        let turn = time + i as f32;
        out.push(Affine3A::from_scale_rotation_translation(
            Vec3::new(0.4, height, 0.4),
            Quat::from_rotation_y(turn),
            Vec3::new(x, height, z),
        ));
    }
    out
}

/// The corners of a box from -1 to 1, as triangles: position and normal.
pub(crate) fn box_vertices() -> Vec<[f32; 6]> {
    let mut out = Vec::new();
    for axis in 0..3 {
        for side in [-1.0_f32, 1.0] {
            let mut normal = Vec3::ZERO;
            normal[axis] = side;
            let u = Vec3::AXES[(axis + 1) % 3] * side;
            let v = Vec3::AXES[(axis + 2) % 3];
            let corner = |a: f32, b: f32| normal + u * a + v * b;
            let corners = [
                corner(-1.0, -1.0),
                corner(1.0, -1.0),
                corner(1.0, 1.0),
                corner(-1.0, 1.0),
            ];
            for i in [0, 1, 2, 0, 2, 3] {
                let p = corners[i];
                out.push([p.x, p.y, p.z, normal.x, normal.y, normal.z]);
            }
        }
    }
    out
}

pub(crate) fn camera() -> Result<Camera> {
    let eye = Vec3::new(9.0, 11.0, 17.0);
    Ok(Camera::perspective(
        eye,
        Vec3::ZERO,
        Vec3::Y,
        0.9,
        [0.1, 100.0],
        SIZE,
    )?)
}

/// What both renderers share: the scene's buffers, its uniforms, and the picture.
pub(crate) struct Shared {
    pub(crate) vertices: wgpu::Buffer,
    pub(crate) vertex_count: u32,
    pub(crate) instances: wgpu::Buffer,
    pub(crate) scene_group: wgpu::BindGroup,
    pub(crate) scene_layout: wgpu::BindGroupLayout,
    pub(crate) color: wgpu::Texture,
    pub(crate) color_view: wgpu::TextureView,
    pub(crate) depth_view: wgpu::TextureView,
    pub(crate) camera: Camera,
}

impl Shared {
    pub(crate) fn new(d: &Device) -> Result<Self> {
        let vertices = box_vertices();
        let camera = camera()?;
        let mut uniforms: Vec<f32> = Vec::new();
        let clip_from_world: Mat4 = camera.space().clip_from_world();
        uniforms.extend(clip_from_world.to_cols_array());
        let colors = [
            [0.9, 0.85, 0.7],
            [0.9, 0.2, 0.1],
            [0.1, 0.3, 0.9],
            [0.2, 0.8, 0.3],
        ];
        for (light, color) in lights().iter().zip(colors) {
            let place: Vec4 = match light.position() {
                Some(position) => position.extend(1.0),
                None => light.direction_from(Vec3::ZERO).extend(0.0),
            };
            uniforms.extend(place.to_array());
            uniforms.extend(color);
            uniforms.push(0.0);
        }
        let scene = d.buffer(wgpu::BufferUsages::UNIFORM, bytemuck::cast_slice(&uniforms));
        let scene_layout = d
            .device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: None,
                entries: &[uniform_entry(0, false)],
            });
        let scene_group = d.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &scene_layout,
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: scene.as_entire_binding(),
            }],
        });
        let instances: Vec<Columns> = columns(&placements(0.0));
        let picture = |format, usage| {
            d.device.create_texture(&wgpu::TextureDescriptor {
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
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | usage,
                view_formats: &[],
            })
        };
        let color = picture(COLOR, wgpu::TextureUsages::COPY_SRC);
        let depth = picture(DEPTH, wgpu::TextureUsages::empty());
        Ok(Self {
            vertex_count: vertices.len() as u32,
            vertices: d.buffer(wgpu::BufferUsages::VERTEX, bytemuck::cast_slice(&vertices)),
            instances: d.buffer(wgpu::BufferUsages::VERTEX, bytemuck::cast_slice(&instances)),
            scene_group,
            scene_layout,
            color_view: color.create_view(&wgpu::TextureViewDescriptor::default()),
            color,
            depth_view: depth.create_view(&wgpu::TextureViewDescriptor::default()),
            camera,
        })
    }

    /// Returns the pipeline that draws the picture with a shader that has `lit`.
    pub(crate) fn pipeline(
        &self,
        d: &Device,
        lit: &str,
        shadows: &wgpu::BindGroupLayout,
    ) -> wgpu::RenderPipeline {
        let text = format!("{lit}{}", include_str!("scene.wgsl"));
        let groups = [Some(&self.scene_layout), Some(shadows)];
        scene_pipeline(d, text, &groups, "shade", COLOR)
    }

    /// Records the picture's pass.
    pub(crate) fn draw(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        pipeline: &wgpu::RenderPipeline,
        shadows: &wgpu::BindGroup,
    ) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.color_view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(depth_attachment(&self.depth_view)),
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_pipeline(pipeline);
        pass.set_bind_group(1, shadows, &[]);
        self.draw_boxes(&mut pass);
    }

    /// Draws the boxes as the camera sees them, with the pipeline that is set.
    pub(crate) fn draw_boxes(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_bind_group(0, &self.scene_group, &[]);
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.set_vertex_buffer(1, self.instances.slice(..));
        pass.draw(0..self.vertex_count, 0..(BOXES * BOXES + 1) as u32);
    }

    /// Moves the boxes.
    pub(crate) fn place(&self, d: &Device, placements: &[Affine3A]) {
        let instances = columns(placements);
        d.queue
            .write_buffer(&self.instances, 0, bytemuck::cast_slice(&instances));
    }
}

pub(crate) const VERTICES: wgpu::VertexBufferLayout<'static> = wgpu::VertexBufferLayout {
    array_stride: 24,
    step_mode: wgpu::VertexStepMode::Vertex,
    attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3],
};

pub(crate) const INSTANCES: wgpu::VertexBufferLayout<'static> = wgpu::VertexBufferLayout {
    array_stride: 48,
    step_mode: wgpu::VertexStepMode::Instance,
    attributes: &wgpu::vertex_attr_array![2 => Float32x4, 3 => Float32x4, 4 => Float32x4],
};

pub(crate) fn columns(placements: &[Affine3A]) -> Vec<Columns> {
    placements.iter().map(Affine3A::to_cols_array).collect()
}

pub(crate) fn uniform_entry(binding: u32, dynamic: bool) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: dynamic,
            min_binding_size: None,
        },
        count: None,
    }
}

pub(crate) fn depth_state() -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format: DEPTH,
        depth_write_enabled: Some(true),
        depth_compare: Some(wgpu::CompareFunction::Less),
        stencil: wgpu::StencilState::default(),
        bias: wgpu::DepthBiasState::default(),
    }
}

pub(crate) fn depth_attachment(
    view: &wgpu::TextureView,
) -> wgpu::RenderPassDepthStencilAttachment<'_> {
    wgpu::RenderPassDepthStencilAttachment {
        view,
        depth_ops: Some(wgpu::Operations {
            load: wgpu::LoadOp::Clear(1.0),
            store: wgpu::StoreOp::Store,
        }),
        stencil_ops: None,
    }
}

/// The renderer that asks a light set.
pub(crate) struct Stage {
    pub(crate) shared: Shared,
    pub(crate) set: LightSet,
    casters: Vec<CasterId>,
    ids: Vec<LightId>,
    pipeline: Option<(u64, wgpu::RenderPipeline)>,
    masks: MaskShading,
}

impl Stage {
    pub(crate) fn new(d: &Device, technique: Arc<dyn ShadowTechnique>) -> Result<Self> {
        let shared = Shared::new(d)?;
        let options = LightSetOptions {
            group: 1,
            still_layers: StillLayers::Auto,
            ..LightSetOptions::default()
        };
        let mut set = LightSet::new(&d.device, options)?;
        let mesh = set.add_mesh(&CasterMesh {
            label: "box",
            vertices: &shared.vertices,
            layout: VertexLayout {
                format: PositionFormat::Float32x3,
                stride: 24,
                position_offset: 0,
            },
            indices: None,
            range: 0..shared.vertex_count,
            base_vertex: 0,
            bounds: Aabb {
                min: Vec3::NEG_ONE,
                max: Vec3::ONE,
            },
        })?;
        let mut casters = Vec::new();
        for place in placements(0.0) {
            casters.push(set.add_caster(mesh, place)?);
        }
        let mut ids = Vec::new();
        for light in lights() {
            ids.push(set.add_light(SetLight {
                light,
                technique: technique.clone(),
                priority: 1.0,
            })?);
        }
        Ok(Self {
            shared,
            set,
            casters,
            ids,
            pipeline: None,
            masks: MaskShading::default(),
        })
    }

    /// Moves all casters to where they are at a time, and draws a frame.
    pub(crate) fn frame(&mut self, d: &Device, time: f32, picture: Picture<'_>) -> Result<()> {
        let placements = placements(time);
        for (&caster, &place) in self.casters.iter().zip(&placements) {
            self.set.move_caster(caster, place)?;
        }
        self.shared.place(d, &placements);
        self.still_frame(d, picture)
    }

    /// Draws a frame in which nothing moved.
    pub(crate) fn still_frame(&mut self, d: &Device, picture: Picture<'_>) -> Result<()> {
        let frame = SetFrame {
            camera: &self.shared.camera,
            geometry: None,
        };
        self.set.prepare(&d.device, &d.queue, &frame)?;
        let mut encoder = d
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.set.encode(&mut encoder)?;
        match picture {
            Picture::Masks(gbuffer) => {
                gbuffer.draw(&mut encoder, &self.shared);
                let inputs = gbuffer.mask_inputs(&self.shared.camera, &self.ids);
                self.set.prepare_masks(&d.queue, &inputs)?;
                let masks = self.set.encode_masks(&mut encoder)?;
                self.masks
                    .shade(d, &mut encoder, gbuffer, &self.shared, masks);
            }
            Picture::Forward | Picture::Deferred(_) => self.draw(d, &mut encoder, picture)?,
        }
        d.queue.submit([encoder.finish()]);
        Ok(())
    }

    /// Draws the picture with a shader that asks the set.
    fn draw(
        &mut self,
        d: &Device,
        encoder: &mut wgpu::CommandEncoder,
        picture: Picture<'_>,
    ) -> Result<()> {
        let (group, layout) = self.set.bind_group()?;
        let revision = self.set.wgsl_revision();
        let pipeline = match self.pipeline.take() {
            Some((made_for, pipeline)) if made_for == revision => pipeline,
            _ => {
                let lit = format!("{}{}", self.set.wgsl(), include_str!("by_set.wgsl"));
                picture.pipeline(d, &self.shared, &lit, layout)
            }
        };
        picture.draw(encoder, &self.shared, &pipeline, group);
        self.pipeline = Some((revision, pipeline));
        Ok(())
    }

    /// Returns the picture, four bytes a pixel.
    pub(crate) fn read(&self, d: &Device) -> Result<Vec<u8>> {
        read(d, &self.shared.color)
    }
}

/// Returns a picture's bytes. Rows of 1280 pixels are multiples of 256 bytes, as copies ask.
pub(crate) fn read(d: &Device, color: &wgpu::Texture) -> Result<Vec<u8>> {
    let row = 4 * SIZE.x;
    let buffer = d.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(row * SIZE.y),
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = d
        .device
        .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let destination = wgpu::TexelCopyBufferInfo {
        buffer: &buffer,
        layout: wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(row),
            rows_per_image: None,
        },
    };
    encoder.copy_texture_to_buffer(color.as_image_copy(), destination, color.size());
    d.queue.submit([encoder.finish()]);
    buffer.map_async(wgpu::MapMode::Read, .., |_| {});
    d.wait()?;
    Ok(buffer.get_mapped_range(..)?.to_vec())
}

/// Returns a pipeline that draws the scene's triangles, by a shader that has `surface` for vertices and this fragment shader.
pub(crate) fn scene_pipeline(
    d: &Device,
    text: String,
    groups: &[Option<&wgpu::BindGroupLayout>],
    fragment: &str,
    target: wgpu::TextureFormat,
) -> wgpu::RenderPipeline {
    let module = d.shader(text);
    let layout = d
        .device
        .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            bind_group_layouts: groups,
            ..wgpu::PipelineLayoutDescriptor::default()
        });
    d.device
        .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: None,
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("surface"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[Some(VERTICES), Some(INSTANCES)],
            },
            primitive: wgpu::PrimitiveState {
                cull_mode: Some(wgpu::Face::Back),
                ..wgpu::PrimitiveState::default()
            },
            depth_stencil: Some(depth_state()),
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some(fragment),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(target.into())],
            }),
            multiview_mask: None,
            cache: None,
        })
}

/// Returns a view of each layer of an array.
pub(crate) fn layer_views(array: &wgpu::Texture) -> Vec<wgpu::TextureView> {
    let view = |layer| {
        array.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2),
            base_array_layer: layer,
            array_layer_count: Some(1),
            ..wgpu::TextureViewDescriptor::default()
        })
    };
    (0..array.depth_or_array_layers()).map(view).collect()
}
