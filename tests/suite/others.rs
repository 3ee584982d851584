//! The prototypes of what others have and the library has not: see docs/others.md.

use umbrage::{
    Backend, Geometry, Receivers, Scene, ShadowTechnique, View,
    metrics::Errors,
    techniques::{Hard, ShadowMap},
};
use umbrage_cpu::Cpu;
use umbrage_examples::contact::Contact;
use umbrage_plan::truth::{Truth, TruthOptions, trace};
use umbrage_tests::gpu::gpu;

/// A scene with what is known of it.
struct Judged {
    scene: Scene,
    geometry: Geometry,
    truth: Truth,
}

impl Judged {
    fn new(name: &str) -> Self {
        let scene = umbrage::scenes::by_argument(name).expect("a built-in scene");
        let geometry = Geometry::bake(&scene).expect("valid");
        let mut cpu = Cpu::new();
        let truth = trace(
            &scene.cameras[0],
            &scene.lights[0],
            &geometry,
            &TruthOptions::default(),
            &mut |camera, geometry| cpu.receivers(camera, geometry),
            &|_, _| (),
        );
        let truth = truth.expect("valid");
        Self {
            scene,
            geometry,
            truth,
        }
    }

    fn receivers(&self) -> &Receivers {
        &self.truth.receivers
    }

    fn mask(&self, backend: &mut dyn Backend, technique: &dyn ShadowTechnique) -> Vec<f32> {
        let camera = &self.scene.cameras[0];
        let view = View::new(camera, &self.scene.lights[0], &self.geometry)
            .with_receivers(self.receivers());
        let recipe = technique.recipe(&view).expect("a map serves it");
        backend.render(&view, &recipe).expect("plays").mask
    }

    fn errors(&self, mask: &[f32]) -> Errors {
        let truth = &self.truth;
        Errors::measure(truth.size, mask, &truth.visibility, &truth.pixels).expect("valid")
    }
}

/// A plate that stands on a floor, under a map so coarse that light leaks in at its foot.
#[test]
fn contact_shadows_close_the_gap_at_a_foot_and_agree_on_both_backends() {
    let judged = Judged::new("thin-plate");
    let map = ShadowMap {
        size: 64,
        ..ShadowMap::default()
    };
    let walk = |pixels, thickness| Contact {
        map,
        radius: 0,
        pixels,
        thickness,
    };
    let mut cpu = Cpu::new();
    let hard = judged.mask(&mut cpu, &Hard { map });
    let without_walk = judged.mask(&mut cpu, &walk(0, 0.01));
    assert_eq!(without_walk, hard, "no pixel to walk");
    let walked = judged.mask(&mut cpu, &walk(60, 0.01));
    let leak = judged.errors(&hard).false_light;
    let left = judged.errors(&walked).false_light;
    assert!(
        leak > 0.0 && left < 0.8 * leak,
        "{leak} % lit wrongly, {left} % with the walk"
    );
    // Spoilt: what is seen is thinner than anything is.
    let too_thin = judged.mask(&mut cpu, &walk(60, 1e-6));
    let still = judged.errors(&too_thin).false_light;
    assert!(
        still > left,
        "{still} % lit wrongly where nothing has a thickness"
    );
    let on_gpu = judged.mask(&mut *gpu(), &walk(60, 0.01));
    let differing = walked.iter().zip(&on_gpu).filter(|(a, b)| a != b).count();
    assert_eq!(differing, 0, "pixels that differ");
}
