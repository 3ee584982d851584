use super::*;
use crate::faulty_backend::FaultyBackend;
use umbrage_core::{Light, Shadows, glam::Vec3};

fn row(rmse: f64, best: f64) -> BiasRow {
    BiasRow {
        scene: "cubes".to_owned(),
        light: "sun".to_owned(),
        triangles: 38,
        kernel: "hard".to_owned(),
        side: 512,
        counted: 100_000,
        default_errors: vec![DefaultBiasError {
            backend: "cpu".to_owned(),
            rmse,
        }],
        best,
        best_bias: "bias: none".to_owned(),
        textbook: 0.2,
        plane: 0.1,
    }
}

#[test]
fn ratios_leave_some_pixels_to_chance() {
    // One wrong pixel of 100,000 is an RMSE of 0.00316.
    let one_pixel = (1.0_f64 / 100_000.0).sqrt();
    assert!(row(one_pixel, 0.0).ratio() < 1.04);
    assert!((row(0.2, 0.1).ratio() - 1.98).abs() < 0.02);
}

#[test]
fn sums_count_what_is_good_and_name_what_is_not() {
    let rows = [row(0.1, 0.1), row(0.2, 0.1)];
    let summary = Summary::from_rows(rows.iter());
    assert_eq!((summary.rows, summary.good), (2, 1));
    let page = markdown(&rows);
    assert!(
        page.contains("| hard, 512 | 2 | 50 % |")
            && page.contains("| cubes | sun | hard | 512 | 0.2000 |"),
        "{page}"
    );
}

fn stairs_on(backend: Box<dyn Backend + Send>) -> Vec<BiasRow> {
    let scene = (umbrage_scenes::find("stairs").expect("built in").build)();
    let staged = stage_scene(scene, false).expect("valid");
    let options = BiasOptions {
        size: Some(UVec2::new(160, 120)),
        sides: vec![512],
    };
    measure(
        &staged,
        &options,
        &mut Backends::from_backends(vec![backend]),
    )
    .expect("valid")
}

/// The default bias equals the best of the others. With every twentieth pixel dark it doesn't.
#[test]
fn the_default_is_near_the_best_and_a_spoilt_one_is_not() {
    let rows = stairs_on(Box::new(umbrage_cpu::Cpu::new()));
    assert_eq!(rows.len(), KERNELS.len());
    assert!(
        Summary::from_rows(rows.iter()).max < 1.1,
        "{}",
        markdown(&rows)
    );
    let spoilt = stairs_on(Box::new(FaultyBackend::new(|shadows: &mut Shadows| {
        shadows.mask.iter_mut().step_by(20).for_each(|v| *v = 0.0);
    })));
    let summary = Summary::from_rows(spoilt.iter());
    assert!(
        summary.good == 0 && summary.mean > 1.5,
        "{}",
        markdown(&spoilt)
    );
}

#[test]
fn models_get_a_floor_and_four_ideal_lights() {
    let mut model = (umbrage_scenes::find("c8-faceted-sphere")
        .expect("built in")
        .build)();
    model.lights.clear();
    let count = model.instances.len();
    let staged = stage_scene(model, true).expect("valid");
    assert_eq!(
        (staged.scene.instances.len(), staged.lights.len()),
        (count + 1, 4)
    );
    assert!(staged.lights.iter().all(|(_, light)| light.is_ideal()));
    let wide = Light::Disc {
        center: Vec3::Y,
        normal: Vec3::NEG_Y,
        radius: 1.0,
    };
    assert!(super::stage::ideal(&wide).is_ideal());
}
