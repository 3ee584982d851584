//! Tests of the wgpu backend inside another program: an external device, external vertex buffers,
//! an external encoder.

use bytemuck::cast_slice;
use umbrage::{
    Backend, BackendError, Geometry, Receivers, Recipe, ShadowTechnique, View, techniques::Pcf,
};
use umbrage_cpu::Cpu;
use umbrage_techniques::{Exact, ExactStructure, MapTechnique};
use umbrage_tests::{
    adapter::{TestDevice, device, open_with},
    foreign,
};
use umbrage_wgpu::{
    Drawable, FrameInputs, GBuffer, Indices, PositionFormat, RendererOptions, ShadowRenderer,
    VertexLayout,
};
use wgpu::{BufferUsages, IndexFormat, TextureFormat, TextureView};

/// GPU objects of an external program.
struct EmbeddedProgram {
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    count: u32,
    position: TextureView,
    normal: TextureView,
    triangle: TextureView,
}

/// Vertices of 32 bytes with the position in the middle, as in some engines.
const LAYOUT: VertexLayout = VertexLayout {
    format: PositionFormat::Float32x3,
    stride: 32,
    position_offset: 8,
};

/// `exact` with the structure that the device builds.
const HIERARCHY: Exact = Exact {
    structure: ExactStructure::Hierarchy,
};

fn renderer(d: &TestDevice) -> ShadowRenderer {
    ShadowRenderer::new(&d.device, &d.queue, RendererOptions::default()).expect("fits")
}

fn encoder(d: &TestDevice) -> wgpu::CommandEncoder {
    d.device
        .create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
}

impl EmbeddedProgram {
    fn new(d: &TestDevice, geometry: &Geometry, receivers: &Receivers) -> Self {
        let vertices: Vec<[f32; 8]> = geometry
            .positions()
            .iter()
            .map(|p| [9.0, 9.0, p.x, p.y, p.z, 9.0, 9.0, 9.0])
            .collect();
        let casters = geometry.run(&geometry.casters());
        let mut positions: Vec<[f32; 4]> = Vec::new();
        let mut normals: Vec<[f32; 4]> = Vec::new();
        for i in 0..receivers.len() {
            let receives = if receivers.receives[i] { 1.0 } else { 0.0 };
            positions.push(receivers.position(i).extend(receives).to_array());
            normals.push(receivers.normal(i).extend(0.0).to_array());
        }
        let upload = |format, bytes: &[u8]| foreign::upload(d, receivers.size, format, bytes);
        let floats = TextureFormat::Rgba32Float;
        Self {
            vertices: foreign::buffer(d, BufferUsages::VERTEX, cast_slice(&vertices)),
            indices: foreign::buffer(d, BufferUsages::INDEX, cast_slice(casters)),
            count: 3 * casters.len() as u32,
            position: upload(floats, cast_slice(&positions)),
            normal: upload(floats, cast_slice(&normals)),
            triangle: upload(TextureFormat::R32Uint, cast_slice(&receivers.triangle)),
        }
    }

    /// Draws and submits one frame of the external program.
    fn frame(
        &self,
        d: &TestDevice,
        shadows: &mut ShadowRenderer,
        recipe: &Recipe,
        size: glam::UVec2,
    ) -> Vec<f32> {
        let mut encoder = encoder(d);
        let mask = self.encode(&mut encoder, shadows, recipe, size);
        foreign::read(d, encoder, &mask)
    }

    /// Prepares and records a light's shadows. Returns their mask.
    fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        shadows: &mut ShadowRenderer,
        recipe: &Recipe,
        size: glam::UVec2,
    ) -> TextureView {
        self.prepare(shadows, recipe, size).expect("prepares");
        shadows.encode(encoder).expect("was prepared").clone()
    }

    fn prepare(
        &self,
        shadows: &mut ShadowRenderer,
        recipe: &Recipe,
        size: glam::UVec2,
    ) -> Result<(), BackendError> {
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
            triangle: Some(&self.triangle),
        };
        let frame = FrameInputs {
            size,
            casters: &casters,
            everything: &[],
            receivers,
        };
        shadows.prepare(recipe, &frame)
    }
}

#[test]
fn a_foreign_program_gets_the_same_shadows() {
    let scene = umbrage::scenes::by_argument("cubes").expect("a built-in scene");
    let geometry = Geometry::bake(&scene).expect("valid");
    let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
    let recipe = MapTechnique::<Pcf>::default()
        .recipe(&view)
        .expect("pcf serves the sun");
    let cpu = Cpu::new().render(&view, &recipe).expect("renders");
    let d = device();
    let program = EmbeddedProgram::new(d, &geometry, cpu.receivers.as_ref().expect("made here"));
    let mut shadows = renderer(d);
    let mask = program.frame(d, &mut shadows, &recipe, cpu.size);
    assert!(mask.iter().any(|&v| v < 1.0));
    let differing = mask
        .iter()
        .zip(&cpu.mask)
        .filter(|(a, b)| (*a - *b).abs() > 1.0 / 255.0)
        .count();
    // Masks are bit-equal on software drivers. A GPU may decide a few edge texels differently.
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
    let recipe = MapTechnique::<Pcf>::default()
        .recipe(&view)
        .expect("pcf serves the sun");
    let receivers = Cpu::new().receivers(view.camera, &geometry).expect("sees");
    let d = device();
    let program = EmbeddedProgram::new(d, &geometry, &receivers);
    let mut shadows = renderer(d);
    program.frame(d, &mut shadows, &recipe, receivers.size);
    let first = shadows.counters();
    for _ in 0..3 {
        program.frame(d, &mut shadows, &recipe, receivers.size);
    }
    assert_eq!(shadows.counters(), first);
    // Negative control of the counters: another kernel needs another pipeline.
    let other = MapTechnique::<umbrage::techniques::Hard>::default()
        .recipe(&view)
        .expect("hard serves the sun");
    program.frame(d, &mut shadows, &other, receivers.size);
    assert_ne!(shadows.counters(), first);
}

/// Lights with hierarchies of different casters and sizes, all encoded before they are submitted.
#[test]
fn hierarchies_of_several_lights_have_the_bits_of_lists() {
    let d = device();
    let mut shadows = renderer(d);
    let mut pending = Vec::new();
    for name in ["cubes", "lamp-in-room", "no-casters", "c10-chequered-card"] {
        let scene = umbrage::scenes::by_argument(name).expect("a built-in scene");
        let geometry = Geometry::bake(&scene).expect("valid");
        let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
        let recipe = HIERARCHY.recipe(&view).expect("serves the light");
        let cpu = Cpu::new().render(&view, &recipe).expect("renders");
        let receivers = cpu.receivers.as_ref().expect("made here");
        let program = EmbeddedProgram::new(d, &geometry, receivers);
        let mut encoder = encoder(d);
        let mask = program.encode(&mut encoder, &mut shadows, &recipe, cpu.size);
        pending.push((name, program, recipe, cpu, encoder, mask));
    }
    while let Some((name, program, recipe, cpu, encoder, mask)) = pending.pop() {
        let mask = foreign::read(d, encoder, &mask);
        let differing = |mask: &[f32]| mask.iter().zip(&cpu.mask).filter(|(a, b)| a != b).count();
        assert_eq!(differing(&mask), 0, "{name}");
        // Another light's buffers are reused.
        if pending.is_empty() {
            let again = program.frame(d, &mut shadows, &recipe, cpu.size);
            assert_eq!(differing(&again), 0, "{name}, again");
            let made = shadows.counters();
            program.frame(d, &mut shadows, &recipe, cpu.size);
            assert_eq!(shadows.counters(), made);
        }
    }
}

#[test]
fn hierarchies_without_valid_tables_are_refused() {
    let scene = umbrage::scenes::by_argument("cubes").expect("a built-in scene");
    let geometry = Geometry::bake(&scene).expect("valid");
    let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
    let mut recipe = HIERARCHY.recipe(&view).expect("serves the sun");
    recipe.make_tables();
    let refusal = |spoilt: &Recipe| {
        let result = Cpu::new().render(&view, spoilt);
        result.expect_err("refused").to_string()
    };
    let valid = recipe.receive.tables.clone();
    for (tables, word) in [
        (vec![0], "reads 1 tables"),
        (vec![0, 0], "same table"),
        (vec![1, 0], "8 rows"),
        (vec![0, 9], "9"),
    ] {
        recipe.receive.tables = tables;
        let error = refusal(&recipe);
        assert!(error.contains(word), "{error}");
    }
    recipe.receive.tables = valid;
    assert!(Cpu::new().render(&view, &recipe).is_ok());
    if let Some(hierarchy) = &mut recipe.hierarchy {
        hierarchy.uniforms.clear();
    }
    let error = refusal(&recipe);
    assert!(error.contains("0 bytes"), "{error}");
}

/// A hierarchy that shaders can't bind is an error that names the limit, and the renderer can be
/// used further.
#[test]
fn hierarchies_beyond_a_binding_are_refused() {
    let scene = umbrage::scenes::by_argument("teapot-lamp").expect("a built-in scene");
    let geometry = Geometry::bake(&scene).expect("valid");
    let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
    let [hierarchy, map] = [
        &HIERARCHY as &dyn ShadowTechnique,
        &MapTechnique::<Pcf>::default(),
    ]
    .map(|technique| technique.recipe(&view).expect("serves the lamp"));
    let receivers = Cpu::new().receivers(view.camera, &geometry).expect("sees");
    // The corners of all casters fit, three rows of 16 bytes each, but not the nodes next to them.
    let corners = 48 * geometry.casters().len() as u64;
    for (most, is_enough) in [(corners + 64, false), (1 << 27, true)] {
        let desc = wgpu::DeviceDescriptor {
            required_limits: wgpu::Limits {
                max_storage_buffer_binding_size: most,
                ..wgpu::Limits::default()
            },
            ..wgpu::DeviceDescriptor::default()
        };
        let d = &open_with(&desc).expect("a device");
        let program = EmbeddedProgram::new(d, &geometry, &receivers);
        let mut shadows = renderer(d);
        let result = program.prepare(&mut shadows, &hierarchy, receivers.size);
        let error = result.err().map(|error| error.to_string());
        assert_eq!(error.is_none(), is_enough, "{error:?}");
        if let Some(error) = error {
            assert!(error.contains("max_storage_buffer_binding_size"), "{error}");
        }
        let mask = program.frame(d, &mut shadows, &map, receivers.size);
        assert!(mask.iter().any(|&v| v < 1.0));
    }
}

/// Casters that move need no other buffers.
#[test]
fn hierarchies_follow_casters_without_other_buffers() {
    let d = device();
    let mut shadows = renderer(d);
    let mut first = None;
    let mut masks = Vec::new();
    for shift in [0.0, 0.25, 0.5] {
        let mut scene = umbrage::scenes::by_argument("cubes").expect("a built-in scene");
        for instance in scene.instances.iter_mut().filter(|i| i.casts) {
            instance.world_from_local.translation.x += shift;
        }
        let geometry = Geometry::bake(&scene).expect("valid");
        let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
        let recipe = HIERARCHY.recipe(&view).expect("serves the sun");
        let cpu = Cpu::new().render(&view, &recipe).expect("renders");
        let receivers = cpu.receivers.as_ref().expect("made here");
        let program = EmbeddedProgram::new(d, &geometry, receivers);
        let mask = program.frame(d, &mut shadows, &recipe, cpu.size);
        assert!(mask == cpu.mask, "moved by {shift}");
        masks.push(mask);
        let buffers = shadows.counters().buffers;
        assert_eq!(buffers, *first.get_or_insert(buffers), "moved by {shift}");
    }
    assert_ne!(masks[0], masks[1]);
    // Negative control of the count: a frame without a hierarchy frees its buffers.
    let scene = umbrage::scenes::by_argument("cubes").expect("a built-in scene");
    let geometry = Geometry::bake(&scene).expect("valid");
    let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
    let receivers = Cpu::new().receivers(view.camera, &geometry).expect("sees");
    let program = EmbeddedProgram::new(d, &geometry, &receivers);
    let hierarchy = HIERARCHY.recipe(&view).expect("serves the sun");
    let lists = Exact::default().recipe(&view).expect("serves the sun");
    let [a, b] =
        [&lists, &hierarchy].map(|recipe| program.frame(d, &mut shadows, recipe, receivers.size));
    assert_eq!(a, b);
    assert!(Some(shadows.counters().buffers) > first);
}
