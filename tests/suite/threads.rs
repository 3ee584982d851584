//! Tests that threads change no result: the CPU backend's, vector instructions, and a program's
//! thread that polls the device.

use glam::UVec2;
use std::sync::atomic::{AtomicBool, Ordering};
use umbrage_core::{Backend, Geometry, ShadowTechnique, Simd, View};
use umbrage_cpu::{Cpu, CpuOptions};
use umbrage_plan::catalogue::all;
use umbrage_techniques::{Hard, MapTechnique};
use umbrage_tests::gpu::gpu;

#[test]
fn threads_and_vectors_change_nothing() {
    // The last one has an area light, for which soft shadows search and filter.
    for name in ["cubes", "figure", "teapot-lamp"] {
        let mut scene = (umbrage_scenes::find(name).expect("a built-in scene").build)();
        scene.cameras[0] = scene.cameras[0].with_size(UVec2::new(160, 120));
        let geometry = Geometry::bake(&scene).expect("valid");
        let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
        for technique in all().iter().flat_map(|e| (e.exhaustive)(200)) {
            let Ok(mut recipe) = technique.recipe(&view) else {
                continue;
            };
            recipe.keep_images = true;
            let render = |threads: usize, simd: Simd| {
                let options = CpuOptions::default().threads(threads).simd(simd);
                let mut cpu = Cpu::with_options(&options).expect("threads start");
                let s = cpu.render(&view, &recipe).expect("renders");
                let bits = |v: &[f32]| v.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
                let images: Vec<_> = s.images.iter().map(|i| bits(&i.texels)).collect();
                (
                    bits(&s.mask),
                    images,
                    s.receivers.expect("made here").triangle,
                )
            };
            let one = render(1, Simd::Baseline);
            let label = format!("{name}: {} {}", technique.name(), technique.settings());
            assert!(
                one == render(1, Simd::Native),
                "{label}: vector instructions changed the result"
            );
            assert!(
                one == render(5, Simd::Native),
                "{label}: threads changed the result"
            );
        }
    }
}

/// A program may poll the device on a separate thread, which then executes the callbacks of a
/// readback.
#[test]
fn read_backs_wait_for_callbacks_of_other_threads() {
    let scene = (umbrage_scenes::find("cubes")
        .expect("a built-in scene")
        .build)();
    let geometry = Geometry::bake(&scene).expect("valid");
    let camera = scene.cameras[0].with_size(UVec2::new(160, 120));
    let view = View::new(&camera, &scene.lights[0], &geometry);
    let recipe = MapTechnique::<Hard>::default()
        .recipe(&view)
        .expect("renders");
    let mut gpu = gpu();
    let device = gpu.device().0.clone();
    let is_over = AtomicBool::new(false);
    let poll_again = || {
        while !is_over.load(Ordering::Acquire) {
            device.poll(wgpu::PollType::Poll).expect("polls");
        }
    };
    let failures: Vec<_> = std::thread::scope(|scope| {
        for _ in 0..3 {
            scope.spawn(poll_again);
        }
        let rendered = (0..200).map(|_| gpu.render(&view, &recipe).err());
        let failures = rendered.flatten().collect();
        is_over.store(true, Ordering::Release);
        failures
    });
    assert!(failures.is_empty(), "{}: {failures:?}", failures.len());
}
