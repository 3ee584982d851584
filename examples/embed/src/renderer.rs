//! The program's renderer: draws the scene forward, or deferred with a G-buffer of its own. `set` is the light set.

use crate::{
    meshes::Meshes,
    pipelines::{self, DEPTH, Placed, color_attachment, depth_attachment, group, texture},
    scene::{self, MAX_LAMPS, Object},
    settings::Settings,
    shadows::{self, SceneShadows},
};
use anyhow::{Context as _, Result};
use std::{
    ops::Range,
    time::{Duration, Instant},
};
use umbrage::{
    Camera, Light,
    glam::{Affine3A, Mat4, UVec2, Vec3},
    wgpu::{DepthBuffer, MaskFormat, MaskInputs, NormalCoding, SetFrame, SetNormals, SetReceivers},
};
use wgpu::util::DeviceExt as _;

const ALBEDO: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;
const NORMAL: wgpu::TextureFormat = wgpu::TextureFormat::Rgb10a2Unorm;

/// How long parts of a frame took on the CPU.
#[derive(Clone, Copy, Default)]
pub struct Times {
    pub prepare: Duration,
    pub encode: Duration,
}

pub struct Renderer {
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    pub shadows: SceneShadows,
    meshes: Meshes,
    objects: Vec<Object>,
    /// For each shape, its objects.
    draws: Vec<Range<u32>>,
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    instances: wgpu::Buffer,
    uniforms: wgpu::Buffer,
    scene_layout: wgpu::BindGroupLayout,
    scene_group: wgpu::BindGroup,
    color_format: wgpu::TextureFormat,
    sky: wgpu::RenderPipeline,
    /// Made for this revision of the set's WGSL.
    forward: Option<(u64, wgpu::RenderPipeline)>,
    gbuffer: wgpu::RenderPipeline,
    lighting: wgpu::RenderPipeline,
    lighting_layout: wgpu::BindGroupLayout,
    targets: Option<Targets>,
}

/// What is as large as the picture.
struct Targets {
    size: UVec2,
    depth: wgpu::TextureView,
    albedo: wgpu::TextureView,
    normal: wgpu::TextureView,
}

impl Renderer {
    /// Draws into targets of a format.
    pub fn new(
        device: wgpu::Device,
        queue: wgpu::Queue,
        color_format: wgpu::TextureFormat,
        settings: &Settings,
    ) -> Result<Self> {
        let meshes = Meshes::new();
        let objects = scene::objects();
        let buffer = |usage, contents: &[u8]| {
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: None,
                contents,
                usage: usage | wgpu::BufferUsages::COPY_DST,
            })
        };
        let vertices = buffer(
            wgpu::BufferUsages::VERTEX,
            bytemuck::cast_slice(&meshes.vertices),
        );
        let indices = buffer(
            wgpu::BufferUsages::INDEX,
            bytemuck::cast_slice(&meshes.indices),
        );
        let instances = buffer(
            wgpu::BufferUsages::VERTEX,
            bytemuck::cast_slice(&instances(&objects, 0.0)),
        );
        let shadows = SceneShadows::new(&device, &meshes, &vertices, &indices, &objects, settings)?;
        let uniforms = buffer(
            wgpu::BufferUsages::UNIFORM,
            bytemuck::cast_slice(&[0.0_f32; UNIFORM_FLOATS]),
        );
        let scene_layout = pipelines::scene_layout(&device);
        let lighting_layout = pipelines::gbuffer_layout(&device);
        let scene_group = group(&device, &scene_layout, [uniforms.as_entire_binding()]);
        let sky = pipelines::sky(&device, &scene_layout, color_format);
        let gbuffer = pipelines::gbuffer(&device, &scene_layout, &[ALBEDO, NORMAL]);
        let lighting = pipelines::lighting(&device, &scene_layout, &lighting_layout, color_format);
        let draws = (0..meshes.meshes.len())
            .map(|shape| {
                let before = |o: &&Object| (o.shape as usize) < shape;
                let first = objects.iter().filter(before).count();
                let is_it = |o: &&Object| o.shape as usize == shape;
                let count = objects.iter().filter(is_it).count();
                first as u32..(first + count) as u32
            })
            .collect();
        Ok(Self {
            shadows,
            meshes,
            objects,
            draws,
            vertices,
            indices,
            instances,
            uniforms,
            scene_layout,
            scene_group,
            color_format,
            sky,
            forward: None,
            gbuffer,
            lighting,
            lighting_layout,
            targets: None,
            device,
            queue,
        })
    }

    /// Records a frame into the encoder: shadows, then the picture.
    pub fn frame(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        target: &wgpu::TextureView,
        camera: &Camera,
        settings: &Settings,
        seconds: f32,
    ) -> Result<Times> {
        self.shadows.apply(settings)?;
        self.shadows.place(&self.objects, seconds)?;
        let instances = instances(&self.objects, seconds);
        self.queue
            .write_buffer(&self.instances, 0, bytemuck::cast_slice(&instances));
        self.write_uniforms(camera);
        if self.targets.as_ref().is_none_or(|t| t.size != camera.size) {
            self.targets = Some(Targets::new(&self.device, camera.size));
        }
        let mut times = Times::default();
        let start = Instant::now();
        let frame = SetFrame {
            camera,
            geometry: None,
        };
        self.shadows
            .set
            .prepare(&self.device, &self.queue, &frame)?;
        times.prepare = start.elapsed();
        let start = Instant::now();
        self.shadows.set.encode(encoder)?;
        times.encode = start.elapsed();
        if settings.deferred {
            self.deferred(encoder, target, camera, &mut times)?;
        } else {
            self.forward(encoder, target)?;
        }
        Ok(times)
    }

    fn forward(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        target: &wgpu::TextureView,
    ) -> Result<()> {
        let set = &self.shadows.set;
        let (group, layout) = set.bind_group()?;
        let revision = set.wgsl_revision();
        let pipeline = match self.forward.take() {
            Some((made_for, pipeline)) if made_for == revision => pipeline,
            _ => pipelines::forward(
                &self.device,
                &self.scene_layout,
                set.wgsl(),
                layout,
                self.color_format,
            ),
        };
        let targets = self.targets.as_ref().context("the picture has no size")?;
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("forward"),
            color_attachments: &[color_attachment(target)],
            depth_stencil_attachment: depth_attachment(&targets.depth),
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_bind_group(0, &self.scene_group, &[]);
        pass.set_bind_group(shadows::GROUP, group, &[]);
        pass.set_pipeline(&pipeline);
        self.draw_surfaces(&mut pass);
        pass.set_pipeline(&self.sky);
        pass.draw(0..3, 0..1);
        drop(pass);
        self.forward = Some((revision, pipeline));
        Ok(())
    }

    fn deferred(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        target: &wgpu::TextureView,
        camera: &Camera,
        times: &mut Times,
    ) -> Result<()> {
        let targets = self.targets.as_ref().context("the picture has no size")?;
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("G-buffer"),
            color_attachments: &[
                color_attachment(&targets.albedo),
                color_attachment(&targets.normal),
            ],
            depth_stencil_attachment: depth_attachment(&targets.depth),
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_bind_group(0, &self.scene_group, &[]);
        pass.set_pipeline(&self.gbuffer);
        self.draw_surfaces(&mut pass);
        drop(pass);

        let start = Instant::now();
        let set = &mut self.shadows.set;
        let inputs = MaskInputs {
            size: targets.size,
            receivers: SetReceivers::Depth {
                depth: DepthBuffer {
                    depth: &targets.depth,
                    world_from_clip: clip_from_world(camera).inverse(),
                    empty: 0.0,
                },
                normals: Some(SetNormals {
                    texture: &targets.normal,
                    coding: NormalCoding::Halved,
                }),
            },
            lights: &self.shadows.lights,
            format: MaskFormat::Unorm8,
        };
        set.prepare_masks(&self.queue, &inputs)?;
        times.prepare += start.elapsed();
        let start = Instant::now();
        let masks = set.encode_masks(encoder)?;
        times.encode += start.elapsed();

        let group = group(
            &self.device,
            &self.lighting_layout,
            [&targets.depth, &targets.albedo, &targets.normal, masks]
                .map(wgpu::BindingResource::TextureView),
        );
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("lighting"),
            color_attachments: &[color_attachment(target)],
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_bind_group(0, &self.scene_group, &[]);
        pass.set_bind_group(1, &group, &[]);
        pass.set_pipeline(&self.lighting);
        pass.draw(0..3, 0..1);
        Ok(())
    }

    fn draw_surfaces(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.set_vertex_buffer(1, self.instances.slice(..));
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint16);
        for (mesh, objects) in self.meshes.meshes.iter().zip(&self.draws) {
            pass.draw_indexed(mesh.indices.clone(), mesh.base_vertex, objects.clone());
        }
    }

    fn write_uniforms(&self, camera: &Camera) {
        let clip_from_world = clip_from_world(camera);
        let lamps = &self.shadows.lamps;
        let sun = lamps[0].light.direction_from(Vec3::ZERO);
        let mut floats: Vec<f32> = Vec::new();
        floats.extend(clip_from_world.to_cols_array());
        floats.extend(clip_from_world.inverse().to_cols_array());
        floats.extend(camera.eye().extend(lamps.len() as f32).to_array());
        floats.extend(sun.extend(0.0).to_array());
        for lamp in lamps {
            let place = match lamp.light.position() {
                Some(position) => position.extend(1.0),
                None => lamp.light.direction_from(Vec3::ZERO).extend(0.0),
            };
            // Lights that shine every way have cones beyond all cosines.
            let (axis, inner, outer) = match lamp.light {
                Light::Spot {
                    direction,
                    inner,
                    outer,
                    ..
                } => (direction.normalize(), inner.cos(), outer.cos()),
                _ => (Vec3::ZERO, -2.0, -3.0),
            };
            floats.extend(place.to_array());
            floats.extend(axis.extend(outer).to_array());
            floats.extend(lamp.color.extend(lamp.range).to_array());
            floats.extend([inner, 0.0, 0.0, 0.0]);
        }
        self.queue
            .write_buffer(&self.uniforms, 0, bytemuck::cast_slice(&floats));
    }
}

/// Floats of the uniform `scene`.
const UNIFORM_FLOATS: usize = 2 * 16 + 2 * 4 + 16 * MAX_LAMPS;

fn clip_from_world(camera: &Camera) -> Mat4 {
    camera.clip_from_view * Mat4::from(camera.world_from_view.inverse())
}

fn instances(objects: &[Object], seconds: f32) -> Vec<Placed> {
    let instance = |object: &Object| {
        let place: Affine3A = object.place(seconds);
        let mut out = [0.0; 16];
        out[..12].copy_from_slice(&place.to_cols_array());
        out[12..15].copy_from_slice(&object.color);
        out[15] = if object.paved { 1.0 } else { 0.0 };
        out
    };
    objects.iter().map(instance).collect()
}

impl Targets {
    fn new(device: &wgpu::Device, size: UVec2) -> Self {
        let view = |format| {
            let usage =
                wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING;
            let texture = texture(device, size, format, usage);
            texture.create_view(&wgpu::TextureViewDescriptor::default())
        };
        Self {
            size,
            depth: view(DEPTH),
            albedo: view(ALBEDO),
            normal: view(NORMAL),
        }
    }
}
