//! Techniques without a rasteriser in their answer: the same bits on every device that rounds sums and products to nearest.
//!
//! `none`, `traced`, `exact` and `soft` are functions of the receivers alone. Where both backends see the same triangle, receivers and
//! masks are equal to the last bit, even if the driver fuses products with sums, or misses quotients and roots. Only a driver that
//! re-associates sums may change pixels, and these are undecided.

use glam::UVec2;
use umbrage_core::{Backend, Geometry, Scene, ShadowTechnique, View};
use umbrage_cpu::Cpu;
use umbrage_lab::compare;
use umbrage_techniques::{Exact, Pcss, Soft, Traced, Unshadowed, Vsm};
use umbrage_tests::{driver_model::DriverModel, gpu::gpu};

/// Built-in scenes of every kind of light: ideal, wide, far from the origin, along surfaces, with casters that have holes.
const SCENES: &[&str] = &[
    "cubes",
    "stairs",
    "stairs-lamp",
    "sun-above",
    "spot-above",
    "lamp-in-room",
    "bar-at-lamp",
    "canopy",
    "two-blockers",
    "rising-boxes-disc",
    "low-sun-2",
    "hills-1e5",
    "hills-1e6",
    "open-shells",
    "c3-sphere-bulb",
];

/// Greatest width, pixels.
const WIDTH: u32 = 240;

fn techniques() -> [Box<dyn ShadowTechnique>; 4] {
    let traced = Traced {
        samples: 8,
        ..Traced::default()
    };
    [
        Box::new(Unshadowed::default()),
        Box::new(traced),
        Box::new(Exact::default()),
        Box::new(Soft::default()),
    ]
}

/// Map techniques, whose bits drivers may change: the control of a model.
fn controls() -> [Box<dyn ShadowTechnique>; 2] {
    [Box::new(Vsm::default()), Box::new(Pcss::default())]
}

/// Pixels of a mask, by what two backends make of them.
#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    same_triangle: usize,
    other_bits: usize,
}

fn scene(name: &str) -> (Scene, Geometry) {
    let mut scene = (umbrage_scenes::find(name).expect("a built-in scene").build)();
    let camera = &mut scene.cameras[0];
    let height = (WIDTH * camera.size.y / camera.size.x).max(1);
    *camera = camera.resized(UVec2::new(WIDTH, height));
    let geometry = Geometry::bake(&scene).expect("built-in scenes are valid");
    (scene, geometry)
}

#[test]
fn masks_are_equal_where_triangles_are() {
    let model = DriverModel::from_env();
    let mut sum = Counts::default();
    let mut faults = Vec::new();
    for name in SCENES {
        let (scene, geometry) = scene(name);
        let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
        for technique in techniques() {
            let Ok(recipe) = technique.recipe(&view) else {
                continue;
            };
            let mine = Cpu::new().render(&view, &recipe).expect("valid");
            let mut gpu = gpu();
            let theirs = gpu.render(&view, &recipe).expect("valid");
            let label = format!("{} in {name}", technique.name());
            if model == Some(DriverModel::Reassociated) {
                let agreement = compare::agree(&view, &recipe, &mine, &theirs, gpu.snapping())
                    .expect("masks of one size");
                if !agreement.holds() {
                    faults.push(format!("{label}: {agreement:?}"));
                }
                continue;
            }
            let [seen, other] = [&mine, &theirs].map(|s| s.receivers.as_ref().expect("none given"));
            let same = (0..mine.mask.len()).filter(|&i| seen.triangle[i] == other.triangle[i]);
            let counts = same.fold(Counts::default(), |counts, i| Counts {
                same_triangle: counts.same_triangle + 1,
                other_bits: counts.other_bits
                    + usize::from(mine.mask[i].to_bits() != theirs.mask[i].to_bits()),
            });
            if counts.other_bits > 0 {
                faults.push(format!("{label}: {counts:?}"));
            }
            sum.same_triangle += counts.same_triangle;
        }
    }
    println!(
        "{model:?}: {} pixels of the same triangle",
        sum.same_triangle
    );
    assert!(faults.is_empty(), "{faults:#?}");
    assert!(model == Some(DriverModel::Reassociated) || sum.same_triangle > 1_000_000);
}

/// A model that changes no technique's bits would prove nothing.
#[test]
fn each_model_changes_bits_of_maps() {
    let Some(model) = DriverModel::from_env() else {
        return;
    };
    let mut differing = 0;
    for name in ["cubes", "lamp-in-room"] {
        let (scene, geometry) = scene(name);
        let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
        for technique in controls() {
            let recipe = technique.recipe(&view).expect("supported");
            let mine = Cpu::new().render(&view, &recipe).expect("valid").mask;
            let theirs = gpu().render(&view, &recipe).expect("valid").mask;
            let pairs = mine.iter().zip(&theirs);
            differing += pairs.filter(|(a, b)| a.to_bits() != b.to_bits()).count();
        }
    }
    println!("{model:?}: {differing} pixels of maps have other bits");
    assert!(differing >= 20, "only {differing} pixels have other bits");
}

/// What the probe reports is what the driver does; and nothing fuses through `product`.
#[test]
fn the_probe_reports_fusing() {
    let is_fused = DriverModel::from_env() == Some(DriverModel::Fused);
    let gpu = gpu();
    let found = gpu.fusing().expect("the device draws");
    println!("{found}");
    assert!(!found.guarded_product, "{found}");
    if is_fused || gpu.check_pinned_driver().is_ok() {
        assert_eq!(found.product_and_sum, is_fused, "{found}");
    }
}
