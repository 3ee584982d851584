//! Tests of techniques without a rasteriser in their result, which is bit-equal on every device
//! that rounds sums and products to nearest.
//!
//! `none`, `traced`, `exact` and `soft` are functions of the receivers alone. Where both backends
//! see the same triangle, receivers and masks are bit-equal, even if the driver fuses products with
//! sums, or returns inexact quotients and roots. Only a driver that re-associates sums may change
//! pixels, and these are undecided.

use umbrage_core::{Backend, Geometry, ShadowTechnique, View};
use umbrage_cpu::Cpu;
use umbrage_lab::{
    card::{BitCounts, compare_bits},
    compare,
};
use umbrage_techniques::{MapTechnique, Pcss, Vsm};
use umbrage_tests::{driver_model::DriverModel, gpu::gpu};

/// Map techniques, whose bits depend on the driver, as negative controls of a model.
fn controls() -> [Box<dyn ShadowTechnique>; 2] {
    [
        Box::new(MapTechnique::<Vsm>::default()),
        Box::new(MapTechnique::<Pcss>::default()),
    ]
}

#[test]
fn masks_are_equal_where_triangles_are() {
    let model = DriverModel::from_env();
    let mut same_triangle = 0;
    let mut faults = Vec::new();
    let mut gpu = gpu();
    let snapping = gpu.snapping();
    compare_bits(&mut *gpu, &mut |pair| {
        let label = format!("{} in {}", pair.technique, pair.scene);
        let [mine, theirs] = [&pair.of_cpu, &pair.of_device];
        if model == Some(DriverModel::Reassociated) {
            let agreement = compare::agree(&pair.view, pair.recipe, mine, theirs, snapping);
            let agreement = agreement.expect("masks of one size");
            if !agreement.holds() {
                faults.push(format!("{label}: {agreement:?}"));
            }
            return;
        }
        let counts = BitCounts::between_masks(mine, theirs);
        if counts.other_bits > 0 {
            faults.push(format!("{label}: {counts:?}"));
        }
        same_triangle += counts.same_triangle;
    })
    .expect("both render");
    println!("{model:?}: {same_triangle} pixels of the same triangle");
    assert!(faults.is_empty(), "{faults:#?}");
    assert!(model == Some(DriverModel::Reassociated) || same_triangle > 1_000_000);
}

/// Each driver model changes bits of some technique; otherwise its tests would be void.
#[test]
fn each_model_changes_bits_of_maps() {
    let Some(model) = DriverModel::from_env() else {
        return;
    };
    let mut differing = 0;
    for name in ["cubes", "lamp-in-room"] {
        let scene = (umbrage_scenes::find(name).expect("a built-in scene").build)();
        let geometry = Geometry::bake(&scene).expect("built-in scenes are valid");
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
    assert!(differing > 0, "the model changes no pixel");
}

/// The probe reports the driver's behaviour, and nothing fuses through `product`.
#[test]
fn the_probe_reports_fusing() {
    let is_fused = DriverModel::from_env() == Some(DriverModel::Fused);
    let gpu = gpu();
    let found = gpu.fusing().expect("the device draws");
    println!("{found}");
    assert_eq!(found.guarded_product, Some(false), "{found}");
    if is_fused || gpu.check_pinned_driver().is_ok() {
        assert_eq!(found.product_and_sum, is_fused, "{found}");
    }
}
