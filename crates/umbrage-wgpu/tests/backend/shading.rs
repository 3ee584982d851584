//! Tests of colour images.

use crate::{
    kernels::{Numbers, kernel},
    scene::{BackendScene, gpu},
};
use glam::Vec4;
use std::sync::Arc;
use umbrage_core::{Backend, NO_TRIANGLE, Receivers, Recipe, Shade, ShadeKernel, Span, Table};

kernel!(
    Reads,
    "fn shade(r: Receiver, visibility: f32) -> vec4f {
        let row = table_0[r.triangle];
        return vec4f(r.position.x + visibility * kernel.numbers.x, r.normal.y, f32(r.pixel.y), f32(row.z));
    }"
);

impl ShadeKernel for Reads {
    fn shade(&self, span: &Span<'_>, visibility: &[f32], out: &mut [[f32; 4]]) {
        for (i, out) in out
            .iter_mut()
            .enumerate()
            .filter(|(i, _)| span.triangle[*i] != NO_TRIANGLE)
        {
            let red = span.x[i] + visibility[i] * self.0.numbers.x;
            *out = [
                red,
                span.ny[i],
                span.first.y as f32,
                7.0 * span.triangle[i] as f32,
            ];
        }
    }
}

const BACKGROUND: [f32; 4] = [0.1, -2.0, 3.5, 0.25];

fn kernel_of(stage: &BackendScene) -> Reads {
    let Numbers {
        clip_from_world, ..
    } = stage.numbers(Vec4::ZERO);
    Reads(Numbers {
        clip_from_world,
        numbers: Vec4::splat(100.0),
    })
}

pub(crate) fn shaded_recipe(stage: &BackendScene) -> Recipe {
    let rows: Vec<[u32; 4]> = (0..4).map(|i| [0, 0, 7 * i, 0]).collect();
    Recipe {
        tables: vec![Table {
            label: "rows",
            rows: rows.into(),
        }],
        shade: Some(Shade {
            kernel: Arc::new(kernel_of(stage)),
            tables: vec![0],
            background: BACKGROUND,
        }),
        ..stage.recipe(64)
    }
}

/// Returns the result of the Rust half for every pixel.
pub(crate) fn reference(
    kernel: &dyn ShadeKernel,
    receivers: &Receivers,
    mask: &[f32],
) -> Vec<[f32; 4]> {
    let mut picture = vec![[0.0; 4]; mask.len()];
    let width = receivers.size.x as usize;
    for (row, out) in picture.chunks_exact_mut(width).enumerate() {
        kernel.shade(
            &receivers.span(row * width, width),
            &mask[row * width..][..width],
            out,
        );
    }
    for (color, _) in picture
        .iter_mut()
        .zip(&receivers.triangle)
        .filter(|(_, t)| **t == NO_TRIANGLE)
    {
        *color = BACKGROUND;
    }
    picture
}

#[test]
fn the_picture_is_what_the_rust_half_says() {
    let stage = BackendScene::new();
    let mut gpu = gpu();
    let shadows = stage.render(&mut gpu, &shaded_recipe(&stage));
    let picture = shadows.picture.expect("the recipe shades");
    let r = shadows.receivers.expect("the view had none");
    let expected = reference(&kernel_of(&stage), &r, &shadows.mask);
    assert_eq!(picture, expected);
    let kinds = |wanted: fn(&Receivers, usize, f32) -> bool| {
        (0..r.len())
            .filter(|&i| wanted(&r, i, shadows.mask[i]))
            .count()
    };
    assert!(kinds(|r, i, _| r.triangle[i] == NO_TRIANGLE) > 100, "sky");
    assert!(
        kinds(|r, i, _| r.triangle[i] != NO_TRIANGLE && !r.receives[i]) > 100,
        "the plate, which receives nothing"
    );
    assert!(kinds(|_, _, v| v == 0.0) > 50, "shadow");
    let spoilt: Vec<f32> = shadows.mask.iter().map(|v| v * 0.5).collect();
    assert_ne!(
        picture,
        reference(&kernel_of(&stage), &r, &spoilt),
        "the comparison must notice"
    );
    assert_eq!(
        shadows.mask,
        stage.render(&mut gpu, &stage.recipe(64)).mask,
        "shading leaves the mask alone"
    );
}

#[test]
fn given_receivers_give_the_same_picture() {
    let stage = BackendScene::new();
    let mut gpu = gpu();
    let first = stage.render(&mut gpu, &shaded_recipe(&stage));
    let receivers = first.receivers.expect("the view had none");
    let second = gpu
        .render(
            &stage.view().with_receivers(&receivers),
            &shaded_recipe(&stage),
        )
        .expect("it rendered before");
    assert_eq!(first.picture, second.picture);
}

#[test]
fn a_second_picture_makes_nothing_and_a_mask_alone_has_none() {
    let stage = BackendScene::new();
    let mut gpu = gpu();
    let recipe = shaded_recipe(&stage);
    let first = stage.render(&mut gpu, &recipe);
    let counters = gpu.counters();
    let mut second = shaded_recipe(&stage);
    second.tables = recipe.tables.clone();
    if let Some(shade) = &mut second.shade {
        shade.background = [9.0; 4];
    }
    let second = stage.render(&mut gpu, &second);
    assert_eq!(gpu.counters(), counters);
    assert_eq!(
        second.picture.expect("the recipe shades")[0],
        [9.0; 4],
        "the corner shows sky"
    );
    let pixels = u64::from(stage.camera.size.element_product());
    let plain = stage.render(&mut gpu, &stage.recipe(64));
    assert_eq!(plain.picture, None);
    assert_eq!(
        first.bytes - plain.bytes,
        16 * pixels + 4 * 16,
        "the picture and the table"
    );
}
