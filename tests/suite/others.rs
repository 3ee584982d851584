//! The prototypes of what others have and the library has not: see docs/others.md.

use umbrage::{
    Backend, Geometry, Receivers, Scene, ShadowTechnique, View,
    glam::{UVec2, Vec3},
    metrics::{Errors, Pixel},
    techniques::{Hard, MapFilter as _, ShadowMap},
};
use umbrage_cpu::Cpu;
use umbrage_examples::{
    contact::ContactShadows,
    panes::{Glass, Panes, shards, transmitted, window},
};
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
        Self::of(umbrage::scenes::by_argument(name).expect("a built-in scene"))
    }

    fn of(scene: Scene) -> Self {
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
    let walk = |pixels, thickness| ContactShadows {
        map,
        radius: 0,
        pixels,
        thickness,
    };
    let mut cpu = Cpu::new();
    let hard = judged.mask(&mut cpu, &Hard {}.on(map));
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

/// Three coloured panes in the sun, and two more behind them; then many that hang above each other.
#[test]
fn coloured_shadows_come_near_rays_through_the_panes_and_agree_on_both_backends() {
    let size = UVec2::new(320, 180);
    for scene in [window::scene(size), shards::scene(size)] {
        check_coloured_shadows(&Judged::of(scene.expect("valid")));
    }
}

fn check_coloured_shadows(judged: &Judged) {
    let scene = &judged.scene;
    let through = |glass| transmitted(scene, judged.receivers(), glass).expect("valid");
    // Rays through panes that let nothing through are those of the truth that all other techniques are compared with.
    let of_opaque = window::GLASS.map(|glass| Glass {
        transmittance: Vec3::ZERO,
        ..glass
    });
    let pixels = &judged.truth.pixels;
    for (i, share) in through(&of_opaque).into_iter().enumerate() {
        if pixels[i] == Pixel::Counted {
            assert_eq!(share, Vec3::splat(judged.truth.visibility[i]), "pixel {i}");
        }
    }
    let truth = through(&window::GLASS);
    let map = ShadowMap {
        size: 1024,
        ..ShadowMap::default()
    };
    let panes = |colour, glass, dithered| Panes {
        map,
        radius: 1,
        glass,
        colour,
        dithered,
    };
    // Spoilt: each pane has the colour of its neighbour.
    let [red, green, blue] = window::GLASS.map(|glass| glass.transmittance);
    let mut swapped = window::GLASS;
    for (glass, other) in swapped.iter_mut().zip([green, blue, red]) {
        glass.transmittance = other;
    }
    let mut cpu = Cpu::new();
    let mut gpu = gpu();
    for colour in 0..3 {
        let wanted: Vec<f32> = truth.iter().map(|share| share[colour]).collect();
        let error = |mask: &[f32]| {
            let errors = Errors::measure(judged.truth.size, mask, &wanted, pixels);
            errors.expect("valid").rmse
        };
        let opaque = error(&judged.mask(&mut cpu, &Hard {}.on(map)));
        let spoilt = error(&judged.mask(&mut cpu, &panes(colour, swapped, false)));
        for dithered in [false, true] {
            let technique = panes(colour, window::GLASS, dithered);
            let mask = judged.mask(&mut cpu, &technique);
            let found = error(&mask);
            assert!(
                found < 0.5 * opaque.min(spoilt),
                "{}, colour {colour}, holes {dithered}: {found}; {opaque} of opaque panes, {spoilt} of others' colours",
                scene.name
            );
            let on_gpu = judged.mask(&mut *gpu, &technique);
            let differing = mask.iter().zip(&on_gpu).filter(|(a, b)| a != b).count();
            assert_eq!(
                differing, 0,
                "pixels that differ, {}, colour {colour}",
                scene.name
            );
        }
    }
}
