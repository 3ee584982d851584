//! Tests that every error states its cause.

use crate::stage::{geometry, recipe, render, view};
use umbrage_core::{Backend, Camera, Cast, Recipe, Snapping, View, glam::UVec2};
use umbrage_cpu::{Cpu, CpuOptions};

#[test]
fn errors_say_what_is_missing() {
    let geometry = geometry();
    let recipe = recipe();
    let view = view();
    let mut cpu = Cpu::new();
    let receivers = cpu.receivers(view.camera, &geometry).unwrap();
    let mut says = |view: &View<'_>, recipe: &Recipe, text: &str| {
        let error = cpu.render(view, recipe).unwrap_err().to_string();
        assert!(error.contains(text), "{error}");
    };
    says(
        &View {
            geometry: None,
            ..view
        }
        .with_receivers(&receivers),
        &recipe,
        "no geometry, but the recipe casts",
    );
    let plain = Recipe {
        casts: Vec::new(),
        ..recipe.clone()
    };
    says(
        &View {
            geometry: None,
            ..view
        },
        &plain,
        "neither receivers nor geometry",
    );
    let other = Camera {
        size: UVec2::new(5, 5),
        ..*view.camera
    };
    says(
        &View {
            camera: &other,
            ..view
        }
        .with_receivers(&receivers),
        &recipe,
        "97 x 61 pixels",
    );
    let mut short = receivers.clone();
    short.ny.pop();
    says(
        &view.with_receivers(&short),
        &recipe,
        "an array has another length",
    );
    let mut huge = recipe.clone();
    huge.images[0].size.x = 16_385;
    says(&view, &huge, "16385");
    for threads in [0, 5000] {
        let error = Cpu::with_options(&CpuOptions::default().threads(threads))
            .unwrap_err()
            .to_string();
        assert!(error.contains("1 to 1024"), "{error}");
    }
    for sub_pixel_bits in [3, 9] {
        let snapping = Snapping {
            sub_pixel_bits,
            ..Snapping::default()
        };
        let error = Cpu::with_options(&CpuOptions::default().snapping(snapping))
            .unwrap_err()
            .to_string();
        assert!(error.contains("use 4 to 8"), "{error}");
    }
    assert!(
        cpu.replay_filter(&recipe, 1, &render(&mut Cpu::new()).images)
            .is_err()
    );
    assert!(cpu.replay_receive(&view, &recipe, &[]).is_err());
    assert!(
        cpu.cast(&geometry, &recipe.casts[0], UVec2::new(0, 4))
            .is_err()
    );
    let cast = Cast {
        layer: 1,
        ..recipe.casts[0].clone()
    };
    let mut image = cpu.cast(&geometry, &cast, UVec2::new(4, 4)).unwrap();
    assert!(cpu.cast_into(&geometry, &cast, &mut image).is_err());
}
