//! Tests of single stages with given images.

use crate::{
    kernels::{Halve, Numbers, reference},
    scene::{BackendScene, gpu},
};
use glam::{Mat4, UVec2, Vec4};
use std::sync::Arc;
use umbrage_core::{Filter, FilterKernel, Format, Image, ImageDesc, Inputs, Recipe, Simd};

#[test]
fn the_lookup_replays_from_given_depth() {
    let stage = BackendScene::new();
    let mut gpu = gpu();
    let recipe = stage.recipe(64);
    let shadows = stage.render(&mut gpu, &recipe);
    let receivers = shadows.receivers.expect("the view had none");
    let view = stage.view().with_receivers(&receivers);
    let replayed = gpu
        .replay_receive(&view, &recipe, &shadows.images)
        .expect("it rendered before");
    assert_eq!(replayed, shadows.mask);
    // Use a map that no cast produces: half of it covered.
    let mut images = shadows.images;
    images[0].texels[..64 * 32].fill(0.1);
    let replayed = gpu
        .replay_receive(&view, &recipe, &images)
        .expect("it rendered before");
    assert_ne!(replayed, shadows.mask);
    assert_eq!(replayed, reference(&stage.compare(), &images, &receivers));
}

#[test]
fn a_filter_replays_from_given_images() {
    let stage = BackendScene::new();
    let halve = Halve(Numbers {
        clip_from_world: Mat4::IDENTITY,
        numbers: Vec4::ZERO,
    });
    let desc = |label| ImageDesc {
        label,
        size: UVec2::new(7, 3),
        layers: 2,
        format: Format::Rg32,
    };
    let output = desc("out");
    let recipe = Recipe {
        images: vec![stage.recipe(4).images[0], desc("in"), output],
        filters: vec![Filter {
            kernel: Arc::new(halve),
            inputs: vec![1],
            tables: vec![],
            output: 2,
        }],
        ..stage.recipe(4)
    };
    let mut images: Vec<Image> = recipe
        .images
        .iter()
        .map(|&d| Image::filled_with(d, 0.0))
        .collect();
    (0..)
        .zip(&mut images[1].texels)
        .for_each(|(i, v)| *v = i as f32);
    let replayed = gpu()
        .replay_filter(&recipe, 0, &images)
        .expect("the recipe is valid");
    let mut expected = Image::filled_with(output, 0.0);
    let inputs = [images[1].view()];
    for layer in 0..2 {
        for (y, row) in (0..).zip(expected.layer_mut(layer).chunks_exact_mut(14)) {
            halve.filter(
                &Inputs {
                    images: &inputs,
                    simd: Simd::Native,
                },
                UVec2::new(0, y),
                layer,
                row,
            );
        }
    }
    assert_eq!(replayed, expected);
    assert!(expected.texels.iter().any(|&v| v != 0.0));
}

#[test]
fn images_of_another_shape_are_refused() {
    let stage = BackendScene::new();
    let recipe = stage.recipe(64);
    let images = vec![Image::filled_with(stage.recipe(32).images[0], 0.0)];
    let error = gpu()
        .replay_receive(&stage.view(), &recipe, &images)
        .expect_err("32 is not 64");
    assert!(
        error.to_string().contains("differ from the recipe's"),
        "{error}"
    );
}
