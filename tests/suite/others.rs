//! Tests of the prototypes of other renderers' techniques: see docs/others.md.

use umbrage::{
    Backend, ShadowTechnique,
    glam::{UVec2, Vec3},
    metrics::{Errors, Pixel},
    techniques::{Hard, MapFilter as _, ShadowMap},
};
use umbrage_cpu::Cpu;
use umbrage_examples::{
    judge::JudgedScene,
    rivals::{
        contact::ContactShadows,
        panes::{
            Glass, Panes,
            scenes::{GLASS, shards, window},
            transmitted_light,
        },
    },
};
use umbrage_plan::truth::TruthOptions;
use umbrage_tests::gpu::gpu;

fn mask(
    judged: &JudgedScene,
    backend: &mut dyn Backend,
    technique: &dyn ShadowTechnique,
) -> Vec<f32> {
    let shadows = judged.render(backend, technique);
    shadows.expect("a map serves it").mask
}

/// A plate on a floor, with a map so coarse that light leaks in at its foot.
#[test]
fn contact_shadows_close_the_gap_at_a_foot_and_agree_on_both_backends() {
    let options = TruthOptions::default();
    let judged = JudgedScene::by_argument("thin-plate", None, &options).expect("a built-in scene");
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
    let hard = mask(&judged, &mut cpu, &Hard {}.on(map));
    let without_walk = mask(&judged, &mut cpu, &walk(0, 0.01));
    assert_eq!(without_walk, hard, "no pixel to walk");
    let walked = mask(&judged, &mut cpu, &walk(60, 0.01));
    let false_light = |mask: &[f32]| {
        let judged_mask = judged.judge(mask.to_vec()).expect("of one size");
        judged_mask.errors.false_light
    };
    let leak = false_light(&hard);
    let left = false_light(&walked);
    assert!(
        leak > 0.0 && left < 0.8 * leak,
        "{leak} % lit wrongly, {left} % with the walk"
    );
    // Negative control: a thickness that is too small for everything.
    let too_thin = mask(&judged, &mut cpu, &walk(60, 1e-6));
    let still = false_light(&too_thin);
    assert!(
        still > left,
        "{still} % lit wrongly where nothing has a thickness"
    );
    let on_gpu = mask(&judged, &mut *gpu(), &walk(60, 0.01));
    let differing = walked.iter().zip(&on_gpu).filter(|(a, b)| a != b).count();
    assert_eq!(differing, 0, "pixels that differ");
}

/// Three coloured panes in the sun, with two more behind them; then many that overlap.
#[test]
fn coloured_shadows_come_near_rays_through_the_panes_and_agree_on_both_backends() {
    let size = UVec2::new(320, 180);
    for scene in [window(size), shards(size)] {
        let judged = JudgedScene::new(scene.expect("valid"), &TruthOptions::default());
        check_coloured_shadows(&judged.expect("valid"));
    }
}

fn check_coloured_shadows(judged: &JudgedScene) {
    let scene = &judged.scene;
    let through = |glass| transmitted_light(scene, &judged.truth.receivers, glass).expect("valid");
    // Rays through opaque panes equal the reference of all other techniques.
    let of_opaque = GLASS.map(|glass| Glass {
        transmittance: Vec3::ZERO,
        ..glass
    });
    let pixels = &judged.truth.pixels;
    for (i, share) in through(&of_opaque).into_iter().enumerate() {
        if pixels[i] == Pixel::Counted {
            assert_eq!(share, Vec3::splat(judged.truth.visibility[i]), "pixel {i}");
        }
    }
    let truth = through(&GLASS);
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
    // Negative control: each pane has the colour of its neighbour.
    let [red, green, blue] = GLASS.map(|glass| glass.transmittance);
    let mut swapped = GLASS;
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
        let opaque = error(&mask(judged, &mut cpu, &Hard {}.on(map)));
        let spoilt = error(&mask(judged, &mut cpu, &panes(colour, swapped, false)));
        for dithered in [false, true] {
            let technique = panes(colour, GLASS, dithered);
            let on_cpu = mask(judged, &mut cpu, &technique);
            let found = error(&on_cpu);
            assert!(
                found < 0.5 * opaque.min(spoilt),
                "{}, colour {colour}, holes {dithered}: {found}; {opaque} of opaque panes, {spoilt} of swapped colours",
                scene.name
            );
            let on_gpu = mask(judged, &mut *gpu, &technique);
            let differing = on_cpu.iter().zip(&on_gpu).filter(|(a, b)| a != b).count();
            assert_eq!(
                differing, 0,
                "pixels that differ, {}, colour {colour}",
                scene.name
            );
        }
    }
}
