//! What shadows of casters that all move take on frames of real size: a map that is drawn anew, and lists that the device makes anew.

use super::scene::Device;
use anyhow::{Context, Result};
use std::{
    sync::Arc,
    time::{Duration, Instant},
};
use umbrage::{
    Camera, Geometry, Light, Receivers, ShadowTechnique,
    cpu::Cpu,
    glam::Affine3A,
    scenes,
    techniques::{Exact, Hard, MapFilter as _, ShadowMap, Traced},
    wgpu::{
        AdapterChoice, CasterMesh, FrameGeometry, GBuffer, Indices, LightId, LightSet,
        LightSetOptions, MaskFormat, MaskInputs, SetFrame, SetLight, SetReceivers, VertexLayout,
        wgpu,
    },
};

/// Frames of each kind, in turn, after one that compiles.
const RUNS: usize = 5;
/// Scenes that are played if none is named.
const SCENES: [&str; 5] = ["night-room", "dancer", "street", "nave", "valley"];

/// Plays the scenes, and prints what each frame's parts take.
pub fn lists(names: &[String]) -> Result<()> {
    let d = Device::open(&AdapterChoice::from_env())?;
    println!("{}: least of {RUNS} frames, milliseconds", d.name);
    println!(
        "scene        triangles   hard 2048: cast + lookup   lists: make + lookup   rays: lookup   lists / hard   rays / lists"
    );
    let all: Vec<String> = if names.is_empty() {
        SCENES.map(str::to_owned).to_vec()
    } else {
        names.to_vec()
    };
    for name in &all {
        scene(&d, name)?;
    }
    Ok(())
}

fn scene(d: &Device, name: &str) -> Result<()> {
    let scene = scenes::by_argument(name)?;
    let geometry = Geometry::bake(&scene)?;
    let camera = scene.cameras[0];
    let receivers = Cpu::new().receivers(&camera, &geometry)?;
    let light = *scene.lights.first().context("the scene has no light")?;
    let seen = Seen::new(d, &receivers);
    let map = ShadowMap {
        size: 2048,
        ..ShadowMap::default()
    };
    let mut hard = Player::new(d, &geometry, light, Arc::new(Hard {}.on(map)), false)?;
    let mut exact = Player::new(d, &geometry, light, Arc::new(Exact::default()), false)?;
    let mut rays = Player::new(d, &geometry, light, Arc::new(Traced { samples: 1 }), true)?;
    let mut least = [Times::default(); 3];
    for run in 0..=RUNS {
        for (player, least) in [&mut hard, &mut exact, &mut rays]
            .into_iter()
            .zip(&mut least)
        {
            let times = player.frame(d, &camera, &geometry, &seen)?;
            if run > 0 {
                least.take(times);
            }
        }
    }
    let [hard, exact, rays] = least;
    println!(
        "{name:12} {:9} {:13.1} + {:6.1} {:15.1} + {:6.1} {:14.1} {:14.2} {:14.1}",
        geometry.casters().len(),
        hard.make,
        hard.lookup,
        exact.make,
        exact.lookup,
        rays.lookup,
        (exact.make + exact.lookup) / (hard.make + hard.lookup),
        rays.lookup / exact.lookup
    );
    Ok(())
}

/// Milliseconds of a frame's parts.
#[derive(Clone, Copy)]
struct Times {
    make: f64,
    lookup: f64,
}

impl Default for Times {
    fn default() -> Self {
        Self {
            make: f64::INFINITY,
            lookup: f64::INFINITY,
        }
    }
}

impl Times {
    fn take(&mut self, other: Self) {
        self.make = self.make.min(other.make);
        self.lookup = self.lookup.min(other.lookup);
    }
}

/// What the camera sees, as textures.
struct Seen {
    position: wgpu::TextureView,
    normal: wgpu::TextureView,
    triangle: wgpu::TextureView,
    size: umbrage::glam::UVec2,
}

impl Seen {
    fn new(d: &Device, receivers: &Receivers) -> Self {
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
            position: d.upload(size, floats, bytemuck::cast_slice(&positions)),
            normal: d.upload(size, floats, bytemuck::cast_slice(&normals)),
            triangle: d.upload(size, ids, bytemuck::cast_slice(&receivers.triangle)),
            size,
        }
    }
}

/// A set with one light.
struct Player {
    set: LightSet,
    light: LightId,
    /// Whether the set is given the triangles on the CPU, too.
    has_triangles: bool,
}

impl Player {
    fn new(
        d: &Device,
        geometry: &Geometry,
        light: Light,
        technique: Arc<dyn ShadowTechnique>,
        has_triangles: bool,
    ) -> Result<Self> {
        let mut set = LightSet::new(&d.device, LightSetOptions::default())?;
        let positions: Vec<[f32; 3]> = geometry.positions().iter().map(|p| p.to_array()).collect();
        let casters = geometry.run(&geometry.casters());
        let storage = wgpu::BufferUsages::STORAGE;
        let vertices = d.buffer(
            storage | wgpu::BufferUsages::VERTEX,
            bytemuck::cast_slice(&positions),
        );
        let indices = d.buffer(
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
        let light = set.add_light(SetLight {
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

    /// Plays a frame in which all casters moved.
    fn frame(
        &mut self,
        d: &Device,
        camera: &Camera,
        geometry: &Geometry,
        seen: &Seen,
    ) -> Result<Times> {
        self.set.touch(&geometry.caster_bounds())?;
        let frame = SetFrame {
            camera,
            geometry: self.has_triangles.then_some(FrameGeometry {
                triangles: geometry,
                revision: 0,
            }),
        };
        self.set.prepare(&d.device, &d.queue, &frame)?;
        if let Some((_, why)) = self.set.unserved().next() {
            println!("{why}");
        }
        let make = timed(d, |encoder| Ok(self.set.encode(encoder)?))?;
        self.set.prepare_masks(
            &d.queue,
            &MaskInputs {
                size: seen.size,
                receivers: SetReceivers::Positions(GBuffer {
                    position: &seen.position,
                    normal: &seen.normal,
                    triangle: Some(&seen.triangle),
                }),
                lights: &[self.light],
                format: MaskFormat::Float32,
            },
        )?;
        let lookup = timed(d, |encoder| {
            self.set.encode_masks(encoder)?;
            Ok(())
        })?;
        let milliseconds = |time: Duration| 1e3 * time.as_secs_f64();
        Ok(Times {
            make: milliseconds(make),
            lookup: milliseconds(lookup),
        })
    }
}

/// Returns what commands take, from their submission to their end.
fn timed(
    d: &Device,
    record: impl FnOnce(&mut wgpu::CommandEncoder) -> Result<()>,
) -> Result<Duration> {
    let mut encoder = d
        .device
        .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    record(&mut encoder)?;
    // What was written before isn't timed.
    d.queue.submit([]);
    d.wait()?;
    let start = Instant::now();
    d.queue.submit([encoder.finish()]);
    d.wait()?;
    Ok(start.elapsed())
}
