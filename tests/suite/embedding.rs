//! The wgpu player inside someone else's program: a foreign device, foreign vertex buffers, a foreign encoder.

use bytemuck::cast_slice;
use umbrage::{Backend, Geometry, Receivers, Recipe, ShadowTechnique, View, techniques::Pcf};
use umbrage_cpu::Cpu;
use umbrage_tests::adapter::{TestDevice, device};
use umbrage_wgpu::{
    Drawable, FrameInputs, GBuffer, Indices, RendererOptions, ShadowRenderer, VertexLayout,
};
use wgpu::{
    BufferUsages, Extent3d, IndexFormat, TexelCopyBufferLayout, TextureDescriptor,
    TextureDimension, TextureFormat, TextureUsages, TextureView,
    util::{BufferInitDescriptor, DeviceExt},
};

/// What a foreign program has on its GPU.
struct Program {
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    count: u32,
    position: TextureView,
    normal: TextureView,
}

/// Vertices of 32 bytes with the position in the middle, as an engine might have them.
const LAYOUT: VertexLayout = VertexLayout {
    stride: 32,
    position_offset: 8,
};

impl Program {
    fn new(d: &TestDevice, geometry: &Geometry, receivers: &Receivers) -> Self {
        let vertices: Vec<[f32; 8]> = geometry
            .positions()
            .iter()
            .map(|p| [9.0, 9.0, p.x, p.y, p.z, 9.0, 9.0, 9.0])
            .collect();
        let casters = geometry.run(&geometry.casters());
        let buffer = |usage, contents| {
            d.device.create_buffer_init(&BufferInitDescriptor {
                label: None,
                contents,
                usage,
            })
        };
        let mut positions: Vec<[f32; 4]> = Vec::new();
        let mut normals: Vec<[f32; 4]> = Vec::new();
        for i in 0..receivers.len() {
            let receives = if receivers.receives[i] { 1.0 } else { 0.0 };
            positions.push(receivers.position(i).extend(receives).to_array());
            normals.push(receivers.normal(i).extend(0.0).to_array());
        }
        let size = receivers.size.to_array();
        Self {
            vertices: buffer(BufferUsages::VERTEX, cast_slice(&vertices)),
            indices: buffer(BufferUsages::INDEX, cast_slice(casters)),
            count: 3 * casters.len() as u32,
            position: upload(d, size, cast_slice(&positions)),
            normal: upload(d, size, cast_slice(&normals)),
        }
    }

    /// One frame of the foreign program, which submits.
    fn frame(
        &self,
        d: &TestDevice,
        shadows: &mut ShadowRenderer,
        recipe: &Recipe,
        size: glam::UVec2,
    ) -> Vec<f32> {
        let casters = [Drawable {
            vertices: &self.vertices,
            layout: LAYOUT,
            indices: Some(Indices {
                buffer: &self.indices,
                format: IndexFormat::Uint32,
            }),
            range: 0..self.count,
            world_from_local: None,
            triangles: None,
        }];
        let receivers = GBuffer {
            position: &self.position,
            normal: &self.normal,
            triangle: None,
        };
        let frame = FrameInputs {
            size,
            casters: &casters,
            everything: &[],
            receivers,
        };
        shadows
            .prepare(&d.device, &d.queue, recipe, &frame)
            .expect("prepares");
        let mut encoder = d
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mask = shadows.encode(&mut encoder).expect("was prepared").clone();
        read(d, encoder, &mask, size)
    }
}

fn upload(d: &TestDevice, size: [u32; 2], data: &[u8]) -> TextureView {
    let [width, height] = size;
    let texture = d.device.create_texture(&TextureDescriptor {
        label: None,
        size: Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: TextureDimension::D2,
        format: TextureFormat::Rgba32Float,
        usage: TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let layout = TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(16 * width),
        rows_per_image: None,
    };
    d.queue
        .write_texture(texture.as_image_copy(), data, layout, texture.size());
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// Submits, and reads an `R32Float` texture.
fn read(
    d: &TestDevice,
    mut encoder: wgpu::CommandEncoder,
    view: &TextureView,
    size: glam::UVec2,
) -> Vec<f32> {
    let row = (4 * size.x).next_multiple_of(256);
    let buffer = d.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(row * size.y),
        usage: BufferUsages::MAP_READ | BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let layout = TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(row),
        rows_per_image: None,
    };
    let destination = wgpu::TexelCopyBufferInfo {
        buffer: &buffer,
        layout,
    };
    encoder.copy_texture_to_buffer(
        view.texture().as_image_copy(),
        destination,
        view.texture().size(),
    );
    d.queue.submit([encoder.finish()]);
    buffer.map_async(wgpu::MapMode::Read, .., |_| {});
    d.device
        .poll(wgpu::PollType::wait_indefinitely())
        .expect("the device lives");
    let bytes = buffer.get_mapped_range(..).expect("mapped");
    let rows = bytes.chunks_exact(row as usize);
    rows.flat_map(|r| bytemuck::pod_collect_to_vec::<u8, f32>(&r[..4 * size.x as usize]))
        .collect()
}

#[test]
fn a_foreign_program_gets_the_same_shadows() {
    let scene = umbrage::scenes::by_argument("cubes").expect("a built-in scene");
    let geometry = Geometry::bake(&scene).expect("valid");
    let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
    let recipe = Pcf::default().recipe(&view).expect("pcf serves the sun");
    let cpu = Cpu::new().render(&view, &recipe).expect("plays");
    let d = device();
    let program = Program::new(d, &geometry, cpu.receivers.as_ref().expect("made here"));
    let mut shadows = ShadowRenderer::new(&d.device, RendererOptions::default()).expect("fits");
    let mask = program.frame(d, &mut shadows, &recipe, cpu.size);
    assert!(mask.iter().any(|&v| v < 1.0));
    let differing = mask
        .iter()
        .zip(&cpu.mask)
        .filter(|(a, b)| (*a - *b).abs() > 1.0 / 255.0)
        .count();
    // Bit-equal on software drivers; a GPU may decide a few edge texels otherwise.
    assert!(
        differing <= mask.len() / 1000,
        "{differing} of {} pixels differ on {}",
        mask.len(),
        d.adapter
    );
}

#[test]
fn later_frames_make_nothing() {
    let scene = umbrage::scenes::by_argument("cubes").expect("a built-in scene");
    let geometry = Geometry::bake(&scene).expect("valid");
    let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
    let recipe = Pcf::default().recipe(&view).expect("pcf serves the sun");
    let receivers = Cpu::new().receivers(view.camera, &geometry).expect("sees");
    let d = device();
    let program = Program::new(d, &geometry, &receivers);
    let mut shadows = ShadowRenderer::new(&d.device, RendererOptions::default()).expect("fits");
    program.frame(d, &mut shadows, &recipe, receivers.size);
    let first = shadows.counters();
    for _ in 0..3 {
        program.frame(d, &mut shadows, &recipe, receivers.size);
    }
    assert_eq!(shadows.counters(), first);
    // The counters do count: another kernel needs another pipeline.
    let other = umbrage::techniques::Hard::default()
        .recipe(&view)
        .expect("hard serves the sun");
    program.frame(d, &mut shadows, &other, receivers.size);
    assert_ne!(shadows.counters(), first);
}
