//! Finer maps are better without end: with the default bias, what is wrong falls at least like a
//! texel's side.
//!
//! A hard shadow's map is wrong in a band along shadow edges that is about a texel wide, so the
//! number of wrong pixels falls like 1 / side and the root mean square error like its root. Acne,
//! shadows that come loose and leaks that don't shrink with the texel would end that.

use glam::UVec2;
use umbrage_core::{
    Aabb, Backend, Camera, FitMemory, Geometry, Light, ShadowTechnique, View,
    metrics::{Errors, ReferenceMask},
};
use umbrage_cpu::Cpu;
use umbrage_lab::bias::lights_around;
use umbrage_plan::truth::{TruthOptions, trace};
use umbrage_techniques::{Hard, MapFilter as _, Pcf, ShadowMap};

/// Finely and coarsely tessellated, closed and open, smooth and with edges.
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
/// Mean signed error allowed at the finest map: shadows are neither wider nor narrower than they
/// should be.
const MOST_SIGNED: f64 = 1e-3;

/// What stands on the floor: the bounds of all that is not flat.
fn bounds_above_floor(geometry: &Geometry) -> Aabb {
    let floor = geometry.bounds().min.y;
    let height = geometry.bounds().extent().y;
    Aabb::around(
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
    let mask = Cpu::new().render(view, &recipe).expect("plays").mask;
    reference.errors(&mask).expect("a mask of this size")
}

/// Wrong pixels, in squares.
fn wrong(errors: &Errors) -> f64 {
    errors.rmse.powi(2) * errors.counted as f64
}

#[test]
fn errors_fall_with_the_texel() {
    for name in MODELS {
        let scene = (umbrage_scenes::find(name).expect("built in").build)();
        let geometry = Geometry::bake(&scene).expect("a good scene");
        let camera = scene.cameras[0].resized(SIZE);
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
        Pcf { radius: 1 }.on(ShadowMap {
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
        // As many pixels are wrong by chance as a Poisson distribution of that mean allows in one
        // of 1,000 cases.
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
