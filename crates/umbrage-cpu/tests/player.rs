//! The player through its public interface: same bits on any threads and instructions, receivers against plain geometry,
//! every error.

use std::sync::Arc;
use umbrage_core::{
    Backend, Camera, Cast, Cull, Extents, Filter, FilterKernel, Format, Geometry, Image, ImageDesc, Inputs, Instance,
    Kernel, Light, LightSpace, Mesh, Module, NO_TRIANGLE, RasterBias, Receive, ReceiveKernel, Recipe, Scene, Shadows,
    Simd, Span, UniformLayout, View,
    glam::{Affine3A, UVec2, Vec3},
    light_space::{look_along, orthographic},
};
use umbrage_cpu::{Cpu, CpuOptions};

/// Receive: compares depth in the filtered image. Filter: averages a texel and its right neighbour.
#[derive(Clone, Copy, Debug)]
struct Plain {
    space: LightSpace,
}

impl Kernel for Plain {
    fn modules(&self) -> Vec<Module> {
        Vec::new()
    }
    fn uniform_bytes(&self) -> Vec<u8> {
        Vec::new()
    }
    fn layout(&self) -> UniformLayout {
        UniformLayout { name: "Plain", fields: Vec::new(), size: 0 }
    }
}

impl ReceiveKernel for Plain {
    fn receive(&self, inputs: &Inputs<'_>, span: &Span<'_>, out: &mut [f32]) {
        let (map, texture_from_world) = (&inputs.images[0], self.space.texture_from_world());
        for (i, out) in out.iter_mut().enumerate() {
            let p = texture_from_world.project_point3(span.position(i));
            let texel = (p.truncate() * map.desc.size.as_vec2()).as_ivec2();
            let last = map.desc.size.as_ivec2() - 1;
            let texel = texel.clamp(UVec2::ZERO.as_ivec2(), last);
            let stored = map.texels[map.index(texel.x, texel.y, 0)];
            *out = if p.z - 0.01 <= stored { 1.0 } else { stored * 0.5 };
        }
    }
}

impl FilterKernel for Plain {
    fn filter(&self, inputs: &Inputs<'_>, start: UVec2, layer: u32, out: &mut [f32]) {
        let image = &inputs.images[0];
        for (i, out) in out.chunks_mut(2).enumerate() {
            let (x, y) = (start.x as i32 + i as i32, start.y as i32);
            let right = (x + 1).min(image.desc.size.x as i32 - 1);
            out[0] = 0.5 * (image.load(x, y, layer) + image.load(right, y, layer));
            out[1] = layer as f32;
        }
    }
}

const SIZE: UVec2 = UVec2::new(97, 61);

/// A bumpy ground with a floating sheet over part of it.
fn geometry() -> Geometry {
    let side = 40_u32;
    let height = |x: u32, z: u32| ((x * 7 + z * 13) % 11) as f32 * 0.02;
    let points = (0..side * side).map(|i| (i % side, i / side));
    let positions = points.map(|(x, z)| Vec3::new(x as f32 * 0.1 - 2.0, height(x, z), z as f32 * 0.1 - 2.0)).collect();
    let cells = (0..side - 1).flat_map(|z| (0..side - 1).map(move |x| z * side + x));
    let triangles = cells.flat_map(|i| [[i, i + side, i + 1], [i + 1, i + side, i + side + 1]]).collect();
    let ground = Mesh::new("ground", positions, triangles).unwrap();
    let corners = [[-0.5, -0.5], [-0.5, 0.5], [0.5, 0.5], [0.5, -0.5]].map(|[x, z]| Vec3::new(x, 0.8, z));
    let sheet = Mesh::new("sheet", corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).unwrap();
    let mut instances = [Instance::new(0, Affine3A::IDENTITY), Instance::new(1, Affine3A::IDENTITY)];
    instances[1].receives = false;
    Geometry::bake(&Scene { meshes: vec![ground, sheet], instances: instances.into(), ..Scene::default() }).unwrap()
}

fn camera() -> Camera {
    Camera::perspective(Vec3::new(2.0, 3.0, 4.0), Vec3::ZERO, Vec3::Y, 0.9, [0.1, 20.0], SIZE).unwrap()
}

fn light() -> Light {
    Light::Directional { direction: Vec3::new(0.3, -1.0, 0.2), angular_diameter: 0.0 }
}

fn space() -> LightSpace {
    let extents = Extents { left: -3.0, right: 3.0, bottom: -3.0, top: 3.0, near: 0.0, far: 10.0 };
    let view_from_world = look_along(Vec3::new(-1.5, 5.0, -1.0), Vec3::new(0.3, -1.0, 0.2), Vec3::Y).unwrap();
    LightSpace { view_from_world, clip_from_view: orthographic(extents).unwrap() }
}

/// Two depth layers, of which the first is drawn; both filtered into two channels; looked up.
fn recipe() -> Recipe {
    let (space, kernel) = (space(), Arc::new(Plain { space: space() }));
    let image = |label, format| ImageDesc { label, size: UVec2::new(130, 75), layers: 2, format };
    let bias = RasterBias { constant: 3, slope: 1.5, clamp: 0.0 };
    Recipe {
        images: vec![image("depth", Format::Depth32), image("blurred", Format::Rg32)],
        tables: Vec::new(),
        casts: vec![Cast { image: 0, layer: 0, space, cull: Cull::None, bias }],
        filters: vec![Filter { kernel: kernel.clone(), inputs: vec![0], tables: Vec::new(), output: 1 }],
        receive: Receive { kernel, inputs: vec![1], tables: Vec::new() },
        keep_images: true,
    }
}

fn bits(values: &[f32]) -> Vec<u32> {
    values.iter().map(|v| v.to_bits()).collect()
}

/// The first thing that differs between two results.
fn difference(a: &Shadows, b: &Shadows) -> Option<&'static str> {
    let images = |s: &Shadows| s.images.iter().map(|i| bits(&i.texels)).collect::<Vec<_>>();
    if bits(&a.mask) != bits(&b.mask) {
        return Some("mask");
    }
    if images(a) != images(b) {
        return Some("images");
    }
    (a.receivers != b.receivers).then_some("receivers")
}

fn render(cpu: &mut Cpu) -> Shadows {
    let (camera, light, geometry) = (camera(), light(), geometry());
    cpu.render(&View::new(&camera, &light, &geometry), &recipe()).unwrap()
}

#[test]
fn threads_and_instructions_change_no_bit() {
    let expected = render(&mut Cpu::with_options(&CpuOptions::default().threads(1)).unwrap());
    assert!(expected.mask.iter().any(|&v| v < 1.0) && expected.mask.contains(&1.0), "shadow and light are both seen");
    for (threads, simd) in [(1, Simd::Baseline), (4, Simd::Native), (3, Simd::Baseline)] {
        let options = CpuOptions::default().threads(threads).simd(simd);
        let found = render(&mut Cpu::with_options(&options).unwrap());
        assert_eq!(difference(&expected, &found), None, "{options:?}");
    }
}

#[test]
fn the_comparison_notices_one_bit() {
    let expected = render(&mut Cpu::new());
    let spoilt = |f: fn(&mut Shadows)| {
        let mut shadows = expected.clone();
        f(&mut shadows);
        difference(&expected, &shadows)
    };
    assert_eq!(spoilt(|s| s.mask[99] = f32::from_bits(s.mask[99].to_bits() ^ 1)), Some("mask"));
    assert_eq!(spoilt(|s| s.images[0].texels[9000] = 0.25), Some("images"));
    assert_eq!(spoilt(|s| s.receivers.as_mut().unwrap().triangle[50] = 3), Some("receivers"));
}

#[test]
fn rendering_again_leaves_no_trace_of_what_was_before() {
    let (camera, light, geometry) = (camera(), light(), geometry());
    let view = View::new(&camera, &light, &geometry);
    let mut cpu = Cpu::new();
    let first = render(&mut cpu);
    let nothing_cast = Recipe { casts: Vec::new(), filters: Vec::new(), ..recipe() };
    let empty = cpu.render(&view, &nothing_cast).unwrap();
    assert!(empty.images[0].texels.iter().all(|&z| z == 1.0), "depth starts at 1");
    assert!(empty.images[1].texels.iter().all(|&v| v == 0.0), "other images start at 0");
    assert_eq!((empty.timings.cast, empty.timings.filter), (None, None));
    assert_eq!(difference(&first, &render(&mut cpu)), None);
}

#[test]
fn without_casters_depth_stays_at_the_far_plane() {
    let (camera, light, geometry) = (camera(), light(), geometry().without_casters());
    let shadows = Cpu::new().render(&View::new(&camera, &light, &geometry), &recipe()).unwrap();
    assert!(shadows.images[0].texels.iter().all(|&z| z == 1.0));
    assert!(shadows.mask.iter().all(|&v| v == 1.0));
}

#[test]
fn replayed_stages_give_what_the_whole_gave() {
    let (camera, light, geometry, recipe) = (camera(), light(), geometry(), recipe());
    let view = View::new(&camera, &light, &geometry);
    let mut cpu = Cpu::new();
    let whole = render(&mut cpu);
    let cast = cpu.cast(&geometry, &recipe.casts[0], recipe.images[0].size).unwrap();
    assert_eq!(bits(&cast.texels), bits(&whole.images[0].texels[..cast.texels.len()]));
    let filtered = cpu.replay_filter(&recipe, 0, &whole.images).unwrap();
    assert_eq!(bits(&filtered.texels), bits(&whole.images[1].texels));
    let mask = cpu.replay_receive(&view, &recipe, &whole.images).unwrap();
    assert_eq!(bits(&mask), bits(&whole.mask));
    let mut other = whole.images.clone();
    other[1] = Image::filled(other[1].desc, 0.0);
    assert_ne!(bits(&cpu.replay_receive(&view, &recipe, &other).unwrap()), bits(&whole.mask));
}

#[test]
fn receivers_lie_on_what_their_rays_meet() {
    let (camera, geometry) = (camera(), geometry());
    let receivers = Cpu::new().shaded_receivers(&camera, &geometry).unwrap();
    let clip_from_world = camera.space().clip_from_world();
    let mut seen = 0;
    for i in 0..receivers.len() {
        let id = receivers.triangle[i];
        if id == NO_TRIANGLE {
            assert_eq!((receivers.depth[i], receivers.distance[i], receivers.receives[i]), (1.0, 0.0, false));
            continue;
        }
        seen += 1;
        let (p, n) = (receivers.position(i), receivers.normal(i));
        let ndc = clip_from_world.project_point3(p);
        let pixel = (ndc.truncate() * UVec2::new(1, 1).as_vec2() * 0.5) * SIZE.as_vec2();
        let (x, y) = (pixel.x + 0.5 * SIZE.x as f32, 0.5 * SIZE.y as f32 - pixel.y);
        // A hundredth of a pixel, and a thousandth of the depth range: far above rounding, far below any mistake.
        assert!(
            (x - (i as u32 % SIZE.x) as f32 - 0.5).abs() < 0.01 && (y - (i as u32 / SIZE.x) as f32 - 0.5).abs() < 0.01
        );
        assert!((ndc.z - receivers.depth[i]).abs() < 1e-3);
        assert!(((p - camera.eye()).length() - receivers.distance[i]).abs() < 1e-4);
        assert!(n.dot(camera.eye() - p) > 0.0 && receivers.shading_normals[i].dot(camera.eye() - p) > 0.0);
        assert!((receivers.shading_normals[i].length() - 1.0).abs() < 1e-5);
        assert_eq!(receivers.receives[i], geometry.receivers().contains(&id));
    }
    assert!(seen > 1000 && receivers.receives.iter().filter(|&&r| r).count() < seen, "ground and sheet are seen");
}

#[test]
fn pixels_that_receive_nothing_are_lit() {
    let shadows = render(&mut Cpu::new());
    let receivers = shadows.receivers.unwrap();
    assert!(receivers.receives.iter().zip(&shadows.mask).all(|(&receives, &v)| receives || v == 1.0));
}

#[test]
fn given_receivers_are_used_as_they_are() {
    let (camera, light, geometry, recipe) = (camera(), light(), geometry(), recipe());
    let mut cpu = Cpu::new();
    let mut receivers = cpu.receivers(&camera, &geometry).unwrap();
    let view = View::new(&camera, &light, &geometry);
    let shadows = cpu.render(&view.with_receivers(&receivers), &recipe).unwrap();
    assert!(shadows.receivers.is_none() && shadows.timings.receivers.is_none());
    assert_eq!(bits(&shadows.mask), bits(&render(&mut cpu).mask));
    receivers.receives.fill(false);
    assert!(cpu.render(&view.with_receivers(&receivers), &recipe).unwrap().mask.iter().all(|&v| v == 1.0));
}

#[test]
fn errors_say_what_is_missing() {
    let (camera, light, geometry, recipe) = (camera(), light(), geometry(), recipe());
    let view = View::new(&camera, &light, &geometry);
    let mut cpu = Cpu::new();
    let receivers = cpu.receivers(&camera, &geometry).unwrap();
    let mut says = |view: &View<'_>, recipe: &Recipe, text: &str| {
        let error = cpu.render(view, recipe).unwrap_err().to_string();
        assert!(error.contains(text), "{error}");
    };
    says(&View { geometry: None, ..view }.with_receivers(&receivers), &recipe, "no geometry, but the recipe casts");
    let plain = Recipe { casts: Vec::new(), ..recipe.clone() };
    says(&View { geometry: None, ..view }, &plain, "neither receivers nor geometry");
    let other = Camera { size: UVec2::new(5, 5), ..camera };
    says(&View { camera: &other, ..view }.with_receivers(&receivers), &recipe, "97 x 61 pixels");
    let mut short = receivers.clone();
    short.ny.pop();
    says(&view.with_receivers(&short), &recipe, "lengths");
    let mut huge = recipe.clone();
    huge.images[0].size.x = 16_385;
    says(&view, &huge, "16385");
    for threads in [0, 5000] {
        let error = Cpu::with_options(&CpuOptions::default().threads(threads)).unwrap_err().to_string();
        assert!(error.contains("1 to 1024"), "{error}");
    }
    assert!(cpu.replay_filter(&recipe, 1, &render(&mut Cpu::new()).images).is_err());
    assert!(cpu.replay_receive(&view, &recipe, &[]).is_err());
    assert!(cpu.cast(&geometry, &recipe.casts[0], UVec2::new(0, 4)).is_err());
    let cast = Cast { layer: 1, ..recipe.casts[0] };
    let mut image = cpu.cast(&geometry, &cast, UVec2::new(4, 4)).unwrap();
    assert!(cpu.cast_into(&geometry, &cast, &mut image).is_err());
}

#[test]
fn working_memory_stays_below_the_image() {
    let (geometry, size) = (geometry(), UVec2::splat(512));
    let mut cpu = Cpu::new();
    let image = cpu.cast(&geometry, &recipe().casts[0], size).unwrap();
    assert!(cpu.working_bytes() > 0 && cpu.working_bytes() < 4 * image.texels.len());
}

#[test]
fn the_name_tells_threads_and_instructions() {
    let cpu = Cpu::with_options(&CpuOptions::default().threads(3).simd(Simd::Baseline)).unwrap();
    assert_eq!((cpu.name(), cpu.kind()), ("cpu (3 threads, baseline)", "cpu"));
    println!("{}", Cpu::new().name());
}
