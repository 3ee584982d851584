//! Tests that errors decrease with finer maps: with the default bias, errors decrease at least like
//! the side of a texel.
//!
//! A hard shadow's map is wrong in a band along shadow edges that is about a texel wide. The number
//! of wrong pixels is therefore proportional to 1 / side, and the root mean square error to its
//! root. Acne, detached shadows, and leaks of constant size would violate that.

use glam::UVec2;
use umbrage_core::{
    Aabb, Backend, Camera, FitMemory, Geometry, Light, ShadowTechnique, View,
    metrics::{Errors, ReferenceMask},
};
use umbrage_cpu::Cpu;
use umbrage_lab::bias::lights_around;
use umbrage_plan::truth::{TruthOptions, trace};
use umbrage_techniques::{Hard, MapFilter as _, Pcf, ShadowMap};

/// Models that are finely and coarsely tessellated, closed and open, smooth and with edges.
const MODELS: [&str; 8] = [
    "statue",
    "figure",
    "teapot-lamp",
    "c8-faceted-sphere",
    "broken-meshes",
    "open-shells",
    "rising-boxes",
    "stairs",
];
const COARSE: u32 = 512;
const FINE: u32 = 8192;
const SIZE: UVec2 = UVec2::new(320, 240);
/// Greatest mean signed error at the finest map: shadows have the right width.
const MOST_SIGNED: f64 = 1e-3;

/// Bounds of the casters on the floor: of everything that is not flat.
fn bounds_above_floor(geometry: &Geometry) -> Aabb {
    let floor = geometry.bounds().min.y;
    let height = geometry.bounds().extent().y;
    Aabb::from_points(
        geometry
            .positions()
            .iter()
            .copied()
            .filter(|p| p.y > floor + 0.02 * height),
    )
}

fn errors(
    view: &View<'_>,
    technique: &dyn ShadowTechnique,
    reference: &ReferenceMask<'_>,
) -> Errors {
    let recipe = technique.recipe(view).expect("served");
    let mask = Cpu::new().render(view, &recipe).expect("renders").mask;
    reference.errors(&mask).expect("a mask of this size")
}

/// Sum of squared errors, as a number of wrong pixels.
fn wrong(errors: &Errors) -> f64 {
    errors.rmse.powi(2) * errors.counted as f64
}

#[test]
fn errors_fall_with_the_texel() {
    for name in MODELS {
        let scene = (umbrage_scenes::find(name).expect("built in").build)();
        let geometry = Geometry::bake(&scene).expect("a good scene");
        let camera = scene.cameras[0].with_size(SIZE);
        let lights = lights_around(bounds_above_floor(&geometry));
        for (light_name, light) in lights
            .iter()
            .filter(|(light_name, _)| light_name != "low sun")
        {
            converges(
                &format!("{name} under the {light_name}"),
                &camera,
                light,
                &geometry,
            );
        }
    }
}

fn converges(what: &str, camera: &Camera, light: &Light, geometry: &Geometry) {
    let mut cpu = Cpu::new();
    let mut find = |camera: &_, geometry: &_| cpu.receivers(camera, geometry);
    let truth = trace(
        camera,
        light,
        geometry,
        &TruthOptions::default(),
        &mut find,
        &|_, _| {},
    )
    .expect("valid");
    let reference = ReferenceMask::new(truth.size, &truth.visibility, &truth.pixels)
        .expect("truth fits itself");
    let fits = FitMemory::default();
    let view = View::new(camera, light, geometry)
        .with_receivers(&truth.receivers)
        .with_fits(&fits);
    let hard = |size| {
        Hard {}.on(ShadowMap {
            size,
            ..ShadowMap::default()
        })
    };
    let pcf = |size| {
        Pcf::new(1).on(ShadowMap {
            size,
            ..ShadowMap::default()
        })
    };
    let techniques: [[Box<dyn ShadowTechnique>; 2]; 2] = [
        [Box::new(hard(COARSE)), Box::new(hard(FINE))],
        [Box::new(pcf(COARSE)), Box::new(pcf(FINE))],
    ];
    for [coarse, fine] in techniques {
        let [before, after] =
            [&coarse, &fine].map(|technique| errors(&view, &**technique, &reference));
        let expected = wrong(&before) / f64::from(FINE / COARSE);
        // Allow as many random errors as a Poisson distribution of that mean exceeds in one of
        // 1,000 cases.
        let most = expected + 3.1 * expected.sqrt() + 3.1;
        let name = coarse.name();
        println!(
            "{what}, {name}: {:.1} wrong, then {:.1} of {most:.1}",
            wrong(&before),
            wrong(&after)
        );
        assert!(
            wrong(&after) <= most,
            "{what}, {name}: {before:?} at {COARSE}, {after:?} at {FINE}"
        );
        assert!(
            after.bias.abs() <= MOST_SIGNED,
            "{what}, {name}: {after:?} at {FINE}"
        );
    }
}
