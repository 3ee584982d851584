//! Tests of whole recipes.

use crate::{
    kernels::{Everything, Halve, Paint, reference},
    scene::{BackendScene, gpu},
};
use glam::{UVec2, Vec3, Vec4};
use std::sync::Arc;
use umbrage_core::{
    Filter, Format, ImageDesc, NO_TRIANGLE, Receive, Recipe, Table, resolve::resolve,
};

#[test]
fn the_map_holds_floor_and_plate() {
    let stage = BackendScene::new();
    let shadows = stage.render(&mut gpu(), &stage.recipe(40));
    // Texels are 0.25 m: the floor covers 32 of 40 each way, the plate 8. Seen from y = 5, with
    // 1..9 m mapped to 0..1.
    let at = |x: usize, y: usize| shadows.images[0].texels[y * 40 + x];
    let near = |a: f32, b: f32| (a - b).abs() < 1e-6;
    for y in 0..40 {
        for x in 0..40 {
            let within = |margin: usize| {
                (margin..40 - margin).contains(&x) && (margin..40 - margin).contains(&y)
            };
            let expected = if within(16) {
                3.0 / 8.0
            } else if within(4) {
                0.5
            } else {
                1.0
            };
            assert!(
                near(at(x, y), expected),
                "texel {x}, {y} is {}, not {expected}",
                at(x, y)
            );
        }
    }
}

#[test]
fn the_mask_is_what_the_rust_half_says() {
    let stage = BackendScene::new();
    let shadows = stage.render(&mut gpu(), &stage.recipe(64));
    let receivers = shadows.receivers.as_ref().expect("the view had none");
    let mask = reference(&stage.compare(), &shadows.images, receivers);
    assert_eq!(shadows.mask, mask);
    let dark = mask.iter().filter(|&&v| v == 0.0).count();
    assert!(
        dark > 50 && dark < mask.len() / 2,
        "{dark} pixels in shadow"
    );
    let mut spoilt = shadows.images.clone();
    spoilt[0].texels.fill(1.0);
    assert_ne!(
        shadows.mask,
        reference(&stage.compare(), &spoilt, receivers),
        "the comparison must notice"
    );
}

#[test]
fn receivers_are_bit_equal_to_the_rust_resolve() {
    let stage = BackendScene::new();
    let shadows = stage.render(&mut gpu(), &stage.recipe(8));
    let r = shadows.receivers.expect("the view had none");
    let rays = stage.camera.rays();
    let mut kinds = [0; 3];
    for i in 0..r.len() {
        if r.triangle[i] == NO_TRIANGLE {
            assert_eq!(
                (r.position(i), r.depth[i], r.receives[i]),
                (Vec3::ZERO, 1.0, false)
            );
            kinds[0] += 1;
            continue;
        }
        let (x, y) = (i as u32 % r.size.x, i as u32 / r.size.x);
        let point = resolve(&rays, x, y, stage.geometry.corners(r.triangle[i]))
            .expect("no ray runs along a plane here");
        assert_eq!(
            (r.position(i), r.normal(i)),
            (point.position, point.normal),
            "pixel {x}, {y}"
        );
        let plate = stage.geometry.corners(r.triangle[i])[0].y == 1.0;
        assert_eq!(r.receives[i], !plate);
        assert!((r.distance[i] - r.position(i).distance(stage.camera.eye())).abs() < 1e-4);
        assert!(r.depth[i] > 0.0 && r.depth[i] < 1.0);
        kinds[1 + usize::from(plate)] += 1;
    }
    assert!(
        kinds.iter().all(|&n| n > 100),
        "sky, floor and plate are all seen: {kinds:?}"
    );
}

#[test]
fn given_receivers_give_the_same_mask() {
    let stage = BackendScene::new();
    let mut gpu = gpu();
    let first = stage.render(&mut gpu, &stage.recipe(64));
    let receivers = first.receivers.expect("the view had none");
    let view = stage.view().with_receivers(&receivers);
    let second = umbrage_core::Backend::render(&mut gpu, &view, &stage.recipe(64))
        .expect("it rendered before");
    assert_eq!(first.mask, second.mask);
    assert!(second.receivers.is_none());
    assert!(second.timings.receivers.is_none());
}

#[test]
fn without_casters_all_is_lit() {
    let mut stage = BackendScene::new();
    stage.geometry = stage.geometry.without_casters();
    let shadows = stage.render(&mut gpu(), &stage.recipe(64));
    assert!(shadows.mask.iter().all(|&v| v == 1.0));
    assert!(shadows.images[0].texels.iter().all(|&v| v == 1.0));
}

/// Returns a recipe with two filters, a layered image, a table, and an unwritten image.
fn everything(stage: &BackendScene) -> Recipe {
    let image = |label| ImageDesc {
        label,
        size: UVec2::new(5, 3),
        layers: 3,
        format: Format::Rgba32,
    };
    let numbers = stage.numbers(Vec4::splat(2.0));
    let rows: Vec<[u32; 4]> = (0..4).map(|i| [0, 10 * i, 0, 0]).collect();
    Recipe {
        images: vec![image("painted"), image("halved"), image("unwritten")],
        tables: vec![Table {
            label: "rows",
            rows: rows.into(),
        }],
        filters: vec![
            Filter {
                kernel: Arc::new(Paint(numbers)),
                inputs: vec![],
                tables: vec![],
                output: 0,
            },
            Filter {
                kernel: Arc::new(Halve(numbers)),
                inputs: vec![0],
                tables: vec![],
                output: 1,
            },
        ],
        receive: Receive {
            kernel: Arc::new(Everything(numbers)),
            inputs: vec![1],
            tables: vec![0],
        },
        casts: Vec::new(),
        shade: None,
        hierarchy: None,
        keep_images: true,
    }
}

#[test]
fn filters_layers_and_tables_reach_the_kernel() {
    let stage = BackendScene::new();
    let shadows = stage.render(&mut gpu(), &everything(&stage));
    let texel = |image: usize, x: usize, y: usize, layer: usize| {
        <[f32; 4]>::try_from(&shadows.images[image].texels[4 * ((layer * 3 + y) * 5 + x)..][..4])
            .expect("four floats")
    };
    assert_eq!(texel(0, 4, 2, 1), [8.0, 4.0, 2.0, 2.0]);
    assert_eq!(texel(1, 4, 2, 1), [4.0, 2.0, 1.0, 1.0]);
    assert!(shadows.images[2].texels.iter().all(|&v| v == 0.0));
    let r = shadows.receivers.expect("the view had none");
    for i in (0..r.len()).filter(|&i| r.receives[i]) {
        let expected = 2.0
            + 10.0 * r.triangle[i] as f32
            + r.ny[i] * 100.0
            + (i as u32 % r.size.x) as f32 * 1000.0;
        assert_eq!(shadows.mask[i], expected, "pixel {i}");
    }
}

#[test]
fn images_that_nothing_writes_start_clean_every_time() {
    let stage = BackendScene::new();
    let mut gpu = gpu();
    let mut recipe = stage.recipe(16);
    let full = stage.render(&mut gpu, &recipe);
    assert!(full.images[0].texels.iter().any(|&v| v < 1.0));
    recipe.casts.clear();
    let empty = stage.render(&mut gpu, &recipe);
    assert!(empty.images[0].texels.iter().all(|&v| v == 1.0));
}

#[test]
fn a_second_cast_into_a_layer_keeps_the_nearest() {
    let stage = BackendScene::new();
    let mut gpu = gpu();
    let mut recipe = stage.recipe(40);
    let mut shifted = recipe.casts[0].clone();
    // Shift by 8 texels to the right: the plate now covers twice the area.
    shifted.space = shifted
        .space
        .nudge_by(glam::Vec2::new(8.0, 0.0), 0.0, UVec2::splat(40));
    recipe.casts.push(shifted);
    let shadows = stage.render(&mut gpu, &recipe);
    let plate = shadows.images[0]
        .texels
        .iter()
        .filter(|&&d| d < 0.4)
        .count();
    assert_eq!(plate, 8 * 16);
}

#[test]
fn nothing_is_made_on_the_second_frame() {
    let stage = BackendScene::new();
    let mut gpu = gpu();
    let everything = everything(&stage);
    stage.render(&mut gpu, &everything);
    let first = gpu.counters();
    stage.render(&mut gpu, &everything);
    assert_eq!(gpu.counters(), first);
    stage.render(&mut gpu, &stage.recipe(32));
    assert_ne!(gpu.counters(), first, "another shape must show");
    let before = gpu.counters().pipelines;
    let after = stage.render(&mut gpu, &stage.recipe(64));
    assert_eq!(
        gpu.counters().pipelines,
        before,
        "a map of another size needs no other shader"
    );
    assert!(after.bytes > 64 * 64 * 4);
}

#[test]
fn stages_are_timed() {
    let stage = BackendScene::new();
    let mut gpu = gpu();
    let timings = stage.render(&mut gpu, &stage.recipe(64)).timings;
    assert!(
        timings.receivers.is_some() && timings.cast.is_some() && timings.receive.is_some(),
        "{timings:?}"
    );
    assert_eq!(timings.filter, None);
    assert!(
        stage
            .render(&mut gpu, &everything(&stage))
            .timings
            .filter
            .is_some()
    );
}
