//! Tests of each cause of error on a scene that isolates it. The reference's own technique has no
//! cause of error.

use umbrage_core::{
    Backend, Camera, Geometry, ShadowTechnique, View,
    metrics::{Cause, Causes},
};
use umbrage_cpu::Cpu;
use umbrage_lab::causes::{CauseExample, faults};
use umbrage_plan::truth::{Truth, TruthOptions, trace};
use umbrage_techniques::{Bias, Hard, MapFilter as _, ShadowMap, Traced};

struct CausesScene {
    geometry: Geometry,
    truth: Truth,
    scene: umbrage_core::Scene,
}

impl CausesScene {
    fn new(name: &str) -> Self {
        let scene = (umbrage_scenes::find(name).expect("a built-in scene").build)();
        let geometry = Geometry::bake(&scene).expect("built-in scenes are valid");
        let options = TruthOptions {
            samples: 256,
            ..TruthOptions::default()
        };
        let mut cpu = Cpu::new();
        let find = &mut |c: &Camera, g: &Geometry| cpu.receivers(c, g);
        let truth = trace(
            &scene.cameras[0],
            &scene.lights[0],
            &geometry,
            &options,
            find,
            &|_, _| {},
        )
        .expect("valid");
        Self {
            geometry,
            truth,
            scene,
        }
    }

    fn causes(&self, technique: &dyn ShadowTechnique) -> Causes {
        let view = View::new(
            &self.scene.cameras[0],
            &self.scene.lights[0],
            &self.geometry,
        );
        let recipe = technique
            .recipe(&view.with_receivers(&self.truth.receivers))
            .expect("supported");
        let mask = Cpu::new().render(&view, &recipe).expect("renders").mask;
        Causes::measure(&mask, &self.truth.image().expect("valid")).expect("valid")
    }
}

fn shares(c: &Causes) -> [(Cause, f64); 5] {
    [
        (Cause::Acne, c.acne),
        (Cause::Gap, c.gap),
        (Cause::Leak, c.leak),
        (Cause::Edge, c.edge),
        (Cause::Penumbra, c.penumbra),
    ]
}

#[test]
fn each_cause_shows_alone_on_its_scene() {
    for CauseExample {
        scene: name,
        technique,
        cause: expected,
    } in faults()
    {
        let causes = CausesScene::new(name).causes(&technique);
        println!("{name}: {causes:?}");
        for (cause, share) in shares(&causes) {
            if cause == expected {
                // A step of 255 over all evaluated pixels, which exceeds the sum of all rounding.
                assert!(share > 1.0 / 255.0, "{name}: {causes:?}");
            } else {
                assert_eq!(share, 0.0, "{name}: {causes:?}");
            }
        }
    }
}

/// The reference's own technique has no error of any kind, except for the noise of its rays under
/// an area light.
#[test]
fn the_reference_has_no_errors() {
    for CauseExample {
        scene: name,
        cause: expected,
        ..
    } in faults()
    {
        let causes = CausesScene::new(name).causes(&Traced { samples: 1024 });
        for (cause, share) in shares(&causes) {
            // The error of 1,024 stratified rays is about 1/1024 to 1/32 of the light, and only in
            // penumbrae.
            let noise = if cause == Cause::Penumbra && expected == Cause::Penumbra {
                1e-3
            } else {
                0.0
            };
            assert!(share <= noise, "{name}: {causes:?}");
        }
    }
}

/// The length of a gap follows from the bias: at 45 degrees, a constant's depth is the distance
/// from the blocker.
#[test]
fn a_gap_has_the_biases_length() {
    let stage = CausesScene::new("cause-gap");
    let gap = |constant| {
        let bias = Bias {
            constant,
            ..Bias::NONE
        };
        stage
            .causes(&Hard {}.on(ShadowMap {
                size: 2048,
                bias,
                ..ShadowMap::default()
            }))
            .gap_metres
            .expect("a gap")
    };
    let ratio = gap(0.06) / gap(0.03);
    // Rows of pixels are 8 mm apart on the ground, and the shorter gap is five times as long.
    assert!((ratio - 2.0).abs() < 0.4, "{ratio}");
}
