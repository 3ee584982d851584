//! Cost of shadows if all casters move, on full-size scenes: redrawing a map, and rebuilding
//! hierarchies on the device.

use super::{open, time_frame};
use crate::renderer::Graphics;
use anyhow::{Context as _, Result};
use std::{sync::Arc, time::Duration};
use umbrage::{
    Camera, Geometry, Light, Receivers, ShadowTechnique,
    cpu::Cpu,
    glam::{Affine3A, UVec2},
    gpu::{
        AdapterChoice, CasterMesh, FrameGeometry, GBuffer, Indices, LightId, LightSet,
        LightSetOptions, MaskFormat, MaskInputs, MaskReceivers, SetFrame, ShadowedLight,
        VertexLayout,
        wgpu::{self, util::DeviceExt as _},
    },
    scenes,
    techniques::{Exact, Hard, MapFilter as _, ShadowMap, Traced},
};

/// Number of frames of each kind, alternating, after one that compiles.
const RUNS: usize = 5;
/// Default scenes.
const SCENES: [&str; 5] = ["night-room", "dancer", "street", "nave", "valley"];

/// Runs the scenes, and prints the times of each frame's parts.
pub fn lists(names: &[String]) -> Result<()> {
    let (adapter, graphics) = open(&AdapterChoice::from_env())?;
    println!("{adapter}: least of {RUNS} frames, milliseconds");
    println!(
        "scene        triangles   hard 2048: cast + lookup   exact: build + lookup   rays: lookup   exact / hard   rays / exact"
    );
    let all: Vec<String> = if names.is_empty() {
        SCENES.map(str::to_owned).to_vec()
    } else {
        names.to_vec()
    };
    for name in &all {
        scene(&graphics, name)?;
    }
    Ok(())
}

fn scene(graphics: &Graphics, name: &str) -> Result<()> {
    let scene = scenes::by_argument(name)?;
    let geometry = Geometry::bake(&scene)?;
    let camera = scene.cameras[0];
    let receivers = Cpu::new().receivers(&camera, &geometry)?;
    let light = *scene.lights.first().context("the scene has no light")?;
    let seen = SeenImages::new(graphics, &receivers);
    let map = ShadowMap {
        size: 2048,
        ..ShadowMap::default()
    };
    // Rays need the triangles on the CPU, too.
    let techniques: [(Arc<dyn ShadowTechnique>, bool); 3] = [
        (Arc::new(Hard {}.on(map)), false),
        (Arc::new(Exact::default()), false),
        (Arc::new(Traced { samples: 1 }), true),
    ];
    let mut least = Vec::new();
    for (technique, has_triangles) in techniques {
        let light = LitScene::new(graphics, &geometry, light, technique, has_triangles)?;
        least.push((light, [f64::INFINITY; 2]));
    }
    for run in 0..=RUNS {
        for (light, least) in &mut least {
            let times = light.frame(graphics, &camera, &geometry, &seen)?;
            if run > 0 {
                *least = std::array::from_fn(|part| least[part].min(times[part]));
            }
        }
    }
    let [hard, exact, rays] = [0, 1, 2].map(|i| least[i].1);
    println!(
        "{name:12} {:9} {:13.1} + {:6.1} {:15.1} + {:6.1} {:14.1} {:14.2} {:14.1}",
        geometry.casters().len(),
        hard[0],
        hard[1],
        exact[0],
        exact[1],
        rays[1],
        (exact[0] + exact[1]) / (hard[0] + hard[1]),
        rays[1] / exact[1]
    );
    Ok(())
}

/// Textures of the camera's visible surfaces.
struct SeenImages {
    position: wgpu::TextureView,
    normal: wgpu::TextureView,
    triangle: wgpu::TextureView,
    size: UVec2,
}

impl SeenImages {
    fn new(graphics: &Graphics, receivers: &Receivers) -> Self {
        let mut positions: Vec<[f32; 4]> = Vec::new();
        let mut normals: Vec<[f32; 4]> = Vec::new();
        for i in 0..receivers.len() {
            let receives = f32::from(u8::from(receivers.receives[i]));
            positions.push(receivers.position(i).extend(receives).to_array());
            normals.push(receivers.normal(i).extend(0.0).to_array());
        }
        let size = receivers.size;
        let floats = wgpu::TextureFormat::Rgba32Float;
        let ids = wgpu::TextureFormat::R32Uint;
        Self {
            position: upload(graphics, size, floats, bytemuck::cast_slice(&positions)),
            normal: upload(graphics, size, floats, bytemuck::cast_slice(&normals)),
            triangle: upload(
                graphics,
                size,
                ids,
                bytemuck::cast_slice(&receivers.triangle),
            ),
            size,
        }
    }
}

/// A set with one light.
struct LitScene {
    set: LightSet,
    light: LightId,
    /// `true` if the set has the triangles on the CPU, too.
    has_triangles: bool,
}

impl LitScene {
    fn new(
        graphics: &Graphics,
        geometry: &Geometry,
        light: Light,
        technique: Arc<dyn ShadowTechnique>,
        has_triangles: bool,
    ) -> Result<Self> {
        let mut set = LightSet::new(
            &graphics.device,
            &graphics.queue,
            LightSetOptions::default(),
        )?;
        let positions: Vec<[f32; 3]> = geometry.positions().iter().map(|p| p.to_array()).collect();
        let casters = geometry.run(&geometry.casters());
        let storage = wgpu::BufferUsages::STORAGE;
        let vertices = graphics.buffer(
            storage | wgpu::BufferUsages::VERTEX,
            bytemuck::cast_slice(&positions),
        );
        let indices = graphics.buffer(
            storage | wgpu::BufferUsages::INDEX,
            bytemuck::cast_slice(casters),
        );
        let mesh = set.add_mesh(&CasterMesh {
            label: "casters",
            vertices: &vertices,
            layout: VertexLayout::PACKED,
            indices: Some(Indices {
                buffer: &indices,
                format: wgpu::IndexFormat::Uint32,
            }),
            range: 0..3 * casters.len() as u32,
            base_vertex: 0,
            bounds: geometry.caster_bounds(),
        })?;
        set.add_caster(mesh, Affine3A::IDENTITY)?;
        let light = set.add_light(ShadowedLight {
            light,
            technique,
            priority: 1.0,
        })?;
        Ok(Self {
            set,
            light,
            has_triangles,
        })
    }

    /// Draws a frame in which all casters moved. Returns the times of updating maps or hierarchies, and
    /// of the lookup, milliseconds.
    fn frame(
        &mut self,
        graphics: &Graphics,
        camera: &Camera,
        geometry: &Geometry,
        seen: &SeenImages,
    ) -> Result<[f64; 2]> {
        self.set.touch(&geometry.caster_bounds())?;
        let frame = SetFrame {
            camera,
            geometry: self.has_triangles.then_some(FrameGeometry {
                triangles: geometry,
                revision: 0,
            }),
        };
        self.set.prepare(&frame)?;
        if let Some((_, why)) = self.set.unserved_lights().next() {
            println!("{why}");
        }
        let make = submit_frame(graphics, |encoder| Ok(self.set.encode(encoder)?))?;
        self.set.prepare_masks(&MaskInputs {
            size: seen.size,
            receivers: MaskReceivers::Positions(GBuffer {
                position: &seen.position,
                normal: &seen.normal,
                triangle: Some(&seen.triangle),
            }),
            lights: &[self.light],
            format: MaskFormat::Float32,
        })?;
        let lookup = submit_frame(graphics, |encoder| {
            self.set.encode_masks(encoder)?;
            Ok(())
        })?;
        Ok([make, lookup].map(|time| 1e3 * time.as_secs_f64()))
    }
}

/// Returns the time of commands from submission to completion.
fn submit_frame(
    graphics: &Graphics,
    record: impl FnOnce(&mut wgpu::CommandEncoder) -> Result<()>,
) -> Result<Duration> {
    let mut encoder = graphics.encoder();
    record(&mut encoder)?;
    // Submit pending writes first, so that they aren't timed.
    graphics.queue.submit([]);
    graphics.wait()?;
    time_frame(graphics, || {
        graphics.queue.submit([encoder.finish()]);
        Ok(())
    })
}

/// Returns a texture with these texels, for reading.
fn upload(
    graphics: &Graphics,
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
    let (device, queue) = (&graphics.device, &graphics.queue);
    let texture = device.create_texture_with_data(queue, &desc, order, texels);
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}
