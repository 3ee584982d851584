//! Tests of comparison samplers.

use crate::{
    foreign::{Foreign, read},
    kernels::{Numbers, kernel},
    scene::{BackendScene, gpu},
};
use glam::{UVec2, Vec2, Vec4};
use std::sync::Arc;
use umbrage_core::{
    Format, Image, ImageDesc, Inputs, NO_TRIANGLE, Receive, ReceiveKernel, Receivers, Recipe, Span,
};
use umbrage_wgpu::{
    FrameInputs, GBuffer, Gpu, RendererOptions, ShadowRenderer, receive_wgsl, wgpu::TextureFormat,
};

kernel!(
    Sampled,
    "fn receive(r: Receiver) -> f32 {
        return compare_0(r.position.xy, i32(kernel.numbers.x), r.position.z);
    }",
    compares true
);

kernel!(
    Gathered,
    "fn receive(r: Receiver) -> f32 {
        let g = gather_compare_0(r.position.xy, i32(kernel.numbers.x), r.position.z);
        return g.x + 10.0 * g.y + 100.0 * g.z + 1000.0 * g.w;
    }",
    compares true
);

kernel!(
    Loaded,
    "fn receive(r: Receiver) -> f32 {
        return load_0(vec2i(r.position.xy * vec2f(size_0())), i32(kernel.numbers.x)).x;
    }",
    compares true
);

macro_rules! silent {
    ($($name:ident)*) => {$(
        /// The expected values are in the tests below.
        impl ReceiveKernel for $name {
            fn receive(&self, _: &Inputs<'_>, _: &Span<'_>, out: &mut [f32]) {
                out.fill(0.0);
            }
        }
    )*};
}
silent!(Sampled Gathered Loaded);

/// Returns a small integer hash, which is equal on every machine.
fn noise(i: usize) -> f32 {
    let h = (i as u32).wrapping_mul(0x9e37_79b9);
    ((h ^ (h >> 15)).wrapping_mul(0x85eb_ca6b) >> 8) as f32 / (1 << 24) as f32
}

fn map(layers: u32, format: Format) -> Image {
    let desc = ImageDesc {
        label: "noise",
        size: UVec2::new(9, 7),
        layers,
        format,
    };
    let texels = (0..desc.floats() as usize).map(noise);
    // 16-bit depth only represents integer steps.
    let step = |z: f32| {
        if format == Format::Depth16 {
            (z * 65_535.0).round() / 65_535.0
        } else {
            z
        }
    };
    Image {
        desc,
        texels: texels.map(step).collect(),
    }
}

/// Returns lookups: (u, v) from -0.1 to 1.1, to include the border, and the depth to compare with.
fn questions() -> Receivers {
    let mut r = Receivers::empty(UVec2::new(64, 32));
    for i in 0..r.len() {
        r.x[i] = noise(3 * i) * 1.2 - 0.1;
        r.y[i] = noise(3 * i + 1) * 1.2 - 0.1;
        r.z[i] = noise(3 * i + 2);
        r.triangle[i] = 0;
        r.receives[i] = true;
    }
    r
}

fn recipe(map: &Image, kernel: Arc<dyn ReceiveKernel>) -> Recipe {
    let receive = Receive {
        kernel,
        inputs: vec![0],
        tables: vec![],
    };
    Recipe {
        images: vec![map.desc],
        casts: vec![],
        receive,
        ..BackendScene::new().recipe(8)
    }
}

fn numbers(layer: u32) -> Numbers {
    BackendScene::new().numbers(Vec4::splat(layer as f32))
}

fn run_lookup(
    gpu: &mut Gpu,
    map: &Image,
    questions: &Receivers,
    kernel: Arc<dyn ReceiveKernel>,
) -> Vec<f32> {
    let stage = BackendScene::new();
    let mut camera = stage.camera;
    camera.size = questions.size;
    let view =
        umbrage_core::View::new(&camera, &stage.light, &stage.geometry).with_receivers(questions);
    gpu.replay_receive(&view, &recipe(map, kernel), std::slice::from_ref(map))
        .unwrap_or_else(|e| panic!("{e}"))
}

/// Returns the comparison results of the four texels around a position, in the order of gathering
/// (whether `depth` is at most the stored one), and the position's fractions in x and y.
fn texels_around(map: &Image, layer: u32, uv: Vec2, depth: f32) -> ([f32; 4], Vec2) {
    let size = map.desc.size.as_vec2();
    let last = map.desc.size.as_ivec2() - 1;
    let c = ((uv * size).min(size) - 0.5).max(Vec2::ZERO);
    let lo = c.floor().as_ivec2();
    let hi = (c.floor().as_ivec2() + 1).min(last);
    let lit = |x, y| f32::from(u8::from(depth <= map.view().load(x, y, layer)));
    (
        [
            lit(lo.x, hi.y),
            lit(hi.x, hi.y),
            lit(hi.x, lo.y),
            lit(lo.x, lo.y),
        ],
        c - c.floor(),
    )
}

/// The blending rule measured on lavapipe; other drivers use weights of at least 8 bits.
fn blend(texels: [f32; 4], at: Vec2) -> f32 {
    let [low_left, low_right, high_right, high_left] = texels;
    let row = |left: f32, right: f32| right * at.x + left * (1.0 - at.x);
    let high = row(high_left, high_right);
    let low = row(low_left, low_right);
    at.y.mul_add(low - high, high)
}

#[test]
fn comparisons_blend_four_texels() {
    let gpu = &mut gpu();
    let questions = questions();
    let tolerance = if gpu.promises_bits() {
        0.0
    } else {
        2.0 / 256.0
    };
    for (layers, layer) in [(1, 0), (3, 0), (3, 2)] {
        for format in [Format::Depth32, Format::Depth16] {
            let map = map(layers, format);
            let answers = run_lookup(gpu, &map, &questions, Arc::new(Sampled(numbers(layer))));
            let expected = |i: usize, layer| {
                let p = questions.position(i);
                let (lit, at) = texels_around(&map, layer, p.truncate(), p.z);
                blend(lit, at)
            };
            let wrong = |layer| {
                (0..answers.len())
                    .filter(|&i| (answers[i] - expected(i, layer)).abs() > tolerance)
                    .count()
            };
            assert_eq!(wrong(layer), 0, "{format:?}, layer {layer} of {layers}");
            let between = answers.iter().filter(|&&v| v > 0.1 && v < 0.9).count();
            assert!(
                between > answers.len() / 4,
                "{between} answers are between dark and lit"
            );
            assert!(
                layers == 1 || wrong(1) > answers.len() / 4,
                "another layer must show"
            );
        }
    }
}

#[test]
fn gathered_comparisons_come_in_wgsl_order() {
    let gpu = &mut gpu();
    let questions = questions();
    for (layers, layer) in [(1, 0), (3, 2)] {
        let map = map(layers, Format::Depth32);
        let answers = run_lookup(gpu, &map, &questions, Arc::new(Gathered(numbers(layer))));
        let expected = |i: usize| {
            let p = questions.position(i);
            let ([a, b, c, d], at) = texels_around(&map, layer, p.truncate(), p.z);
            // Skip positions that are equally near to two texels within rounding, where drivers may
            // gather either.
            let clear = [at.x, at.y].iter().all(|&s| s > 1e-3 && s < 1.0 - 1e-3);
            clear.then_some(a + 10.0 * b + 100.0 * c + 1000.0 * d)
        };
        let clear: Vec<_> = (0..answers.len())
            .filter_map(|i| Some((answers[i], expected(i)?)))
            .collect();
        assert!(
            clear.len() > answers.len() / 2,
            "{} of {} places are clear",
            clear.len(),
            answers.len()
        );
        assert!(clear.iter().all(|(have, wanted)| have == wanted));
    }
}

#[test]
fn kernels_that_compare_load_as_others_do() {
    let gpu = &mut gpu();
    let mut questions = questions();
    for i in 0..questions.len() {
        questions.x[i] = noise(2 * i);
        questions.y[i] = noise(2 * i + 1);
    }
    let map = map(2, Format::Depth32);
    let answers = run_lookup(gpu, &map, &questions, Arc::new(Loaded(numbers(1))));
    for (i, answer) in answers.iter().enumerate() {
        let p = questions.position(i).truncate() * map.desc.size.as_vec2();
        assert_eq!(*answer, map.view().load(p.x as i32, p.y as i32, 1));
    }
    assert!(questions.triangle.iter().all(|&t| t != NO_TRIANGLE));
}

#[test]
fn pasted_text_compares_on_a_foreign_device() {
    let stage = BackendScene::new();
    let foreign = Foreign::new();
    let recipe = stage.recipe_with(64, Arc::new(Sampled(numbers(0))));
    let q = questions();
    let flat: Vec<Vec4> = (0..q.len()).map(|i| q.position(i).extend(1.0)).collect();
    let texture = foreign.texture(
        TextureFormat::Rgba32Float,
        q.size,
        bytemuck::cast_slice(&flat),
    );
    let receivers = GBuffer {
        position: &texture,
        normal: &texture,
        triangle: None,
    };
    let mut renderer = ShadowRenderer::new(
        &foreign.device,
        &foreign.queue,
        RendererOptions {
            kernel_group: 1,
            ..RendererOptions::default()
        },
    )
    .expect("there are two groups");
    let frame = FrameInputs {
        size: q.size,
        casters: &[],
        everything: &[],
        receivers,
    };
    renderer.prepare(&recipe, &frame).expect("all is valid");
    let mut encoder = foreign.encoder();
    for target in renderer.cast_targets().expect("it was prepared") {
        foreign.draw_casters(&mut encoder, target, &stage.geometry);
    }
    let mask = renderer
        .encode_filters_and_receive(&mut encoder)
        .expect("it was prepared")
        .clone();
    let kernel = renderer.receive_bind_group().expect("it was prepared");
    let pasted = foreign.shade(
        &mut encoder,
        &receive_wgsl(&recipe, 1, "").expect("no prefix"),
        kernel,
        &texture,
        q.size,
    );
    let pasted = read(&foreign, encoder, &pasted);
    let own = read(&foreign, foreign.encoder(), mask.texture());
    assert_eq!(pasted, own);
    assert!(own.contains(&0.0) && own.contains(&1.0));
}
