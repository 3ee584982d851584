//! Test of the lab's yardstick: the same work on both backends.

use umbrage_core::{Backend, Geometry, ShadowTechnique, View, join};
use umbrage_cpu::Cpu;
use umbrage_techniques::{Hard, MapTechnique};
use umbrage_tests::{gpu::gpu, layouts::check};
use umbrage_yardstick::Yardstick;

#[test]
fn the_yardstick_is_the_same_work_on_both_backends() {
    let scene = (umbrage_scenes::find("cubes").expect("built in").build)();
    let camera = scene.cameras[0].with_size(umbrage_core::glam::UVec2::new(160, 120));
    let geometry = Geometry::bake(&scene).expect("valid");
    let receivers = Cpu::new().receivers(&camera, &geometry).expect("valid");
    let view = View::new(&camera, &scene.lights[0], &geometry).with_receivers(&receivers);
    let row = MapTechnique::<Hard>::default()
        .recipe(&view)
        .expect("supported");
    let [short, long] =
        [0.1, 10.0].map(|cost| Yardstick::new(&row, &receivers, cost).expect("something receives"));
    assert!(
        long.units > 50.0 * short.units,
        "{} against {}",
        long.units,
        short.units
    );
    for yardstick in [short, long] {
        let kernel = &yardstick.recipe.receive.kernel;
        let uniforms = kernel.uniforms().expect("it has some");
        check(&uniforms.uniform_layout(), &join(&kernel.modules()))
            .expect("uniforms lie where the shader reads them");
        let mine = Cpu::new()
            .render(&view, &yardstick.recipe)
            .expect("renders")
            .mask;
        let theirs = gpu()
            .render(&view, &yardstick.recipe)
            .expect("renders")
            .mask;
        // All numbers are integers up to the last division.
        let differing = mine
            .iter()
            .zip(&theirs)
            .filter(|(a, b)| (*a - *b).abs() > 1e-6)
            .count();
        assert_eq!(differing, 0);
        let mut values: Vec<u32> = mine.iter().map(|v| (v * 255.0) as u32).collect();
        values.sort_unstable();
        values.dedup();
        assert!(
            values.len() > 200,
            "every chain ends elsewhere: {} values",
            values.len()
        );
    }
}
