//! Test of the CPU backend's memory: its peak is at most three times the size of the maps and
//! receivers.

use peak_alloc::PeakAlloc;

use umbrage_core::{Backend, Geometry, ShadowTechnique, View, glam::UVec2};
use umbrage_cpu::Cpu;
use umbrage_techniques::{MapFilter as _, Pcf, ShadowMap};

#[global_allocator]
static ALLOCATIONS: PeakAlloc = PeakAlloc;

/// A single test, since the allocator's peak belongs to the whole program.
#[test]
fn rendering_takes_at_most_three_times_what_it_holds() {
    for (name, map) in [("terrain", 2048), ("town", 1024), ("cubes", 512)] {
        let scene = (umbrage_scenes::find(name).expect("a built-in scene").build)();
        let geometry = Geometry::bake(&scene).expect("valid");
        let camera = scene.cameras[0].with_size(UVec2::new(640, 360));
        let view = View::new(&camera, &scene.lights[0], &geometry);
        let technique = Pcf::new(1).on(ShadowMap {
            size: map,
            ..ShadowMap::default()
        });
        let recipe = technique.recipe(&view).expect("pcf serves the sun");
        let before = ALLOCATIONS.current_usage();
        ALLOCATIONS.reset_peak_usage();
        let mut cpu = Cpu::new();
        let mut held = 0;
        for _ in 0..3 {
            held = cpu.render(&view, &recipe).expect("renders").bytes;
        }
        let peak = (ALLOCATIONS.peak_usage() - before) as f64;
        let ratio = peak / held as f64;
        println!(
            "{name}: {:.1} MB at the peak, {:.1} MB held: {ratio:.2}",
            peak / 1e6,
            held as f64 / 1e6
        );
        // A ratio below one would mean that the counter doesn't work.
        assert!(
            (1.0..=3.0).contains(&ratio),
            "{name}: {ratio:.2} times what it holds"
        );
    }
}
