//! A technique from outside, on both backends: nothing of ours knows it.

use umbrage::{Backend, Geometry, ShadowTechnique, View, techniques::ShadowMap};
use umbrage_cpu::Cpu;
use umbrage_examples::variance::Variance;
use umbrage_plan::footprint;
use umbrage_tests::gpu::gpu;

#[test]
fn a_users_technique_runs_on_both_backends() {
    let scene = umbrage::scenes::by_argument("cubes").expect("a built-in scene");
    let geometry = Geometry::bake(&scene).expect("valid");
    let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
    let technique = Variance {
        map: ShadowMap {
            size: 256,
            ..ShadowMap::default()
        },
        radius: 3,
        least_variance: 1e-6,
    };
    let recipe = technique.plan(&view).expect("variance maps serve the sun");
    let cpu = Cpu::new().render(&view, &recipe).expect("plays");
    let gpu = gpu().render(&view, &recipe).expect("plays");
    let soft = cpu.mask.iter().filter(|&&v| v > 0.05 && v < 0.95).count();
    assert!(
        soft > 100,
        "a variance map has soft edges, here {soft} pixels"
    );
    // Sums of at most 7 products near 1, each rounded; the inequality divides by at least 1e-6.
    let worst = cpu
        .mask
        .iter()
        .zip(&gpu.mask)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f32::max);
    assert!(worst <= 1.0 / 255.0, "the backends differ by {worst}");
}

/// How a user's maps are used is told as that of ours is.
#[test]
fn a_users_map_has_figures() {
    let scene = umbrage::scenes::by_argument("cubes").expect("a built-in scene");
    let geometry = Geometry::bake(&scene).expect("valid");
    let receivers = Cpu::new()
        .receivers(&scene.cameras[0], &geometry)
        .expect("valid");
    let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry).with_receivers(&receivers);
    let map = ShadowMap {
        size: 256,
        ..ShadowMap::default()
    };
    let of = |radius: u32| {
        let technique = Variance {
            map,
            radius,
            least_variance: 1e-6,
        };
        let recipe = technique.plan(&view).expect("variance maps serve the sun");
        let used = footprint::of(&technique, &view, &recipe, &receivers).expect("it has a map");
        assert_eq!(
            used,
            footprint::measure(&view, &recipe, &receivers, radius as f32),
            "the blur's reach"
        );
        used.total
    };
    let [narrow, wide] = [0, 8].map(of);
    assert!(narrow.side.is_some() && narrow.unused > 0.0, "{narrow:?}");
    assert!(
        wide.unused < narrow.unused,
        "{wide:?} against {narrow:?}: a wider blur takes in more texels"
    );
}
